"""The sweep: the dominant multiplier at every point of a (speed, gain) grid."""

import time
import warnings
from typing import Any

import jax
import numpy as np

from lobex import _checks
from lobex.grids.evaluation import dominant_over_grid
from lobex.grids.resolution import oddities
from lobex.operators.operator import Method
from lobex.processes.process import Process, check_gain, check_process, check_speed
from lobex.results.chart import Chart
from lobex.results.description import describe
from lobex.verbs import DEFAULT_METHOD, check_method

Array = Any


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
        multiplier, frequency, repeated = dominant_over_grid(process, speeds, gains, method, progress)
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
