"""``next_speed``: which speed to try after a cut that chattered."""

from typing import Any

import numpy as np

from lobex import _checks
from lobex.limits.critical import critical_gain
from lobex.processes.process import Process, check_process, check_speed
from lobex.processes.quantity import DEPTH_OF_CUT, has_units, quantity_of
from lobex.results.codes import Status
from lobex.results.next_speeds import NextSpeeds

# Times the fastest mode's frequency, above which no chatter is.
_BEYOND = 20.0
# The lobes told of where nobody says between which speeds.
_LOBES = 8


def next_speed(
    chatter_frequency: float,
    teeth: int,
    *,
    speed: Any = None,
    process: Process | None = None,
    bounds: tuple[float, float] | None = None,
) -> NextSpeeds:
    """Speeds at which the teeth pass once in a whole number of waves of a chatter that was heard: n = f_c/(N k).

    There each tooth meets the wave that the one ahead left in phase, so that the chip does not change its thickness
    (Smith and Tlusty, Stabilizing chatter by automatic spindle speed regulation, CIRP Ann. 41, 1992). With a process
    they are ranked by its limits, without one by speed.

    Args:
        chatter_frequency: f_c, Hz, as a microphone hears it.
        teeth: N, of equal pitch.
        speed: lowest and highest speed of the machine, Hz; without it the first eight lobes are told of.
        process: whose limits rank the speeds.
        bounds: with a process, the lowest and the highest gain at which limits are sought.

    Returns:
        ``NextSpeeds``, the one to try first coming first.

    Raises:
        ValueError: for frequencies and speeds that are not above zero, frequencies that can only be rpm, ranges that
            hold none of the speeds, and one of ``process`` and ``bounds`` without the other.
    """
    _checks.untraced("next_speed", chatter_frequency=chatter_frequency, speed=speed, process=process)
    _checks.positive("chatter_frequency", chatter_frequency, "Hz")
    _checks.scalar("chatter_frequency", chatter_frequency)
    teeth = _checks.integer("teeth", teeth, 1)
    if (process is None) != (bounds is None):
        raise ValueError("process and bounds rank the speeds together; give both, the bounds as two gains, or neither")
    frequency = float(chatter_frequency)
    if process is not None:
        check_process(process)
        _check_frequency(process, frequency)
    lobes = np.arange(1, _LOBES + 1)
    if speed is not None:
        ends = _checks.as_numbers("speed", speed, "Hz")
        if ends is None or ends.shape != (2,) or not 0 < ends[0] < ends[1]:
            raise ValueError(f"speed = {_checks.brief(speed)} must be a range in Hz, its lowest and its highest value")
        first, last = (frequency / (teeth * end) for end in ends[::-1])
        if np.floor(last) < np.ceil(first):
            raise ValueError(
                f"speed = {_checks.brief(speed)} holds none of f/(N k) = {frequency / teeth:.6g} Hz/k; give a wider "
                "range in revolutions per second, which is rpm/60"
            )
        lobes = np.arange(np.ceil(first), np.floor(last) + 1)
    speeds = frequency / (teeth * lobes)
    limit, status = np.full(len(speeds), np.nan), np.full(len(speeds), Status.UNDEFINED, dtype=np.int8)
    if process is not None and bounds is not None:
        check_speed(process, speeds)
        found = critical_gain(process, speeds, bounds)
        limit, status = found.gain, found.status_code
    # Where nothing is unstable comes first, and where all is last.
    everywhere = np.isin(status, (Status.NONE_IN_RANGE, Status.STABLE_AT_ANY_GAIN))
    height = np.where(everywhere, np.inf, np.nan_to_num(limit, nan=-np.inf))
    order = np.argsort(-height, kind="stable")
    return NextSpeeds(
        lobe=lobes[order].astype(float),
        speed=speeds[order],
        limit=limit[order],
        status_code=status[order],
        chatter_frequency=frequency,
        teeth=teeth,
        quantity=DEPTH_OF_CUT if process is None else quantity_of(process),
        speed_unit="rpm" if process is None else process.speed_unit,
    )


def _check_frequency(process: Any, frequency: float) -> None:
    """Refuse what no mode of the process can chatter at."""
    known = getattr(getattr(process, "modes", None), "frequency", None)
    if known is not None and has_units(process) and frequency > _BEYOND * float(np.max(known)):
        raise ValueError(
            f"chatter_frequency = {frequency:.6g} is {frequency / float(np.max(known)):.0f} times that of the fastest "
            f"mode, {float(np.max(known)):.6g} Hz; give Hz, which is rpm/60"
        )
