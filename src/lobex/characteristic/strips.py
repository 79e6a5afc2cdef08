"""How many roots lie to the right of a line Re z = x, at all gains of an interval at once.

With k = 1/K the roots are where k + L(z) = 0, L = −P − Q e^{−z}, P = Σ p H and Q = Σ q H. While k goes over an
interval no root passes the line if −L misses the interval everywhere on it, and then the number of roots to the right
is the same for all its gains. A cell of the line is decided in one of three ways, each by bounds of H and H′ from the
distances to the poles: the delayed part is smaller than the rest, |Q e^{−z}| < |k − P|, for all k; it is larger for
all k; or −L in its middle is further from the interval than it can change in half a cell. The number itself is
counted at the largest |K|, as in ``line``.
"""

from functools import partial
from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float, Int, Shaped

from lobex._batches import in_one_size
from lobex._compiled import compiled
from lobex.characteristic.cells import Cells, bounds_of_mode, decide, first_cells, over_modes, value_of_mode
from lobex.characteristic.closed_loop import Loops
from lobex.characteristic.function import decaying
from lobex.characteristic.lanes import take
from lobex.characteristic.open_loop import Open, weighted

_DONE, _SPLIT, _LOUD, _CLEAR = 0, 1, 2, 3
# How often a cell is divided before its strip is given up.
_ROUNDS = 7


class Strips(NamedTuple):
    """Each (k,): the number of the lane, x, and the gains of smallest and of largest modulus, of one sign."""

    lane: Int[Any, " k"]
    level: Float[Any, " k"]
    weakest: Float[Any, " k"]
    strongest: Float[Any, " k"]


def roots_over(
    opened: Open, on_device: Open, strips: Strips, poles: Int[Any, " k"]
) -> tuple[Int[Any, " k"], Bool[Any, " k"]]:
    """The number of roots to the right of the lines at every gain of the strips, (k,), and whether it is known.

    Args:
        opened: of every lane, on the host.
        on_device: the same, where it is computed with.
        strips: the lines, and their gains.
        poles: how many poles of M lie to the right of each line at its strongest gain, (k,).
    """
    lane, level = strips.lane, strips.level
    mine = take(opened, lane)
    with np.errstate(all="ignore"):
        size = np.exp(-level)
        low, high = 1 / strips.strongest, 1 / strips.weakest
        bottom = (level - mine.loops.upper) * (level - mine.loops.lower)
        at = np.sum((mine.loops.first * level + mine.loops.constant) / bottom[:, None], axis=0).real
        number = poles - (weighted(mine.delayed, at) * size / (low - weighted(mine.present, at)) > 1)

    def look(cells: Cells) -> Bool[Any, "c parts"]:
        line = cells.line
        (code,) = verdicts_over(on_device, lane[line], level[line], low[line], high[line], cells.low, cells.high)
        turning = np.nonzero(code >= _LOUD)
        if len(turning[0]):
            line, begin, end = cells.at(*turning)
            loud = code[turning] == _LOUD
            (passed,) = passes_over(on_device, lane[line], level[line], low[line], begin, end, loud)
            np.add.at(number, line, 2 * passed)
        return code == _SPLIT

    with np.errstate(all="ignore"):
        decided = decide(first_cells(mine.bounding(size), level, np.abs(low)), look, len(lane), _ROUNDS)
    return number, decided


def verdicts_over(on_device: Open, *cells: Shaped[Any, "c ..."]) -> Any:
    """As ``_look``, of any number of cells."""
    return in_one_size(partial(_look, on_device), cells)


def passes_over(on_device: Open, *cells: Shaped[Any, " c"]) -> Any:
    """As ``_passed``, of any number of cells."""
    return in_one_size(partial(_passed, on_device), cells)


def _beyond(
    distance: Float[Any, "..."], along: Float[Any, "..."], low: Float[Any, "..."], high: Float[Any, "..."]
) -> Float[Any, "..."]:
    """The distance of points from the interval between two numbers: of their height, and along it."""
    least, most = jnp.minimum(low, high), jnp.maximum(low, high)
    return jnp.hypot(distance, jnp.maximum(jnp.maximum(least - along, along - most), 0.0))


@compiled
def _look(
    opened: Open,
    lane: Int[Any, " c"],
    level: Float[Any, " c"],
    k: Float[Any, " c"],
    other: Float[Any, " c"],
    low: Float[Any, "c parts"],
    high: Float[Any, "c parts"],
) -> tuple[Int[Any, "c parts"]]:
    """What is to be done with cells, for all 1/K between k and the other."""
    mine = take(opened, lane)
    low, high = low.T, high.T
    middle, half = (low + high) / 2, (high - low) / 2
    z = jax.lax.complex(jnp.broadcast_to(level, low.shape), middle)

    def term(mode: Loops) -> Any:
        bounds = [bounds_of_mode(one, level, middle, half) for one in mode.each()]
        values = [value_of_mode(one, z) for one in mode.each()]
        return values, [over.value for over in bounds], [over.slope for over in bounds]

    outputs = len(mine.present)
    values, most, steepest = over_modes(term, mine.loops, ([z] * outputs, [low] * outputs, [low] * outputs))
    present, delayed = jnp.abs(mine.present), jnp.abs(mine.delayed) * jnp.exp(-level)
    now, before = weighted(mine.present, values), weighted(mine.delayed, values)
    across, along = now.imag, now.real
    change = weighted(present, steepest) * half
    nearest = _beyond(across, along, k, other) - change
    farthest = jnp.hypot(across, jnp.maximum(jnp.abs(along - k), jnp.abs(along - other))) + change
    largest, varying = jnp.abs(before) * jnp.exp(-level), weighted(delayed, steepest) * half
    quiet = jnp.minimum(largest + varying, weighted(delayed, most)) < nearest
    # The rest keeps its phase to within half a turn.
    steady = jnp.hypot(across, along - k) > change
    loud = steady & (largest - varying > farthest)
    turned = decaying(z)
    loop = now + before * turned
    nearby = [
        jnp.minimum(jnp.abs(p + q * turned) + by * half, at_once + by)
        for p, q, at_once, by in zip(mine.present, mine.delayed, present, delayed, strict=True)
    ]
    moved = half * (jnp.minimum(weighted(delayed, most), largest + varying) + weighted(nearby, steepest))
    # −L is what misses the interval.
    clear = steady & (_beyond(loop.imag, loop.real, k, other) > moved)
    # 1 − w has a positive real part in the middle, and turns by less than a quarter from there: w passes nothing.
    rest, whole = k - along, k - loop.real
    size, whole_size = jnp.square(rest) + jnp.square(across), jnp.square(whole) + jnp.square(loop.imag)
    ahead = rest * whole + across * loop.imag > 0
    apart = ahead & (jnp.square(moved) * size + jnp.square(change) * whole_size < size * whole_size)
    code = jnp.where(quiet | (clear & apart), _DONE, jnp.where(loud, _LOUD, jnp.where(clear, _CLEAR, _SPLIT)))
    return (code.astype(jnp.int8).T,)


@compiled
def _passed(
    opened: Open,
    lane: Int[Any, " c"],
    level: Float[Any, " c"],
    k: Float[Any, " c"],
    low: Float[Any, " c"],
    high: Float[Any, " c"],
    loud: Bool[Any, " c"],
) -> tuple[Int[Any, " c"]]:
    """How often w passes the real axis beyond 1 downwards in a cell, at 1/K = k."""
    mine = take(opened, lane)
    places = jax.lax.complex(level, low), jax.lax.complex(level, high)

    def term(mode: Loops) -> Any:
        return [[value_of_mode(one, z) for one in mode.each()] for z in places]

    values = over_modes(term, mine.loops, [[z] * len(mine.present) for z in places])
    now, before = ([weighted(part, at) for at in values] for part in (mine.present, mine.delayed))
    # Nothing but rounding on the real axis, where its sign would be counted.
    for part in (now, before):
        part[0] = jax.lax.complex(part[0].real, cast(Array, jnp.where(low == 0, 0.0, part[0].imag)))
    rest = [k - p for p in now]
    delayed = [q * decaying(z) for q, z in zip(before, places, strict=True)]
    whole = [r - d for r, d in zip(rest, delayed, strict=True)]

    def angle(pair: list[Complex[Any, " c"]]) -> Float[Any, " c"]:
        """From the first to the second, by less than π."""
        return jnp.angle(pair[1] * pair[0].conj())

    # The argument of 1 − w, followed, and as the principal value has it.
    opening = angle(rest)
    by_delay = angle(before) - (high - low) + angle([w * d.conj() for w, d in zip(whole, delayed, strict=True)])
    turned = jnp.where(loud, by_delay, angle(whole)) - opening
    first, last = (jnp.angle(w * r.conj()) for w, r in zip(whole, rest, strict=True))
    first = jnp.where((low == 0) & (jnp.abs(first) > jnp.pi / 2), -jnp.pi, first)
    return (-jnp.round((turned - (last - first)) / (2 * jnp.pi)).astype(int),)
