"""Chebyshev collocation of the monodromy operator, (3.10)-(3.15), in pieces that end at the jumps."""

from dataclasses import replace
from typing import Any

import jax.numpy as jnp
import numpy as np

from lobex import _checks
from lobex._pytree import pytree
from lobex.operators.exponential import exponential
from lobex.operators.operator import MOST_NODES, MonodromyOperator, in_form
from lobex.systems.coefficients import Piece
from lobex.systems.mesh import pieces_of
from lobex.systems.system import DelaySystem

Array = Any


def chebyshev_points(nodes: int) -> np.ndarray:
    """The ``nodes`` Chebyshev extreme points (3.10), increasing, on [0, 1]."""
    return np.sin(np.pi * np.arange(nodes) / (2 * (nodes - 1))) ** 2


def differentiation_matrix(nodes: int) -> np.ndarray:
    """Derivative of the interpolant on ``chebyshev_points``, (nodes, nodes).

    Trefethen, Spectral Methods in MATLAB, ch. 6, with the diagonal from the row sums (Baltensperger and
    Trummer, 2003) and the differences of points as products of sines, against cancellation.
    """
    index = np.arange(nodes)
    angle = np.pi * index / (2 * (nodes - 1))
    difference = np.sin(angle[:, None] + angle) * np.sin(angle[:, None] - angle)
    sign = (-1.0) ** index
    sign[[0, -1]] *= 2
    np.fill_diagonal(difference, 1.0)
    matrix = np.outer(sign, 1 / sign) / difference
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    return matrix


def quadrature_weights(nodes: int) -> np.ndarray:
    """Clenshaw-Curtis weights on ``chebyshev_points``, (nodes,), summing to 1."""
    order = np.arange(0, nodes, 2)
    moments = np.zeros(nodes)
    moments[order] = 1 / (1.0 - order**2)
    cosines = np.cos(np.pi * np.outer(np.arange(nodes), np.arange(nodes)) / (nodes - 1))
    ends = np.ones(nodes)
    ends[[0, -1]] = 0.5
    return 2 / (nodes - 1) * ends * ((ends * moments) @ cosines)


@pytree(static=("nodes", "aligned", "full"))
class Chebyshev:
    """Collocation at Chebyshev points: spectrally accurate on smooth coefficients.

    Attributes:
        nodes: collocation points per piece, both ends included (the thesis' codes count so, too).
        aligned: end the pieces at the jumps of the coefficients and pass parts without force exactly. False
            gives the thesis' single interval from phase 0, which loses its accuracy over a jump.
        full: keep the history of the whole state (the thesis' operator) and not only of the output. Same
            nonzero multipliers, at N ≈ d·nodes instead of d + r·nodes.
    """

    nodes: int = 40
    aligned: bool = True
    full: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "nodes", _checks.integer("nodes", self.nodes, 2, MOST_NODES))
        _checks.choice("aligned", self.aligned, (True, False))
        _checks.choice("full", self.full, (True, False))

    def operator(self, system: DelaySystem) -> MonodromyOperator:
        """The monodromy operator; its state is (z, y at the earlier collocation points of the delay)."""
        return in_form(self._operator, system, self.full)

    def size(self, system: DelaySystem) -> int:
        """N: d + r·(nodes − 1) per piece in contact, less the last point where it is z itself."""
        pieces = self._pieces(system)
        outputs = system.state_size if self.full else system.output_size
        stored = (self.nodes - 1) * sum(piece.idle is not True for piece in pieces)
        return system.state_size + outputs * (stored - (pieces[-1].idle is not True))

    def finer(self) -> "Chebyshev":
        """The same with half as many nodes again."""
        return replace(self, nodes=self.nodes + self.nodes // 2)

    def resolved_radians(self, system: DelaySystem) -> float:
        """π points per wave at the middle of the widest piece, less the points that convergence takes."""
        lengths = [piece.length for piece in self._pieces(system) if piece.idle is not True]
        return max(2.0 * (self.nodes - 8), 0.0) / max(float(length) for length in lengths)

    def _pieces(self, system: DelaySystem) -> tuple[Piece, ...]:
        return pieces_of(system) if self.aligned else (Piece(0.0, 1.0, False),)

    def _operator(self, system: DelaySystem) -> MonodromyOperator:
        pieces = self._pieces(system)
        points, weights = chebyshev_points(self.nodes), quadrature_weights(self.nodes)
        size, state, r = self.size(system), system.state_size, system.output_size
        block = r * (self.nodes - 1)
        output = system.output_matrix()
        identity = jnp.eye(size, dtype=jnp.result_type(system.blocks))
        current = identity[:state]
        # Past the last stored point, the history ends in the output of z itself.
        history = jnp.concatenate([identity[state:], output @ current])
        stored, phases, quadrature, motion = [], [], [], []
        for piece in pieces:
            if piece.idle is True:
                fine = chebyshev_points(2 * self.nodes)
                flight = _free_flight(system, piece.length * fine, output)
                motion.append(jnp.einsum("srd,dn->srn", flight, current))
                phases.append(piece.start + piece.length * fine)
                quadrature.append(piece.length * quadrature_weights(2 * self.nodes))
                current = _propagate(system, piece.length, current)
                continue
            phase = piece.start + piece.length * points
            inside = piece.start + piece.length / 2
            present, (of_delayed,) = system.within(inside, phase[1:]) if self.aligned else system.at(phase[1:])
            delayed, history = history[:block], history[block:]
            values, end = self._through(system, piece, (present, of_delayed), current, delayed)
            samples = jnp.concatenate([output @ current, values]).reshape(self.nodes, r, size)
            stored.append(values)
            motion.append(samples)
            phases.append(phase)
            quadrature.append(piece.length * weights)
            current = end
        matrix = jnp.concatenate([current, *stored])[:size]
        return MonodromyOperator(matrix, jnp.concatenate(phases), jnp.concatenate(quadrature), jnp.concatenate(motion))

    def _through(
        self,
        system: DelaySystem,
        piece: Piece,
        feedback: tuple[Array, Array],
        start: Array,
        delayed: Array,
    ) -> tuple[Array, Array]:
        """The outputs at a piece's points and the state at its end, from its start and the delayed outputs."""
        free, forced, free_end, forced_end = collocated_response(system, piece, self.nodes)
        q, r = self.nodes - 1, system.output_size
        current_force, delayed_force = feedback
        width = jnp.shape(start)[-1]

        def apply(coefficient: Array, values: Array) -> Array:
            stacked = jnp.einsum("qab,qbn->qan", coefficient, values.reshape(q, r, width))
            return stacked.reshape(q * r, width)

        push = apply(delayed_force, delayed)
        looped = jnp.einsum("pqb,qbc->pqc", forced.reshape(q * r, q, r), current_force).reshape(q * r, q * r)
        unit = jnp.eye(q * r, dtype=jnp.result_type(looped))
        values = jnp.linalg.solve(unit - looped, free @ start + forced @ push)
        force = apply(current_force, values) + push
        return values, free_end @ start + forced_end @ force


def collocated_response(system: DelaySystem, piece: Piece, nodes: int) -> tuple[Array, Array, Array, Array]:
    """The structure's response over a piece, without the feedback: it depends on the speed, not on the gain.

    With q = nodes − 1 points after the start: outputs from the start state, (q·r, d), and from the forces at
    the points, (q·r, q·r); end state from the start state, (d, d), and from the forces, (d, q·r). Each block
    of A is collocated by itself, which is (3.13)-(3.15) row for row.
    """
    blocks, inputs, outputs = system.blocks, system.inputs, system.outputs
    n, s, r = jnp.shape(inputs)
    q = nodes - 1
    derivative = differentiation_matrix(nodes)
    duration = system.period * piece.length
    unit = np.eye(s)
    left = np.kron(derivative[1:, 1:], unit) - duration * _kron(np.eye(q), blocks)
    by_start = jnp.broadcast_to(np.kron(-derivative[1:, :1], unit), (n, q * s, s))
    by_force = duration * _kron(np.eye(q), inputs)
    response = jnp.linalg.solve(left, jnp.concatenate([by_start, by_force], axis=-1)).reshape(n, q, s, -1)
    start, force = response[..., :s], response[..., s:]
    if piece.idle is not False:
        # Whether the piece is in contact is not known before tracing: without force, pass it exactly.
        exact = exponential(duration * chebyshev_points(nodes)[1:, None, None] * blocks[:, None])
        start = jnp.where(piece.idle, exact, start)
    free = jnp.einsum("nrs,nqsa->qrna", outputs, start).reshape(q * r, n * s)
    forced = jnp.einsum("nrs,nqsa->qra", outputs, force).reshape(q * r, q * r)
    spread = jnp.einsum("nab,nm->namb", start[:, -1], jnp.eye(n, dtype=jnp.result_type(blocks)))
    return free, forced, spread.reshape(n * s, n * s), force[:, -1].reshape(n * s, q * r)


def _kron(left: np.ndarray, right: Array) -> Array:
    """Kronecker products of one matrix with a stack of matrices."""
    n, a, b = jnp.shape(right)
    rows, columns = left.shape
    return jnp.einsum("ij,nab->niajb", left, right).reshape(n, rows * a, columns * b)


def _propagate(system: DelaySystem, length: Array, state: Array) -> Array:
    n, s = jnp.shape(system.blocks)[:2]
    steps = exponential(system.period * length * system.blocks)
    return jnp.einsum("nab,nbk->nak", steps, state.reshape(n, s, -1)).reshape(n * s, -1)


def _free_flight(system: DelaySystem, lengths: Array, output: Array) -> Array:
    n, s = jnp.shape(system.blocks)[:2]
    steps = exponential(system.period * lengths[:, None, None, None] * system.blocks)
    parts = output.reshape(-1, n, s)
    return jnp.einsum("rna,pnab->prnb", parts, steps).reshape(len(lengths), -1, n * s)
