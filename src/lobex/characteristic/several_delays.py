"""Roots where the force remembers several constant delays: how many lie beyond a line, and steps towards one.

With z = sτ of the longest delay τ, w = Σ e^{−zθ_k} M_k(z) over the delays θ_k τ, whose responses M_k have the same
poles, and the roots are those of F = 1 − w. Their number to the right of a line is that of the poles there plus the
turns of F about 0 down the line (the argument principle). What F turns by in a cell is known from its ends where
|w| < 1 all over it, or where F changes by less than its size in the middle; bounds from the distances to the poles say
so, and a cell is divided until one of them does: nothing is sampled. Unlike those of one delay (``line``) the cells
must follow every wave of the delays where |w| may be above 1.
"""

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from lobex._batches import in_one_size
from lobex._compiled import compiled
from lobex.characteristic.cells import (
    Bounds,
    Cells,
    bounds_of_mode,
    decide,
    first_cells,
    narrow,
    over_modes,
    value_of_mode,
)
from lobex.characteristic.closed_loop import Loops
from lobex.characteristic.function import decaying
from lobex.characteristic.lanes import take
from lobex.characteristic.line import PLACES, Count

_DONE, _SPLIT, _LOST = 0, 1, 2
# A root is beside a cell that is no further from it than so many waves.
_BESIDE = 1.0
_INTEGER = 0.1
# Of the search for a real root, and |w| at none.
_DOUBLINGS, _HALVINGS, _POLE = 8, 40, 10.0
# Of Newton's method, and a share of log w that counts as a step.
_STEPS, _MISSED = 4, 1e-3


class SeveralDelays(NamedTuple):
    """w of lanes.

    Attributes:
        loops: M_k, first and constant of shape (modes, delays, lanes).
        lag: θ_k in (0, 1], (delays, lanes).
    """

    loops: Loops
    lag: Float[Any, "k l"]

    @property
    def lanes(self) -> int:
        """Their number."""
        return np.shape(self.lag)[1]

    @property
    def upper(self) -> Any:
        """Poles, (modes, lanes)."""
        return self.loops.upper

    @property
    def lower(self) -> Any:
        """Their partners."""
        return self.loops.lower

    @property
    def finite(self) -> Any:
        """Of which lanes all is a number, (lanes,)."""
        return np.all(np.isfinite(self.loops.first), axis=(0, 1))

    @property
    def rightmost(self) -> Any:
        """The largest real part of a pole, (lanes,)."""
        return self.loops.rightmost

    def filled(self) -> "SeveralDelays":
        """With modes that add nothing, up to one of a few numbers of them."""
        return self._replace(loops=self.loops.filled())

    def value(self, z: Any) -> Any:
        """w at z, (lanes,), in NumPy."""
        with np.errstate(all="ignore"):
            bottom = (z - self.loops.upper) * (z - self.loops.lower)
            parts = np.sum((self.loops.first * z + self.loops.constant) / bottom[:, None], axis=0)
            return np.sum(np.exp(-z * self.lag) * parts, axis=0)


def roots_beyond(there: SeveralDelays, on_device: Any, lane: Int[Any, " k"], level: Float[Any, " k"]) -> Count:
    """As ``line.roots_beyond``."""
    mine = take(there, lane)
    poles = np.sum(mine.loops.upper.real > level, axis=0) + np.sum(mine.loops.lower.real > level, axis=0)
    turned, lost = np.zeros(len(lane)), np.zeros(len(lane), dtype=bool)
    found: list[tuple[Any, ...]] = []

    def look(cells: Cells) -> Any:
        arrays = lane[cells.line], level[cells.line], cells.low, cells.high
        code, turn, apart, size = in_one_size(partial(_look, on_device), arrays)
        done = np.nonzero(code == _DONE)
        line, low, high = cells.at(*done)
        np.add.at(turned, line, turn[done])
        found.append((line, (low + high) / 2, apart[done], size[done]))
        lost[cells.line[np.nonzero(code == _LOST)[0]]] = True
        return (code == _SPLIT) & ~lost[cells.line][:, None]

    with np.errstate(all="ignore"):
        size = np.exp(-level * mine.lag)
        first, constant = (np.sum(size * np.abs(part), axis=1) for part in mine.loops[:2])
        cells = first_cells(mine.loops._replace(first=first, constant=constant), level, np.ones(len(lane)))
        top = np.zeros(len(lane))
        np.maximum.at(top, cells.line, cells.high[:, -1])
        decided = decide(cells, look, len(lane)) & ~lost
        # Beyond the last cell |w| < 1, and F tends to 1.
        turned -= np.angle(1 - mine.value(level + 1j * top))
    number = poles - turned / np.pi
    roots = np.round(np.nan_to_num(number))
    decided &= np.abs(number - roots) < _INTEGER
    return Count(roots.astype(int), decided, np.column_stack([*_places(found, level), _on_the_real_axis(mine, level)]))


def _places(found: list[tuple[Any, ...]], level: Any) -> tuple[Any, Any]:
    """Of each line the places where F is nearest to 0, next to each other the nearest alone; and off the line where it
    turns about 0.
    """
    line, place, apart, size = map(np.concatenate, zip(*found, strict=True))
    order = np.lexsort((place, line))
    line, place, apart, size = (part[order] for part in (line, place, apart, size))
    before, after = (np.pad(apart, 1, constant_values=np.inf)[part] for part in (slice(None, -2), slice(2, None)))
    beside = np.flatnonzero((apart <= before) & (apart <= after) & (apart < _BESIDE))
    around = np.flatnonzero(size > 1)
    nearest = _foremost(len(level), line[beside], apart[beside], level[line[beside]] + 1j * place[beside])
    # Of the longest delay alone |w| is 1 there.
    off = level[line[around]] + np.log(size[around]) + 1j * place[around]
    return nearest, _foremost(len(level), line[around], -size[around], off)


def _foremost(lines: int, line: Any, key: Any, place: Any) -> Any:
    """The places of the least keys of each line, (lines, PLACES), NaN-filled."""
    places = np.full((lines, PLACES), np.nan + 0j)
    order = np.lexsort((key, line))
    rank = np.arange(len(line)) - np.searchsorted(line[order], line[order])
    kept = rank < PLACES
    places[line[order][kept], rank[kept]] = place[order][kept]
    return places


def _on_the_real_axis(mine: SeveralDelays, level: Any) -> Any:
    """A real root beyond each line where F is below 0 on it, else NaN: far to the right it is 1."""
    low, high = level, level + 1.0
    there = (1 - mine.value(low + 0j)).real < 0
    for _ in range(_DOUBLINGS):
        high = np.where((1 - mine.value(high + 0j)).real < 0, level + 2 * (high - level), high)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        below = (1 - mine.value(middle + 0j)).real < 0
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    # At a pole the sign changes, too.
    return np.where(there & (np.abs(mine.value(low + 0j)) < _POLE), low + 0j, np.nan)


def _sum(mine: SeveralDelays, z: Any, values: list[Any]) -> Any:
    return sum(decaying(lag * z) * value for lag, value in zip(mine.lag, values, strict=True))


@compiled
def _look(there: SeveralDelays, lane: Any, level: Any, low: Any, high: Any) -> tuple[Any, ...]:
    """What is to be done with cells, by how much F turns in them, how far 0 is from it, in changes of F, and |w| where
    it passes the real axis beyond 1.
    """
    mine = take(there, lane)
    low, high = low.T, high.T
    middle, half = (low + high) / 2, (high - low) / 2
    points = [jax.lax.complex(jnp.broadcast_to(level, low.shape), y) for y in (low, middle, high)]
    delays = len(mine.lag)

    def term(mode: Loops) -> Any:
        each = mode.each()
        over = [bounds_of_mode(one, level, middle, half) for one in each]
        return over, [[value_of_mode(one, z) for one in each] for z in points]

    like = [Bounds(low, low, low)] * delays, [[points[0]] * delays] * 3
    over, values = over_modes(term, mine.loops, like)
    first, at, last = (1 - _sum(mine, z, value) for z, value in zip(points, values, strict=True))
    most = steepest = jnp.zeros_like(low)
    for lag, bound in zip(mine.lag, over, strict=True):
        size = jnp.exp(-lag * level)
        most, steepest = most + size * bound.value, steepest + size * (lag * bound.value + bound.slope)
    change = steepest * half
    known = (jnp.minimum(most, jnp.abs(1 - at) + change) < 1) | (change < jnp.abs(at))
    code = jnp.where(known, _DONE, jnp.where(narrow(middle, half), _LOST, _SPLIT))
    turn = jnp.angle(last * first.conj())
    # Where w passes the real axis beyond 1, its size.
    passed = ((first.imag > 0) != (last.imag > 0)) & (first.real < 0) & (last.real < 0)
    size = jnp.where(passed, jnp.abs(1 - at), 0.0)
    return code.astype(jnp.int8).T, turn.T, (jnp.abs(at) / steepest).T, size.T


@compiled
def newton(there: SeveralDelays, lane: Any, start: Any) -> tuple[Any, Any]:
    """Steps of Newton's method on log w, of 1 at most; z, and the last step, or a share of log w if that is more."""
    mine = take(there, lane)
    delays = len(mine.lag)

    def improve(_: int, state: tuple[Any, Any]) -> tuple[Any, Any]:
        z, _ = state

        def term(mode: Loops) -> Any:
            upper, lower = 1 / (z - mode.upper), 1 / (z - mode.lower)
            values = [(one.first * z + one.constant) * upper * lower for one in mode.each()]
            pairs = zip(mode.each(), values, strict=True)
            return values, [one.first * upper * lower - value * (upper + lower) for one, value in pairs]

        values, slopes = over_modes(term, mine.loops, ([z] * delays, [z] * delays))
        value = _sum(mine, z, values)
        falls = [slope - lag * one for slope, lag, one in zip(slopes, mine.lag, values, strict=True)]
        miss = jnp.log(value)
        step = -miss * value / _sum(mine, z, falls)
        size = jnp.abs(step)
        # To a pole, too, the steps become shorter and shorter.
        return z + step / jnp.maximum(size, 1.0), jnp.maximum(size, _MISSED * jnp.abs(miss))

    return jax.lax.fori_loop(0, _STEPS, improve, (start, jnp.full(jnp.shape(lane), jnp.inf)))


def moved_poles(there: SeveralDelays, modes: Any) -> tuple[Any, Any]:
    """As ``peaks.moved_poles``."""
    first, constant, upper, lower = there.loops
    poles, moves = [], []
    for pole, partner in ((upper, lower), (lower, upper)):
        for mode in modes:
            with np.errstate(all="ignore"):
                one = np.arange(there.lanes)
                here, other = pole[mode, one], partner[mode, one]
                alpha, beta = np.moveaxis(first, 1, 0)[:, mode, one], np.moveaxis(constant, 1, 0)[:, mode, one]
                fade = np.exp(-here * there.lag)
                bottom = (here - upper) * (here - lower)
                terms = (first * here + constant) / bottom[:, None]
                terms[mode, :, one] = 0.0
                # M_k = r_k/(z − π) + rest.
                at_pole, at_partner = (alpha * here + beta) / (here - other), (alpha * other + beta) / (other - here)
                rest = np.sum(terms, axis=0) + at_partner / (here - other)
                moves.append(np.sum(fade * at_pole, axis=0) / (1 - np.sum(fade * rest, axis=0)))
                poles.append(here)
    return np.stack(poles), np.stack(moves)
