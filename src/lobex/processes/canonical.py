"""The test equations of the field: the damped delayed Mathieu equation and the scalar equation."""

from typing import ClassVar

from lobex import _checks
from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import Number
from lobex.processes.process import check_point
from lobex.processes.quantity import DELAYED_GAIN, Quantity
from lobex.systems.coefficients import Constant, Harmonic
from lobex.systems.system import DelaySystem
from lobex.systems.terms import Delayed, Present


@pytree()
class DelayedMathieu:
    """ẍ + c ẋ + (δ + ε cos(2πt/T)) x = b x(t − τ) with T = τ = 1/speed (Insperger and Stépán, 2002).

    The field's form with T = τ = 2π has the speed 1/(2π). Time and x are plain numbers, and so is the gain b, of
    either sign.

    Attributes:
        delta: δ.
        epsilon: ε.
        damping: c.
    """

    delta: Number
    epsilon: Number
    damping: Number = 0.0

    gain: ClassVar[Quantity] = DELAYED_GAIN

    @property
    def speed_unit(self) -> str:
        """No unit: all its numbers are plain."""
        return "1"

    def __post_init__(self) -> None:
        for name in ("delta", "epsilon", "damping"):
            check = _checks.not_negative if name == "damping" else _checks.as_numbers
            check(name, getattr(self, name))
            _checks.scalar(name, getattr(self, name))

    @in_float64
    def system(self, speed: Number, gain: Number) -> DelaySystem:
        """The delay system at one speed and one gain b."""
        check_point(self, speed, gain)
        lib = namespace(self.delta, self.epsilon, self.damping, gain)
        numbers = self.delta, self.epsilon, self.damping
        delta, epsilon, damping = (lib.asarray(v, dtype=lib.result_type(float)) for v in numbers)
        zero, one = lib.zeros_like(delta), lib.ones_like(delta)
        return DelaySystem(
            blocks=lib.stack([lib.stack([zero, one]), lib.stack([-delta, -damping])])[None],
            inputs=lib.stack([zero, one]).reshape(1, 2, 1),
            outputs=lib.stack([one, zero]).reshape(1, 1, 2),
            period=1 / speed,
            terms=(Present(Harmonic(-epsilon.reshape(1, 1))), Delayed(Constant(lib.asarray(gain).reshape(1, 1)))),
        )


@pytree()
class Scalar:
    """ẋ(t) = a x(t) + b x(t − τ), τ = 1/speed (Hayes, 1950). The gain is b, of either sign.

    All of them are plain numbers, without units.
    """

    a: Number

    gain: ClassVar[Quantity] = DELAYED_GAIN

    @property
    def speed_unit(self) -> str:
        """No unit: all its numbers are plain."""
        return "1"

    def __post_init__(self) -> None:
        _checks.as_numbers("a", self.a)
        _checks.scalar("a", self.a)

    @in_float64
    def system(self, speed: Number, gain: Number) -> DelaySystem:
        """The delay system at one speed and one gain b."""
        check_point(self, speed, gain)
        lib = namespace(self.a)
        a = lib.asarray(self.a, dtype=lib.result_type(float))
        one = lib.ones((1, 1, 1), dtype=a.dtype)
        return DelaySystem(a.reshape(1, 1, 1), one, one, 1 / speed, (Delayed(Constant(gain * one[0])),))
