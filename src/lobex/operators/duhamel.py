"""The monodromy operator with the structure solved exactly and the force a polynomial through Gauss points."""

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
from lobex.operators.answer import Chips, answer_to_chips, answer_to_forces, looped, resolvents
from lobex.operators.elimination import Inverse, pivoted_inverse
from lobex.operators.estimate import InContact, estimated_error, rounding, sizes_of, unresolved, unresolved_force
from lobex.operators.operator import MOST_NODES, MonodromyOperator
from lobex.operators.over_pieces import March, Pieces, marched, matrix_of, size_of_state
from lobex.operators.prepared import Prepared, points_between, prepare
from lobex.operators.response import forced_response, gauss_nodes
from lobex.operators.rows import acting, rows
from lobex.systems.mesh import Mesh, mesh_of
from lobex.systems.system import DelaySystem, Forces
from lobex.systems.traits import FOLLOWING, Traits

_NODES = 40
# Samples of the free vibration over a piece without force, where nobody says how many waves there are: 80 of them.
IN_FLIGHT = 256
_FINEST, _COARSEST = 1e-12, 1e-2


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
        """The monodromy operator; its state is z, and the scaled forces that the past has due."""
        prepared, mesh = self.prepare(system), mesh_of(system)
        pieces = self.respond(prepared, system, pivoted_inverse)
        march = marched(pieces, mesh, jnp.eye(self.size(system), dtype=pieces.onward.dtype))
        parts = _parts(prepared, march)
        outputs = (parts.free + parts.forced).reshape(mesh.pieces, self.count, system.output_size, -1)
        phase, weight, outputs = self._samples(prepared, mesh, parts.flown + parts.pushed, outputs)
        return MonodromyOperator(march.end, phase, weight, _output_scale(system) * outputs)

    def size(self, system: DelaySystem) -> int:
        """N: d + e·nodes per piece to come in which the past has forces due, or 1·nodes where that is a chip."""
        due = 1 if system.chips else system.force_size
        return size_of_state(mesh_of(system), system.state_size, due * self.count)

    def finer(self) -> "Duhamel":
        """The same with half as many nodes again."""
        return replace(self, nodes=self.count + -(-self.count // 2))

    def resolved_radians(self, system: DelaySystem) -> float:
        """π points per wave at the middle of the widest piece, less what convergence takes; any where chosen."""
        if self.nodes is None:
            return np.inf
        return max(2.0 * (self.count - 4), 0.0) / float(np.max(mesh_of(system).length))

    def prepare(
        self, system: DelaySystem, traits: Traits = FOLLOWING, in_flight: int = IN_FLIGHT, samples: int | None = None
    ) -> Prepared:
        """What the structure makes of the past, for scaled forces and outputs: it does not depend on the coefficients.

        Of coefficients that by the ``traits`` of the process do not follow the gain what they do is included. A free
        vibration is sampled ``in_flight`` times, and the structure's kernel, over pieces that are short enough for
        it, ``kernel_samples``.
        """
        size, force = _output_scale(system), _force_scale(system)
        remembered = None if system.remembered is None else system.remembered / size
        scaled = replace(system, inputs=system.inputs / force, outputs=system.outputs / size, remembered=remembered)
        prepared = prepare(scaled, self.count, in_flight, samples)
        if system.chips and not traits.chips_by_gain:
            prepared = replace(prepared, left=None, chips=_left(prepared, mesh_of(system), self._factors(system).met))
        # Forces that delays shorter than a piece bring act within it, and follow the gain.
        if traits.present_by_gain or prepared.recent is not None:
            return prepared
        return replace(prepared, resolvent=resolvents(looped(prepared, self.forces(system)), pivoted_inverse))

    def respond(
        self, prepared: Prepared, system: DelaySystem, inverse: Inverse, forces: Forces | None = None
    ) -> Pieces:
        """What every piece does to the state.

        With ``inverse`` for the matrices (e·q, e·q) of the contact, and ``forces`` of the system where these are known.
        """
        forces, mesh = forces or self.forces(system), mesh_of(system)
        if system.chips:
            chips = self._factors(system)
            left = _left(prepared, mesh, chips.met) if prepared.chips is None else prepared.chips
            return Pieces(answer_to_chips(prepared, system, mesh, forces, chips, inverse), prepared.onward, left)
        answer = answer_to_forces(prepared, system, mesh, forces, inverse)
        if mesh.to_nodes:
            return Pieces(answer, prepared.onward, _left(prepared, mesh, jnp.stack(forces.delayed)))
        assert prepared.left is not None
        readers = _readers(mesh)
        parts = [rows(acts[readers], prepared.left[:, index]) for index, acts in enumerate(forces.delayed)]
        return Pieces(answer, prepared.onward, sum(parts[1:], parts[0]))

    def assemble(self, pieces: Pieces, system: DelaySystem) -> Float[Array, "N N"]:
        """The operator's matrix, (N, N)."""
        return matrix_of(pieces, mesh_of(system))

    def motion(
        self,
        prepared: Prepared,
        pieces: Pieces,
        system: DelaySystem,
        pair: Pair,
        forces: Forces | None = None,
    ) -> Motion:
        """The motion of a multiplier μ and its state, how far they miss the equations, and the error of |μ|."""
        value, vector, mirrored = pair
        d, mesh, forces = system.state_size, mesh_of(system), forces or self.forces(system)
        march = marched(pieces, mesh, vector)
        parts = _parts(prepared, march)
        after = (parts.free + parts.forced).reshape(mesh.pieces, self.count, -1, 2)
        acts = [acting(forces.present, after), march.pushed.reshape(mesh.pieces, self.count, -1, 2)]
        if prepared.recent is not None:
            own = jnp.concatenate([march.starts, march.forces], axis=1)
            for index, coefficient in enumerate(forces.delayed):
                acts.append(rows(coefficient, prepared.recent[:, index] @ own).reshape(jnp.shape(acts[0])))
        unmet_force = march.forces.reshape(jnp.shape(acts[0])) - sum(acts)
        ends = jnp.stack([march.starts, parts.flown + parts.pushed], axis=1)
        shape = system.output_matrix() / _output_scale(system)
        now, later = (sizes_of(outputs) / _scale(system) for outputs in (system.outputs, system.recalled))
        unscaled = _size(forces.present * now), sum(_size(part * later) for part in forces.delayed)
        # What is due may be chips: forces are told in the size of those.
        pushed, due = jnp.sum(march.pushed**2), jnp.sum(march.due)
        size = jnp.where(pushed > 0, due / jnp.where(pushed > 0, pushed, 1.0), 1.0)
        contacts = InContact(
            length=mesh.length,
            missed=prepared.missed,
            force=jnp.stack(jnp.broadcast_arrays(*unscaled), axis=1),
            unresolved_force=mesh.length[:, None] * jax.vmap(unresolved_force)(unmet_force + sum(acts)),
            unresolved=jax.vmap(unresolved)(after, jnp.einsum("rd,mkdp->mkrp", shape, ends)),
            unmet=size * _squares(unmet_force),
            terms=jnp.stack([_squares(parts.flown) + _squares(parts.pushed), size * sum(map(_squares, acts))], axis=1),
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

    def path(self, pieces: Pieces, system: DelaySystem, state: Float[Array, " N"]) -> Float[AnyArray, "M terms r"]:
        """y over the period after a state (N,), between nodes too: Chebyshev terms of every piece, (M, terms, r)."""
        march = marched(pieces, mesh_of(system), state[:, None])
        known = jnp.concatenate([march.starts, march.forces], axis=1)[..., 0]
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

    def forces(self, system: DelaySystem, coefficients: Forces | None = None) -> Forces:
        """The coefficients at the nodes of every piece, (M, q, e, r), for scaled forces and outputs, from those of
        ``coefficients`` where they are known.
        """
        found = self.coefficients(system) if coefficients is None else coefficients
        return jax.tree.map(lambda part: _scale(system) * part, found)

    def coefficients(self, system: DelaySystem) -> Forces:
        """The coefficients at the nodes of every piece, (M, q, e, r)."""
        mesh = mesh_of(system)

        def over(start: Number, length: Number) -> Forces:
            return system.at_nodes(start, length, self.count)

        return jax.vmap(over)(mesh.start, mesh.length)

    def _factors(self, system: DelaySystem) -> Chips:
        """Forces per chip and chips per output of every delay at the nodes of every piece, scaled as ``forces``."""
        mesh, points = mesh_of(system), gauss_nodes(self.count)[0]

        def over(start: Number, length: Number) -> list[tuple[Float[AnyArray, "q e 1"], Float[AnyArray, "q 1 m"]]]:
            return [chip.factors(start + length / 2, start + length * points) for chip in system.chips]

        pushes, met = zip(*jax.vmap(over)(mesh.start, mesh.length), strict=True)
        return Chips(_force_scale(system) * jnp.stack(pushes), _output_scale(system) * jnp.stack(met))


class _Parts(NamedTuple):
    """What pieces make of z at their start and of the forces in them, apart: outputs at the nodes, and z at the end."""

    free: Float[Array, "M qr p"]
    forced: Float[Array, "M qr p"]
    flown: Float[Array, "M d p"]
    pushed: Float[Array, "M d p"]


def _parts(prepared: Prepared, march: March) -> _Parts:
    d, made = prepared.state, prepared.made
    free, forced = made[..., :d] @ march.starts, made[..., d:] @ march.forces
    return _Parts(free[:, :-d], forced[:, :-d], free[:, -d:], forced[:, -d:])


def _readers(mesh: Mesh) -> np.ndarray:
    """In which piece acts what each of ``Mesh.links`` leaves."""
    return np.array([(link.piece + link.later) % mesh.pieces for link in mesh.links])


def _left(prepared: Prepared, mesh: Mesh, met: Float[AnyArray, "K M q c m"]) -> Float[AnyArray, "L qc dqe"]:
    """What is due by each of ``Mesh.links``, from node to node, where each delay brings so much of outputs."""
    assert prepared.left is not None
    return rows(met[np.array([link.delay for link in mesh.links]), _readers(mesh)], prepared.left[:, 0])


def _output_scale(system: DelaySystem) -> Float[Array, ""]:
    """|C|: outputs divided by it are of the size of the state."""
    return jnp.sqrt(jnp.sum(jnp.asarray(system.outputs) ** 2))


def _force_scale(system: DelaySystem) -> Float[Array, ""]:
    """|E| T: forces times it are of the size of the state that they make in a period."""
    return jnp.sqrt(jnp.sum(jnp.asarray(system.inputs) ** 2)) * system.period


def _scale(system: DelaySystem) -> Float[Array, ""]:
    """Of a coefficient, from outputs to forces."""
    return _output_scale(system) * _force_scale(system)


def _squares(parts: Float[AnyArray, "M ..."]) -> Float[Array, " M"]:
    """Sums of squares over all axes but the first."""
    return jnp.sum(parts**2, axis=tuple(range(1, parts.ndim)))


def _size(coefficient: Float[AnyArray, "M q e r"]) -> Float[Array, "M q"]:
    """Norms of (M, q, e, r)."""
    return jnp.sqrt(jnp.sum(coefficient**2, axis=(2, 3)))
