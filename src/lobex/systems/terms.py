"""Terms: the forces of which a delay system is the sum."""

from typing import Any

from lobex._pytree import pytree
from lobex.systems.coefficients import Coefficient
from lobex.systems.delays import Delay, WholePeriod

Array = Any


@pytree()
class Present:
    """f = P(t) y(t)."""

    coefficient: Coefficient

    delay: None = None

    def parts(self, value: Array) -> tuple[Array | None, Array | None]:
        """What a value of the coefficient does to y(t) and to w(t − τ)."""
        return value, None


@pytree()
class Delayed:
    """f = Q(t) w(t − τ)."""

    coefficient: Coefficient
    delay: Delay = WholePeriod()

    def parts(self, value: Array) -> tuple[Array | None, Array | None]:
        """What a value of the coefficient does to y(t) and to w(t − τ)."""
        return None, value


@pytree()
class Regenerative:
    """f = −H(t) [y(t) − w(t − τ)]: what is left by the pass before is met again."""

    coefficient: Coefficient
    delay: Delay = WholePeriod()

    def parts(self, value: Array) -> tuple[Array | None, Array | None]:
        """What a value of the coefficient does to y(t) and to w(t − τ)."""
        return -value, value


@pytree()
class Forcing:
    """f = g(t), whatever the motion is: a coefficient of one column, (e, 1).

    It makes the motion that a stable system comes to, and leaves its multipliers as they are.
    """

    coefficient: Coefficient


Feedback = Present | Delayed | Regenerative
Term = Feedback | Forcing
