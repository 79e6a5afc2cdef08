"""Changes of stability from the crossings of the imaginary axis: constant coefficients, every gain at once."""

import numpy as np

from lobex.characteristic.axis_crossings import AxisCrossings, axis_crossings
from lobex.limits.changes import TIE, Changes
from lobex.processes.process import Process
from lobex.results.codes import Kind


def changes_on_axis(
    process: Process, speeds: np.ndarray, lowest: float, highest: float
) -> tuple[np.ndarray, np.ndarray, Changes]:
    """Whether the lowest gain is stable, (n,), whether a speed is settled, (n,), and the changes of stability."""
    found = axis_crossings(process, speeds, lowest, highest)
    # Roots to the right before and after every crossing.
    total = np.cumsum(found.change)
    first = np.searchsorted(found.owner, found.owner)
    after = found.unstable[found.owner] + total - (total - found.change)[first]
    changes = np.flatnonzero((after == 0) != (after - found.change == 0))
    return (
        found.unstable == 0,
        found.trusted,
        Changes(
            lane=found.owner[changes],
            gain=found.gain[changes],
            frequency=found.frequency[changes],
            kind=np.where(found.frequency[changes] == 0, Kind.FOLD, Kind.HOPF),
            tie=_tied(found)[changes],
            error=found.error[changes],
        ),
    )


def _tied(found: AxisCrossings) -> np.ndarray:
    """Whether another root is on the axis at the gain of each crossing, to within the growth that makes a tie."""
    tied = np.zeros(len(found.owner), dtype=bool)
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = np.abs(np.diff(found.gain) / found.gain[:-1])
    for here, other in ((slice(None, -1), slice(1, None)), (slice(1, None), slice(None, -1))):
        growth = np.abs(found.rate[other]) * apart
        tied[here] |= (growth < TIE) & (found.owner[here] == found.owner[other])
    return tied
