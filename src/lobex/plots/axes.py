"""Axes that all pictures share: units and labels."""

from lobex import _checks
from lobex.processes.quantity import SPEED_UNITS, Quantity


def speed_axis(unit: str) -> tuple[float, str]:
    """The factor from Hz to ``unit``, "Hz", "rpm" or "1", and the axis' label."""
    _checks.choice("speed_unit", unit, SPEED_UNITS)
    labels = {"Hz": "rotational frequency (Hz)", "rpm": "spindle speed (rpm)", "1": "speed 1/τ"}
    return 60.0 if unit == "rpm" else 1.0, labels[unit]


def frequency_label(speed_unit: str) -> str:
    """Of an axis of chatter frequencies."""
    return "chatter frequency" if speed_unit == "1" else "chatter frequency (Hz)"


def gain_label(quantity: Quantity) -> str:
    """Such as "depth of cut b (mm)"."""
    head, _, tail = quantity.symbol.partition("_")
    unit = "" if quantity.display_unit == "1" else f" ({quantity.display_unit})"
    return f"{quantity.name} ${head}{f'_{{{tail}}}' if tail else ''}${unit}"
