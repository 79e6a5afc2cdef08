"""Growth per delay, log max|μ|, its slope, and the gain at which it is zero."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Complex, Float, Int

from lobex._shapes import Number
from lobex.floquet import dense, iteration, power
from lobex.floquet.dense import Triple
from lobex.grids.differentiated import radius
from lobex.operators.operator import Method
from lobex.processes.process import Process

# What a change of the gain makes of the operator's image of vectors.
Change = Callable[[Float[Array, "N p"]], Float[Array, "N p"]]
# The operator's matrix as a function of the gain, and its derivative.
Family = Callable[[Number], tuple[Float[Array, "N N"], Change]]

_NEWTON_STEPS = 10
# A slope is good for steering Newton's method long before it is exact.
_USABLE_RESIDUAL = 1e-6
# A polished limit leaves log max|μ| below this; steps end well below it.
CONVERGED = 1e-9
_DONE = 1e-12
SQUARINGS = 10


def growth(process: Process, method: Method, speed: Number, gain: Number) -> Float[Array, ""]:
    """log max|μ| at one point, below 0 where stable; differentiable by the rule of the dominant multiplier."""
    return jnp.log(radius(process, method, speed, gain))


def growth_and_gradient(
    process: Process, method: Method, speed: Number, gain: Number
) -> tuple[Float[Array, ""], Float[Array, ""], Float[Array, ""], Float[Array, ""]]:
    """log max|μ| at one point, its derivatives by speed and by gain, and a residual; without the dense solver."""

    def matrix(speed: Number, gain: Number) -> Float[Array, "N N"]:
        return method.operator(process.system(speed, gain)).matrix

    one, zero = jnp.ones_like(speed), jnp.zeros_like(speed)
    operator, along = jax.linearize(matrix, speed, gain)
    changes = jax.vmap(along)(jnp.stack([one, zero]), jnp.stack([zero, one]))
    triple, residual = iteration.triple_by_iteration(operator)
    by_speed, by_gain = jax.vmap(partial(_rate, triple))(changes)
    return jnp.log(jnp.abs(triple.value)), by_speed, by_gain, residual


def _rate(triple: Triple, change: Float[Array, "N N"]) -> Float[Array, ""]:
    return _rate_along(triple, change @ triple.right)


def _rate_along(triple: Triple, moved: Complex[Array, " N"]) -> Float[Array, ""]:
    """d log|μ| of a change dU of the operator, from dU v: Re (wᵀ dU v)/(wᵀ v)/μ."""
    value, right, left = triple
    return ((left @ moved) / (left @ right) / value).real


class ZeroGrowth(NamedTuple):
    """A gain in a bracket at which the growth is zero.

    Attributes:
        gain: where it is.
        growth: what is left there.
        slope: of the growth.
        matrix: the operator there, (N, N).
        triple: its dominant multiplier and vectors.
        residual: of these.
    """

    gain: Float[Array, " *lanes"]
    growth: Float[Array, " *lanes"]
    slope: Float[Array, " *lanes"]
    matrix: Float[Array, "*lanes N N"]
    triple: Triple
    residual: Float[Array, " *lanes"]


# Steps taken, the ends of the bracket, the next gain, and the best so far.
_Search = tuple[int | Int[Array, ""], Float[Array, ""], Float[Array, ""], Float[Array, ""], ZeroGrowth]


def find_zero_growth(
    family: Family,
    low: Float[Array, ""],
    high: Float[Array, ""],
    ends: tuple[Float[Array, ""], Float[Array, ""]],
    guess: Float[Array, ""],
    squarings: int | Int[Array, ""],
    densely: bool = False,
) -> ZeroGrowth:
    """The gain in [low, high] at which the growth, of the values ``ends`` there, changes sign.

    For one point: Newton steps, ten at most, that stay in the bracket. A step that leaves it, or whose slope is not
    finite or not trusted, is a bisection, so that the bracket shrinks over a kink, where two multipliers change
    places, as well. NaN where the ends do not bracket.

    Args:
        family: the operator's matrix, (N, N), at a gain, and its derivative there.
        low, high: the bracket.
        ends: the growth at both.
        guess: where in it to begin.
        squarings: work of the multiplier, see ``floquet.power``.
        densely: by the dense solver instead.
    """
    start, end = ends
    # Near convergence one end is the root itself, and rounding puts a good step just outside the bracket.
    margin = 1e-6 * (high - low)

    def step(state: _Search) -> _Search:
        count, low, high, gain, best = state
        matrix, change = family(gain)
        if densely:
            triple, residual = dense.triple_by_eigensolver(matrix), jnp.zeros_like(gain)
        else:
            triple, residual = power.triple_by_squaring(matrix, squarings)
        value = jnp.log(jnp.abs(triple.value))
        slope = _rate_along(triple, power.as_complex(change(power.as_pair(triple.right))))
        trusted = residual < _USABLE_RESIDUAL
        same = jnp.sign(value) == jnp.sign(start)
        low, high = jnp.where(trusted & same, gain, low), jnp.where(trusted & ~same, gain, high)
        better = trusted & ~(jnp.abs(value) >= jnp.abs(best.growth))
        new = ZeroGrowth(gain, value, slope, matrix, triple, residual)
        best = jax.tree.map(lambda new, old: jnp.where(better, new, old), new, best)
        newton = gain - value / slope
        inside = trusted & (newton > low - margin) & (newton < high + margin)
        return count + 1, low, high, jnp.where(inside, newton, (low + high) / 2), best

    def going(state: _Search) -> Bool[Array, ""]:
        return (state[0] < _NEWTON_STEPS) & ~(jnp.abs(state[4].growth) < _DONE) & (start * end < 0)

    matrix = jax.eval_shape(lambda gain: family(gain)[0], low)
    nothing, vector = jnp.full_like(start, jnp.nan), jnp.zeros(matrix.shape[0], jnp.result_type(matrix.dtype, 1j))
    still = Triple(vector[0], vector, vector)
    none = ZeroGrowth(nothing, nothing, nothing, jnp.zeros(matrix.shape, matrix.dtype), still, nothing)
    return jax.lax.while_loop(going, step, (0, low, high, jnp.clip(guess, low, high), none))[4]
