"""Chebyshev collocation of the monodromy operator, (3.10)-(3.15), in pieces that end at the jumps."""

from dataclasses import replace
from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from lobex import _checks
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.operators.exponential import exponential
from lobex.operators.lookup import look_up
from lobex.operators.operator import MOST_NODES, MonodromyOperator, in_form
from lobex.systems.links import Link
from lobex.systems.mesh import Mesh, mesh_of, pieces_of
from lobex.systems.system import DelaySystem, Forces, dense_outputs

# A loop over so few pieces is written out.
_FEW = 4


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

    What is remembered is looked up between the points by their polynomial, so that delays may have any length.

    Attributes:
        nodes: collocation points per piece, both ends included (the thesis' codes count so, too).
        aligned: end the pieces at the jumps of the coefficients and pass parts without force exactly. False
            gives the thesis' single interval from phase 0, which loses its accuracy over a jump; it takes systems
            whose only delay is the period.
        full: keep the history of the whole state (the thesis' operator) and not only of what is remembered. Same
            nonzero multipliers, at N ≈ d·nodes instead of d + r·nodes; of systems whose only delay is the period.
    """

    nodes: int = 40
    aligned: bool = True
    full: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "nodes", _checks.integer("nodes", self.nodes, 2, MOST_NODES))
        _checks.choice("aligned", self.aligned, (True, False))
        _checks.choice("full", self.full, (True, False))

    def operator(self, system: DelaySystem) -> MonodromyOperator:
        """The monodromy operator; its state is (z, w at the earlier collocation points of the longest delay)."""
        return in_form(self._operator, system, self.full)

    def size(self, system: DelaySystem) -> int:
        """N: d + m·(nodes − 1) per piece that the longest delay reaches back, less the last point where it is z itself.

        Where delays are not the period, the start of the oldest piece is stored as well.
        """
        mesh = self._mesh(system)
        remembered = system.state_size if self.full else np.shape(system.recalled)[1]
        stored = (self.nodes - 1) * mesh.history + (not system.repeats)
        return system.state_size + remembered * (stored - (mesh.gap is None))

    def finer(self) -> "Chebyshev":
        """The same with half as many nodes again."""
        return replace(self, nodes=self.nodes + self.nodes // 2)

    def resolved_radians(self, system: DelaySystem) -> float:
        """π points per wave at the middle of the widest piece, less the points that convergence takes."""
        return max(2.0 * (self.nodes - 8), 0.0) / float(np.max(self._mesh(system).length))

    def _mesh(self, system: DelaySystem) -> Mesh:
        if self.aligned:
            return mesh_of(system if system.places is None else replace(system, places=system.places.open))
        if not system.repeats:
            raise ValueError("aligned = False takes systems whose only delay is the period; leave it out")
        return Mesh(jnp.zeros(1), jnp.ones(1), None, 1, False, (Link(0, 1, 0),))

    def _operator(self, system: DelaySystem) -> MonodromyOperator:
        mesh, q, d = self._mesh(system), self.nodes - 1, system.state_size
        output, memory = system.output_matrix(), dense_outputs(system.recalled)
        r, m, e = len(output), len(memory), system.force_size
        identity = jnp.eye(self.size(system), dtype=jnp.result_type(system.blocks))
        # Where no flight follows the last piece, the past ends in what is remembered of z itself.
        past = identity[d:] if mesh.gap is not None else jnp.concatenate([identity[d:], memory @ identity[:d]])
        response = self._response(system, mesh)
        forces = self._forces(system, mesh)
        found = None if system.repeats else _looked_up(system, mesh, self.nodes)
        flights = None if mesh.gap is None else _flights(system, mesh.gap, chebyshev_points(2 * self.nodes), output)

        def acted(coefficient: Float[AnyArray, "q e r"], values: Float[Array, "qr p"]) -> Float[Array, "qe p"]:
            """Forces (q·e, N) of values (q·r, N)."""
            each = values.reshape(q, jnp.shape(coefficient)[2], -1)
            return jnp.einsum("qab,qbn->qan", coefficient, each).reshape(q * e, -1)

        def over(
            state: tuple[Float[Array, "d N"], Float[Array, "stored N"]], piece: Any
        ) -> tuple[tuple[Float[Array, "d N"], Float[Array, "stored N"]], Any]:
            z, past = state
            (free, forced, through, push), (present, delayed), found, flights = piece
            # Of what is seen at the points, outputs come first and what is remembered last, where that is not the same.
            seen = len(forced)
            at_once = jnp.einsum("pqb,qbc->pqc", forced.reshape(seen, q, e), present).reshape(seen, q * r)
            looped = jnp.pad(at_once, ((0, 0), (0, seen - q * r)))
            # What acts was at the points of the oldest piece, or between those of any.
            earlier = [past[: q * m]] * len(delayed)
            if found is not None:
                earlier = [weights @ past.reshape(-1, m * len(identity)) for weights in found.earlier]
            driven = sum(map(acted, delayed, earlier), jnp.zeros((q * e, 1)))
            late = None
            if found is not None and found.recent is not None:
                late = sum(jnp.einsum("qab,qj->qajb", *pair) for pair in zip(delayed, found.recent, strict=True))
                late = jnp.reshape(late, (q * e, q * m))
                looped = looped + jnp.pad(forced @ late, ((0, 0), (seen - q * m, 0)))
            unit = jnp.eye(seen, dtype=looped.dtype)
            values = jnp.linalg.solve(unit - looped, free @ z + forced @ driven)
            force = acted(present, values[: q * r]) + driven
            if late is not None:
                force = force + late @ values[-q * m :]
            samples = jnp.concatenate([output @ z, values[: q * r]]).reshape(self.nodes, r, -1)
            past = jnp.concatenate([past[q * m :], values[-q * m :]])
            z = through @ z + push @ force
            if flights is None:
                return (z, past), (samples, None)
            flown, after = flights
            return (after @ z, past), (samples, jnp.einsum("srd,dn->srn", flown, z))

        steps = response, forces, found, flights
        # The first by itself: products with what is the same at all points of a batch are quicker.
        state, first = over((identity[:d], past), jax.tree.map(lambda part: part[0], steps))
        motion = jax.tree.map(lambda one: one[None], first)
        if mesh.pieces > 1:
            rest = jax.tree.map(lambda part: part[1:], steps)
            state, others = jax.lax.scan(over, state, rest, unroll=mesh.pieces <= _FEW or 1)
            motion = jax.tree.map(lambda one, more: jnp.concatenate([one, more]), motion, others)
        z, past = state
        matrix = jnp.concatenate([z, past])[: len(identity)]
        return MonodromyOperator(matrix, *self._samples(mesh, *motion))

    def _response(
        self, system: DelaySystem, mesh: Mesh
    ) -> tuple[Float[Array, "M rows d"], Float[Array, "M rows qe"], Float[Array, "M d d"], Float[Array, "M d qe"]]:
        """``collocated_response`` over all pieces."""
        idle = [piece.idle for piece in pieces_of(system) if piece.idle is not True] if system.repeats else []
        if not self.aligned or all(mark is False for mark in idle):
            return jax.vmap(lambda length: collocated_response(system, length, self.nodes))(mesh.length)
        marks = jnp.stack([jnp.asarray(mark) for mark in idle])
        return jax.vmap(lambda *piece: collocated_response(system, piece[0], self.nodes, piece[1]))(mesh.length, marks)

    def _forces(self, system: DelaySystem, mesh: Mesh) -> Forces:
        """The coefficients at the points after the start of every piece, (M, q, e, r)."""

        def over(start: Number, length: Number) -> Forces:
            phase = start + length * chebyshev_points(self.nodes)[1:]
            return system.within(start + length / 2, phase) if self.aligned else system.at(phase)

        return jax.vmap(over)(mesh.start, mesh.length)

    def _samples(
        self, mesh: Mesh, crossed: Float[Array, "M p r N"], flown: Float[Array, "M f r N"] | None
    ) -> tuple[Float[Array, " S"], Float[Array, " S"], Float[Array, "S r N"]]:
        """Phases, weights and outputs (S, r, N) at the points of all pieces, and of what follows each without force."""

        def over(
            start: Float[AnyArray, " M"], length: Float[AnyArray, " M"], samples: Float[Array, "M p r N"]
        ) -> tuple[Float[AnyArray, "M p"], Float[AnyArray, "M p"], Float[Array, "M p r N"]]:
            count = jnp.shape(samples)[1]
            return (
                start[:, None] + length[:, None] * chebyshev_points(count),
                length[:, None] * quadrature_weights(count),
                samples,
            )

        parts = [over(mesh.start, mesh.length, crossed)]
        if flown is not None and mesh.gap is not None:
            parts.append(over(mesh.start + mesh.length, mesh.gap, flown))
        phase, weight, output = (jnp.concatenate(part, axis=1) for part in zip(*parts, strict=True))
        return phase.ravel(), weight.ravel(), output.reshape(-1, *jnp.shape(output)[2:])


def collocated_response(
    system: DelaySystem, length: Number, nodes: int, idle: Bool[Array, ""] | None = None
) -> tuple[Float[Array, "rows d"], Float[Array, "rows qe"], Float[Array, "d d"], Float[Array, "d qe"]]:
    """The structure's response over a piece, without the feedback: it depends on the speed, not on the gain.

    With q = nodes − 1 points after the start: outputs there, and what is remembered there where that is not the
    outputs, from the start state, (rows, d), and from the forces at the points, (rows, q·e); end state from the start
    state, (d, d), and from the forces, (d, q·e). Each block of A is collocated by itself, which is (3.13)-(3.15) row
    for row. A piece that may be ``idle``, without force, is then passed exactly.
    """
    blocks, inputs = system.blocks, system.inputs
    n, s, e = jnp.shape(inputs)
    q = nodes - 1
    derivative = differentiation_matrix(nodes)
    duration = system.period * length
    unit = np.eye(s)
    left = np.kron(derivative[1:, 1:], unit) - duration * _kron(np.eye(q), blocks)
    by_start = jnp.broadcast_to(np.kron(-derivative[1:, :1], unit), (n, q * s, s))
    by_force = duration * _kron(np.eye(q), inputs)
    response = jnp.linalg.solve(left, jnp.concatenate([by_start, by_force], axis=-1)).reshape(n, q, s, -1)
    start, force = response[..., :s], response[..., s:]
    if idle is not None:
        exact = exponential(duration * chebyshev_points(nodes)[1:, None, None] * blocks[:, None])
        start = cast(Array, jnp.where(idle, exact, start))
    kept = [system.outputs] if system.remembered is None else [system.outputs, system.remembered]
    free = [jnp.einsum("nrs,nqsa->qrna", seen, start).reshape(-1, n * s) for seen in kept]
    forced = [jnp.einsum("nrs,nqsa->qra", seen, force).reshape(-1, q * e) for seen in kept]
    through = jnp.einsum("nab,nm->namb", start[:, -1], jnp.eye(n, dtype=jnp.result_type(blocks))).reshape(n * s, n * s)
    return jnp.concatenate(free), jnp.concatenate(forced), through, force[:, -1].reshape(n * s, q * e)


class _Found(NamedTuple):
    """What delays bring to the points of every piece: from the points of the past, the start of the oldest piece first,
    (M, K, q, H·q + 1), and, if a delay may be that short, from those of the piece itself after its start, (M, K, q, q).
    """

    earlier: Float[Array, "M K q past"]
    recent: Float[Array, "M K q q"] | None


def _looked_up(system: DelaySystem, mesh: Mesh, nodes: int) -> _Found:
    q, history = nodes - 1, mesh.history
    points = chebyshev_points(nodes)
    slot, inside = look_up(system, mesh, points[1:])
    weights = chebyshev_polynomials(2 * inside - 1, nodes) @ _synthesis(nodes)
    here = (jnp.arange(history + 1) == slot[..., None])[..., None]
    # The last point of a piece is the first of the next.
    by_first = (here * weights[..., None, :q]).reshape(*jnp.shape(slot), -1)
    last = jnp.pad(here * weights[..., None, q:], [(0, 0)] * (np.ndim(slot) + 1) + [(q - 1, 0)])
    one = [(0, 0)] * np.ndim(slot)
    by_point = jnp.pad(by_first, [*one, (0, 1)]) + jnp.pad(last.reshape(*jnp.shape(slot), -1), [*one, (1, 0)])
    earlier, recent = jnp.split(by_point, [history * q + 1], axis=-1)
    return _Found(earlier, recent if mesh.recent else None)


def _synthesis(nodes: int) -> np.ndarray:
    """Chebyshev terms from samples at ``chebyshev_points``, (terms, points)."""
    order = np.arange(nodes)
    ends = np.where((order == 0) | (order == nodes - 1), 0.5, 1.0)
    # The points rise, so that x = −cos.
    cosines = np.cos(np.pi * np.outer(order, order) / (nodes - 1))
    return 2 / (nodes - 1) * (-1.0) ** order[:, None] * ends[:, None] * cosines * ends


def chebyshev_polynomials(x: Float[Array, " *lanes"], count: int) -> Float[Array, "*lanes {count}"]:
    """T_0 … T_{count−1} (DLMF 18.9.2), along a new last axis."""

    def next_one(
        pair: tuple[Float[Array, " *lanes"], Float[Array, " *lanes"]], _: None
    ) -> tuple[tuple[Float[Array, " *lanes"], Float[Array, " *lanes"]], Float[Array, " *lanes"]]:
        return (pair[1], 2 * x * pair[1] - pair[0]), pair[0]

    return jnp.moveaxis(jax.lax.scan(next_one, (jnp.ones_like(x), x), None, length=count, unroll=8)[1], 0, -1)


def _kron(left: np.ndarray, right: Float[AnyArray, "n a b"]) -> Float[Array, "n rows columns"]:
    """Kronecker products of one matrix with a stack of matrices."""
    n, a, b = jnp.shape(right)
    rows, columns = left.shape
    return jnp.einsum("ij,nab->niajb", left, right).reshape(n, rows * a, columns * b)


def _flights(
    system: DelaySystem, gap: Float[AnyArray, " M"], points: np.ndarray, output: Float[AnyArray, "r d"]
) -> tuple[Float[Array, "M p r d"], Float[Array, "M d d"]]:
    """Over gaps (M,) without force: outputs at points of each, (M, p, r, d), and the end state, (M, d, d)."""
    n, s = jnp.shape(system.blocks)[:2]
    steps = exponential(system.period * (gap[:, None] * points)[..., None, None, None] * system.blocks)
    flown = jnp.einsum("rna,mpnab->mprnb", output.reshape(-1, n, s), steps)
    # By itself, since where motions are not asked for the others go unused.
    whole = exponential(system.period * gap[:, None, None, None] * system.blocks)
    through = jnp.einsum("mnab,nk->mnakb", whole, jnp.eye(n, dtype=jnp.result_type(whole)))
    return flown.reshape(*jnp.shape(flown)[:3], n * s), through.reshape(-1, n * s, n * s)
