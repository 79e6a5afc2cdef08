"""The sweep: the dominant multiplier at every point of a (speed, gain) grid."""

from typing import Any

import numpy as np
from jaxtyping import Float

from lobex import _checks
from lobex._float64 import at_once, widened
from lobex._memory import check_memory
from lobex._timing import timed
from lobex._warnings import SweepWarning, warn
from lobex.grids.choice import AUTO, AnyMethod, check_any_method, chosen_method, tolerance_of
from lobex.grids.evaluation import dominant_over_grid
from lobex.grids.resolution import oddities
from lobex.processes.at_speeds import tabled
from lobex.processes.declared import check_system
from lobex.processes.plausible import warn_of_implausible
from lobex.processes.process import Process, check_gain, check_process, check_speed, fine_enough
from lobex.processes.quantity import quantity_of
from lobex.results.chart import Chart
from lobex.results.codes import PointStatus
from lobex.results.description import describe

# A point of a chart: multiplier, modulus, frequency, error, and what stands beside them while they are computed.
_BYTES = 100


def sweep(
    process: Process,
    speed: Any,
    gain: Any,
    method: AnyMethod = AUTO,
    *,
    progress: bool = False,
    plausible: bool = True,
) -> Chart:
    """``lobex.sweep`` without further axes and stores; arguments, errors and warnings as there.

    With ``plausible=False`` nothing is said of implausible numbers, nor of none at all: a study looks at all of them
    itself.
    """
    speeds, gains = checked(process, speed, gain, method, finite=plausible)
    check_memory(
        f"speed and gain make {len(speeds)} × {len(gains)} points",
        _BYTES * len(speeds) * len(gains),
        "give a coarser grid, or a store that takes it in parts: store=, in the shell --store DIR",
    )
    if plausible:
        warn_of_implausible(process, speeds, gains)
    with timed() as spent, at_once():
        process = widened(process)
        model = fine_enough(tabled(process, speeds), speeds, gains, tolerance_of(method))
        chosen = chosen_method(method, model, float(speeds[0]))
        for message in oddities(model, chosen, float(speeds[0]), float(gains[-1])):
            warn(message, SweepWarning)
        found = dominant_over_grid(model, speeds, gains, chosen, progress)
    multiplier, tolerance = found.multiplier, tolerance_of(chosen)
    status = np.where(found.again, PointStatus.SETTLED_AGAIN, PointStatus.GOOD).astype(np.int8)
    status[found.error > tolerance] = PointStatus.ABOVE_TOLERANCE
    status[~np.isfinite(multiplier)] = PointStatus.FAILED
    if failed := int(np.sum(status == PointStatus.FAILED)):
        warn(
            f"{failed} of {multiplier.size} points failed and are NaN; check the model at those speeds and gains",
            SweepWarning,
        )
    if coarse := int(np.sum(status == PointStatus.ABOVE_TOLERANCE)):
        warn(
            f"{coarse} of {multiplier.size} points have an estimated error above the tolerance {tolerance:g}; "
            "their error is in the chart",
            SweepWarning,
        )
    return Chart(
        speed=speeds,
        gain=gains,
        spectral_radius=np.abs(multiplier),
        multiplier=multiplier,
        chatter_frequency=found.frequency,
        error=found.error,
        status_code=status,
        quantity=quantity_of(process),
        speed_unit=process.speed_unit,
        process=describe(process),
        method=describe(chosen),
        seconds=spent.seconds,
        compiling=spent.compiling,
    )


def checked(
    process: Process, speed: Any, gain: Any, method: AnyMethod, *, finite: bool = True
) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " m"]]:
    """Speeds and gains of a sweep, once all arguments are what they should be; ``finite`` as in ``check_system``."""
    check_process(process)
    check_any_method(method)
    _checks.untraced("sweep", process=process, speed=speed, gain=gain)
    speeds, gains = _checks.grid("speed", speed, "Hz"), _checks.grid("gain", gain, process.gain.unit)
    check_speed(process, speeds)
    check_gain(process, gains)
    check_system(process, speeds[[0, -1], None], gains[[0, -1]], finite=finite)
    return speeds, gains
