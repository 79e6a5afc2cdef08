"""Changes of stability polished in brackets: gain, frequency, kind, tie and error, with the nodes that each needs."""

from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, Real

from lobex._batches import in_batches, over_few, together
from lobex._compiled import either_way
from lobex._shapes import Number
from lobex.floquet import dense, power
from lobex.floquet.chatter import carrier_frequency
from lobex.floquet.dense import Triple
from lobex.floquet.power import Pair, as_pair
from lobex.grids.choice import tolerance_of
from lobex.grids.evaluation import dominant_at_points
from lobex.grids.node_counts import node_counts
from lobex.grids.one_size import prepared_at
from lobex.grids.refinement import SPEEDS
from lobex.limits.growth import CONVERGED, SQUARINGS, Change, Family, find_zero_growth
from lobex.limits.scan import Brackets
from lobex.operators.duhamel import Duhamel
from lobex.operators.elimination import inverse, pivoted_inverse
from lobex.operators.operator import Method
from lobex.operators.over_pieces import Pieces, marched
from lobex.operators.response import samples_in_flight
from lobex.processes.process import Process
from lobex.results.codes import Kind
from lobex.systems.mesh import mesh_of
from lobex.systems.traits import traits_of

# A second multiplier is in a tie where its log|μ| at the limit is above minus this.
TIE = 1e-7
_SAME = 1e-9
# What a change gets: gain, growth and slope, its label, and the residual.
_RESULTS = 8
# Work per change, lightest first: squarings of the operator, or 0 for the dense solver.
_EFFORTS = (SQUARINGS, 24, 0)
_RESIDUAL = 1e-9
# Changes that are settled side by side on a core.
_TOGETHER = 8


class Label(NamedTuple):
    """Of a change: chatter frequency (Hz), kind, |μ| of the strongest multiplier beside the dominant pair, and the
    estimated relative error of |μ| (NaN where the method gives none)."""

    frequency: Float[Array, " *lanes"]
    kind: Int[Array, " *lanes"]
    rival: Float[Array, " *lanes"]
    error: Float[Array, " *lanes"]


class Changes(NamedTuple):
    """Gains at which stability changes, by speed and then by gain, each (e,).

    Attributes:
        lane: number of the speed.
        gain: NaN where it did not converge.
        frequency: chatter frequency, Hz.
        kind: member of ``Kind``.
        tie: whether a second multiplier is on the unit circle as well.
        error: estimated error of the gain.
    """

    lane: np.ndarray
    gain: np.ndarray
    frequency: np.ndarray
    kind: np.ndarray
    tie: np.ndarray
    error: np.ndarray


def polished(
    process: Process, method: Method, speeds: np.ndarray, brackets: Brackets, quickly: bool = False
) -> Changes:
    """The changes in brackets at speeds (n,), Hz, of all lanes side by side, with programs compiled as for the scan;
    call in the scope of float64.
    """
    count = len(brackets.lane)
    in_flight = samples_in_flight(process.system(np.min(speeds), 0.0))
    parts = [np.full(count, np.nan) for _ in range(_RESULTS)]
    gain, growth, slope, frequency, kind, rival, error, residual = parts
    sized, size, last = _sizes(process, method, speeds, brackets.lane)
    guess = brackets.guess.copy()
    for index, one in enumerate(sized):
        left = here = np.flatnonzero(size == index)
        for effort in _EFFORTS if here.size else ():
            arrays = speeds[brackets.lane[left]], *(a[left] for a in (*brackets[1:5], guess))
            results = in_batches(
                partial(_polished_batch, quickly, process, one, effort, in_flight), arrays, SPEEDS, first=_TOGETHER
            )
            for target, result in zip(parts, results, strict=True):
                target[left] = result
            left = left[~((np.abs(growth[left]) < CONVERGED) & (residual[left] < _RESIDUAL))]
            if not left.size:
                break
        coarse = here[(error[here] > tolerance_of(method)) & (index < last[here])]
        size[coarse], guess[coarse] = index + 1, np.where(np.isfinite(gain[coarse]), gain[coarse], guess[coarse])
    converged = np.abs(growth) < CONVERGED
    if np.isnan(error[converged]).any():
        error[converged] = _from_finer(process, method, speeds[brackets.lane[converged]], gain[converged])
    with np.errstate(divide="ignore", invalid="ignore"):
        tie, moved = np.log(rival) > -TIE, np.abs(error / slope)
    return Changes(brackets.lane, np.where(converged, gain, np.nan), frequency, kind, tie & converged, moved)


def _sizes(
    process: Process, method: Method, speeds: np.ndarray, lane: np.ndarray
) -> tuple[list[Method], np.ndarray, np.ndarray]:
    """The method with each size in turn, and which of them changes in lanes (e,) begin and end with, (e,) each."""
    if not isinstance(method, Duhamel):
        return [method], np.zeros(len(lane), dtype=int), np.zeros(len(lane), dtype=int)
    points = np.bincount(lane, minlength=len(speeds))
    sizes, first, last = node_counts(process, method, speeds, points, np.min, method.tolerance)
    return [replace(method, nodes=nodes) for nodes in sizes], first[lane], last[lane]


def _from_finer(process: Process, method: Method, speeds: np.ndarray, gains: np.ndarray) -> np.ndarray:
    """What a finer discretisation makes of |μ| = 1."""
    with np.errstate(divide="ignore"):
        return np.abs(np.log(np.abs(dominant_at_points(process, speeds, gains, method.finer()).multiplier)))


def _polished_batch(
    quickly: bool,
    process: Process,
    method: Method,
    effort: int,
    in_flight: int,
    count: int,
    speed: np.ndarray,
    low: np.ndarray,
    *others: Any,
) -> tuple[Real[Array, " p"], ...]:
    # The scan has compiled this for as many speeds.
    prepared = None
    if isinstance(method, Duhamel):
        prepared = prepared_at[quickly](process, method, speed, low[0], count, traits_of(process), in_flight)
    return _POLISHED[quickly](process, method, effort, count, prepared, speed, low, *others, densely=effort == 0)


def _polished(
    process: Process,
    method: Method,
    squarings: int | Int[Array, ""],
    count: Int[Array, ""],
    prepared: Any,
    speed: Float[Array, " p"],
    low: Float[Array, " p"],
    high: Float[Array, " p"],
    start: Float[Array, " p"],
    end: Float[Array, " p"],
    guess: Float[Array, " p"],
    densely: bool,
) -> tuple[Real[Array, " p"], ...]:
    def one(
        prepared: Any,
        speed: Float[Array, ""],
        low: Float[Array, ""],
        high: Float[Array, ""],
        start: Float[Array, ""],
        end: Float[Array, ""],
        guess: Float[Array, ""],
    ) -> tuple[Real[Array, ""], ...]:
        family = _family(process, method, prepared, speed, densely)
        found = find_zero_growth(family, low, high, (start, end), guess, squarings, densely)
        gain = jnp.where(jnp.isnan(found.gain), low, found.gain)
        label = _label(process, method, prepared, found.matrix, found.triple, speed, gain, squarings, densely)
        return found.gain, found.growth, found.slope, *label, found.residual

    return over_few(one, together(len(speed), _TOGETHER), count, prepared, speed, low, high, start, end, guess)


_POLISHED = either_way(_polished, "densely")


def _family(process: Process, method: Method, prepared: Any, speed: Number, densely: bool) -> Family:
    if not isinstance(method, Duhamel):

        def whole(gain: Number) -> tuple[Float[Array, "N N"], Change]:
            def made(gain: Number) -> Float[Array, "N N"]:
                return method.operator(process.system(speed, gain)).matrix

            matrix, change = jax.jvp(made, (gain,), (jnp.ones_like(gain),))
            return matrix, lambda vectors: change @ vectors

        return whole
    solve = pivoted_inverse if densely else inverse

    def assembled(gain: Number) -> tuple[Float[Array, "N N"], Change]:
        def responded(gain: Number) -> Pieces:
            system = process.system(speed, gain)
            mine = method.prepare(system) if prepared is None else prepared
            return method.respond(mine, system, solve)

        system = process.system(speed, gain)
        pieces, change = jax.jvp(responded, (gain,), (jnp.ones_like(gain),))

        # The pieces' changes act on few vectors, which is less than to assemble that of the operator.
        def along(vectors: Float[Array, "N p"]) -> Float[Array, "N p"]:
            return jax.jvp(lambda pieces: marched(pieces, mesh_of(system), vectors).end, (pieces,), (change,))[1]

        return method.assemble(pieces, system), along

    return assembled


def operator_family(process: Process, method: Method, speed: Number, gain: Number) -> tuple[Any, Family]:
    """What a method prepares at a speed, once for all gains, and the operator's matrix as a function of the gain."""
    prepared, traits = None, traits_of(process)
    if isinstance(method, Duhamel) and not traits.structure_by_gain:
        prepared = method.prepare(process.system(speed, gain), traits)
    return prepared, _family(process, method, prepared, speed, densely=True)


def _label(
    process: Process,
    method: Method,
    prepared: Any,
    matrix: Float[Array, "N N"],
    triple: Triple,
    speed: Number,
    gain: Number,
    squarings: int | Int[Array, ""],
    densely: bool,
) -> Label:
    """What goes on at one limit."""
    system, value = process.system(speed, gain), triple.value
    if isinstance(method, Duhamel):
        pair = Pair(*map(as_pair, (value, triple.right, triple.left / (triple.left @ triple.right))))
        prepared = method.prepare(system) if prepared is None else prepared
        forces = method.forces(system)
        pieces = method.respond(prepared, system, pivoted_inverse if densely else inverse, forces)
        motion = method.motion(prepared, pieces, system, pair, forces)
        frequency = carrier_frequency(motion.phase, motion.weight, motion.output, system.period, as_pair(value))
        error = motion.error + motion.rounding
    else:
        frequency = method.operator(system).chatter_frequency(system.period, value, triple.right)
        error = jnp.full_like(gain, jnp.nan)
    real = jnp.abs(value.imag) <= _SAME * jnp.abs(value)
    kind = jnp.where(real, jnp.where(value.real < 0, Kind.FLIP, Kind.FOLD), Kind.HOPF)
    return Label(frequency, kind, _rival(matrix, triple, real, squarings, densely), error)


def _rival(
    matrix: Float[Array, "N N"], triple: Triple, real: Bool[Array, ""], squarings: int | Int[Array, ""], densely: bool
) -> Float[Array, ""]:
    """|μ| of the strongest multiplier beside the dominant one and its conjugate."""
    value, right, left = triple
    if densely:
        others = dense.all_multipliers(matrix)
        same = jnp.minimum(jnp.abs(others - value), jnp.abs(others - value.conj())) <= _SAME * jnp.abs(value)
        return jnp.max(jnp.where(same, 0.0, jnp.abs(others)))
    part = (value / (left @ right)) * (right[:, None] * left)
    rest = matrix - jnp.where(real, 1.0, 2.0) * part.real
    pair = power.pair_by_squaring(rest, squarings)
    return jnp.sqrt(jnp.sum(pair.value**2))


def label_densely(process: Process, method: Method, speed: Number, gain: Number) -> Label:
    """``Label`` of one point by the dense solver, for use under a caller's own transformations."""
    prepared, family = operator_family(process, method, speed, gain)
    matrix, _ = family(gain)
    triple, none = dense.triple_by_eigensolver(matrix), jnp.zeros((), int)
    return _label(process, method, prepared, matrix, triple, speed, gain, none, densely=True)
