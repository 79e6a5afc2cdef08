"""Every place on the imaginary axis where a root stands at some gain, by cells that cannot hide one.

For 1 + K L(z) = 0 that is where L(jy) is real and negative, at K = −1/L (D-subdivision: Neimark, 1949). A part of the
axis holds no such place where |L| < 1/K for all gains asked for, or where the phase of L cannot reach π; and it holds
one at most where that phase can only rise or only fall. Bounds of L, L′ and L″ from the distances to the poles say so,
and a part is divided until they do: nothing is sampled.
"""

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Complex, Float, Int, Shaped

from lobex._batches import in_one_size
from lobex._compiled import compiled
from lobex.characteristic.cells import Bounds, Cells, bounds_of_mode, decide, first_cells, narrow, over_modes
from lobex.characteristic.closed_loop import Loops
from lobex.characteristic.lanes import placed, take
from lobex.characteristic.open_loop import Open, weighted

_STEPS = 8


class AxisPlaces(NamedTuple):
    """Where L(jy) is real and negative, y > 0, each (e,).

    Attributes:
        lane: whose L.
        height: y.
        gain: K = −1/L.
        rate: dz/d(log K) of the root that stands there.
        moved: how far the last of Newton's steps moved K.
    """

    lane: Int[Any, " e"]
    height: Float[Any, " e"]
    gain: Float[Any, " e"]
    rate: Complex[Any, " e"]
    moved: Float[Any, " e"]


def axis_places(feedback: Open, largest: float) -> tuple[AxisPlaces, Bool[Any, " b"]]:
    """The places with K up to ``largest``, and whether those of a lane are all known, (b,)."""
    lanes = np.shape(feedback.present)[1]
    found: list[tuple[Any, ...]] = []
    there = placed(feedback.filled())
    level = np.zeros(lanes)

    def look(cells: Cells) -> Bool[Any, "c parts"]:
        index = np.full(len(cells.line), largest), *cells
        split, crossed = in_one_size(partial(_crossed, there), index)
        found.append(cells.at(*np.nonzero(crossed)))
        return split

    least = np.full(lanes, 1 / largest)
    decided = decide(first_cells(feedback.bounding(np.ones(lanes)), level, least), look, lanes)
    lane, low, high = map(np.concatenate, zip(*found, strict=True))
    height, gain, rate, moved, good = in_one_size(partial(_place, there), (lane, low, high))
    decided[lane[~good]] = False
    kept = good & (gain <= largest)
    return AxisPlaces(*(part[kept] for part in (lane, height, gain, rate, moved))), decided


def _responses_of_mode(mode: Loops, y: Float[Any, " *cells"]) -> list[list[Complex[Any, " *cells"]]]:
    """Each H and each H′ at jy."""
    upper, lower = 1 / (1j * y - mode.upper), 1 / (1j * y - mode.lower)
    values = [(one.first * 1j * y + one.constant) * upper * lower for one in mode.each()]
    slopes = [
        one.first * upper * lower - value * (upper + lower) for one, value in zip(mode.each(), values, strict=True)
    ]
    return [values, slopes]


def _looped(
    feedback: Open,
    y: Float[Any, " *cells"],
    response: list[Complex[Any, " *cells"]],
    slope: list[Complex[Any, " *cells"]],
) -> tuple[Complex[Any, " *cells"], Complex[Any, " *cells"]]:
    """L and L′ at jy from H and H′."""
    turned = _turned(feedback, y)
    before = [q * turn for q, turn in zip(feedback.delayed, turned, strict=True)]
    fading = before if feedback.lag is None else [q * turn for q, turn in zip(feedback.fading, turned, strict=True)]
    whole = [p + b for p, b in zip(feedback.present, before, strict=True)]
    return -weighted(whole, response), weighted(fading, response) - weighted(whole, slope)


def _turned(feedback: Open, y: Any) -> list[Any]:
    """e^{−jyθ} of each output."""
    if feedback.lag is None:
        return [jnp.exp(-1j * y)] * len(feedback.present)
    return [jnp.exp(-1j * lag * y) for lag in feedback.lag]


def _loop(feedback: Open, y: Float[Any, " *cells"]) -> tuple[Complex[Any, " *cells"], Complex[Any, " *cells"]]:
    """L and L′ at jy."""
    like = [[y + 0j] * len(feedback.present)] * 2
    return _looped(feedback, y, *over_modes(partial(_responses_of_mode, y=y), feedback.loops, like))


@compiled
def _crossed(
    feedback: Open,
    largest: Float[Any, " c"],
    lane: Int[Any, " c"],
    low: Float[Any, "c parts"],
    high: Float[Any, "c parts"],
) -> tuple[Bool[Any, "c parts"], Bool[Any, "c parts"]]:
    """Whether to divide cells, and, if not, whether the phase of −L passes 0 in them."""
    mine = take(feedback, lane)
    low, high = low.T, high.T
    middle, half = (low + high) / 2, (high - low) / 2

    def term(mode: Loops) -> Any:
        over = [bounds_of_mode(one, jnp.zeros_like(low), middle, half) for one in mode.each()]
        return over, _responses_of_mode(mode, middle)

    outputs = len(mine.present)
    like = [Bounds(low, low, low)] * outputs, [[low + 0j] * outputs] * 2
    over, response = over_modes(term, mine.loops, like)
    value, slope = _looped(mine, middle, *response)
    size = jnp.abs(value)
    most = steepest = bend = jnp.zeros_like(low)
    # Of shorter delays the bounds are those of the longest.
    for p, q, turn, bound in zip(mine.present, mine.delayed, _turned(mine, middle), over, strict=True):
        delayed = jnp.abs(q)
        nearby = jnp.abs(p + q * turn) + delayed * half
        most += nearby * bound.value
        steepest += delayed * bound.value + nearby * bound.slope
        bend += delayed * (bound.value + 2 * bound.slope) + nearby * bound.bend
    change = steepest * half
    quiet = jnp.minimum(most, size + change) * largest < 1
    share = change / size
    phase = jnp.angle(-value)
    apart = (share < 1) & (jnp.abs(phase) > jnp.arcsin(jnp.minimum(share, 1.0)))
    # The phase changes as Re(L′/L), and that by no more than its derivative's bound.
    least = size - change
    turning = jnp.abs((slope / value).real)
    one_way = (share < 0.5) & (turning > half * (bend / least + jnp.square(steepest / least)))
    begin, end = (jnp.angle(-_loop(mine, y)[0]) for y in (low, high))
    # The phase is 0 at y = 0 itself, which is looked at apart.
    crossed = (low > 0) & ((begin > 0) != (end > 0)) & (jnp.abs(begin) + jnp.abs(end) < jnp.pi)
    decided = quiet | apart | one_way | narrow(middle, half)
    return (~decided).T, (decided & ~quiet & ~apart & crossed).T


@compiled
def _place(
    feedback: Open, lane: Int[Any, " c"], low: Float[Any, " c"], high: Float[Any, " c"]
) -> tuple[Shaped[Any, " c"], ...]:
    """The zero of arg(−L) in a cell by Newton's method, bisecting where that leaves it: y, K, rate, last step."""
    mine = take(feedback, lane)
    rising = jnp.angle(-_loop(mine, high)[0]) > 0

    def improve(_: Int[Any, ""], state: tuple[Float[Any, " c"], ...]) -> tuple[Float[Any, " c"], ...]:
        low, high, y, before, _ = state
        value, slope = _loop(mine, y)
        phase = jnp.angle(-value)
        beyond = (phase > 0) == rising
        low, high = jnp.where(beyond, low, y), jnp.where(beyond, y, high)
        following = y - phase / (slope / value).real
        following = jnp.where((following >= low) & (following <= high), following, (low + high) / 2)
        gain = 1 / jnp.abs(value)
        return low, high, following, gain, jnp.abs(gain - before)

    middle = (low + high) / 2
    start = low, high, middle, jnp.full_like(middle, jnp.inf), jnp.zeros_like(middle)
    _, _, y, _, moved = jax.lax.fori_loop(0, _STEPS, improve, start)
    value, slope = _loop(mine, y)
    return y, 1 / jnp.abs(value), -value / slope, moved, jnp.abs(jnp.angle(-value)) < 1e-6
