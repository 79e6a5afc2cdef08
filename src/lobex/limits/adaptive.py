"""The stability limit as a curve: speeds are added where it bends, ends or jumps, as an adaptive plotter does."""

import warnings
from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

import numpy as np

from lobex import _checks
from lobex.grids.sweep import SweepWarning
from lobex.limits.intervals import of_width
from lobex.results.codes import Status
from lobex.results.limit import Limit

Search = Callable[[np.ndarray], Limit]

# Of the picture's width and height: about the width of a drawn line.
_TOLERANCE = 1e-3
# Speeds that are searched together.
_BATCH = 32
_SUMS = ("seconds", "compiling")


def limit_curve(search: Search, speed: Any, budget: int) -> Limit:
    """The limit at the given speeds and at up to ``budget`` speeds more, sorted by speed.

    A gap between neighbours is halved where the curve seems to stand off the line through them by more than 1/1000
    of the picture's width and height, and where a limit ends, or the number of stable intervals changes, within a
    gap of more than 1/1000 of its width; the worst gaps first. What lies wholly between two speeds that show nothing
    of it is not found.

    Args:
        search: the limits at speeds in any order, (n,): such as ``partial(lobex.exact_limit, process)`` or
            ``partial(lobex.critical_gain, process, bounds=(1e-5, 5e-3))``.
        speed: increasing speeds to begin with, (n,), Hz; nothing is added to fewer than 3.
        budget: most speeds to add; 0 for none.

    Returns:
        A ``Limit``, whose warnings are those of the first search.

    Raises:
        ValueError: for speeds that are not increasing, a negative budget, and what ``search`` refuses.
    """
    speeds = _checks.grid("speed", speed, "Hz")
    left = _checks.integer("budget", budget, 0)
    limit = search(speeds)
    while left and (added := _added(limit))[:left].size:
        added = added[: min(left, _BATCH)]
        # What is odd about these speeds was said of the first. Batches are of one size, filled up with repeats, so
        # that the search is compiled once.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SweepWarning)
            limit = merged(limit, search(np.resize(added, _BATCH)))
        left -= len(added)
    return limit


def merged(first: Limit, second: Limit) -> Limit:
    """The limits of the same search at the speeds of both, in order of speed, each once."""
    counts = len(first.speed), len(second.speed)
    width = max(first.intervals.shape[1], second.intervals.shape[1])
    first, second = (replace(part, intervals=of_width(part.intervals, width)) for part in (first, second))
    order = np.unique(np.concatenate([first.speed, second.speed]), return_index=True)[1]
    changes: dict[str, Any] = {}
    for field in fields(first):
        parts = getattr(first, field.name), getattr(second, field.name)
        if field.name in _SUMS:
            changes[field.name] = sum(parts)
        elif isinstance(parts[0], np.ndarray) and tuple(map(len, parts)) == counts:
            changes[field.name] = np.concatenate(parts)[order]
    return replace(first, **changes)


def _added(limit: Limit) -> np.ndarray:
    """The middles of the gaps that need one, the worst first."""
    if len(limit.speed) < 3:
        return np.empty(0)
    worth = _worth(limit)
    order = np.argsort(-worth, kind="stable")
    order = order[worth[order] > _TOLERANCE]
    return (limit.speed[order] + limit.speed[order + 1]) / 2


def _worth(limit: Limit) -> np.ndarray:
    """By how much the line in each gap may be wrong, of the picture's width and height, (n − 1,)."""
    x = (limit.speed - limit.speed[0]) / np.ptp(limit.speed)
    known = np.isfinite(limit.gain)
    height = np.ptp(limit.gain[known]) if known.any() else 0.0
    y = limit.gain / height if height > 0 else limit.gain * 0.0
    gap = np.diff(x)
    status = np.where(limit.status_code == Status.TIE, Status.FOUND, limit.status_code)
    # No curve ends between the two.
    status = np.where(status == Status.STABLE_AT_ANY_GAIN, Status.NONE_IN_RANGE, status)
    stable = np.sum(np.isfinite(limit.intervals[:, :, 0]), axis=1)
    ends = (np.diff(status) != 0) | (np.diff(stable) != 0)
    return np.where(ends, gap, _bulge(gap, np.diff(y)))


def _bulge(run: np.ndarray, rise: np.ndarray) -> np.ndarray:
    """How far the curve may stand off each chord (run, rise), (n − 1,): half of where its neighbours' lines meet.

    Neighbours that turn to different sides make a step, which is drawn within its gap however high it is. Beside a
    neighbour that turns sharply a curved branch may hide a corner: such a gap is not left wide.
    """
    length = np.hypot(run, rise)
    with np.errstate(invalid="ignore", divide="ignore"):
        across = (run[:-1] * rise[1:] - run[1:] * rise[:-1]) / (length[1:] * length[:-1])
        ahead = (run[1:] * run[:-1] + rise[1:] * rise[:-1]) / (length[1:] * length[:-1])
        turn = np.arctan2(across, ahead)
        left, right = np.append(np.nan, turn), np.append(turn, np.nan)
        # At an end of the curve there is one neighbour.
        left, right = np.where(np.isnan(left), right, left), np.where(np.isnan(right), left, right)
        slant = 1 / np.tan(np.abs(left)) + 1 / np.tan(np.abs(right))
        meeting = np.where(slant > 0, length / slant, 1.0) / 2
    beside = run * np.sin(np.maximum(np.abs(left), np.abs(right)) / 2) / 4
    most = np.where(np.sign(left) * np.sign(right) < 0, run / 2, 0.5)
    return np.where(np.isfinite(left), np.maximum(np.minimum(meeting, most), beside), 0.0)
