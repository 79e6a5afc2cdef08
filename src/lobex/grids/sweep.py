"""The sweep: the dominant multiplier at every point of a (speed, gain) grid."""

import warnings
from typing import Any

import jax
import numpy as np

from lobex import _checks
from lobex._timing import timed
from lobex._warnings import SweepWarning
from lobex.characteristic.method import CharacteristicRoots
from lobex.grids.choice import check_sweep_method, chosen_method
from lobex.grids.evaluation import dominant_over_grid
from lobex.grids.resolution import oddities
from lobex.operators.duhamel import Duhamel
from lobex.operators.operator import Method
from lobex.processes.plausible import warn_of_implausible
from lobex.processes.process import Process, check_gain, check_process, check_speed
from lobex.processes.quantity import quantity_of
from lobex.results.chart import Chart
from lobex.results.description import describe

Array = Any


def sweep(
    process: Process,
    speed: Any,
    gain: Any,
    method: Method | CharacteristicRoots | None = None,
    *,
    progress: bool = False,
    plausible: bool = True,
) -> Chart:
    """``lobex.sweep`` without further axes and stores; arguments, errors and warnings as there.

    With ``plausible=False`` nothing is said of implausible numbers: a study looks at all of them itself.
    """
    check_process(process)
    check_sweep_method(method)
    speeds, gains = _checks.grid("speed", speed, "Hz"), _checks.grid("gain", gain, process.gain.unit)
    check_speed(process, speeds)
    check_gain(process, gains)
    if plausible:
        warn_of_implausible(process, speeds, gains)
    if method is None:
        method = chosen_method(process, float(speeds[0]))
    for message in oddities(process, method, float(speeds[0]), float(gains[-1])):
        warnings.warn(message, SweepWarning, stacklevel=3)
    with timed() as spent, jax.enable_x64(True):
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
        quantity=quantity_of(process),
        speed_unit=process.speed_unit,
        process=describe(process),
        method=describe(method),
        seconds=spent.seconds,
        compiling=spent.compiling,
        failed=failed,
        repeated=repeated,
    )
