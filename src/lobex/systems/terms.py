"""Terms: the forces of which a delay system is the sum."""

from collections.abc import Callable

from jaxtyping import Float

from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.systems.coefficients import Coefficient, gauss_nodes
from lobex.systems.delays import Delay, Spread, WholePeriod


@pytree()
class Present:
    """f = P(t) y(t)."""

    coefficient: Coefficient

    delay: None = None

    def parts(
        self, value: Float[AnyArray, "k e r"]
    ) -> tuple[Float[AnyArray, "k e r"] | None, Float[AnyArray, "k e r"] | None]:
        """What a value of the coefficient does to y(t) and to w(t − τ)."""
        return value, None


@pytree()
class Delayed:
    """f = Q(t) w(t − τ)."""

    coefficient: Coefficient
    delay: Delay = WholePeriod()

    def parts(
        self, value: Float[AnyArray, "k e r"]
    ) -> tuple[Float[AnyArray, "k e r"] | None, Float[AnyArray, "k e r"] | None]:
        """What a value of the coefficient does to y(t) and to w(t − τ)."""
        return None, value


@pytree()
class Regenerative:
    """f = −H(t) [y(t) − w(t − τ)]: what is left by the pass before is met again."""

    coefficient: Coefficient
    delay: Delay = WholePeriod()

    def parts(
        self, value: Float[AnyArray, "k e r"]
    ) -> tuple[Float[AnyArray, "k e r"] | None, Float[AnyArray, "k e r"] | None]:
        """What a value of the coefficient does to y(t) and to w(t − τ)."""
        return -value, value


@pytree(static=("nodes",))
class Distributed:
    """f = ∫ Q(t, s) w(t − s) ds over delays s from ``start`` to ``stop``, in s, by Gauss' rule.

    It stands for as many point delays as it has nodes: exact for what is a polynomial of degree 2·nodes − 1 in s.

    Attributes:
        kernel: of s and of the rule's weight, the weight times the coefficient Q(·, s).
        start, stop: the shortest and the longest delay.
        nodes: of Gauss' rule.
    """

    kernel: Callable[[Number, Number], Coefficient]
    start: Number
    stop: Number
    nodes: int

    def points(self) -> tuple[Delayed, ...]:
        """The point delays."""
        width = self.stop - self.start
        rule = zip(*gauss_nodes(self.nodes), strict=True)
        delays = [(self.start + width * place, width * weight) for place, weight in rule]
        return tuple(Delayed(self.kernel(delay, weight), Spread(delay)) for delay, weight in delays)


@pytree()
class Forcing:
    """f = g(t), whatever the motion is: a coefficient of one column, (e, 1).

    It makes the motion that a stable system comes to, and leaves its multipliers as they are.
    """

    coefficient: Coefficient


Feedback = Present | Delayed | Regenerative
Term = Feedback | Distributed | Forcing
