"""How many roots lie to the right of a line Re z = x at one gain, by cells that cannot hide one.

With w = e^{−z} M(z) the roots are those of 1 − w. Their number to the right of a line is that of the poles of M
there, plus the turns of 1 − w about 0 down the line (the argument principle); and 1 − w turns once where w crosses
the real axis beyond 1. Where |w| < 1 nothing can, and where |w| > 1 the phase of w at the ends of a cell says how often
it did, however often e^{−z} turns in between. A cell is decided by bounds of M and M′ from the distances of
its points to the poles, and divided until it is: nothing is sampled.
"""

from functools import partial
from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float, Inexact, Int, Shaped

from lobex._batches import in_one_size
from lobex._compiled import compiled
from lobex.characteristic.cells import Cells, bounds_of_mode, decide, first_cells, narrow, over_modes, value_of_mode
from lobex.characteristic.closed_loop import Loops
from lobex.characteristic.lanes import take

_DONE, _SPLIT, _LOUD = 0, 1, 2
# Places that are reported for each line.
PLACES = 3


class Count(NamedTuple):
    """Roots to the right of lines, (k,).

    Attributes:
        roots: their number.
        decided: whether every cell was.
        places: z on the line next to which some of them lie, (k, PLACES + 1), NaN-filled.
    """

    roots: Int[Any, " k"]
    decided: Bool[Any, " k"]
    places: Complex[Any, "k p"]


def roots_beyond(loops: Loops, on_device: Any, lane: Int[Any, " k"], level: Float[Any, " k"]) -> Count:
    """Count the roots of the lanes (k,) to the right of Re z = ``level``, (k,).

    Args:
        loops: of every lane, on the host.
        on_device: the same loops, where they are computed with.
        lane: numbers of lanes.
        level: x.
    """
    mine = take(loops, lane)
    number = np.sum(mine.upper.real > level, axis=0) + np.sum(mine.lower.real > level, axis=0)
    # Half of the line says what the other does, but for its middle.
    with np.errstate(all="ignore"):
        size = np.exp(-level)
        beyond_one = response_of_loops(mine, level + 0j).real * size > 1
    number = number - beyond_one
    found: list[tuple[Any, ...]] = []

    def look(cells: Cells) -> Bool[Any, "c parts"]:
        arrays = lane[cells.line], level[cells.line], size[cells.line], cells.low, cells.high
        code, turn, height = verdicts_of(on_device, *arrays)
        loud = np.nonzero(code == _LOUD)
        if len(loud[0]):
            line, low, high = cells.at(*loud)
            (passed,) = passes_of(on_device, lane[line], level[line], low, high)
            np.add.at(number, line, 2 * passed)
            hit = np.flatnonzero(passed)
            line, low, high = line[hit], low[hit], high[hit]
            place = np.clip((low + high) / 2 + turn[loud][hit], low, high)
            found.append((line, place, height[loud][hit]))
        return code == _SPLIT

    with np.errstate(all="ignore"):
        decided = decide(first_cells(mine, level, np.exp(level)), look, len(lane))
    return Count(number, decided, _places(found, level, beyond_one))


def verdicts_of(on_device: Any, *cells: Shaped[Any, "c ..."]) -> Any:
    """As ``_look``, of any number of cells."""
    return in_one_size(partial(_look, on_device), cells)


def passes_of(on_device: Any, *cells: Shaped[Any, " c"]) -> Any:
    """As ``_passed``, of any number of cells."""
    return in_one_size(partial(_passed, on_device), cells)


def response_of_loops(loops: Loops, z: Complex[Any, " l"]) -> Complex[Any, " l"]:
    """M at z, (lanes,)."""
    with np.errstate(all="ignore"):
        return np.sum((loops.first * z + loops.constant) / ((z - loops.upper) * (z - loops.lower)), axis=0)


def _places(
    found: list[tuple[Shaped[Any, " _"], ...]],
    level: Float[Any, " k"],
    beyond_one: Bool[Any, " k"],
) -> Complex[Any, "k p"]:
    """The places of the highest |w| of each line, and the real axis where a root is on it."""
    places = np.full((len(level), PLACES + 1), np.nan + 0j)
    places[beyond_one, PLACES] = level[beyond_one]
    if not found:
        return places
    line, place, height = map(np.concatenate, zip(*found, strict=True))
    order = np.lexsort((-height, line))
    line, place = line[order], place[order]
    rank = np.arange(len(line)) - np.searchsorted(line, line)
    kept = rank < PLACES
    places[line[kept], rank[kept]] = level[line[kept]] + 1j * place[kept]
    return places


@compiled
def _look(
    loops: Loops,
    lane: Int[Any, " c"],
    level: Float[Any, " c"],
    scale: Float[Any, " c"],
    low: Float[Any, "c parts"],
    high: Float[Any, "c parts"],
) -> tuple[Int[Any, "c parts"], Float[Any, "c parts"], Float[Any, "c parts"]]:
    """What is to be done with cells; how far w in their middles is turned from the real axis, rad; and |w| there."""
    mine = take(loops, lane)
    low, high = low.T, high.T
    middle, half = (low + high) / 2, (high - low) / 2
    mine = mine._replace(first=mine.first * scale, constant=mine.constant * scale)

    z = jax.lax.complex(jnp.broadcast_to(level, low.shape), middle)

    def term(mode: Loops) -> tuple[Inexact[Any, "parts c"], ...]:
        over = bounds_of_mode(mode, level, middle, half)
        return value_of_mode(mode, z), over.value, over.slope

    value, most, steepest = over_modes(term, mine, (z, low, low))
    size = jnp.sqrt(jnp.square(value.real) + jnp.square(value.imag))
    change = steepest * half
    phase = jnp.arctan2(value.imag, value.real) - middle
    turn = phase - 2 * jnp.pi * jnp.round(phase / (2 * jnp.pi))
    smallest = narrow(middle, half)
    quiet = (jnp.minimum(most, size + change) < 1) | (smallest & (size <= 1))
    share = jnp.minimum(change / size, 1.0)
    # arcsin s ≤ s + (π/2 − 1) s³
    apart = (share < 1) & (jnp.abs(turn) > half + share + (jnp.pi / 2 - 1) * share**3)
    loud = (size - change > 1) | smallest
    code = jnp.where(quiet | apart, _DONE, jnp.where(loud, _LOUD, _SPLIT))
    return code.astype(jnp.int8).T, turn.T, size.T


@compiled
def _passed(
    loops: Loops, lane: Int[Any, " c"], level: Float[Any, " c"], low: Float[Any, " c"], high: Float[Any, " c"]
) -> tuple[Int[Any, " c"]]:
    """How often w passes the real axis beyond 1 downwards, in a cell where |w| > 1 and M turns by less than π."""
    mine = take(loops, lane)
    places = jax.lax.complex(level, low), jax.lax.complex(level, high)

    def term(mode: Loops) -> tuple[Complex[Any, " c"], ...]:
        return tuple(value_of_mode(mode, z) for z in places)

    first, last = over_modes(term, mine, places)
    # Nothing but rounding on the real axis, where its sign would be counted.
    first = jax.lax.complex(first.real, cast(Array, jnp.where(low == 0, 0.0, first.imag)))
    begin, end = jnp.mod(jnp.angle(first) - low, 2 * jnp.pi), jnp.mod(jnp.angle(last) - high, 2 * jnp.pi)
    swing = jnp.angle(last * first.conj())
    return (jnp.round((end - begin - swing + (high - low)) / (2 * jnp.pi)).astype(int),)
