"""The sweep: the dominant multiplier at every point of a (speed, gain) grid."""

import time
import warnings
from typing import Any

import jax
import numpy as np

from lobex import _checks
from lobex._memory import check_memory
from lobex.characteristic.method import CharacteristicRoots
from lobex.grids.choice import check_sweep_method, chosen_method
from lobex.grids.evaluation import dominant_over_grid
from lobex.grids.resolution import oddities
from lobex.operators.duhamel import Duhamel
from lobex.operators.operator import Method
from lobex.processes.process import Process, check_gain, check_process, check_speed
from lobex.results.chart import Chart
from lobex.results.description import describe

Array = Any


# A point of a chart: multiplier, modulus, frequency, error, and what stands beside them while they are computed.
_BYTES = 100


class SweepWarning(UserWarning):
    """Points of a sweep that failed and are NaN, or that are coarsely resolved."""


def sweep(
    process: Process,
    speed: Any,
    gain: Any,
    method: Method | CharacteristicRoots | None = None,
    *,
    progress: bool = False,
) -> Chart:
    """``lobex.sweep`` without further axes and stores; arguments, errors and warnings as there."""
    check_process(process)
    check_sweep_method(method)
    speeds, gains = _checks.grid("speed", speed, "Hz"), _checks.grid("gain", gain, process.gain.unit)
    check_speed(process, speeds)
    check_gain(process, gains)
    check_memory(
        f"speed and gain make {len(speeds)} × {len(gains)} points",
        _BYTES * len(speeds) * len(gains),
        "give a coarser grid, or a store that takes it in parts: store=, in the shell --store DIR",
    )
    if method is None:
        method = chosen_method(process, float(speeds[0]))
    for message in oddities(process, method, float(speeds[0]), float(gains[-1])):
        warnings.warn(message, SweepWarning, stacklevel=3)
    begun = time.perf_counter()
    with jax.enable_x64(True):
        process = jax.tree.map(lambda leaf: np.asarray(leaf, dtype=np.float64), process)
        multiplier, frequency, error, _, repeated = dominant_over_grid(process, speeds, gains, method, progress)
    failed = int(np.sum(~np.isfinite(multiplier)))
    if failed:
        warnings.warn(
            f"{failed} of {multiplier.size} points failed and are NaN; check the model at those speeds and gains",
            SweepWarning,
            stacklevel=3,
        )
    if isinstance(method, Duhamel) and method.nodes is None and (coarse := int(np.sum(error > method.tolerance))):
        warnings.warn(
            f"{coarse} of {multiplier.size} points have an estimated error above the tolerance {method.tolerance:g}; "
            "their error is in the chart",
            SweepWarning,
            stacklevel=3,
        )
    return Chart(
        speed=speeds,
        gain=gains,
        spectral_radius=np.abs(multiplier),
        multiplier=multiplier,
        chatter_frequency=frequency,
        error=error,
        quantity=process.gain,
        speed_unit=process.speed_unit,
        process=describe(process),
        method=describe(method),
        seconds=time.perf_counter() - begun,
        failed=failed,
        repeated=repeated,
    )
