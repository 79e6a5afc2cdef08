"""What the gain and the speed of a process are: their names and units, on which axes and messages agree."""

from typing import Any, NamedTuple

SPEED_UNITS = ("Hz", "rpm", "1")
"""Revolutions per second, drawn per minute, or a plain number: the process has no units."""


class Quantity(NamedTuple):
    """What a gain is.

    Attributes:
        name, symbol, unit: for axes and messages.
        display_unit, scale: the unit of axes, and its size in SI.
        signed: negative gains have a meaning. Otherwise they are refused.
    """

    name: str
    symbol: str
    unit: str
    display_unit: str
    scale: float
    signed: bool = False


CONTACT_STIFFNESS = Quantity("contact stiffness", "K_e", "N/m", "MN/m", 1e6)
DEPTH_OF_CUT = Quantity("depth of cut", "b", "m", "mm", 1e-3)
PLAIN_GAIN = Quantity("gain", "g", "1", "1", 1.0, signed=True)
DELAYED_GAIN = Quantity("delayed gain", "b", "1", "1", 1.0, signed=True)


def has_units(process: Any) -> bool:
    """Whether time and lengths of a process are those of a machine, and not scaled."""
    return getattr(process, "speed_unit", "Hz") != "1"


def hertz(speed_unit: str) -> str:
    """What follows a frequency in a text: its unit, or nothing where the process has no units."""
    return "" if speed_unit == "1" else " Hz"


def quantity_of(process: Any) -> Quantity:
    """The gain of a process, a plain number where the process has no units."""
    gain: Quantity = process.gain
    return gain if has_units(process) else gain._replace(unit="1", display_unit="1", scale=1.0)
