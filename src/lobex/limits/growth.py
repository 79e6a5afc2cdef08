"""Growth per delay, log max|μ|, its slope, and the gain at which it is zero."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from lobex.floquet.dense import largest_modulus
from lobex.floquet.iteration import dominant_triple
from lobex.operators.operator import Method
from lobex.processes.process import Process

Array = Any

_NEWTON_STEPS = 10
# A slope is good for steering Newton's method long before it is exact.
_USABLE_RESIDUAL = 1e-6


def growth(process: Process, method: Method, speed: Array, gain: Array) -> Array:
    """log max|μ| at one point, below 0 where stable; differentiable by the rule of the dominant multiplier."""
    return jnp.log(largest_modulus(method.operator(process.system(speed, gain)).matrix))


def growth_and_slope(process: Process, method: Method, speed: Array, gain: Array) -> tuple[Array, Array, Array]:
    """log max|μ| at one point, its derivative by the gain, and a residual; without the dense solver."""

    def matrix(gain: Array) -> Array:
        return method.operator(process.system(speed, gain)).matrix

    operator, change = jax.jvp(matrix, (gain,), (jnp.ones_like(gain),))
    value, right, left, residual = dominant_triple(operator)
    return jnp.log(jnp.abs(value)), _rate(value, right, left, change), residual


def growth_and_gradient(
    process: Process, method: Method, speed: Array, gain: Array
) -> tuple[Array, Array, Array, Array]:
    """log max|μ| at one point, its derivatives by speed and by gain, and a residual; without the dense solver."""

    def matrix(speed: Array, gain: Array) -> Array:
        return method.operator(process.system(speed, gain)).matrix

    one, zero = jnp.ones_like(speed), jnp.zeros_like(speed)
    operator, by_speed = jax.jvp(matrix, (speed, gain), (one, zero))
    _, by_gain = jax.jvp(matrix, (speed, gain), (zero, one))
    value, right, left, residual = dominant_triple(operator)
    rates = (_rate(value, right, left, change) for change in (by_speed, by_gain))
    return jnp.log(jnp.abs(value)), *rates, residual


def _rate(value: Array, right: Array, left: Array, change: Array) -> Array:
    """d log|μ| of a change dU of the operator: Re (wᵀ dU v)/(wᵀ v)/μ."""
    return ((left @ (change @ right)) / (left @ right) / value).real


class Crossing(NamedTuple):
    """A root of the growth in a bracket: the gain, the growth left there, its slope, and the width bracketed."""

    gain: Array
    growth: Array
    slope: Array
    width: Array


def find_crossing(
    process: Process, method: Method, speed: Array, low: Array, high: Array, ends: tuple[Array, Array]
) -> Crossing:
    """The gain in [low, high] at which the growth, of the values ``ends`` there, changes sign.

    For one point: a fixed number of Newton steps that stay in the bracket. A step that leaves it, or whose
    slope is not finite or not trusted, is a bisection, so that the bracket shrinks over a kink, where two
    multipliers change places, as well. NaN where the ends do not bracket.
    """
    start, end = ends
    # Near convergence one end is the root itself, and rounding puts a good step just outside the bracket.
    margin = 1e-9 * (high - low)

    def step(state: tuple[Array, Array, Array, Crossing], _: None) -> tuple[tuple[Array, Array, Array, Crossing], None]:
        low, high, gain, best = state
        value, slope, residual = growth_and_slope(process, method, speed, gain)
        trusted = residual < _USABLE_RESIDUAL
        same = jnp.sign(value) == jnp.sign(start)
        low, high = jnp.where(trusted & same, gain, low), jnp.where(trusted & ~same, gain, high)
        better = trusted & ~(jnp.abs(value) >= jnp.abs(best.growth))
        here = Crossing(gain, value, slope, high - low)
        best = jax.tree.map(lambda new, old: jnp.where(better, new, old), here, best)
        newton = gain - value / slope
        inside = trusted & (newton > low - margin) & (newton < high + margin)
        return (low, high, jnp.where(inside, newton, (low + high) / 2), best), None

    # Regula falsi of the ends is the first guess, kept off the ends themselves.
    share = jnp.clip(start / (start - end), 0.02, 0.98)
    none = Crossing(*(jnp.full_like(start, jnp.nan),) * 4)
    state = (low, high, low + share * (high - low), none)
    best = jax.lax.scan(step, state, None, length=_NEWTON_STEPS)[0][3]
    return jax.tree.map(lambda part: jnp.where(start * end < 0, part, jnp.nan), best)
