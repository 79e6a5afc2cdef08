"""The sweep: the dominant multiplier at every point of a (speed, gain) grid."""

import time
import warnings
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from tqdm import tqdm

from lobex import _checks
from lobex._broadcast import over_points
from lobex.floquet import dense, iteration
from lobex.floquet.chatter import chatter_frequency
from lobex.grids.resolution import oddities
from lobex.operators.operator import Method
from lobex.processes.process import Process, check_gain, check_process, check_speed
from lobex.results.chart import Chart
from lobex.results.description import describe
from lobex.verbs import DEFAULT_METHOD, check_method

Array = Any

# The operators of one chunk: a few megabytes stay in cache, and larger chunks measured up to twice slower.
_CHUNK_BYTES = 3e6
# Below this residual the iterated |μ| agrees with the dense solver to 1e-9 (tests/test_iteration.py).
_TRUSTED_RESIDUAL = 1e-10
# What is settled again, and how: more squarings first, for many slow modes at high speed; then the dense solver.
_BATCH = 128
_SQUARINGS = 5
_MORE_SQUARINGS = 12


class SweepWarning(UserWarning):
    """Points of a sweep that failed and are NaN, or that are coarsely resolved."""


def sweep(
    process: Process,
    speed: Any,
    gain: Any,
    method: Method = DEFAULT_METHOD,
    *,
    progress: bool = False,
) -> Chart:
    """The dominant Floquet multiplier and its chatter frequency over a grid: a stability lobe diagram.

    Every point is computed by subspace iteration with a residual; points whose residual is not at rounding
    are computed again by the dense eigensolver. The grid is worked through in chunks, so memory does not
    grow with it but for the results. Runs in float64 whatever JAX' setting.

    Args:
        process: a process, such as ``Rub(modes)``.
        speed: increasing speeds, Hz (revolutions per second), shape (n,).
        gain: increasing gains, shape (m,): K_e in N/m or depth of cut in m.
        method: ``Chebyshev(…)`` or ``SemiDiscretization(…)``.
        progress: show a progress bar on standard error.

    Returns:
        A ``Chart`` of shape (n, m).

    Raises:
        ValueError: for a grid that is empty, not increasing, not one-dimensional or not finite, for speeds
            not above zero and gains that the process cannot have.

    Warns:
        SweepWarning: when points failed (they are NaN), when the method's samples are too few to follow the
            first mode at the lowest speed, or when all speeds lie above every lobe.
    """
    check_process(process)
    check_method(method)
    speeds, gains = _checks.grid("speed", speed, "Hz"), _checks.grid("gain", gain, process.gain.unit)
    check_speed(process, speeds)
    check_gain(process, gains)
    for message in oddities(process, method, float(speeds[0]), float(gains[-1])):
        warnings.warn(message, SweepWarning, stacklevel=2)
    begun = time.perf_counter()
    with jax.enable_x64(True):
        process = jax.tree.map(lambda leaf: np.asarray(leaf, dtype=np.float64), process)
        multiplier, frequency, repeated = _work_through(process, speeds, gains, method, progress)
    failed = int(np.sum(~np.isfinite(multiplier)))
    if failed:
        warnings.warn(
            f"{failed} of {multiplier.size} points failed and are NaN; check the model at those speeds and gains",
            SweepWarning,
            stacklevel=2,
        )
    return Chart(
        speed=speeds,
        gain=gains,
        spectral_radius=np.abs(multiplier),
        multiplier=multiplier,
        chatter_frequency=frequency,
        quantity=process.gain,
        speed_unit=process.speed_unit,
        process=describe(process),
        method=describe(method),
        seconds=time.perf_counter() - begun,
        failed=failed,
        repeated=repeated,
    )


def _work_through(
    process: Process, speeds: np.ndarray, gains: np.ndarray, method: Method, progress: bool
) -> tuple[np.ndarray, np.ndarray, int]:
    rows, columns = _chunk_shape(process, method, speeds, gains)
    shape = (len(speeds), len(gains))
    multiplier = np.full(shape, np.nan, dtype=np.complex128)
    frequency = np.full(shape, np.nan)
    residual = np.full(shape, np.inf)
    starts = [(i, j) for i in range(0, shape[0], rows) for j in range(0, shape[1], columns)]
    with tqdm(total=multiplier.size, unit="pt", unit_scale=True, disable=not progress, leave=False) as bar:
        for i, j in starts:
            # The last chunks reach back over points already done, so that one shape serves all.
            i0, j0 = min(i, max(shape[0] - rows, 0)), min(j, max(shape[1] - columns, 0))
            part = np.s_[i0 : i0 + rows, j0 : j0 + columns]
            result = _dominant(process, speeds[part[0], None], gains[part[1]], method, _SQUARINGS)
            multiplier[part], frequency[part], residual[part] = (np.asarray(r) for r in result)
            bar.update((min(i + rows, shape[0]) - i) * (min(j + columns, shape[1]) - j))
    dense_points = 0
    for squarings in (_MORE_SQUARINGS, None):
        doubtful = np.argwhere(~(residual < _TRUSTED_RESIDUAL) | ~np.isfinite(multiplier))
        for start in range(0, len(doubtful), _BATCH):
            index = tuple(doubtful[start : start + _BATCH].T)
            padded = [np.resize(axis, _BATCH) for axis in index]
            result = _dominant(process, speeds[padded[0]], gains[padded[1]], method, squarings)
            multiplier[index], frequency[index], residual[index] = (np.asarray(r)[: len(index[0])] for r in result)
        dense_points = len(doubtful)
    return multiplier, frequency, dense_points


def _chunk_shape(process: Process, method: Method, speeds: np.ndarray, gains: np.ndarray) -> tuple[int, int]:
    system = process.system(speeds[0], gains[0])
    points = max(int(_CHUNK_BYTES / (8 * method.size(system) ** 2)), 1)
    columns = min(len(gains), points)
    return min(len(speeds), max(points // columns, 1)), columns


@partial(jax.jit, static_argnames="squarings")
def _dominant(
    process: Process, speed: Array, gain: Array, method: Method, squarings: int | None
) -> tuple[Array, Array, Array]:
    """Dominant multipliers, chatter frequencies and residuals; by the dense solver where squarings is None."""

    def point(speed: Array, gain: Array) -> tuple[Array, Array, Array]:
        system = process.system(speed, gain)
        operator = method.operator(system)
        if squarings is None:
            value, vector = dense.dominant_pair(operator.matrix)
            residual = jnp.zeros(())
        else:
            value, vector, residual = iteration.dominant_pair(operator.matrix, squarings)
        return value, chatter_frequency(operator, system.delay, value, vector), residual

    return over_points(point, speed, gain)
