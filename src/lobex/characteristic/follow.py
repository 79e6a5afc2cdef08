"""Roots followed along the gain: where they are thought to be, which ``loci`` proves afterwards."""

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Complex, Float, Inexact, Int

from lobex._batches import in_one_size
from lobex.characteristic.cells import over_modes
from lobex.characteristic.climb import newton
from lobex.characteristic.closed_loop import Loops
from lobex.characteristic.function import decaying, inverted
from lobex.characteristic.lanes import placed, take
from lobex.characteristic.open_loop import Open, weighted
from lobex.characteristic.peaks import likely_roots

# Every so many gains are looked at from scratch, and so many of their roots are followed upwards, and downwards.
STRIDE = 32
_UPWARDS, _DOWNWARDS = 2, 1
_SAME = 1e-6
# Of Newton's.
_STEPS = 2
# What is left of the distance from a root.
_CONVERGED = 1e-7
# Of batches.
_SIZE = 512


def followed(
    there: Open,
    lanes: int,
    closed: Callable[[Int[Any, " k"], Int[Any, " k"]], Loops],
    gains: Float[Any, " m"],
) -> Complex[Any, "{lanes} m h"]:
    """Roots at every gain (m,), followed from those of coarse gains on either side: (n, m, h), NaN-filled.

    Args:
        there: the lanes, where they are computed with.
        lanes: n, their number.
        closed: gives the loops closed at lanes and numbers of gains.
        gains: K.
    """
    count = len(gains)
    coarse = np.unique(np.append(np.arange(0, count, STRIDE), count - 1))
    lane, column = (a.ravel() for a in np.meshgrid(np.arange(lanes), coarse, indexing="ij"))
    begun = _begun(closed(lane, column)).reshape(lanes, len(coarse), _UPWARDS)
    hand: Any = np.full((lanes, count, _UPWARDS + _DOWNWARDS), np.nan + 0j)
    hand[:, coarse, :_UPWARDS] = begun
    step = np.arange(STRIDE)
    upwards, downwards = coarse[:-1, None] + step, coarse[1:, None] - step
    for path, starts, first in (
        (upwards, begun[:, :-1], 0),
        (downwards, begun[:, 1:, :_DOWNWARDS], _UPWARDS),
    ):
        path = np.clip(path, 0, count - 1)
        inside = (path > coarse[:-1, None]) & (path < coarse[1:, None])
        lane, way, which = np.nonzero(np.isfinite(starts))
        roots = follow_each(there, lane, gains[path[way]], starts[lane, way, which])
        place, along = np.nonzero(inside[way][:, 1:])
        hand[lane[place], path[way[place], along + 1], first + which[place]] = roots[place, along]
    return hand.real + 1j * np.abs(hand.imag)


def real_or_less(z: Complex[Any, "..."]) -> Float[Any, "..."]:
    """Re z, −∞ where there is none."""
    return np.where(np.isnan(z.real), -np.inf, z.real)


def _begun(loops: Loops) -> Complex[Any, "l r"]:
    """The foremost of the roots beside the peaks of |M|, (lanes, r), NaN-filled."""
    starts = likely_roots(loops)
    lane, number = np.nonzero(np.isfinite(starts))
    found, converged = newton(placed(loops.filled()), lane, starts[lane, number])
    root = np.full(starts.shape, np.nan + 0j)
    root[lane[converged], number[converged]] = found[converged]
    root = np.take_along_axis(root, np.argsort(-real_or_less(root), axis=1), axis=1)
    with np.errstate(invalid="ignore"):
        again = np.abs(np.diff(root, axis=1, prepend=np.nan)) < _SAME * (1 + np.abs(root))
    root = np.where(again, np.nan, root)
    return np.take_along_axis(root, np.argsort(-real_or_less(root), axis=1)[:, :_UPWARDS], axis=1)


def follow_each(
    there: Open, lane: Int[Any, " k"], gains: Float[Any, "k g"], start: Complex[Any, " k"]
) -> Complex[Any, "k _"]:
    """Roots at gains (k, g), of one sign, from roots (k,) at the first of each row; (k, g), NaN where they were lost.

    Each step goes along dz/d(log K), and then by Newton's method on log w with w = e^{−z} M.
    """
    (root,) = in_one_size(partial(_follow, there), (lane, gains, start), _SIZE)
    return root


# Not in short: the newer loops take an eighth off a whole chart.
@jax.jit
def _follow(
    opened: Open, lane: Int[Any, " k"], gains: Float[Any, "k g"], start: Complex[Any, " k"]
) -> tuple[Complex[Any, "k _"]]:
    mine = take(opened, lane)

    def look(
        z: Complex[Any, " k"], reciprocal: Float[Any, " k"]
    ) -> tuple[Complex[Any, " k"], Complex[Any, " k"], Float[Any, " k"]]:
        """Newton's step of z, dz/d(log K), and how far z is from a root: log w or the step, whichever is more."""

        def term(mode: Loops) -> Any:
            left, right = z - mode.upper, z - mode.lower
            both = inverted(left * right)
            values = [(one.first * z + one.constant) * both for one in mode.each()]
            turned = both * (left + right)
            return values, [one.first * both - value * turned for one, value in zip(mode.each(), values, strict=True)]

        sums = over_modes(term, mine.loops, ([z] * len(mine.present),) * 2)
        (now, now_slope), (before, slope) = (
            [weighted(part, values) for values in sums] for part in (mine.present, mine.delayed)
        )
        rest = inverted(reciprocal - now)
        w = decaying(z) * before * rest
        share = reciprocal * rest
        against = inverted(1 - slope * inverted(before) - now_slope * rest)
        # log w to third order at 1.
        away = 2 * (w - 1) * inverted(w + 1)
        step = away * against
        size = jnp.abs(step)
        return step / jnp.maximum(size, 1.0), share * against, jnp.maximum(size, jnp.abs(away))

    def advance(
        state: tuple[Complex[Any, " k"], Complex[Any, " k"], Float[Any, " k"]], gain: Float[Any, " k"]
    ) -> tuple[tuple[Complex[Any, " k"], Complex[Any, " k"], Float[Any, " k"]], Complex[Any, " k"]]:
        z, rate, before = state
        z = z + rate * jnp.log(gain / before)

        def improve(_: Int[Any, ""], state: tuple[Inexact[Any, " k"], ...]) -> tuple[Inexact[Any, " k"], ...]:
            step, rate, size = look(state[0], 1 / gain)
            return state[0] + step, rate, state[3], size

        none = jnp.abs(z)
        z, rate, first, last = jax.lax.fori_loop(0, _STEPS, improve, (z, rate, none, none))
        # The next step would be to the last one squared as that is to the first one squared.
        least = _CONVERGED * (1 + jnp.abs(z))
        kept = jnp.where((last**3 < least * jnp.square(first)) | (last < _CONVERGED**2), z, jnp.nan)
        return (z, rate, gain), kept

    _, rate, _ = look(start, 1 / gains[:, 0])
    return (jax.lax.scan(advance, (start, rate, gains[:, 0]), gains.T[1:])[1].T,)
