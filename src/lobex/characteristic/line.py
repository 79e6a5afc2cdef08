"""How many roots lie to the right of a line Re z = x at one gain, by cells that cannot hide one.

With w = e^{−z} M(z) the roots are those of 1 − w. Their number to the right of a line is that of the poles of M
there, plus the turns of 1 − w about 0 down the line (the argument principle); and 1 − w turns once where w crosses
the real axis beyond 1. Where |w| < 1 nothing can, and where |w| > 1 the phase of w at the ends of a cell says how often
it did, however often e^{−z} turns in between. A cell is decided by bounds of M and M′ from the distances of
its points to the poles, and halved until it is: nothing is sampled.
"""

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from lobex.characteristic.cells import Cells, bounds, decide, first_cells
from lobex.characteristic.closed_loop import Loops
from lobex.characteristic.lanes import in_batches, take

Array = Any

# Places that are reported for each line.
PLACES = 3


class Count(NamedTuple):
    """Roots to the right of lines, (k,).

    Attributes:
        roots: their number.
        decided: whether every cell was.
        places: z on the line next to which some of them lie, (k, PLACES + 1), NaN-filled.
    """

    roots: Array
    decided: Array
    places: Array


def roots_beyond(loops: Loops, on_device: Any, lane: Array, level: Array) -> Count:
    """Count the roots of the lanes (k,) to the right of Re z = ``level``, (k,).

    Args:
        loops: of every lane, on the host.
        on_device: the same loops, where they are computed with.
        lane: numbers of lanes.
        level: x.
    """
    mine = take(loops, lane)
    number = np.sum(mine.upper.real > level, axis=0) + np.sum(mine.lower.real > level, axis=0)
    # Half of the line says what the other does, but for the crossing at its middle.
    on_axis = response(mine, level + 0j).real
    with np.errstate(divide="ignore"):
        beyond_one = (on_axis > 0) & (np.log(np.abs(on_axis)) > level)
    number = number - beyond_one
    found: list[tuple[Array, Array, Array]] = []

    def look(cells: Cells) -> Array:
        arrays = lane[cells.line], level[cells.line], cells.low, cells.high
        split, passed, place, height = in_batches(partial(_crossings, on_device), arrays)
        np.add.at(number, cells.line, 2 * passed)
        hit = np.flatnonzero(passed)
        found.append((cells.line[hit], place[hit], height[hit]))
        return split

    decided = decide(first_cells(mine, level, level), look, len(lane))
    return Count(number, decided, _places(found, level, beyond_one))


def response(loops: Loops, z: Array) -> Array:
    """M at z, (lanes,)."""
    with np.errstate(all="ignore"):
        return np.sum((loops.first * z + loops.constant) / ((z - loops.upper) * (z - loops.lower)), axis=0)


def _places(found: list[tuple[Array, Array, Array]], level: Array, beyond_one: Array) -> Array:
    """The places of the highest |w| of each line, and the real axis where a root is on it."""
    places = np.full((len(level), PLACES + 1), np.nan + 0j)
    places[beyond_one, PLACES] = level[beyond_one]
    line, place, height = map(np.concatenate, zip(*found, strict=True))
    order = np.lexsort((-height, line))
    line, place = line[order], place[order]
    rank = np.arange(len(line)) - np.searchsorted(line, line)
    kept = rank < PLACES
    places[line[kept], rank[kept]] = level[line[kept]] + 1j * place[kept]
    return places


def on_line(loops: Loops, level: Array, y: Array) -> tuple[Array, Array]:
    """M at x + jy, real and imaginary part."""
    left, right = level - loops.upper.real, level - loops.lower.real
    above, below = y - loops.upper.imag, y - loops.lower.imag
    real, imaginary = left * right - above * below, left * below + right * above
    top_real, top_imaginary = loops.first * level + loops.constant, loops.first * y
    scale = 1 / (jnp.square(real) + jnp.square(imaginary))
    return (
        jnp.sum((top_real * real + top_imaginary * imaginary) * scale, axis=0),
        jnp.sum((top_imaginary * real - top_real * imaginary) * scale, axis=0),
    )


@jax.jit
def _crossings(loops: Loops, lane: Array, level: Array, low: Array, high: Array) -> tuple[Array, ...]:
    """Whether to halve a cell; if not, crossings counted downwards; with a place of one, and log |w| in the middle."""
    mine = take(loops, lane)
    over = bounds(mine, level, low, high)
    real, imaginary = on_line(mine, level, over.middle)
    size = jnp.sqrt(jnp.square(real) + jnp.square(imaginary))
    change = over.slope * over.half
    height = jnp.log(size) - level
    quiet = (jnp.log(jnp.minimum(over.value, size + change)) < level) | (over.narrow & (height <= 0))
    share = change / size
    phase = jnp.arctan2(imaginary, real) - over.middle
    turn = phase - 2 * jnp.pi * jnp.round(phase / (2 * jnp.pi))
    apart = (share < 1) & (jnp.abs(turn) > over.half + jnp.arcsin(jnp.minimum(share, 1.0)))
    loud = (share < 1) & (jnp.log(size - change) > level) | over.narrow
    ends = []
    for y in (low, high):
        here, there = on_line(mine, level, y)
        # Turned from the middle by less than a right angle where the cell is loud.
        swing = jnp.arctan2(there * real - here * imaginary, here * real + there * imaginary)
        ends.append((jnp.mod(jnp.arctan2(there, here) - y, 2 * jnp.pi), swing))
    (begin, before), (end, after) = ends
    passed = jnp.round((end - begin - (after - before) + (high - low)) / (2 * jnp.pi)).astype(int)
    counted = loud & ~quiet & ~apart
    place = jnp.clip(over.middle + turn, low, high)
    return ~(quiet | apart | loud), jnp.where(counted, passed, 0), place, height
