"""The rightmost root of every lane: roots are found until a line to the left of the foremost has no other beyond it.

What is returned is what was counted: at the gain itself, on a line at a small distance to the left of the root, the
number of roots beyond is that of the roots in hand.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from lobex._batches import in_one_size
from lobex._compiled import compiled
from lobex.characteristic import several_delays
from lobex.characteristic.cells import over_modes
from lobex.characteristic.closed_loop import Loops
from lobex.characteristic.lanes import placed, take
from lobex.characteristic.line import PLACES, roots_beyond
from lobex.characteristic.peaks import foremost, highest, moved_poles, peaks
from lobex.characteristic.several_delays import SeveralDelays

# Roots that are remembered of each lane.
ROOTS = 6
# Of the line from the foremost root, at first and at last.
_APART, _CLOSE = 0.1, 1e-11
_ROUNDS = 80
_SAME = 1e-8
_REAL = 1e-9
_UNMOVED = 1e-11
# Of Newton, so many at a time.
_STEPS, _ROUNDS_OF_STEPS = 4, 5
_CONVERGED = 1e-10


class Climbed(NamedTuple):
    """The roots found of each lane, the foremost first, (l, ROOTS), Im z ≥ 0, and whether a count proves it, (l,)."""

    found: Complex[Any, "l roots"]
    proven: Bool[Any, " l"]


class _Search:
    """The lanes of one chunk and what is known of each: roots found, and lines with roots beyond and without."""

    def __init__(self, loops: Loops | SeveralDelays, guesses: Complex[Any, "l _"] | None, apart: float) -> None:
        lanes = loops.lanes
        self.ways = _SEVERAL if isinstance(loops, SeveralDelays) else _ONE
        self.loops, self.on_device = loops, placed(loops.filled())
        self.found: Any = np.full((lanes, ROOTS), np.nan + 0j)
        self.distance = np.full(lanes, apart)
        self.low, self.high = np.full(lanes, -np.inf), np.full(lanes, np.inf)
        self.step = np.full(lanes, 0.5)
        self.level = np.full(lanes, -np.inf)
        if guesses is not None:
            self.add(np.arange(lanes), guesses, np.full((lanes, 0), np.nan + 0j))
        bare = np.flatnonzero(self.foremost == -np.inf)
        self.level = self.foremost - self.distance
        self.level[bare] = self.ways.first_level(take(loops, bare))

    @property
    def foremost(self) -> Float[Any, " l"]:
        return _real(self.found[:, 0])

    def add(self, lane: Int[Any, " k"], starts: Complex[Any, "k s"], roots: Complex[Any, "k u"]) -> None:
        """Keep roots, and those that Newton's method reaches beyond the level from starts (k, s) of lanes (k,)."""
        row, column = np.nonzero(np.isfinite(starts))
        root, converged = newton(self.on_device, lane[row], starts[row, column], self.ways.steps)
        converged &= root.real > self.level[lane[row]]
        new = np.full(starts.shape, np.nan + 0j)
        new[row[converged], column[converged]] = root[converged]
        everything = np.concatenate([self.found[lane], new, roots], axis=1)
        everything = np.take_along_axis(everything, np.argsort(-_real(everything), axis=1), axis=1)
        kept = np.full((len(lane), ROOTS), np.nan + 0j)
        filled = np.zeros(len(lane), dtype=int)
        with np.errstate(invalid="ignore"):
            for one in everything.T:
                same = np.any(np.abs(kept - one[:, None]) < _SAME * (1 + np.abs(one[:, None])), axis=1)
                fresh = np.flatnonzero(~same & (filled < ROOTS) & ~np.isnan(one.real))
                kept[fresh, filled[fresh]] = one[fresh]
                filled[fresh] += 1
        self.found[lane] = kept

    def look(self, lane: Int[Any, " k"]) -> tuple[Bool[Any, " k"], Bool[Any, " k"]]:
        """Count beyond the levels of the lanes, and seek what is not in hand; which are proven, and which go on."""
        level = self.level[lane]
        count = self.ways.count(self.loops, self.on_device, lane, level)
        proven = count.decided & (count.roots > 0) & (self._in_hand(lane) == count.roots)
        rest = np.flatnonzero(~proven)
        if len(rest):
            starts, unmoved = _starts(self.ways, self.loops, lane[rest], level[rest], count.places[rest])
            self.add(lane[rest], starts, unmoved)
            in_hand, roots = self._in_hand(lane[rest]), count.roots[rest]
            proven[rest] = count.decided[rest] & (roots > 0) & (in_hand == roots)
            # More than there are: one of them is none.
            self.found[lane[rest[in_hand > roots]]] = np.nan
        rest = ~proven
        self._next(lane[rest], count.roots[rest] > 0, count.decided[rest])
        return proven, rest & (self.distance[lane] > _CLOSE)

    def _in_hand(self, lane: Int[Any, " k"]) -> Int[Any, " k"]:
        """How many roots are known beyond the levels of the lanes; a pair counts twice."""
        mine = self.found[lane]
        weight = np.where(np.abs(mine.imag) > _REAL * (1 + np.abs(mine)), 2, 1)
        return np.sum(weight * (mine.real > self.level[lane, None]), axis=1)

    def _next(self, lane: Int[Any, " k"], some: Bool[Any, " k"], decided: Bool[Any, " k"]) -> None:
        """Choose the next level: closer to the foremost root, or between what is known to have roots beyond and not."""
        level = self.level[lane]
        # A line that too many roots lie beyond to be counted is one with roots beyond.
        some = some | ~decided
        self.low[lane] = np.where(some, np.maximum(self.low[lane], level), self.low[lane])
        self.high[lane] = np.where(some, self.high[lane], np.minimum(self.high[lane], level))
        low, high, foremost, step = (a[lane] for a in (self.low, self.high, self.foremost, self.step))
        has = foremost > -np.inf
        closer = has & (foremost - self.distance[lane] <= level)
        self.distance[lane] = np.where(closer, self.distance[lane] / 4, self.distance[lane])
        with np.errstate(invalid="ignore"):
            middle = np.where(np.isinf(high), level + step, np.where(np.isinf(low), level - step, (low + high) / 2))
        self.step[lane] = np.where(has, step, 2 * step)
        self.level[lane] = np.where(has, foremost - self.distance[lane], middle)


def climb(loops: Loops | SeveralDelays, guesses: Complex[Any, "l _"] | None = None, apart: float = _APART) -> Climbed:
    """The rightmost roots of lanes (l,), from places (l, k) where roots are thought to be, NaN-filled.

    The first line is that far from the foremost of these.
    """
    search = _Search(loops, guesses, apart)
    proven = np.zeros(loops.lanes, dtype=bool)
    left = np.flatnonzero(loops.finite)
    for _ in range(_ROUNDS):
        if not len(left):
            break
        done, further = search.look(left)
        proven[left[done]] = True
        left = left[further]
    return Climbed(search.found, proven)


def newton(
    loops: Any, lane: Int[Any, " k"], start: Complex[Any, " k"], steps: Callable[..., Any] | None = None
) -> tuple[Complex[Any, " k"], Bool[Any, " k"]]:
    """Roots from starts (k,) of lanes, Im z ≥ 0, and whether they are."""
    steps = steps or _newton
    root, change = start.astype(complex), np.full(len(lane), np.inf)
    left = np.arange(len(lane))
    for _ in range(_ROUNDS_OF_STEPS):
        root[left], change[left] = in_one_size(partial(steps, loops), (lane[left], root[left]))
        with np.errstate(invalid="ignore"):
            left = left[change[left] >= _CONVERGED * (1 + np.abs(root[left]))]
        if not len(left):
            break
    root = root.real + 1j * np.abs(root.imag)
    with np.errstate(invalid="ignore"):
        return root, (change < _CONVERGED * (1 + np.abs(root))) & np.isfinite(root)


@compiled
def _newton(
    loops: Loops, lane: Int[Any, " k"], start: Complex[Any, " k"]
) -> tuple[Complex[Any, " k"], Float[Any, " k"]]:
    """Steps of Newton's method on log w, to the nearest of its turns, of 1 at most; z, and the last step."""
    mine = take(loops, lane)

    def improve(
        _: Int[Any, ""], state: tuple[Complex[Any, " k"], Float[Any, " k"]]
    ) -> tuple[Complex[Any, " k"], Float[Any, " k"]]:
        z, _ = state

        def term(mode: Loops) -> tuple[Complex[Any, " k"], Complex[Any, " k"]]:
            upper, lower = 1 / (z - mode.upper), 1 / (z - mode.lower)
            value = (mode.first * z + mode.constant) * upper * lower
            return value, mode.first * upper * lower - value * (upper + lower)

        value, slope = over_modes(term, mine, (z, z))
        rest = jnp.log(value) - z
        turns = 2 * jnp.pi * jnp.round(rest.imag / (2 * jnp.pi))
        step = (rest - 1j * turns) / (1 - slope / value)
        size = jnp.abs(step)
        return z + step / jnp.maximum(size, 1.0), size

    return jax.lax.fori_loop(0, _STEPS, improve, (start, jnp.full(jnp.shape(lane), jnp.inf)))


def _first_level(loops: Loops) -> Float[Any, " l"]:
    """A line near the foremost root."""
    return np.max(peaks(loops, highest(loops)), axis=0) - _APART


def _starts(
    ways: "_Ways", loops: Any, lane: Int[Any, " k"], level: Float[Any, " k"], places: Complex[Any, "k p"]
) -> tuple[Complex[Any, "k s"], Complex[Any, "k u"]]:
    """Where to look for roots beyond the lines: next to the places on them, and next to poles beyond, (k, s).

    And the roots, (k, u), that are poles as good as unmoved: the contact does not see them.
    """
    mine = take(loops, lane)
    near, still = [], []
    for pole, move in zip(*ways.moved_poles(mine, foremost(mine)), strict=True):
        with np.errstate(all="ignore"):
            beyond = (pole.real > level) & (pole.imag >= 0)
            unmoved = np.abs(move) < _UNMOVED * (1 + np.abs(pole))
            move = move / np.maximum(np.abs(move), 1.0)
        near.append(np.where(beyond & ~unmoved, pole + np.where(np.isfinite(move), move, 0.1), np.nan))
        still.append(np.where(beyond & unmoved, pole, np.nan))
    # The foremost are enough: the line comes closer when there are more.
    ahead = [
        np.take_along_axis(z, np.argsort(-_real(z), axis=1)[:, : PLACES + 1], axis=1)
        for z in (np.stack(near, axis=1), np.stack(still, axis=1))
    ]
    return np.concatenate([places, ahead[0]], axis=1), ahead[1]


def _real(z: Complex[Any, "..."]) -> Float[Any, "..."]:
    return np.where(np.isnan(z.real), -np.inf, z.real)


class _Ways(NamedTuple):
    """What is done otherwise with one delay and with several."""

    count: Callable[..., Any]
    steps: Callable[..., Any]
    first_level: Callable[[Any], Any]
    moved_poles: Callable[..., tuple[Any, Any]]


_ONE = _Ways(roots_beyond, _newton, _first_level, moved_poles)
_SEVERAL = _Ways(
    several_delays.roots_beyond,
    several_delays.newton,
    lambda there: there.rightmost - _APART,
    several_delays.moved_poles,
)
