"""How many roots lie to the right of a line Re z = x, at all gains of an interval at once.

With k = 1/K the roots are where k + L(z) = 0, L = −(p + q e^{−z}) H. While k goes over an interval no root passes the
line if −L misses the interval everywhere on it, and then the number of roots to the right is the same for all its
gains. A cell of the line is decided in one of three ways, each by bounds of H and H′ from the distances to the poles:
the delayed part is smaller than the rest, |q e^{−z} H| < |k − p H|, for all k; it is larger for all k; or
−L in its middle is further from the interval than it can change in half a cell. The number itself is counted at the
largest |K|, as in ``line``.
"""

from functools import partial
from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np

from lobex.characteristic.cells import Cells, bounds_of_mode, decide, first_cells, over_modes, value_of_mode
from lobex.characteristic.closed_loop import Loops
from lobex.characteristic.function import decaying
from lobex.characteristic.lanes import in_batches, take

Array = Any

_DONE, _SPLIT, _LOUD, _CLEAR = 0, 1, 2, 3
# How often a cell is divided before its strip is given up.
_ROUNDS = 7
# Of batches.
_SIZE = (1024,)


class Open(NamedTuple):
    """L = −(p + q e^{−z}) H of lanes (b,): p, q, and H as the loop that it makes alone."""

    present: Array
    delayed: Array
    loops: Loops

    def filled(self) -> "Open":
        """With modes that add nothing, up to one of a few numbers of them, for which programs are compiled."""
        return self._replace(loops=self.loops.filled())


class Strips(NamedTuple):
    """Each (k,): the number of the lane, x, and the gains of smallest and of largest modulus, of one sign."""

    lane: Array
    level: Array
    weakest: Array
    strongest: Array


def roots_over(opened: Open, on_device: Open, strips: Strips, poles: Array) -> tuple[Array, Array]:
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
        at = np.sum(
            (mine.loops.first * level + mine.loops.constant)
            / ((level - mine.loops.upper) * (level - mine.loops.lower)),
            axis=0,
        ).real
        number = poles - (mine.delayed * size * at / (low - mine.present * at) > 1)

    def look(cells: Cells) -> Array:
        line = cells.line
        arrays = lane[line], level[line], low[line], high[line], cells.low, cells.high
        (code,) = in_batches(partial(_look, on_device), arrays, _SIZE)
        turning = np.nonzero(code >= _LOUD)
        if len(turning[0]):
            line, begin, end = cells.at(*turning)
            arrays = lane[line], level[line], low[line], begin, end, code[turning] == _LOUD
            (passed,) = in_batches(partial(_passed, on_device), arrays, _SIZE)
            np.add.at(number, line, 2 * passed)
        return code == _SPLIT

    with np.errstate(all="ignore"):
        least = np.abs(low) / (np.abs(mine.present) + np.abs(mine.delayed) * size)
        decided = decide(first_cells(mine.loops, level, least), look, len(lane), _ROUNDS)
    return number, decided


def _beyond(distance: Array, along: Array, low: Array, high: Array) -> Array:
    """The distance of points from the interval between two numbers: of their height, and along it."""
    least, most = jnp.minimum(low, high), jnp.maximum(low, high)
    return jnp.hypot(distance, jnp.maximum(jnp.maximum(least - along, along - most), 0.0))


@jax.jit
def _look(opened: Open, lane: Array, level: Array, k: Array, other: Array, low: Array, high: Array) -> tuple[Array]:
    """What is to be done with cells, for all 1/K between k and the other."""
    mine = take(opened, lane)
    low, high = low.T, high.T
    middle, half = (low + high) / 2, (high - low) / 2
    z = jax.lax.complex(jnp.broadcast_to(level, low.shape), middle)

    def term(mode: Loops) -> tuple[Array, ...]:
        over = bounds_of_mode(mode, level, middle, half)
        return value_of_mode(mode, z), over.value, over.slope

    value, most, steepest = over_modes(term, mine.loops, (z, low, low))
    modulus = jnp.abs(value)
    change = steepest * half
    present, delayed = jnp.abs(mine.present), jnp.abs(mine.delayed) * jnp.exp(-level)
    across, along = mine.present * value.imag, mine.present * value.real
    nearest = _beyond(across, along, k, other) - present * change
    farthest = jnp.hypot(across, jnp.maximum(jnp.abs(along - k), jnp.abs(along - other))) + present * change
    quiet = delayed * jnp.minimum(modulus + change, most) < nearest
    # The rest keeps its phase to within half a turn.
    steady = jnp.hypot(across, along - k) > present * change
    loud = steady & (delayed * (modulus - change) > farthest)
    feedback = mine.present + mine.delayed * decaying(z)
    loop = feedback * value
    nearby = jnp.minimum(jnp.abs(feedback) + delayed * half, present + delayed)
    moved = half * (delayed * jnp.minimum(most, modulus + change) + nearby * steepest)
    # −L is what misses the interval.
    clear = steady & (_beyond(loop.imag, loop.real, k, other) > moved)
    # 1 − w has a positive real part in the middle, and turns by less than a quarter from there: w passes nothing.
    rest, whole = k - along, k - loop.real
    size, whole_size = jnp.square(rest) + jnp.square(across), jnp.square(whole) + jnp.square(loop.imag)
    ahead = rest * whole + across * loop.imag > 0
    apart = ahead & (jnp.square(moved) * size + jnp.square(present * change) * whole_size < size * whole_size)
    code = jnp.where(quiet | (clear & apart), _DONE, jnp.where(loud, _LOUD, jnp.where(clear, _CLEAR, _SPLIT)))
    return (code.astype(jnp.int8).T,)


@jax.jit
def _passed(opened: Open, lane: Array, level: Array, k: Array, low: Array, high: Array, loud: Array) -> tuple[Array]:
    """How often w passes the real axis beyond 1 downwards in a cell, at 1/K = k."""
    mine = take(opened, lane)
    places = jax.lax.complex(level, low), jax.lax.complex(level, high)

    def term(mode: Loops) -> tuple[Array, ...]:
        return tuple(value_of_mode(mode, z) for z in places)

    begin, end = over_modes(term, mine.loops, places)
    # Nothing but rounding on the real axis, where its sign would be counted.
    begin = jax.lax.complex(begin.real, cast(Array, jnp.where(low == 0, 0.0, begin.imag)))
    rest = [k - mine.present * h for h in (begin, end)]
    delayed = [mine.delayed * h * decaying(z) for h, z in zip((begin, end), places, strict=True)]
    whole = [r - d for r, d in zip(rest, delayed, strict=True)]

    def angle(pair: list[Array]) -> Array:
        """From the first to the second, by less than π."""
        return jnp.angle(pair[1] * pair[0].conj())

    # The argument of 1 − w, followed, and as the principal value has it.
    opening = angle(rest)
    by_delay = angle([begin, end]) - (high - low) + angle([w * d.conj() for w, d in zip(whole, delayed, strict=True)])
    turned = jnp.where(loud, by_delay, angle(whole)) - opening
    before, after = (jnp.angle(w * r.conj()) for w, r in zip(whole, rest, strict=True))
    before = jnp.where((low == 0) & (jnp.abs(before) > jnp.pi / 2), -jnp.pi, before)
    return (-jnp.round((turned - (after - before)) / (2 * jnp.pi)).astype(int),)
