"""What every process is, and the checks of the point (speed, gain) at which it is asked for."""

from collections.abc import Iterator
from typing import Any, ClassVar, Protocol, TypeVar, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float

from lobex import _checks
from lobex._pytree import check_pytree
from lobex._shapes import Number
from lobex.processes.plausible import TOO_FAST, passes_per_period
from lobex.processes.quantity import Quantity, has_units
from lobex.systems.system import DelaySystem

AnyProcess = TypeVar("AnyProcess")


@runtime_checkable
class Process(Protocol):
    """A delayed process: speed (revolutions per second) and gain in, a delay system out.

    A pytree of numbers. ``differentiable``, ``by_gain`` and ``fine_enough``, if there are, are what the functions of
    these names ask for.

    Attributes:
        gain: what the gain is.
        speed_unit: "Hz" or "rpm", in which speeds are drawn, or "1" of a process without units, its time and lengths
            being scaled: nothing is then said of numbers that would be implausible for a machine.
    """

    gain: ClassVar[Quantity]

    @property
    def speed_unit(self) -> str: ...

    def system(self, speed: Number, gain: Number) -> DelaySystem:
        """The delay system at one speed and one gain."""
        ...


def check_process(process: Any) -> None:
    """Require something that makes a delay system, says what its gain is, and is a pytree of numbers."""
    if isinstance(process, type) or not callable(getattr(process, "system", None)):
        raise ValueError(f"process = {_checks.brief(process)} is no process; give one such as lobex.Rub(modes)")
    for name, kind in (("gain", Quantity), ("speed_unit", str)):
        if not isinstance(getattr(process, name, None), kind):
            raise ValueError(
                f"process = {_checks.brief(process)} has no {name}; give its class one, such as that of lobex.Rub"
            )
    check_pytree("process", process)


def differentiable(process: Process) -> tuple[tuple[float, Process], ...]:
    """Processes, with weights, whose derivatives by their own numbers add up to those of ``process``: itself, unless
    it knows better.
    """
    own = getattr(process, "differentiable", None)
    return ((1.0, process),) if own is None else own()


def by_gain(process: Process, gains: Float[np.ndarray, " p"]) -> Iterator[tuple[Process, Bool[np.ndarray, " p"]]]:
    """Forms of a process that a method makes smaller operators of, each with the gains that it is for: none, unless it
    knows better.
    """
    own = getattr(process, "by_gain", None)
    return iter(()) if own is None else own(gains)


def fine_enough(process: AnyProcess, speed: Any, gain: Any, tolerance: float) -> AnyProcess:
    """A process of as many parts as leave less of multipliers than a relative error, at speeds, Hz, and gains: itself,
    unless it knows better and nothing is traced.
    """
    own = getattr(process, "fine_enough", None)
    if own is None or not np.size(speed) or not np.size(gain) or _checks.is_traced((process, speed, gain)):
        return process
    return own(speed, gain, tolerance)


def check_speed(process: Any, speed: Any) -> None:
    """Require finite speeds above zero, not all of them rpm where revolutions per second are meant, and in the table of
    modes that depend on them.
    """
    _checks.positive("speed", speed, "Hz (revolutions per second)")
    table = getattr(getattr(process, "modes", None), "check_speed", None)
    if table is not None:
        table(speed)
    numbers = _checks.as_numbers("speed", speed)
    if numbers is None or numbers.size == 0 or not has_units(process):
        return
    passes = passes_per_period(process, numbers, fastest=True)
    if passes is not None and passes > TOO_FAST:
        raise ValueError(
            f"speed = {float(numbers.min()):.6g} Hz or more passes {passes:.0f} times per period of the "
            "fastest mode; give revolutions per second, which is rpm/60"
        )


def check_gain(process: Process, gain: Any) -> None:
    """Require finite gains, not negative where the process cannot have them."""
    quantity = process.gain
    check = _checks.as_numbers if quantity.signed else _checks.not_negative
    check("gain", gain, quantity.unit)


def check_point(process: Process, speed: Any, gain: Any) -> None:
    """Both checks, where a system is asked for."""
    check_speed(process, speed)
    check_gain(process, gain)


def lanes_shape(speed: Any, gain: Any, name: str = "gain") -> tuple[int, ...]:
    """The shape that speeds and gains, called ``name``, have together."""
    try:
        return np.broadcast_shapes(np.shape(speed), np.shape(gain))
    except ValueError:
        raise ValueError(
            f"{name} has shape {np.shape(gain)} and speed {np.shape(speed)}; give shapes that broadcast"
        ) from None
