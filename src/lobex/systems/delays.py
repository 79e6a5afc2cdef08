"""Delays: how long ago that was which acts now, as a share of the period T."""

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number


@runtime_checkable
class Delay(Protocol):
    """A delay τ(t) of period T, above zero. A class of one's own is a pytree of numbers with this function."""

    def shares(self, phase: Float[AnyArray, " k"], period: Number) -> Float[AnyArray, " k"]:
        """τ/T at phases t/T, (k,) → (k,)."""
        ...


@pytree()
class WholePeriod:
    """τ = T: what acts is found at the same places of the period before, and nothing is looked up between them."""

    def shares(self, phase: Float[AnyArray, " k"], period: Number) -> Float[AnyArray, " k"]:
        return namespace(phase).ones_like(phase)


@pytree()
class Share:
    """τ is a constant share of T, such as the pitch angle before a tooth in a revolution."""

    share: Number

    def shares(self, phase: Float[AnyArray, " k"], period: Number) -> Float[AnyArray, " k"]:
        return namespace(self.share, phase).broadcast_to(self.share, np.shape(phase))


@pytree()
class ConstantDelay:
    """τ in seconds, whatever T is."""

    delay: Number

    def shares(self, phase: Float[AnyArray, " k"], period: Number) -> Float[AnyArray, " k"]:
        share = self.delay / period
        return namespace(share, phase).broadcast_to(share, np.shape(phase))


class OneOfMany:
    """One of the delays that stand for a distributed one: what jumps acts through each a little, and ends no pieces."""


@pytree()
class Spread(ConstantDelay, OneOfMany):
    """A constant one of many."""


@pytree()
class Varying:
    """τ(t) in seconds as a function of time t, s, and of speed and gain, which repeats with the period.

    Attributes:
        function: in pure JAX, of (t, speed, gain).
        speed, gain: of the point.
        breaks: phases t/T at which it jumps, (b,), as it does where what acts is sampled and held.
    """

    function: Callable[..., Number]
    speed: Number
    gain: Number
    breaks: Float[AnyArray, " b"] | tuple[()] = ()

    def shares(self, phase: Float[AnyArray, " k"], period: Number) -> Float[AnyArray, "k ..."]:
        def one(phase: Number) -> Any:
            return self.function(jnp.mod(phase, 1.0) * period, self.speed, self.gain) / period

        shares = jax.vmap(one)(jnp.ravel(phase))
        # Of a function that returns no number, too, so that it is told by its shape.
        return shares.reshape(*jnp.shape(phase), *jnp.shape(shares)[1:])


def varies(delay: Delay) -> bool:
    """Whether it may change within the period by itself: any but those that are known not to, or stand with many."""
    return not isinstance(delay, WholePeriod | Share | ConstantDelay | OneOfMany)
