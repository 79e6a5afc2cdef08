"""How many nodes per piece points begin with, and go on to while these are too few: some sizes, as each is compiled."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from lobex.grids.dominant import Dominant
from lobex.operators.duhamel import Duhamel
from lobex.operators.response import quickness, tail_bound
from lobex.processes.process import Process
from lobex.systems.mesh import mesh_of

# Every second one for any points, the others where many of them begin there.
_SIZES = (6, 8, 10, 13, 16, 20, 26, 33, 42, 53, 68, 86, 110)
# And for few pieces through which a mode turns a hundred times, as long as forces are not more.
_LARGE, _MOST_FORCES = (178, 288, 466), 700
MANY = 20_000
"""Points for which it is quicker to compile several sizes than to compute them all with one."""
# Of these, how many a size between has to serve.
_BETWEEN = 4_000
# The same where pieces are more than this, whose operators take longer to compute than to compile.
_PIECES = 4
# Radians over half a piece that coefficients add to those of the first mode, for the first guess alone, and the part
# of a period below which a piece has but its share of them.
_BY_COEFFICIENTS, _SHARED = 1.5, 0.25
# How much of them nodes may miss, in roots of the tolerance, for that: where a wrong guess costs one more size, and
# where it costs a few points.
_SAFE, _BOLD = 2.0, 20.0
# Of the tolerance, what the error at a point may be for its neighbours to meet it too.
_MARGIN = 0.1


class NodeCounts(NamedTuple):
    """The sizes in turn, and the indices of those to begin and to end with at each of the speeds."""

    sizes: tuple[int, ...]
    first: np.ndarray
    last: np.ndarray


def node_counts(
    process: Process,
    method: Duhamel,
    speeds: np.ndarray,
    points: np.ndarray,
    followed: Callable[[np.ndarray], float],
    accuracy: float,
) -> NodeCounts:
    """From how far the mode that is ``followed`` turns at speeds (n,), with so many points at each, (n,)."""
    if method.nodes is not None:
        return NodeCounts((method.nodes,), np.zeros(len(speeds), dtype=int), np.zeros(len(speeds), dtype=int))
    ends = np.array([np.min(speeds), np.max(speeds)])
    # Turning is a power of the speed, or nearly, unless what is called speed is something else.
    turns = [turn_of(process, speed, 0.0, followed) for speed in ends]
    system = process.system(ends[0], 0.0)
    mesh = mesh_of(system)
    pieces, widest = mesh.pieces, float(np.max(mesh.length))
    half = np.exp(np.interp(np.log(speeds), np.log(ends), np.log(turns)))
    half = half + _BY_COEFFICIENTS * min(widest / _SHARED, 1.0)
    fine = np.array(_SIZES)
    large = [size for size in _LARGE if size * pieces * system.force_size <= _MOST_FORCES]
    # Of few points it is quicker to compute some too finely than to compile one more size, unless pieces are many.
    apart = np.sum(points) >= MANY or pieces > _PIECES
    missed = (_BOLD if apart else _SAFE) * np.sqrt(accuracy)
    begun = np.sum(_coarse(half, fine, missed), axis=1)
    between = (np.bincount(begun, points, minlength=len(fine)) >= _BETWEEN)[: len(fine)] & apart
    between[::2] = True
    sizes = np.array([*fine[between], *large])
    coarse = _coarse(half, sizes, missed)
    # Where the finest would not do either, it is not tried.
    last = np.where(coarse[:, -1], len(sizes) - len(large), len(sizes)) - 1
    first = np.minimum(np.sum(coarse, axis=1), last)
    return NodeCounts(tuple(map(int, sizes)), first if apart else np.minimum(first.max(), last), last)


def enough_nodes(found: Dominant, tolerance: float) -> int:
    """Nodes with which all of the points found, and others near them, are well within the tolerance."""
    near = found.nodes[found.error > _MARGIN * tolerance]
    enough = np.max(found.nodes)
    return int(next((size for size in _SIZES[::2] if size > np.max(near, initial=0) and size >= enough), enough))


def _coarse(half: np.ndarray, sizes: np.ndarray, missed: float) -> np.ndarray:
    """Whether sizes (k,) miss more of a turn of ±x radians, (n,), shape (n, k)."""
    return np.asarray(tail_bound(half[:, None], sizes)) > missed


def turn_of(process: Process, speed: float, gain: float, followed: Callable[[np.ndarray], float]) -> float:
    """Radians that the mode to follow turns through in half of the widest piece in contact."""
    system = process.system(speed, gain)
    rate = float(followed(np.asarray(quickness(np.asarray(system.blocks)))))
    widest = float(np.max(mesh_of(system).length))
    return max(np.nan_to_num(rate * float(system.period) * widest / 2), np.finfo(float).tiny)
