"""What is accepted of a blade but can hardly be meant: lengths in millimetres, moduli in GPa, densities in g/cm³."""

from typing import Any

import numpy as np

from lobex import _checks
from lobex._warnings import warn

# Least and largest number that a blade of anything has, its unit, and a number in a wrong one.
_RANGES = {
    "length": (1e-4, 20.0, "m", "0.5 for 500 mm"),
    "young_modulus": (1e6, 1e13, "Pa", "210e9 for 210 GPa"),
    "hub_radius": (0.0, 50.0, "m", "0.5 for 500 mm"),
    "density": (15.0, 1e5, "kg/m³", "7850 for 7.85 g/cm³"),
}


def warn_of_blade(**numbers: Any) -> None:
    """Warn, at the user's line, of numbers by name that no blade has; of nothing that JAX traces."""
    for name, number in numbers.items():
        if _checks.is_traced(number):
            continue
        least, most, unit, example = _RANGES[name]
        value = float(np.asarray(number))
        if not least <= value <= most:
            side = "less" if value < least else "more"
            warn(f"{name} = {value:.6g} {unit} is {side} than a blade has; it is in {unit}, {example}")
