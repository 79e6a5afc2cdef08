"""Axes that all pictures share: units and labels."""

from lobex import _checks
from lobex.processes.quantity import Quantity


def speed_axis(unit: str) -> tuple[float, str]:
    """The factor from Hz to ``unit``, "Hz" or "rpm", and the axis' label."""
    _checks.choice("speed_unit", unit, ("Hz", "rpm"))
    return (60.0, "spindle speed (rpm)") if unit == "rpm" else (1.0, "rotational frequency (Hz)")


def gain_label(quantity: Quantity) -> str:
    """Such as "depth of cut b (mm)"."""
    head, _, tail = quantity.symbol.partition("_")
    return f"{quantity.name} ${head}{f'_{{{tail}}}' if tail else ''}$ ({quantity.display_unit})"
