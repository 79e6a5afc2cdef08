"""The units that results are told in, those of their pictures: rpm and mm where a machine tool has them."""

from collections.abc import Callable
from typing import Any

import numpy as np

from lobex.processes.quantity import Quantity


def shown_speed(speed: Any, unit: str, digits: int = 6) -> str:
    """A speed in Hz as such as "6000 rpm"."""
    number = f"{float(speed) * (60 if unit == 'rpm' else 1):.{digits}g}"
    return number if unit == "1" else f"{number} {unit}"


def shown_gain(gain: Any, quantity: Quantity, digits: int = 6) -> str:
    """A gain in SI units as such as "0.5 mm"."""
    number = f"{float(gain) / quantity.scale:.{digits}g}"
    return number if quantity.display_unit == "1" else f"{number} {quantity.display_unit}"


def shown_span(numbers: np.ndarray, shown: Callable[[Any], str]) -> str:
    """The range of the finite numbers, each as ``shown`` says it."""
    finite = numbers[np.isfinite(numbers)]
    return shown_range(shown(finite.min()), shown(finite.max())) if finite.size else "none finite"


def shown_range(low: str, high: str) -> str:
    """Such as "2000 to 25000 rpm" from both ends; one of them where they are the same."""
    number, _, unit = low.partition(" ")
    return low if low == high else f"{number} to {high}" if high.endswith(unit) else f"{low} to {high}"
