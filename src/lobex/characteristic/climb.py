"""The rightmost root of every lane: roots are found until a line to the left of the foremost has no other beyond it.

What is returned is what was counted: at the gain itself, on a line at a small distance to the left of the root, the
number of roots beyond is that of the roots in hand.
"""

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from lobex.characteristic.closed_loop import Loops
from lobex.characteristic.lanes import in_batches, take
from lobex.characteristic.line import response, roots_beyond

Array = Any

# Roots that are remembered of each lane.
ROOTS = 8
# Of the line from the foremost root, at first and at last.
_APART, _CLOSE = 0.05, 1e-11
_ROUNDS = 80
_SAME = 1e-8
_REAL = 1e-9
_GUESSES = 6
_STEPS = 16
_CONVERGED = 1e-9


class Climbed(NamedTuple):
    """The foremost root z of each lane, Im z ≥ 0, the others found, (l, ROOTS), and whether a count proves it, (l,)."""

    root: Array
    found: Array
    proven: Array


class _Search:
    """The lanes of one chunk and what is known of each: roots found, and lines with roots beyond and without."""

    def __init__(self, loops: Loops, guesses: Array | None) -> None:
        lanes = np.shape(loops.first)[1]
        self.loops, self.on_device = loops, Loops(*map(jnp.asarray, loops))
        self.found: Array = np.full((lanes, ROOTS), np.nan + 0j)
        self.distance = np.full(lanes, _APART)
        self.low, self.high = np.full(lanes, -np.inf), np.full(lanes, np.inf)
        self.step = np.full(lanes, 0.5)
        if guesses is not None:
            lane, column = np.nonzero(np.isfinite(guesses))
            self.add(lane, guesses[lane, column], np.full(lanes, -np.inf))
        self.level = np.where(self.foremost > -np.inf, self.foremost - self.distance, _first_level(loops))

    @property
    def foremost(self) -> Array:
        return np.max(_real(self.found), axis=1)

    def add(self, lane: Array, starts: Array, level: Array) -> None:
        """Keep the roots that Newton's method reaches from starts (k,) and that are to the right of the lanes' level."""
        root, converged = newton(self.on_device, lane, starts)
        converged &= root.real > level[lane]
        lane, root = lane[converged], root[converged]
        while len(lane):
            first = np.unique(lane, return_index=True)[1]
            owner, new = lane[first], root[first]
            known = self.found[owner]
            with np.errstate(invalid="ignore"):
                repeated = np.any(np.abs(known - new[:, None]) < _SAME * (1 + np.abs(new[:, None])), axis=1)
            owner, new = owner[~repeated], new[~repeated]
            hindmost = np.argmin(_real(self.found[owner]), axis=1)
            ahead = new.real > _real(self.found[owner, hindmost])
            self.found[owner[ahead], hindmost[ahead]] = new[ahead]
            left = np.ones(len(lane), dtype=bool)
            left[first] = False
            lane, root = lane[left], root[left]

    def look(self, lane: Array) -> tuple[Array, Array]:
        """Count beyond the levels of the lanes and add what is found there; whether they are proven, and go on."""
        level = self.level[lane]
        count = roots_beyond(self.loops, self.on_device, lane, level)
        owner, starts = _starts(self.loops, lane, level, count.places)
        self.add(owner, starts, self.level)
        mine = self.found[lane]
        beyond = mine.real > level[:, None]
        known = np.sum(beyond * np.where(np.abs(mine.imag) > _REAL * (1 + np.abs(mine)), 2, 1), axis=1)
        proven = count.decided & (count.roots == known) & (known > 0)
        self._next(lane, level, count.roots, count.decided)
        return proven, ~proven & (self.distance[lane] > _CLOSE)

    def _next(self, lane: Array, level: Array, roots: Array, decided: Array) -> None:
        # A line that too many roots lie beyond to be counted is one with roots beyond.
        some = (roots > 0) | ~decided
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


def climb(loops: Loops, guesses: Array | None = None) -> Climbed:
    """The rightmost roots of lanes (l,), from places (l, k) where roots are thought to be, NaN-filled."""
    search = _Search(loops, guesses)
    proven = np.zeros(np.shape(loops.first)[1], dtype=bool)
    left = np.flatnonzero(np.all(np.isfinite(loops.first), axis=0))
    for _ in range(_ROUNDS):
        if not len(left):
            break
        done, further = search.look(left)
        proven[left[done]] = True
        left = left[further]
    best = np.argmax(_real(search.found), axis=1)[:, None]
    return Climbed(np.take_along_axis(search.found, best, axis=1)[:, 0], search.found, proven)


def newton(loops: Any, lane: Array, start: Array) -> tuple[Array, Array]:
    """Roots from starts (k,) of lanes, Im z ≥ 0, and whether they are."""
    root, change = in_batches(partial(_newton, loops), (lane, start))
    root = root.real + 1j * np.abs(root.imag)
    return root, (change < _CONVERGED * (1 + np.abs(root))) & np.isfinite(root)


@jax.jit
def _newton(loops: Loops, lane: Array, z: Array) -> tuple[Array, Array]:
    """Newton's method on log w, to the nearest of its turns, with steps of 1 at most; z, and its last step."""
    mine = take(loops, lane)

    def improve(_: int, state: tuple[Array, Array]) -> tuple[Array, Array]:
        z, _ = state
        upper, lower = 1 / (z - mine.upper), 1 / (z - mine.lower)
        terms = (mine.first * z + mine.constant) * upper * lower
        value = jnp.sum(terms, axis=0)
        slope = jnp.sum(mine.first * upper * lower - terms * (upper + lower), axis=0)
        rest = jnp.log(value) - z
        turns = 2 * jnp.pi * jnp.round(rest.imag / (2 * jnp.pi))
        step = (rest - 1j * turns) / (1 - slope / value)
        size = jnp.abs(step)
        return z + step / jnp.maximum(size, 1.0), size

    return jax.lax.fori_loop(0, _STEPS, improve, (z, jnp.full(jnp.shape(lane), jnp.inf)))


def _first_level(loops: Loops) -> Array:
    """A line near the foremost root: the highest log |M| over the poles, on a line near itself."""
    level = loops.rightmost + 0.1
    for _ in range(_GUESSES):
        with np.errstate(divide="ignore"):
            size = [np.log(np.abs(response(loops, level + 1j * height))) for height in loops.upper.imag]
        level = np.maximum((level + np.max(size, axis=0)) / 2, loops.rightmost + 1e-3)
    return level - _APART


def _starts(loops: Loops, lane: Array, level: Array, places: Array) -> tuple[Array, Array]:
    """Where to look for roots beyond the lines: next to the places on them, and next to poles beyond."""
    row, column = np.nonzero(np.isfinite(places))
    owners, starts = [lane[row]], [places[row, column]]
    for pole, other in ((loops.upper, loops.lower), (loops.lower, loops.upper)):
        mine, partner = pole[:, lane], other[:, lane]
        mode, row = np.nonzero((mine.real > level) & (mine.imag >= 0))
        place, partner = mine[mode, row], partner[mode, row]
        index = mode, lane[row]
        with np.errstate(all="ignore"):
            residue = (loops.first[index] * place + loops.constant[index]) / (place - partner)
            move = residue * np.exp(-place)
            move = move / np.maximum(np.abs(move), 1.0)
        # A pole that the contact does not see is a root itself.
        owners.append(lane[row])
        starts.append(place + np.where(np.isfinite(move), move, 0.1))
    return np.concatenate(owners), np.concatenate(starts)


def _real(z: Array) -> Array:
    return np.where(np.isnan(z.real), -np.inf, z.real)
