"""What every process is, and the checks of the point (speed, gain) at which it is asked for."""

from typing import Any, ClassVar, Protocol

import numpy as np

from lobex import _checks
from lobex._pytree import check_pytree
from lobex.processes.quantity import Quantity
from lobex.processes.system import DelaySystem

Array = Any


class Process(Protocol):
    """A delayed process: speed (revolutions per second) and gain in, a delay system out.

    A pytree of numbers. The gain enters P and Q alone, and affinely: operators keep the structure's part of one gain
    for all. ``differentiable``, if there is one, is what ``processes.process.differentiable`` asks for.
    """

    gain: ClassVar[Quantity]
    speed_unit: ClassVar[str]

    def system(self, speed: Array, gain: Array) -> DelaySystem:
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


def check_speed(process: Process, speed: Any) -> None:
    """Require finite speeds above zero, and not all of them rpm where revolutions per second are meant."""
    _checks.positive("speed", speed, "Hz (revolutions per second)")
    frequency = _first_frequency(process)
    numbers = _checks.as_numbers("speed", speed)
    if numbers is None or frequency is None or numbers.size == 0:
        return
    ratio = float(numbers.min()) * getattr(process, "passes", 1) / frequency
    if ratio > 60:
        raise ValueError(
            f"speed = {float(numbers.min()):.6g} Hz or more passes {ratio:.0f} times per period of the first "
            f"mode ({frequency:.6g} Hz); give revolutions per second, which is rpm/60"
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


def _first_frequency(process: Process) -> float | None:
    frequency = getattr(getattr(process, "modes", None), "angular_frequency", None)
    if frequency is None or _checks.is_traced(frequency):
        return None
    return float(np.asarray(frequency).min()) / (2 * np.pi)
