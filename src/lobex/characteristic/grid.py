"""The dominant root over a grid of speeds and gains above zero: lines, beginnings, paths, and the last digits."""

from typing import Any, NamedTuple

import numpy as np

from lobex.characteristic.chunks import in_chunks
from lobex.characteristic.count import Lines, take
from lobex.characteristic.function import Contact
from lobex.characteristic.level import choose
from lobex.characteristic.paths import leaders
from lobex.characteristic.polish import dominant
from lobex.characteristic.roots import (
    Poles,
    Starts,
    beginning,
    crossing_starts,
    double_starts,
    follow,
    pole_starts,
)

Array = Any

# Of log K from node to node; numbers of nodes are whole multiples, so that few functions are compiled.
_STEP = 0.12
_NODES = 32
# A pole where the path cannot begin straight, such as a double one, begins at this part of the largest gain.
_LEAST = 1e-13


class _Effort(NamedTuple):
    """What is tried for the speeds that are left.

    Attributes:
        stretch: of the line's first distance: a root may run along the line.
        parts: that the steps along the gain are cut into: paths may come close to each other.
        steps: of Newton's method at a point: close to a double root it begins slowly.
    """

    stretch: float
    parts: int
    steps: int


_EFFORTS = (_Effort(1.0, 1, 2), _Effort(1.7, 8, 8), _Effort(3.1, 64, 16))
# The last step of Newton's method, which converges quadratically.
_CONVERGED = 1e-9
# Paths that are looked at together: with more, the chunk is halved.
_PATHS = 4096


def dominant_roots(contact: Contact, poles: Poles, gains: Array) -> tuple[Array, Array]:
    """The dominant root z, and whether it is settled, each (b, m), for lanes (b,) and increasing gains (m,) above 0.

    Im z may have either sign; what is not settled is NaN.
    """
    rows = len(poles.place)
    root: Array = np.full((rows, len(gains)), np.nan + 0j)
    settled = np.zeros(root.shape, dtype=bool)
    left = np.nonzero(~np.all(poles.still, axis=1))[0]
    nodes = _NODES
    for effort in _EFFORTS:
        if len(left) == 0:
            break
        chosen = Poles(*(a[left] for a in poles))
        found, proven, nodes = _attempt(take(contact, left), chosen, gains, effort, nodes)
        new = proven & ~settled[left]
        root[left] = np.where(new, found, root[left])
        settled[left] |= new
        left = left[~np.all(settled[left], axis=1)]
    # Roots that the gain does not move have no part in the count.
    still = np.where(poles.still, poles.place.real, -np.inf)
    foremost = np.argmax(still, axis=1)[:, None]
    unmoved = np.all(poles.still, axis=1)[:, None]
    settled |= unmoved
    ahead = settled & (unmoved | (np.take_along_axis(still, foremost, axis=1) > root.real))
    root = np.where(ahead, np.take_along_axis(poles.place, foremost, axis=1), root)
    return root, settled


def _attempt(contact: Contact, poles: Poles, gains: Array, effort: _Effort, least: int) -> tuple[Array, Array, int]:
    largest = float(gains[-1])
    lines = choose(contact, poles, gains, effort.stretch)
    first = np.min(np.where(beginning(poles, lines.level), poles.safe, np.inf), axis=1)
    np.minimum.at(first, lines.crossings.owner, lines.crossings.gain * 0.999)
    first = np.clip(first, _LEAST * largest, largest / 2)
    nodes = max(-(-int(np.ceil(np.max(np.log(largest / first)) / _STEP)) // _NODES) * _NODES, least)
    step = np.log(largest / first) / (nodes - 1)
    order = np.argsort(lines.crossings.owner, kind="stable")
    ordered = type(lines.crossings)(*(a[order] for a in lines.crossings))

    def work(index: Array, count: int) -> tuple[Array, Array]:
        begin, end = np.searchsorted(ordered.owner, [index[0], index[count - 1] + 1])
        if end - begin > _PATHS and count > 1:
            half = count // 2
            lower = work(np.resize(index[:half], len(index)), half)
            upper = work(np.resize(index[half:count], len(index)), count - half)
            return np.concatenate([lower[0], upper[0]]), np.concatenate([lower[1], upper[1]])
        mine = type(ordered)(*(a[begin:end] for a in ordered))
        mine = mine._replace(owner=mine.owner - index[0])
        part = Lines(lines.level[index], lines.start[index], mine, lines.trusted[index])
        chosen = Poles(*(a[index] for a in poles))
        root, settled = _dominant(take(contact, index), chosen, part, gains, first[index], step[index], nodes, effort)
        return root[:count], settled[:count]

    root, settled = (np.concatenate(p) for p in zip(*in_chunks(work, np.arange(len(first))), strict=True))
    return root, settled, nodes


def _dominant(
    contact: Contact,
    poles: Poles,
    lines: Lines,
    gains: Array,
    first: Array,
    step: Array,
    nodes: int,
    effort: _Effort,
) -> tuple[Array, Array]:
    level, crossings = lines.level, lines.crossings
    begun = (
        crossing_starts(crossings),
        double_starts(contact, level, poles, float(gains[-1])),
        pole_starts(poles, level, first),
    )
    starts = Starts(*map(np.concatenate, zip(*begun, strict=True)))
    paths, slopes = follow(contact, level, starts, first, step, nodes, effort.parts)
    position = np.ceil(np.log(crossings.gain / first[crossings.owner]) / step[crossings.owner]).astype(int)
    lead = leaders(starts, paths, slopes, level, lines.beyond(position, nodes))
    found = dominant(contact, lead.ends, lead.rest, lead.closed, first, step, gains, effort.steps)
    root: Array
    root, change, clear = map(np.asarray, found)
    settled = clear & (change < _CONVERGED) & (root.real > level[:, None]) & lines.trusted[:, None]
    return np.where(settled, root, np.nan), settled
