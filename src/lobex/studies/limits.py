"""``critical_gain``, with further axes and a store: each chunk is a search of its own."""

from typing import Any

from lobex import _checks
from lobex.characteristic.method import CharacteristicRoots
from lobex.grids.choice import AUTO, AnyMethod, chosen_method
from lobex.limits import critical
from lobex.limits.intervals import kept
from lobex.processes.plausible import implausible
from lobex.results.limit import Limit
from lobex.studies.studied import studied
from lobex.studies.task import AnyExecutor, Over, Path, Task
from lobex.studies.variation import Variation, axes_of

Bounds = tuple[Any, Any]

# Speeds of a chunk, some seconds' work, and what is kept of each, and of each gain of the scan.
_BY_ROOTS, _BY_OPERATORS, _BYTES, _BYTES_OF_SCAN = 4096, 128, 64, 8


@studied(critical.critical_gain)
def critical_gain(
    process: Any,
    speed: Any,
    bounds: Bounds,
    method: AnyMethod = AUTO,
    *,
    scan: int = 65,
    over: Over | None = None,
    store: Path | None = None,
    executor: AnyExecutor | None = None,
    progress: bool = False,
) -> Task:
    """The lowest gain within bounds at which a process turns from stable to unstable, per speed.

    For constant coefficients every gain at which a root stands on the imaginary axis is found at once, and with them
    the number of unstable roots at all gains: nothing is scanned, and the limits are good to rounding.

    With an operator, a scan of ``scan`` equally spaced gains brackets the sign changes of log max|μ|; cells in which
    the neighbours' slopes point across zero, or differ by enough to bend it across, are divided further. Newton's
    method with the derivative of the dominant multiplier then polishes every change, of all speeds side by side,
    within its bracket. An instability that begins and ends between two scanned gains without showing in the slopes
    beside it is missed: take a finer scan.

    Under ``jit``, ``grad`` or ``vmap`` of speed or process the lowest limit alone is found: by D-subdivision of ``Rub``
    and ``Turning`` in one direction, else with an operator of fixed size. ``gain`` carries the derivative by the
    implicit function theorem by speed and every number of the process; ``intervals`` and ``error`` are NaN.

    With ``over`` and ``store`` as for ``sweep``: further axes, and a folder to which the chunks go.

    Args:
        process: a process, such as ``Rub(modes)``, or with ``over`` a function of a dictionary of numbers.
        speed: speeds, Hz (revolutions per second), (n,) or one number; with ``over`` increasing.
        bounds: lowest and highest gain, in the units of the process' gain.
        method: ``Auto()``, which is ``CharacteristicRoots()`` where the process has constant coefficients, one
            force and one delay, and ``Duhamel()`` elsewhere; or one of these, ``Chebyshev(…)`` or
            ``SemiDiscretization(…)``.
        scan: number of gains in the scan of an operator; a study and a store have room for (scan + 1) // 2 stable
            intervals at a speed.
        over, store, executor: further axes, the study's folder and who computes it, as ``sweep`` takes them.
        progress: show a progress bar on standard error; with ``over`` or ``store``, if that is a terminal.

    Returns:
        A ``Limit`` over the speeds, or with ``over`` a ``Study``. Where no limit lies in the bounds, ``gain`` is NaN
        and ``status`` says why.

    Raises:
        ValueError: for speeds that are not positive and finite, bounds that are not two increasing gains that
            the process can have, a scan of fewer than 3 gains, and axes, stores or executors as ``sweep`` refuses them.

    Warns:
        SweepWarning: when the method's samples are too few to follow the first mode at the lowest speed, when an
            estimated error leaves open what is stable, when speeds of a study or a store have more stable intervals
            than there is room for, or when chunks of the store were damaged (they are computed again).
        LobexWarning: for numbers that can hardly be meant: speeds in rpm, damping in per cent, depths in mm.
    """
    variation = Variation({"process": process}, axes_of(over, "critical_gain"))
    first = variation.at(0)["process"]
    _checks.untraced("a study", speed=speed)
    speeds, gains = critical.checked(first, speed, bounds, method, scan)
    if over is not None:
        _checks.grid("speed", speeds, "Hz")
    chosen = chosen_method(method, first, float(speeds.min()))
    return Task(
        verb="critical_gain",
        variation=variation,
        speed=speeds,
        settings={"bounds": bounds, "method": method, "scan": scan},
        compute=_limit,
        implausible=lambda model: implausible(model["process"], speeds, *bounds),
        points=1,
        lanes=_BY_ROOTS if isinstance(chosen, CharacteristicRoots) else _BY_OPERATORS,
        bytes=_BYTES + _BYTES_OF_SCAN * len(gains),
    )


def _limit(*, scan: int, **arguments: Any) -> Limit:
    limit = critical.critical_gain(**arguments, scan=scan, plausible=False)
    # All chunks are of one shape: as many intervals as so many samples can tell apart.
    return kept(limit, (int(scan) + 1) // 2)
