"""The critical gain of any process: every change of stability is found, polished, and labelled."""

from typing import Any

import numpy as np
from jaxtyping import Float, Shaped

from lobex import _checks
from lobex._float64 import at_once, widened
from lobex._memory import check_memory
from lobex._shapes import AnyArray
from lobex._timing import Stopwatch, timed
from lobex._warnings import SweepWarning, warn
from lobex.characteristic.method import CharacteristicRoots
from lobex.grids.choice import AUTO, AnyMethod, check_any_method, chosen_method, operator_of, tolerance_of
from lobex.grids.one_size import compile_longer
from lobex.grids.resolution import oddities
from lobex.limits.changes import Changes, polished
from lobex.limits.changes_on_axis import changes_on_axis
from lobex.limits.chattering_mode import labels_of_process
from lobex.limits.closed_form import Regeneration, closed_form
from lobex.limits.intervals import of_width
from lobex.limits.receptance import Receptance
from lobex.limits.scan import scan_gains
from lobex.limits.traced import traced_critical_gain
from lobex.limits.undamped import undefined
from lobex.operators.operator import Method
from lobex.processes.at_speeds import tabled
from lobex.processes.declared import check_system
from lobex.processes.plausible import warn_of_implausible
from lobex.processes.process import Process, check_gain, check_process, check_speed, fine_enough
from lobex.processes.quantity import quantity_of
from lobex.results.codes import Kind, Status
from lobex.results.description import describe
from lobex.results.limit import Limit

# So many times the highest gain are as good as any: what is not proportional to the gain is rounding there.
_ANY, _FURTHER = 1e9, 30.0
# A sample of the scan: its multiplier, and its neighbours' while it is sorted.
_BYTES = 60


def critical_gain(
    process: Process,
    speed: Any,
    bounds: tuple[Any, Any],
    method: AnyMethod = AUTO,
    *,
    scan: int = 65,
    progress: bool = False,
    plausible: bool = True,
) -> Limit:
    """``lobex.critical_gain`` without further axes and stores; arguments, errors and warnings as there.

    With ``plausible=False`` nothing is said of implausible numbers, nor of none at all: a study looks at all of them
    itself.
    """
    speeds, gains = checked(process, speed, bounds, method, scan, finite=plausible)
    if _checks.is_traced((process, speeds)):
        return traced_critical_gain(process, speeds, gains, method)
    if plausible:
        warn_of_implausible(process, speeds, *bounds)
    slowest = float(speeds.min())
    check_memory(
        f"speed and scan make {len(speeds)} × {len(gains)} samples",
        _BYTES * len(speeds) * len(gains),
        "give fewer of them",
    )
    with timed() as spent, at_once():
        process = widened(process)
        model = fine_enough(tabled(process, speeds), speeds, gains, tolerance_of(method))
        chosen = chosen_method(method, model, slowest)
        for message in oddities(model, chosen, slowest, float(gains[-1])):
            warn(message, SweepWarning)
        parts, doubts = _search(model, speeds, gains, chosen, progress)
        _leave_undefined(model, speeds, parts)
        labels = labels_of_process(model, speeds, parts["gain"], parts["chatter_frequency"])
    if doubts:
        warn(doubts, SweepWarning)
    return _limit(process, speeds, gains, chosen, spent, **parts, **labels._asdict())


def checked(
    process: Process, speed: Any, bounds: tuple[Any, Any], method: AnyMethod, scan: int, *, finite: bool = True
) -> tuple[Any, Float[np.ndarray, " scan"]]:
    """Speeds, (n,) float64 unless JAX traces them, and gains of a scan, once all arguments are what they should be;
    ``finite`` as ``check_system`` has it.
    """
    check_process(process)
    check_any_method(method)
    if _checks.is_traced(bounds):
        raise ValueError("bounds are traced by JAX; give plain numbers: speed and process may be traced")
    scan = _checks.integer("scan", scan, 3)
    if np.ndim(bounds) != 1 or len(bounds) != 2:
        raise ValueError(f"bounds = {bounds!r} must be two gains, the lowest and the highest")
    speed = _checks.as_array(speed, "speed")
    if np.ndim(speed) > 1 or np.size(speed) == 0:
        raise ValueError(f"speed has shape {np.shape(speed)}; give one speed or a list of them")
    check_speed(process, speed)
    check_gain(process, bounds)
    if float(bounds[0]) >= float(bounds[1]):
        raise ValueError(f"bounds = {tuple(map(float, bounds))} must be increasing; give the lowest gain first")
    gains = np.linspace(float(bounds[0]), float(bounds[1]), scan)
    if not _checks.is_traced((process, speed)):
        speed = np.atleast_1d(np.asarray(speed, dtype=np.float64))
        check_system(process, speed[:, None], bounds, finite=finite)
    return speed, gains


def _limit(
    process: Process,
    speeds: Float[AnyArray, " speeds"],
    gains: np.ndarray,
    method: Method | CharacteristicRoots,
    spent: Stopwatch,
    **parts: Shaped[AnyArray, "speeds ..."],
) -> Limit:
    return Limit(
        speed=speeds,
        bounds=(float(gains[0]), float(gains[-1])),
        quantity=quantity_of(process),
        speed_unit=process.speed_unit,
        process=describe(process),
        method=describe(method),
        seconds=spent.seconds,
        compiling=spent.compiling,
        **parts,
    )


def _search(
    process: Process, speeds: np.ndarray, gains: np.ndarray, method: Method | CharacteristicRoots, progress: bool
) -> tuple[dict[str, np.ndarray], str]:
    """The fields of the limits, and what is to be warned of."""
    if not isinstance(method, CharacteristicRoots):
        return _by_operator(process, speeds, gains, method, progress)
    stable, settled, changes = changes_on_axis(process, speeds, float(gains[0]), float(gains[-1]))
    parts = _assembled(stable, np.full(len(speeds), np.inf), changes, gains)
    none = np.flatnonzero(settled & (parts["status_code"] == Status.NONE_IN_RANGE))
    parts["status_code"][_always_stable(process, speeds, none, float(gains[-1]))] = Status.STABLE_AT_ANY_GAIN
    left = np.flatnonzero(~settled)
    if not left.size:
        return parts, ""
    others, doubts = _by_operator(process, speeds[left], gains, operator_of(method), progress)
    widest = max(part["intervals"].shape[1] for part in (parts, others))
    for target in (parts, others):
        target["intervals"] = of_width(target["intervals"], widest)
    for name, values in parts.items():
        values[left] = others[name]
    return parts, doubts


def _always_stable(process: Process, speeds: np.ndarray, lanes: np.ndarray, highest: float) -> np.ndarray:
    """Of the lanes that are stable at the highest gain those that are at every gain above."""
    # What is regenerative has a limit at every speed, be it far above.
    if not lanes.size or highest <= 0 or not isinstance(closed_form(process), str):
        return lanes[:0]
    most = highest
    while lanes.size and most < _ANY * highest:
        low, most = most, min(most * _FURTHER, _ANY * highest)
        stable, sure, changes = changes_on_axis(process, speeds[lanes], low, most)
        lanes = lanes[stable & sure & ~np.isin(np.arange(lanes.size), changes.lane)]
    return lanes


def _leave_undefined(process: Process, speeds: np.ndarray, parts: dict[str, np.ndarray]) -> None:
    """Say nothing at the speeds at which a mode without damping is a root at every gain."""
    found = closed_form(process)
    if not isinstance(found, Regeneration) or isinstance(found.receptance, Receptance):
        return
    neutral = undefined(found.receptance, speeds)
    for name in ("gain", "chatter_frequency", "error", "intervals"):
        parts[name][neutral] = np.nan
    parts["kind_code"][neutral], parts["status_code"][neutral] = Kind.NONE, Status.UNDEFINED


def _by_operator(
    process: Process, speeds: np.ndarray, gains: np.ndarray, method: Method, progress: bool
) -> tuple[dict[str, np.ndarray], str]:
    quickly = compile_longer(process, speeds, gains)
    scan = scan_gains(process, method, speeds, gains, progress, quickly)
    changes = polished(process, method, speeds, scan.brackets, quickly)
    unsure = np.isnan(changes.gain)
    # A change that was not polished hides what lies around it from every limit above, as a failed sample does.
    hidden = scan.failed
    np.minimum.at(hidden, changes.lane[unsure], scan.brackets.low[unsure])
    doubts = (
        f"{scan.doubtful} of {scan.samples} samples of the scan have an estimated error above the tolerance "
        f"{tolerance_of(method):g} that leaves open whether they are stable, and limits may be missed or wrong"
    )
    return _assembled(scan.stable, hidden, changes, gains), doubts if scan.doubtful else ""


def _assembled(stable: np.ndarray, hidden: np.ndarray, changes: Changes, gains: np.ndarray) -> dict[str, np.ndarray]:
    """The limits of n speeds: whether the lowest gain is stable, (n,), the gain above which something failed, (n,)."""
    # Rounding may put one that lies at a bound beyond it.
    changes = changes._replace(gain=np.clip(changes.gain, gains[0], gains[-1]))
    number = np.arange(len(stable))
    count = np.bincount(changes.lane, minlength=len(stable))
    has = stable & (count > 0)
    pick = np.where(has, np.searchsorted(changes.lane, number), -1)
    # One more entry, for the speeds without a limit.
    gain, frequency, kind, tie, error = (np.append(part, np.nan)[pick] for part in changes[1:])
    lost = np.isfinite(hidden)
    unsure = lost & ~(gain < hidden)
    status = np.where(stable, np.where(has, Status.FOUND, Status.NONE_IN_RANGE), Status.UNSTABLE_AT_THE_LOWER_BOUND)
    status = np.where(has & (tie == 1), Status.TIE, status)
    status = np.where(unsure, Status.NOT_CONVERGED, status)
    known = has & ~unsure
    return {
        "gain": np.where(known, gain, np.nan),
        "chatter_frequency": np.where(known, frequency, np.nan),
        "kind_code": np.where(known, np.nan_to_num(kind), Kind.NONE).astype(np.int8),
        "status_code": status.astype(np.int8),
        "intervals": _intervals(stable, changes.lane, changes.gain, gains, lost),
        "error": np.where(known, error, np.nan),
    }


def _intervals(
    stable: np.ndarray, lane: np.ndarray, changes: np.ndarray, gains: np.ndarray, lost: np.ndarray
) -> np.ndarray:
    """Pairs of edges of the stable intervals of every lane, (n, k, 2), NaN-filled."""
    n = len(stable)
    count = np.bincount(lane, minlength=n)
    edges = np.full((n, count.max(initial=0) + 2), np.nan)
    edges[stable, 0] = gains[0]
    order = np.arange(len(lane)) - np.searchsorted(lane, lane)
    edges[lane, order + stable[lane]] = changes
    filled = count + stable
    odd = filled % 2 == 1
    edges[np.flatnonzero(odd), filled[odd]] = gains[-1]
    edges[lost] = np.nan
    width = max(2 * int(np.ceil(filled.max(initial=1) / 2)), 2)
    return edges[:, :width].reshape(n, -1, 2) if width <= edges.shape[1] else edges.reshape(n, -1, 2)
