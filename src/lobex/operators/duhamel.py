"""The monodromy operator with the structure solved exactly and the force a polynomial through Gauss points."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex import _checks
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.floquet.power import Pair, rotation
from lobex.operators.elimination import pivoted_inverse
from lobex.operators.estimate import InContact, estimated_error, rounding, sizes_of, unresolved, unresolved_force
from lobex.operators.operator import MOST_NODES, MonodromyOperator
from lobex.operators.prepared import Prepared, points_between, prepare
from lobex.operators.response import forced_response, gauss_nodes
from lobex.systems.mesh import Mesh, mesh_of
from lobex.systems.system import DelaySystem, Forces

Inverse = Callable[[Float[Array, "n n"]], Float[Array, "n n"]]

_NODES = 40
# Samples of the free vibration over a piece without force, where nobody says how many waves there are: 80 of them.
IN_FLIGHT = 256
_FINEST, _COARSEST = 1e-12, 1e-2
_FEW = 4


class Motion(NamedTuple):
    """The motion that a multiplier and its state stand for, over the period after the state.

    Attributes:
        phase: sampling phases t/T, (S,).
        weight: quadrature weights, (S,), summing to 1.
        output: y at the samples, real and imaginary part, (S, r, 2).
        defect: by how much the multiplier misses the discrete equations, relative to the state and to |μ|.
        error: estimated relative error of |μ| by the nodes, infinite where they might have missed a larger one.
        rounding: that by the arithmetic, defect included.
    """

    phase: Float[Array, " S"]
    weight: Float[Array, " S"]
    output: Float[Array, "S r 2"]
    defect: Float[Array, ""]
    error: Float[Array, ""]
    rounding: Float[Array, ""]


@pytree(static=("nodes", "tolerance"))
class Duhamel:
    """Collocation of the contact force alone, at Gauss points; what it does to the structure is exact.

    Between contact samples the force is a polynomial, and Duhamel's integral of it over every mode is exact.
    Stiff modes thus need no nodes of their own, and Gauss points make the multipliers converge twice as fast
    as the force does (superconvergence of collocation at Gauss points: Chatelin, Spectral Approximation of
    Linear Operators, 1983, ch. 6). The pieces end at the jumps of the coefficients, and those without force
    are passed exactly. What does not depend on the coefficients is separate: ``prepare`` is the structure's part,
    ``respond`` and ``assemble`` that of the forces.

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
        """The monodromy operator; its state is z as long ago as the system remembers, and the scaled forces since."""
        prepared, mesh = self.prepare(system), mesh_of(system)
        respond = self.respond(prepared, system, pivoted_inverse)
        march = _marched(prepared, respond, jnp.eye(jnp.shape(respond)[-1], dtype=respond.dtype))
        parts = _parts(prepared, march)
        outputs = (parts.free + parts.forced).reshape(mesh.pieces, self.count, system.output_size, -1)
        phase, weight, outputs = self._samples(prepared, mesh, parts.flown + parts.pushed, outputs)
        return MonodromyOperator(march.end, phase, weight, _output_scale(system) * outputs)

    def size(self, system: DelaySystem) -> int:
        """N: d + e·nodes per piece that the longest delay reaches back."""
        return system.state_size + system.force_size * self.count * mesh_of(system).history

    def finer(self) -> "Duhamel":
        """The same with half as many nodes again."""
        return replace(self, nodes=self.count + -(-self.count // 2))

    def resolved_radians(self, system: DelaySystem) -> float:
        """π points per wave at the middle of the widest piece, less what convergence takes; any where chosen."""
        if self.nodes is None:
            return np.inf
        return max(2.0 * (self.count - 4), 0.0) / float(np.max(mesh_of(system).length))

    def prepare(self, system: DelaySystem, resolved: bool = False, in_flight: int = IN_FLIGHT) -> Prepared:
        """What the structure makes of the past, for scaled forces and outputs: it does not depend on the coefficients.

        With ``resolved``, for a gain that acts on delayed forces only, the present force is included. A free
        vibration is sampled ``in_flight`` times.
        """
        size, force = _output_scale(system), _force_scale(system)
        remembered = None if system.remembered is None else system.remembered / size
        scaled = replace(system, inputs=system.inputs / force, outputs=system.outputs / size, remembered=remembered)
        prepared = prepare(scaled, self.count, in_flight)
        # Forces that delays shorter than a piece bring act within it, and follow the gain.
        if not resolved or prepared.recent is not None:
            return prepared
        return replace(prepared, resolvent=_resolvents(prepared, self.forces(system), pivoted_inverse))

    def respond(
        self, prepared: Prepared, system: DelaySystem, inverse: Inverse, forces: Forces | None = None
    ) -> Float[Array, "M qe N"]:
        """The forces at the nodes of every piece that its past makes, (M, e·q, N).

        With ``inverse`` for the matrices (e·q, e·q) of the contact, and ``forces`` of the system where these are known.
        """
        forces = forces or self.forces(system)
        driven = _rows(forces.present, prepared.free)
        for index, coefficient in enumerate(forces.delayed):
            driven = driven + _rows(coefficient, prepared.remembered[:, index])
        resolvent = _resolvents(prepared, forces, inverse) if prepared.resolvent is None else prepared.resolvent
        return resolvent @ driven

    def assemble(self, prepared: Prepared, respond: Float[Array, "M qe N"]) -> Float[Array, "N N"]:
        """The operator's matrix, (N, N); a product with the identity is spared."""
        size = jnp.shape(respond)[-1]
        first = _moved_on(jnp.eye(size, dtype=respond.dtype), prepared.advance[0], respond[0])
        if len(respond) == 1:
            return first

        def over(
            past: Float[Array, "N N"], piece: tuple[Float[Array, "qe N"], Float[Array, "d N"]]
        ) -> tuple[Float[Array, "N N"], None]:
            return _moved_on(past, piece[1] @ past, piece[0] @ past), None

        return jax.lax.scan(over, first, (respond[1:], prepared.advance[1:]), unroll=_unrolled(respond))[0]

    def motion(
        self,
        prepared: Prepared,
        respond: Float[Array, "M qe N"],
        system: DelaySystem,
        pair: Pair,
        forces: Forces | None = None,
    ) -> Motion:
        """The motion of a multiplier μ and its state, how far they miss the equations, and the error of |μ|."""
        value, vector, mirrored = pair
        d, mesh, forces = system.state_size, mesh_of(system), forces or self.forces(system)
        march = _marched(prepared, respond, vector)
        parts = _parts(prepared, march)
        after = (parts.free + parts.forced).reshape(mesh.pieces, self.count, -1, 2)
        recalled = parts.recalled.reshape(mesh.pieces, len(forces.delayed), self.count, -1, 2)
        acting = [_act(forces.present, after)]
        acting += [_act(coefficient, recalled[:, k]) for k, coefficient in enumerate(forces.delayed)]
        unmet_force = march.forces.reshape(jnp.shape(acting[0])) - sum(acting)
        ends = jnp.stack([parts.start, parts.flown + parts.pushed], axis=1)
        shape = system.output_matrix() / _output_scale(system)
        now, later = (sizes_of(outputs) / _scale(system) for outputs in (system.outputs, system.recalled))
        unscaled = _size(forces.present * now), sum(_size(part * later) for part in forces.delayed)
        contacts = InContact(
            length=mesh.length,
            missed=prepared.missed,
            force=jnp.stack(jnp.broadcast_arrays(*unscaled), axis=1),
            unresolved_force=mesh.length[:, None] * jax.vmap(unresolved_force)(unmet_force + sum(acting)),
            unresolved=jax.vmap(unresolved)(after, jnp.einsum("rd,mkdp->mkrp", shape, ends)),
            unmet=_squares(unmet_force),
            terms=jnp.stack([_squares(parts.flown) + _squares(parts.pushed), sum(map(_squares, acting))], axis=1),
        )
        missed = march.end - vector @ rotation(value)
        unmet = jnp.stack([jnp.sum(missed[:d] ** 2), jnp.sum(missed[d:] ** 2) + jnp.sum(contacts.unmet)])
        held = jnp.stack([jnp.sum(vector[:d] ** 2), jnp.sum(vector[d:] ** 2)])
        condition = jnp.sqrt(held * jnp.stack([jnp.sum(mirrored[:d] ** 2), jnp.sum(mirrored[d:] ** 2)]))
        phase, weight, output = self._samples(prepared, mesh, parts.flown + parts.pushed, after)
        return Motion(
            phase=phase,
            weight=weight,
            output=output,
            defect=jnp.sqrt(jnp.sum(unmet) / (jnp.sum(held) * jnp.sum(value**2))),
            error=jnp.sum(condition) * estimated_error(system, contacts, value),
            rounding=condition @ rounding(system, contacts, unmet, held * jnp.sum(value**2)),
        )

    def path(
        self, prepared: Prepared, respond: Float[Array, "M qe N"], system: DelaySystem, state: Float[Array, " N"]
    ) -> Float[AnyArray, "M terms r"]:
        """y over the period after a state (N,), between nodes too: Chebyshev terms of every piece, (M, terms, r)."""
        march = _marched(prepared, respond, state[:, None])
        known = jnp.concatenate([_parts(prepared, march).start, march.forces], axis=1)[..., 0]
        points = points_between(self.count)
        synthesis = np.linalg.inv(np.polynomial.chebyshev.chebvander(2 * points - 1, len(points) - 1))
        seen = replace(system, inputs=system.inputs / _force_scale(system), remembered=None)

        def over(length: Number, known: Float[Array, " known"]) -> Float[AnyArray, "terms r"]:
            outputs = forced_response(seen, length, self.count, points).recalled @ known
            return synthesis @ outputs.reshape(len(points), -1)

        return jax.vmap(over)(mesh_of(system).length, known)

    def _samples(
        self, prepared: Prepared, mesh: Mesh, landed: Float[Array, "M d p"], outputs: Float[Array, "M q r p"]
    ) -> tuple[Float[Array, " S"], Float[Array, " S"], Float[Array, "S r p"]]:
        """Phases, weights, and outputs (S, r, …) from those at the nodes, (M, q, r, …), and of the free vibrations."""

        def over(
            start: Float[AnyArray, " M"], length: Float[AnyArray, " M"], samples: Float[Array, "M q r p"]
        ) -> tuple[Float[AnyArray, "M q"], Float[AnyArray, "M q"]]:
            points, weights = gauss_nodes(jnp.shape(samples)[1])
            return start[:, None] + length[:, None] * points, length[:, None] * weights

        parts = [(*over(mesh.start, mesh.length, outputs), outputs)]
        if prepared.flights is not None and mesh.gap is not None:
            flown = jnp.einsum("msrd,mdn->msrn", prepared.flights, landed)
            parts.append((*over(mesh.start + mesh.length, mesh.gap, flown), flown))
        # Piece by piece, each with what follows it.
        phase, weight, output = (jnp.concatenate(part, axis=1) for part in zip(*parts, strict=True))
        return phase.ravel(), weight.ravel(), output.reshape(-1, *jnp.shape(output)[2:])

    def forces(self, system: DelaySystem) -> Forces:
        """The coefficients at the nodes of every piece, (M, q, e, r), for scaled forces and outputs."""
        mesh, points = mesh_of(system), gauss_nodes(self.count)[0]

        def over(start: Number, length: Number) -> Forces:
            return system.within(start + length / 2, start + length * points)

        return jax.tree.map(lambda part: _scale(system) * part, jax.vmap(over)(mesh.start, mesh.length))


class _March(NamedTuple):
    """The past of every piece, (M, N, …), the forces at its nodes, (M, q·e, …), and the past at the end, (N, …)."""

    pasts: Float[Array, "M N p"]
    forces: Float[Array, "M qe p"]
    end: Float[Array, "N p"]


def _marched(prepared: Prepared, respond: Float[Array, "M qe N"], past: Float[Array, "N p"]) -> _March:
    """March a past over the period, piece by piece."""

    def over(
        past: Float[Array, "N p"], piece: tuple[Float[Array, "qe N"], Float[Array, "d N"]]
    ) -> tuple[Float[Array, "N p"], tuple[Float[Array, "N p"], Float[Array, "qe p"]]]:
        force = piece[0] @ past
        return _moved_on(past, piece[1] @ past, force), (past, force)

    steps = respond, prepared.advance
    end, (pasts, forces) = jax.lax.scan(over, past, steps, unroll=_unrolled(respond))
    return _March(pasts, forces, end)


class _Parts(NamedTuple):
    """What is known of a march, piece by piece: of z at the start, of z at the end, and at the nodes, from the past and
    from the forces of the same piece apart.
    """

    free: Float[Array, "M qr p"]
    forced: Float[Array, "M qr p"]
    recalled: Float[Array, "M Kqm p"]
    start: Float[Array, "M d p"]
    flown: Float[Array, "M d p"]
    pushed: Float[Array, "M d p"]


def _parts(prepared: Prepared, march: _March) -> _Parts:
    outputs, first, landed, advance = prepared.starts
    past, force = prepared.past[:, :advance] @ march.pasts, prepared.force @ march.forces
    end = outputs + prepared.sizes[3]
    recalled = past[:, outputs:first]
    if jnp.shape(force)[1] > end:
        recalled = recalled + force[:, end:]
    return _Parts(
        past[:, :outputs], force[:, :outputs], recalled, past[:, first:landed], past[:, landed:], force[:, outputs:end]
    )


def _unrolled(pieces: Float[Array, "M _ _"]) -> bool | int:
    """A loop over few pieces is written out."""
    return jnp.shape(pieces)[0] <= _FEW or 1


def _moved_on(
    past: Float[Array, "N p"], oldest: Float[Array, "d p"], force: Float[Array, "qe p"]
) -> Float[Array, "N p"]:
    """The past one piece later."""
    return jnp.concatenate([oldest, past[jnp.shape(oldest)[0] + jnp.shape(force)[0] :], force])


def _resolvents(prepared: Prepared, forces: Forces, inverse: Inverse) -> Float[Array, "M qe qe"]:
    """From the forces at the nodes without those that they themselves bring about to all of them, (M, q·e, q·e)."""
    looped = _rows(forces.present, prepared.forced)
    if prepared.recent is not None:
        for index, coefficient in enumerate(forces.delayed):
            looped = looped + _rows(coefficient, prepared.recent[:, index])
    return jax.vmap(inverse)(jnp.eye(jnp.shape(looped)[-1], dtype=looped.dtype) - looped)


def _output_scale(system: DelaySystem) -> Float[Array, ""]:
    """|C|: outputs divided by it are of the size of the state."""
    return jnp.sqrt(jnp.sum(jnp.asarray(system.outputs) ** 2))


def _force_scale(system: DelaySystem) -> Float[Array, ""]:
    """|E| T: forces times it are of the size of the state that they make in a period."""
    return jnp.sqrt(jnp.sum(jnp.asarray(system.inputs) ** 2)) * system.period


def _scale(system: DelaySystem) -> Float[Array, ""]:
    """Of a coefficient, from outputs to forces."""
    return _output_scale(system) * _force_scale(system)


def _rows(coefficient: Float[AnyArray, "M q e r"], matrix: Float[Array, "M qr p"]) -> Float[AnyArray, "M qe p"]:
    """blockdiag(coefficient) · matrix: (M, q, e, r) by (M, q·r, p) → (M, q·e, p)."""
    pieces, q, e, r = jnp.shape(coefficient)
    return _act(coefficient, matrix.reshape(pieces, q, r, -1)).reshape(pieces, q * e, -1)


def _act(coefficient: Float[AnyArray, "M q e r"], samples: Float[Array, "M q r p"]) -> Float[AnyArray, "M q e p"]:
    """(M, q, e, r) times (M, q, r, p): as sums, since XLA is slow at products of a few rows."""
    parts = [coefficient[..., j, None] * samples[:, :, j, None] for j in range(jnp.shape(samples)[2])]
    return sum(parts[1:], parts[0])


def _squares(parts: Float[AnyArray, "M ..."]) -> Float[Array, " M"]:
    """Sums of squares over all axes but the first."""
    return jnp.sum(parts**2, axis=tuple(range(1, parts.ndim)))


def _size(coefficient: Float[AnyArray, "M q e r"]) -> Float[Array, "M q"]:
    """Norms of (M, q, e, r)."""
    return jnp.sqrt(jnp.sum(coefficient**2, axis=(2, 3)))
