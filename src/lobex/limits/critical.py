"""The critical gain of any process: a scan brackets every crossing of max|μ| = 1, Newton's method polishes it."""

import time
import warnings
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from lobex import _checks
from lobex.floquet import dense
from lobex.floquet.chatter import chatter_frequency
from lobex.grids.evaluation import dominant_at_points, dominant_over_grid
from lobex.grids.resolution import oddities
from lobex.grids.sweep import SweepWarning
from lobex.limits.batches import in_batches
from lobex.limits.growth import Crossing, find_crossing, growth, growth_and_slope
from lobex.limits.hidden import hidden_crossings
from lobex.operators.operator import Method
from lobex.processes.process import Process, check_gain, check_process, check_speed
from lobex.results.description import describe
from lobex.results.limit import Kind, Limit, Status
from lobex.verbs import DEFAULT_METHOD, check_method

Array = Any

_REFINEMENTS = 2
_PARTS = 8
# A polished limit leaves log max|μ| below this; a second multiplier is in a tie within the wider one.
_CONVERGED = 1e-9
_TIE = 1e-7


def critical_gain(
    process: Process,
    speed: Any,
    bounds: tuple[Any, Any],
    method: Method = DEFAULT_METHOD,
    *,
    scan: int = 65,
    progress: bool = False,
) -> Limit:
    """The lowest gain within bounds at which a process turns from stable to unstable, per speed.

    A scan of ``scan`` equally spaced gains brackets the sign changes of log max|μ|; cells in which the
    neighbours' slopes point across zero are divided further. Newton's method with the derivative of the
    dominant multiplier then polishes every crossing, of all speeds side by side, within its bracket and in a
    fixed number of steps. An instability that begins and ends between two scanned gains without showing in
    the slopes beside it is missed: take a finer scan.

    Under ``jit``, ``grad`` or ``vmap`` the lowest crossing alone is found, and ``gain`` carries the
    derivative by the implicit function theorem with respect to speed and every number of the process;
    ``intervals`` and ``error`` are NaN there.

    Args:
        process: a process, such as ``Rub(modes)``.
        speed: speeds, Hz (revolutions per second), (n,) or one number.
        bounds: lowest and highest gain, in the units of the process' gain.
        method: ``Chebyshev(…)`` or ``SemiDiscretization(…)``.
        scan: number of gains in the scan.
        progress: show a progress bar on standard error.

    Returns:
        A ``Limit`` over the speeds. Where no limit lies in the bounds, ``gain`` is NaN and ``status`` says why.

    Raises:
        ValueError: for speeds that are not positive and finite, bounds that are not two increasing gains that
            the process can have, or a scan of fewer than 3 gains.

    Warns:
        SweepWarning: when the method's samples are too few to follow the first mode at the lowest speed, or when
            all speeds lie above every lobe.
    """
    check_process(process)
    check_method(method)
    scan = _checks.integer("scan", scan, 3)
    if np.ndim(bounds) != 1 or len(bounds) != 2:
        raise ValueError(f"bounds = {bounds!r} must be two gains, the lowest and the highest")
    speed = speed if _checks.is_traced(speed) else np.asarray(speed)
    if np.ndim(speed) > 1 or np.size(speed) == 0:
        raise ValueError(f"speed has shape {np.shape(speed)}; give one speed or a list of them")
    check_speed(process, speed)
    check_gain(process, bounds)
    if float(bounds[0]) >= float(bounds[1]):
        raise ValueError(f"bounds = {tuple(map(float, bounds))} must be increasing; give the lowest gain first")
    gains = np.linspace(float(bounds[0]), float(bounds[1]), scan)
    if any(map(_checks.is_traced, jax.tree.leaves((process, speed)))):
        return _traced(process, jnp.atleast_1d(speed), gains, method)
    begun = time.perf_counter()
    speeds = np.atleast_1d(np.asarray(speed, dtype=np.float64))
    for message in oddities(process, method, float(speeds.min()), float(gains[-1])):
        warnings.warn(message, SweepWarning, stacklevel=2)
    with jax.enable_x64(True):
        process = jax.tree.map(lambda leaf: np.asarray(leaf, dtype=np.float64), process)
        parts = _search(process, speeds, gains, method, progress)
    return _limit(process, speeds, gains, method, time.perf_counter() - begun, **parts)


def _limit(process: Process, speeds: Array, gains: np.ndarray, method: Method, seconds: float, **parts: Array) -> Limit:
    return Limit(
        speed=speeds,
        bounds=(float(gains[0]), float(gains[-1])),
        quantity=process.gain,
        speed_unit=process.speed_unit,
        process=describe(process),
        method=describe(method),
        seconds=seconds,
        **parts,
    )


def _search(
    process: Process, speeds: np.ndarray, gains: np.ndarray, method: Method, progress: bool
) -> dict[str, np.ndarray]:
    scanned = np.abs(dominant_over_grid(process, speeds, gains, method, progress).multiplier)
    lane, gain, value = _refine(process, speeds, gains, method, _log(scanned))
    opening = np.flatnonzero((lane[1:] == lane[:-1]) & (value[1:] * value[:-1] < 0))
    ends = (value[opening], value[opening + 1])
    found = _polish(process, speeds[lane[opening]], gain[opening], gain[opening + 1], ends, method)
    converged = np.abs(found.growth) < _CONVERGED
    crossings = np.where(converged, found.gain, np.nan)

    first = np.searchsorted(lane, np.arange(len(speeds)))
    stable = value[first] < 0
    lowest = np.searchsorted(lane[opening], np.arange(len(speeds)))
    count = np.bincount(lane[opening], minlength=len(speeds))
    has = stable & (count > 0)
    pick = np.where(has, lowest, 0)
    limit = np.where(has, crossings[pick], np.nan) if len(crossings) else np.full(len(speeds), np.nan)
    status = np.where(stable, np.where(has, Status.FOUND, Status.NONE_IN_RANGE), Status.UNSTABLE_AT_THE_LOWER_BOUND)
    # A sample that failed, or a crossing that was not polished, hides what lies around it from every limit above.
    hidden_lane = np.r_[lane[np.isnan(value)], lane[opening][~converged]]
    hidden_gain = np.full(len(speeds), np.inf)
    np.minimum.at(hidden_gain, hidden_lane, np.r_[gain[np.isnan(value)], gain[opening][~converged]])
    lost = np.isfinite(hidden_gain)
    unsure = lost & ~(limit < hidden_gain)
    status = np.where(unsure, Status.NOT_CONVERGED, status)
    limit = np.where(unsure, np.nan, limit)

    at = np.flatnonzero(np.isfinite(limit))
    frequency, kind, error = (np.full(len(speeds), np.nan) for _ in range(3))
    if at.size:
        frequency[at], kind[at], tie = _label(process, speeds[at], limit[at], method)
        status[at[tie]] = Status.TIE
        error[at] = _error(process, speeds[at], limit[at], found.slope[pick[at]], method)
    return {
        "gain": limit,
        "chatter_frequency": frequency,
        "kind_code": np.nan_to_num(kind).astype(np.int8),
        "status_code": status.astype(np.int8),
        "intervals": _intervals(stable, lane[opening], crossings, gains, lost),
        "error": error,
    }


def _log(modulus: np.ndarray) -> np.ndarray:
    """log |μ|, with exactly 1 taken as just unstable and 0 as far below."""
    with np.errstate(divide="ignore"):
        growth = np.maximum(np.log(modulus), -1e3)
    return np.where(growth == 0, np.finfo(float).tiny, growth)


def _refine(
    process: Process, speeds: np.ndarray, gains: np.ndarray, method: Method, scanned: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The samples of the scan, (lane, gain, growth) in order, with more where a pair of crossings may hide."""
    lane = np.repeat(np.arange(len(speeds)), len(gains))
    gain, value = np.tile(gains, len(speeds)), scanned.ravel()
    for _ in range(_REFINEMENTS):
        cells, _ = hidden_crossings(lane, gain, value)
        share = np.arange(1, _PARTS) / _PARTS
        more_lane = np.repeat(lane[cells], _PARTS - 1)
        more_gain = (gain[cells, None] + share * (gain[cells + 1] - gain[cells])[:, None]).ravel()
        more = dominant_at_points(process, speeds[more_lane], more_gain, method).multiplier
        lane, gain = np.r_[lane, more_lane], np.r_[gain, more_gain]
        value = np.r_[value, _log(np.abs(more))]
        order = np.lexsort((gain, lane))
        lane, gain, value = lane[order], gain[order], value[order]
    return lane, gain, value


def _polish(
    process: Process, speeds: np.ndarray, low: np.ndarray, high: np.ndarray, ends: tuple, method: Method
) -> Crossing:
    if not len(speeds):
        return Crossing(*(np.empty(0) for _ in Crossing._fields))
    return in_batches(_crossings, (process, method), (speeds, low, high, *ends))


def _label(
    process: Process, speeds: np.ndarray, gains: np.ndarray, method: Method
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Chatter frequency, kind and whether it is a tie, at limits."""
    frequency, kind, rival = in_batches(_labels, (process, method), (speeds, gains))
    return frequency, kind, np.log(rival) > -_TIE


def _error(process: Process, speeds: np.ndarray, gains: np.ndarray, slope: np.ndarray, method: Method) -> np.ndarray:
    """How far the limit moves on a finer discretisation: one Newton step there."""
    finer = np.abs(dominant_at_points(process, speeds, gains, method.finer()).multiplier)
    return np.abs(_log(finer) / slope)


@jax.jit
def _crossings(
    process: Process, method: Method, speed: Array, low: Array, high: Array, start: Array, end: Array
) -> Crossing:
    def one(speed: Array, low: Array, high: Array, start: Array, end: Array) -> Crossing:
        return find_crossing(process, method, speed, low, high, (start, end))

    return jax.vmap(one)(speed, low, high, start, end)


@jax.jit
def _labels(process: Process, method: Method, speed: Array, gain: Array) -> tuple[Array, Array, Array]:
    return jax.vmap(partial(_label_point, process, method))(speed, gain)


def _label_point(process: Process, method: Method, speed: Array, gain: Array) -> tuple[Array, Array, Array]:
    """Chatter frequency, kind, and the modulus of the strongest multiplier that is not of the dominant pair."""
    system = process.system(speed, gain)
    operator = method.operator(system)
    value, vector = dense.dominant_pair(operator.matrix)
    frequency = chatter_frequency(operator, system.delay, value, vector)
    real = jnp.abs(value.imag) <= 1e-9 * jnp.abs(value)
    kind = jnp.where(real, jnp.where(value.real < 0, Kind.FLIP, Kind.FOLD), Kind.HOPF)
    others = dense.all_multipliers(operator.matrix)
    same = jnp.minimum(jnp.abs(others - value), jnp.abs(others - value.conj())) <= 1e-9 * jnp.abs(value)
    return frequency, kind, jnp.max(jnp.where(same, 0.0, jnp.abs(others)))


def _intervals(
    stable: np.ndarray, lane: np.ndarray, crossings: np.ndarray, gains: np.ndarray, lost: np.ndarray
) -> np.ndarray:
    """Pairs of edges of the stable intervals of every lane, (n, k, 2), NaN-filled."""
    n = len(stable)
    count = np.bincount(lane, minlength=n)
    edges = np.full((n, count.max(initial=0) + 2), np.nan)
    edges[stable, 0] = gains[0]
    order = np.arange(len(lane)) - np.searchsorted(lane, lane)
    edges[lane, order + stable[lane]] = crossings
    filled = count + stable
    odd = filled % 2 == 1
    edges[np.flatnonzero(odd), filled[odd]] = gains[-1]
    edges[lost] = np.nan
    width = max(2 * int(np.ceil(filled.max(initial=1) / 2)), 2)
    return edges[:, :width].reshape(n, -1, 2) if width <= edges.shape[1] else edges.reshape(n, -1, 2)


def _traced(process: Process, speeds: Array, gains: np.ndarray, method: Method) -> Limit:
    """The lowest crossing in pure JAX, one speed after the other, with its implicit derivative."""
    fixed = jax.lax.stop_gradient((process, speeds))

    def search(speed: Array) -> tuple[Array, Array, Array, Array, Array]:
        values = jax.vmap(lambda g: growth_and_slope(fixed[0], method, speed, g)[0])(jnp.asarray(gains))
        unstable = values >= 0
        first = jnp.argmax(unstable)
        before = jnp.maximum(first - 1, 0)
        ends = values[before], values[first]
        low, high = jnp.asarray(gains)[before], jnp.asarray(gains)[first]
        crossing = find_crossing(fixed[0], method, speed, low, high, ends)
        bracketed = unstable.any() & (first > 0)
        good = bracketed & (jnp.abs(crossing.growth) < jnp.sqrt(jnp.finfo(values.dtype).eps) / 10)
        status = jnp.where(
            good,
            Status.FOUND,
            jnp.where(
                unstable[0],
                Status.UNSTABLE_AT_THE_LOWER_BOUND,
                jnp.where(bracketed | jnp.isnan(values).any(), Status.NOT_CONVERGED, Status.NONE_IN_RANGE),
            ),
        )
        gain: Array = jnp.where(good, crossing.gain, jnp.nan)
        frequency, kind, rival = _label_point(fixed[0], method, speed, jnp.nan_to_num(gain, nan=gains[0]))
        status = jnp.where(good & (jnp.log(rival) > -_TIE), Status.TIE, status)
        return gain, status, jnp.where(good, frequency, jnp.nan), jnp.where(good, kind, Kind.NONE), crossing.slope

    root, status, frequency, kind, slope = jax.lax.stop_gradient(jax.lax.map(search, fixed[1]))
    # On the limit the growth stays zero: ∂F/∂θ dθ + ∂F/∂g dg = 0.
    safe = jnp.where(jnp.isnan(root), gains[0], root)
    residual = jax.vmap(partial(growth, process, method))(speeds, safe)
    gain = root - (residual - jax.lax.stop_gradient(residual)) / slope
    nothing = jnp.full((*jnp.shape(gain), 1, 2), jnp.nan)
    parts = {"gain": gain, "chatter_frequency": frequency, "kind_code": kind, "status_code": status}
    return Limit(
        speed=speeds,
        bounds=(float(gains[0]), float(gains[-1])),
        quantity=process.gain,
        speed_unit=process.speed_unit,
        process={"type": type(process).__name__},
        method=describe(method),
        seconds=float("nan"),
        intervals=nothing,
        error=nothing[:, 0, 0],
        **parts,
    )
