"""The stable intervals of limits, (n, k, 2), with as much room as is wanted."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from lobex._warnings import SweepWarning, warn
from lobex.results.codes import Status
from lobex.results.limit import Limit


def of_width(intervals: Float[np.ndarray, "n k 2"], width: int) -> Float[np.ndarray, "n width 2"]:
    """The first ``width`` intervals of every speed, filled up with NaN."""
    missing = max(width - intervals.shape[1], 0)
    return np.pad(intervals, ((0, 0), (0, missing), (0, 0)), constant_values=np.nan)[:, :width]


def kept(limit: Limit, most: int) -> Limit:
    """The limit with room for ``most`` intervals at every speed. Where there are more the status says so.

    Warns:
        SweepWarning: when there are such speeds.
    """
    more = np.isfinite(limit.intervals[:, most:, 0]).any(axis=1)
    if more.any():
        warn(
            f"{more.sum()} of {more.size} speeds have more than {most} stable intervals, of which the lowest are kept; "
            "take a larger scan",
            SweepWarning,
        )
    status = np.where(more, Status.MORE_INTERVALS_THAN_KEPT, limit.status_code).astype(np.int8)
    return replace(limit, intervals=of_width(limit.intervals, most), status_code=status)


def trimmed(limit: Limit) -> Limit:
    """The limit without the room that no speed needs."""
    used = np.flatnonzero(np.isfinite(limit.intervals[..., 0]).any(axis=0))
    return replace(limit, intervals=limit.intervals[:, : used.max(initial=0) + 1])
