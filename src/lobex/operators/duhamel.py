"""The monodromy operator with the structure solved exactly and the force a polynomial through Gauss points."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from lobex import _checks
from lobex._pytree import pytree
from lobex.floquet.power import Pair, rotation
from lobex.operators.estimate import InContact, estimated_error, rounding, unresolved
from lobex.operators.operator import MOST_NODES, MonodromyOperator
from lobex.operators.response import Response, forced_response, free_response, gauss_nodes
from lobex.processes.feedback import Feedback, Piece
from lobex.processes.system import DelaySystem

Array = Any
Inverse = Callable[[Array], Array]

_NODES = 40
# Samples of the free vibration over a piece without force, where nobody says how many waves there are: 80 of them.
IN_FLIGHT = 256
_FINEST, _COARSEST = 1e-12, 1e-2


class Flight(NamedTuple):
    """A piece without force: outputs at samples from the start state, (samples, r, d), and the end state, (d, d)."""

    outputs: Array
    through: Array


class Motion(NamedTuple):
    """The motion that a multiplier and its state stand for, over the period after the state.

    Attributes:
        phase: sampling phases t/τ, (S,).
        weight: quadrature weights, (S,), summing to 1.
        output: y at the samples, real and imaginary part, (S, r, 2).
        defect: by how much the multiplier misses the discrete equations, relative to the state and to |μ|.
        error: estimated relative error of |μ| by the nodes, infinite where they might have missed a larger one.
        rounding: that by the arithmetic, defect included.
    """

    phase: Array
    weight: Array
    output: Array
    defect: Array
    error: Array
    rounding: Array


@pytree(static=("nodes", "tolerance"))
class Duhamel:
    """Collocation of the contact force alone, at Gauss points; what it does to the structure is exact.

    Between contact samples the force is a polynomial, and Duhamel's integral of it over every mode is exact.
    Stiff modes thus need no nodes of their own, and Gauss points make the multipliers converge twice as fast
    as the force does (superconvergence of collocation at Gauss points: Chatelin, Spectral Approximation of
    Linear Operators, 1983, ch. 6). The pieces end at the jumps of the coefficients, and those without force
    are passed exactly. What does not depend on the gain is separate: ``prepare`` is the structure's part,
    ``assemble`` that of the feedback.

    Attributes:
        nodes: Gauss points per piece in contact. None lets ``sweep`` and its like choose them, point by point,
            from the estimated error; where one operator is asked for, it is then 40.
        tolerance: the estimated relative error of μ that is enough where nodes are chosen, and of which more is
            warned of.
    """

    nodes: int | None = None
    tolerance: float = 1e-8

    def __post_init__(self) -> None:
        if self.nodes is not None:
            object.__setattr__(self, "nodes", _checks.integer("nodes", self.nodes, 3, MOST_NODES))
        tolerance = _checks.as_numbers("tolerance", self.tolerance)
        if tolerance is None or np.ndim(tolerance) or not _FINEST <= tolerance <= _COARSEST:
            raise ValueError(f"tolerance = {self.tolerance!r} must be a number from {_FINEST:g} to {_COARSEST:g}")
        object.__setattr__(self, "tolerance", float(tolerance))

    @property
    def count(self) -> int:
        """Nodes per piece of one operator."""
        return _NODES if self.nodes is None else self.nodes

    def operator(self, system: DelaySystem) -> MonodromyOperator:
        """The monodromy operator; its state is (z, y/|C| at the nodes of the period before)."""
        prepared = self.prepare(system)
        size = _output_scale(system)
        matrix, starts = self._matrix(prepared, system.feedback, jnp.linalg.inv)
        phase, weight, outputs = [], [], []
        r = system.output_size
        row = system.state_size
        for piece, part, start in zip(system.feedback.pieces(), prepared, starts, strict=True):
            points, weights = self._samples(part)
            phase.append(piece.start + piece.length * points)
            weight.append(piece.length * weights)
            if isinstance(part, Flight):
                outputs.append(jnp.einsum("srd,dn->srn", part.outputs, start))
            else:
                outputs.append(matrix[row : row + self.count * r].reshape(self.count, r, -1))
                row += self.count * r
        motion = size * jnp.concatenate(outputs)
        return MonodromyOperator(matrix, jnp.concatenate(phase), jnp.concatenate(weight), motion)

    def size(self, system: DelaySystem) -> int:
        """N: d + r·nodes per piece in contact."""
        contacts = sum(piece.idle is not True for piece in system.feedback.pieces())
        return system.state_size + system.output_size * self.count * contacts

    def finer(self) -> "Duhamel":
        """The same with half as many nodes again."""
        return replace(self, nodes=self.count + -(-self.count // 2))

    def resolved_radians(self, system: DelaySystem) -> float:
        """π points per wave at the middle of the widest piece, less what convergence takes; any where chosen."""
        if self.nodes is None:
            return np.inf
        lengths = [piece.length for piece in system.feedback.pieces() if piece.idle is not True]
        return max(2.0 * (self.count - 4), 0.0) / max(float(length) for length in lengths)

    def prepare(
        self, system: DelaySystem, resolved: bool = False, in_flight: int = IN_FLIGHT
    ) -> tuple[Response | Flight, ...]:
        """The structure's response over every piece, for y/|C|: it depends on the speed, not on the gain.

        With ``resolved``, for a gain that acts on the delayed force only, the present force is included. A free
        vibration is sampled ``in_flight`` times.
        """
        # Outputs of the size of the state, whatever the mode shapes' units: residuals then mean the same everywhere.
        size = _output_scale(system)
        system = replace(system, inputs=system.inputs * size, outputs=system.outputs / size)

        def over(index: int, piece: Piece) -> Response | Flight:
            if piece.idle is True:
                return Flight(*free_response(system, piece, gauss_nodes(in_flight)[0]))
            part = forced_response(system, piece, self.count)
            if not resolved:
                return part
            present = system.feedback.within(index, piece.start + piece.length * gauss_nodes(self.count)[0])[0]
            return part._replace(resolvent=_resolvent(part, present, jnp.linalg.inv))

        return tuple(over(index, piece) for index, piece in enumerate(system.feedback.pieces()))

    def assemble(self, prepared: tuple[Response | Flight, ...], feedback: Feedback, inverse: Inverse) -> Array:
        """The operator's matrix, (N, N), with ``inverse`` for the matrices (r·nodes, r·nodes) of the contact."""
        return self._matrix(prepared, feedback, inverse)[0]

    def motion(self, prepared: tuple[Response | Flight, ...], system: DelaySystem, pair: Pair) -> Motion:
        """The motion of a multiplier μ and its state, how far they miss the equations, and the error of |μ|."""
        value, vector, mirrored = pair
        state = jnp.shape(prepared[0].through)[0]
        z, row, turn, feedback = vector[:state], state, rotation(value), system.feedback
        shape = system.output_matrix() / _output_scale(system)
        phases, weights, outputs, contacts = [], [], [], []
        for index, (piece, part) in enumerate(zip(feedback.pieces(), prepared, strict=True)):
            points, weight = self._samples(part)
            phases.append(piece.start + piece.length * points)
            weights.append(piece.length * weight)
            if isinstance(part, Flight):
                outputs.append(part.outputs @ z)
                z = part.through @ z
                continue
            current, delayed = feedback.within(index, phases[-1])
            r = jnp.shape(current)[-1]
            before = vector[row : row + self.count * r].reshape(self.count, r, 2)
            row += self.count * r
            after = before @ turn
            force = (_force(current, after) + _force(delayed, before)).reshape(-1, 2)
            free, forced = part.free @ z, part.forced @ force
            flown, pushed = part.through @ z, part.push @ force
            ends = shape @ jnp.stack([z, flown + pushed])
            z = flown + pushed
            outputs.append(after)
            contacts.append(
                InContact(
                    length=jnp.asarray(piece.length),
                    missed=part.missed,
                    force=jnp.stack([_size(current), _size(delayed)]),
                    unresolved=unresolved(after, ends),
                    unmet=jnp.sum((after.reshape(-1, 2) - free - forced) ** 2),
                    terms=jnp.stack([jnp.sum(flown**2 + pushed**2), jnp.sum(free**2 + forced**2)]),
                )
            )
        every: InContact = jax.tree.map(lambda *parts: jnp.stack(parts), *contacts)
        unmet = jnp.stack([jnp.sum((vector[:state] @ turn - z) ** 2), jnp.sum(every.unmet)])
        split = [part[:state] for part in (vector, mirrored)], [part[state:] for part in (vector, mirrored)]
        held = jnp.stack([jnp.sum(right**2) for right, _ in split])
        condition = jnp.sqrt(held * jnp.stack([jnp.sum(left**2) for _, left in split]))
        return Motion(
            phase=jnp.concatenate(phases),
            weight=jnp.concatenate(weights),
            output=jnp.concatenate(outputs),
            defect=jnp.sqrt(jnp.sum(unmet) / (jnp.sum(held) * jnp.sum(value**2))),
            error=jnp.sum(condition) * estimated_error(system, every, value),
            rounding=condition @ rounding(system, every, unmet, held * jnp.sum(value**2)),
        )

    def _samples(self, part: Response | Flight) -> tuple[np.ndarray, np.ndarray]:
        """Points and weights, on [0, 1], at which the motion over a piece is known."""
        return gauss_nodes(len(part.outputs) if isinstance(part, Flight) else self.count)

    def _matrix(
        self, prepared: tuple[Response | Flight, ...], feedback: Feedback, inverse: Inverse
    ) -> tuple[Array, list[Array]]:
        """The matrix, and the state at the start of every piece as a linear map of the state."""
        pieces = feedback.pieces()
        points = gauss_nodes(self.count)[0]
        contacts = [part for part in prepared if isinstance(part, Response)]
        state = jnp.shape(prepared[0].through)[0]
        block = jnp.shape(contacts[0].forced)[0]
        size = state + block * len(contacts)
        current = jnp.eye(state, size, dtype=jnp.result_type(contacts[0].forced))
        starts, rows, column = [], [], state
        for index, (piece, part) in enumerate(zip(pieces, prepared, strict=True)):
            starts.append(current)
            if isinstance(part, Flight):
                current = part.through @ current
                continue
            now, before = feedback.within(index, piece.start + piece.length * points)
            r = jnp.shape(now)[-1]
            remembered = jnp.pad(_columns(part.forced, before, r), ((0, 0), (column, size - column - block)))
            resolvent = _resolvent(part, now, inverse) if part.resolvent is None else part.resolvent
            # At the first piece the state is what it starts from, and a product with the identity is spared.
            free = jnp.pad(part.free, ((0, 0), (0, size - state))) if index == 0 else part.free @ current
            values = resolvent @ (free + remembered)
            push = _columns(part.push, now, r) @ values
            push = push + jnp.pad(_columns(part.push, before, r), ((0, 0), (column, size - column - block)))
            passed = jnp.pad(part.through, ((0, 0), (0, size - state))) if index == 0 else part.through @ current
            current = passed + push
            rows.append(values)
            column += block
        return jnp.concatenate([current, *rows]), starts


def _output_scale(system: DelaySystem) -> Array:
    return jnp.sqrt(jnp.sum(jnp.asarray(system.outputs) ** 2))


def _resolvent(part: Response, present: Array, inverse: Inverse) -> Array:
    """From the outputs at the nodes that the present force is left out of to those that it makes."""
    looped = _columns(part.forced, present, jnp.shape(present)[-1])
    return inverse(jnp.eye(jnp.shape(looped)[0], dtype=looped.dtype) - looped)


def _columns(matrix: Array, coefficient: Array, r: int) -> Array:
    """matrix · blockdiag(coefficient): (p, q·r) by (q, r, r) → (p, q·r)."""
    if r == 1:
        return matrix * coefficient[:, 0, 0]
    p = jnp.shape(matrix)[0]
    return jnp.einsum("pqb,qbc->pqc", matrix.reshape(p, -1, r), coefficient).reshape(p, -1)


def _size(coefficient: Array) -> Array:
    """Norms of (q, r, r)."""
    return jnp.sqrt(jnp.sum(coefficient**2, axis=(1, 2)))


def _force(coefficient: Array, samples: Array) -> Array:
    """(q, r, r) times (q, r, 2)."""
    if jnp.shape(coefficient)[-1] == 1:
        return coefficient * samples
    return jnp.einsum("qab,qbp->qap", coefficient, samples)
