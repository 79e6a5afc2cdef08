"""For each speed a line Re z = x, beyond which there is a root at every gain, so that the dominant one is there."""

from typing import Any

import numpy as np

from lobex.characteristic.chunks import in_chunks
from lobex.characteristic.count import Lines, cross, joined, take
from lobex.characteristic.function import Contact
from lobex.characteristic.roots import Poles

Array = Any

# The first line's distance to the left of the least damped pole: in z, or in distances of the poles from 0. It is
# doubled until there is a root beyond the line at every gain. Of a pole that is damped out within the delay the roots
# are far to the right already at small gains, and there would be many of them beyond a line so far to the left.
_FIRST = 0.1
_DAMPED = -0.5
_ROUNDS = 12


def choose(contact: Contact, poles: Poles, gains: Array, stretch: float) -> Lines:
    """Lines for contacts of lanes (b,) and increasing gains (m,) above 0.

    Args:
        contact: of every speed.
        poles: of every speed.
        gains: K.
        stretch: of the first line's distance, for another choice where one did not do.
    """
    rows = len(poles.place)
    moving: Array = np.where(poles.still, np.nan, poles.place)
    right = np.maximum(np.nanmax(moving.real, axis=1), _DAMPED)
    size = np.nanmax(np.abs(moving), axis=1)
    offset = _FIRST * stretch * np.where(size > 0, np.minimum(size, 1.0), 1.0)
    level, start, trusted = right - offset, np.zeros(rows, dtype=int), np.zeros(rows, dtype=bool)
    kept = []

    def look(index: Array, count: int) -> tuple[Lines, Array]:
        lines = cross(take(contact, index), level[index], moving[index], float(gains[-1]))
        position = np.searchsorted(gains, lines.crossings.gain, side="right")
        enough = np.all(lines.beyond(position, len(gains)) > 0, axis=1) & lines.trusted
        return lines, enough & (np.arange(len(index)) < count)

    left = np.arange(rows)
    for _ in range(_ROUNDS):
        again = []
        chunks = in_chunks(look, left)
        for begin, (lines, enough) in zip(range(0, len(left), len(chunks[0][1])), chunks, strict=True):
            index = left[begin : begin + len(enough)]
            enough_here = enough[: len(index)]
            trusted[index] = enough_here
            start[index] = lines.start[: len(index)]
            mine = enough[lines.crossings.owner]
            crossings = lines.crossings._replace(owner=np.resize(index, len(enough))[lines.crossings.owner])
            kept.append(type(crossings)(*(a[mine] for a in crossings)))
            again.append(index[~enough_here])
        left = np.concatenate(again)
        if len(left) == 0:
            break
        offset[left] *= 2
        level[left] = right[left] - offset[left]
    return Lines(level, start, joined(*kept), trusted)
