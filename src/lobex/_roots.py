"""Roots of many functions at once, each within a bracket."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Real

from lobex._shapes import AnyArray, Number

# Newton takes about five, bisection alone the digits of the number format.
_MOST_STEPS = 80


def bracketed_root(
    function: Callable[[Float[Array, ""]], tuple[Float[AnyArray, ""], Float[AnyArray, ""]]],
    first: Float[Array, ""],
    last: Float[Array, ""],
    rising: bool | Bool[Array, ""],
    start: Float[Array, ""],
    tolerance: Number,
    wanted: bool | Bool[Array, ""] = True,
) -> Float[Array, ""]:
    """A zero of a function between ``first`` and ``last``, by Newton steps, bisecting where one leaves the bracket.

    Ends as soon as all members of a batch have converged, and after 80 steps at the latest.

    Args:
        function: value and derivative at a scalar.
        first: one end of the bracket.
        last: the other end, above or below the first.
        rising: whether the function is positive at ``last`` and negative at ``first``, else the other way.
        start: where to start, within the bracket.
        tolerance: how small a value counts as zero.
        wanted: False to do no work and return ``start``.
    """

    def unfinished(state: tuple[Real[Array, ""], ...]) -> Bool[Array, ""]:
        return state[0] < _MOST_STEPS

    def improve(state: tuple[Real[Array, ""], ...]) -> tuple[Real[Array, ""], ...]:
        count, first, last, x = state
        value, slope = function(x)
        beyond = (value > 0) == rising
        first, last = jnp.where(beyond, first, x), jnp.where(beyond, x, last)
        newton = x - value / jnp.where(slope == 0, jnp.inf, slope)
        inside = ((newton - first) * (newton - last) <= 0) & (slope != 0)
        zero = jnp.abs(value) <= tolerance
        # At a zero to rounding, Newton's step may leave the bracket by rounding: the middle would be worse.
        new = jnp.where(inside, newton, jnp.where(zero, x, (first + last) / 2))
        done = zero | (jnp.abs(new - x) <= jnp.finfo(x.dtype).eps * jnp.abs(x))
        return jnp.where(done, _MOST_STEPS, count + 1), first, last, new

    begin = jnp.where(wanted, 0, _MOST_STEPS)
    return jax.lax.while_loop(unfinished, improve, (begin, first, last, start))[3]
