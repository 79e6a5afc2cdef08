"""The paths of each speed side by side: do they account for the count, and which lead between two nodes?"""

from typing import Any, NamedTuple

import numpy as np

from lobex.characteristic.roots import Starts

Array = Any

# Paths looked at in each interval; the rest only has to stay to the left of them.
LEADERS = 3
_SAME = 1e-7
_REAL = 1e-9


class Leaders(NamedTuple):
    """The leading paths in each interval between nodes, the first of which begins at a gain of zero.

    Attributes:
        ends: z and step·dz/d(log K) at its beginning, then at its end, (b, nodes, LEADERS, 4).
        rest: Re z that no other path passes at either end, (b, nodes).
        closed: whether the roots found at both ends are as many as the count says, (b, nodes).
    """

    ends: Array
    rest: Array
    closed: Array


def leaders(starts: Starts, paths: Array, slopes: Array, level: Array, count: Array) -> Leaders:
    """The leaders of b speeds from paths and slopes, (nodes, e), and the count at the nodes, (b, nodes)."""
    rows, nodes = count.shape
    order = np.argsort(starts.owner, kind="stable")
    owner = starts.owner[order]
    place = np.arange(len(owner)) - np.searchsorted(owner, owner)
    lanes = max(int(place.max(initial=0)) + 1, LEADERS + 1)
    z: Array = np.full((rows, nodes + 1, lanes), np.nan + 0j)
    slope = np.full_like(z, np.nan)
    z[owner, 1:, place] = paths.T[order]
    z[owner, 0, place] = starts.pole[order]
    slope[owner, 1:, place] = slopes.T[order]
    real = np.where(np.isnan(z.real), -np.inf, z.real)
    ranked = np.argsort(-real, axis=2)
    real = np.take_along_axis(real, ranked, axis=2)
    sorted_z: Array = np.take_along_axis(z, ranked, axis=2)
    with np.errstate(invalid="ignore"):
        repeated = np.abs(np.diff(sorted_z, axis=2)) < _SAME
    repeats = np.zeros_like(real, dtype=bool)
    repeats[:, :, 1:] = repeated
    weight = np.where(sorted_z.imag > _REAL, 2, 1)
    found = np.sum(np.where(~repeats & (real > level[:, None, None]), weight, 0), axis=2)[:, 1:]
    closed = found == count
    closed = np.concatenate([closed[:, :1], closed[:, :-1] & closed[:, 1:]], axis=1)
    # A repeated path is no path of its own.
    np.put_along_axis(z, ranked, np.where(repeats, np.nan, sorted_z), axis=2)
    real = np.where(np.isnan(z.real), -np.inf, z.real)
    key = np.maximum(real[:, :-1], real[:, 1:])
    lead = np.argpartition(-key, LEADERS, axis=2)[:, :, : LEADERS + 1]
    tops = -np.sort(-np.take_along_axis(key, lead, axis=2), axis=2)
    rest = tops[:, :, LEADERS]
    lead = lead[:, :, :LEADERS]
    parts = [np.take_along_axis(a, lead, axis=2) for a in (z[:, :-1], slope[:, :-1], z[:, 1:], slope[:, 1:])]
    ends = np.stack(parts, axis=-1)
    # From zero gain the paths go straight in K.
    straight = ends[:, 0, :, 2] - ends[:, 0, :, 0]
    ends[:, 0, :, 1] = ends[:, 0, :, 3] = straight
    return Leaders(ends, rest, closed)
