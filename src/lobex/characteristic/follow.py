"""Roots followed along the gain: where they are thought to be, which ``strips`` prove afterwards."""

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp

from lobex.characteristic.cells import over_modes
from lobex.characteristic.closed_loop import Loops
from lobex.characteristic.function import decaying, inverse
from lobex.characteristic.lanes import in_batches, take
from lobex.characteristic.strips import Open

Array = Any

_STEPS = 2
# What is left of the distance from a root.
_CONVERGED = 1e-7
# Of batches.
_SIZE = (512,)


def follow(on_device: Open, lane: Array, gains: Array, start: Array) -> Array:
    """Roots at gains (k, g), of one sign, from roots (k,) at the first of each row; (k, g), NaN where they were lost.

    Each step goes along dz/d(log K), and then by Newton's method on log w with w = e^{−z} M.
    """
    (root,) = in_batches(partial(_follow, on_device), (lane, gains, start), _SIZE)
    return root


@jax.jit
def _follow(opened: Open, lane: Array, gains: Array, start: Array) -> tuple[Array]:
    mine = take(opened, lane)

    def look(z: Array, reciprocal: Array) -> tuple[Array, Array, Array]:
        """Newton's step of z, dz/d(log K), and how far z is from a root: log w or the step, whichever is more."""

        def term(mode: Loops) -> tuple[Array, Array]:
            left, right = z - mode.upper, z - mode.lower
            both = inverse(left * right)
            value = (mode.first * z + mode.constant) * both
            return value, mode.first * both - value * both * (left + right)

        value, slope = over_modes(term, mine.loops, (z, z))
        rest = inverse(reciprocal - mine.present * value)
        w = mine.delayed * decaying(z) * value * rest
        share = reciprocal * rest
        against = inverse(1 - slope * inverse(value) * share)
        # log w to third order at 1.
        away = 2 * (w - 1) * inverse(w + 1)
        step = away * against
        size = jnp.abs(step)
        return step / jnp.maximum(size, 1.0), share * against, jnp.maximum(size, jnp.abs(away))

    def advance(state: tuple[Array, Array, Array], gain: Array) -> tuple[tuple[Array, Array, Array], Array]:
        z, rate, before = state
        z = z + rate * jnp.log(gain / before)

        def improve(_: int, state: tuple[Array, ...]) -> tuple[Array, ...]:
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
