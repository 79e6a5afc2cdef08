"""Lengths that people write with a unit, such as 19.05mm."""

import re
from typing import Any

from lobex import _checks

_METRES = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "in": 0.0254}
_WRITTEN = re.compile(r"\s*([-+.\deE]+?)\s*([a-zµμ]*)\s*")


def metres(name: str, length: Any) -> float:
    """A length in metres: a number that is one, or text of a number and m, mm, µm, um or in."""
    if isinstance(length, str):
        found = _WRITTEN.fullmatch(length)
        try:
            number, unit = (found[1], found[2]) if found else ("", "")
            return float(number) * _METRES[unit or "m"]
        except (ValueError, KeyError):
            units = ", ".join(unit for unit in _METRES if unit.isascii())
            raise ValueError(f"{name} = {_checks.brief(length)} is no length; give such as 19.05mm ({units})") from None
    if isinstance(length, bool) or not isinstance(length, int | float):
        raise ValueError(f"{name} = {_checks.brief(length)} is no length; give metres, or text such as 19.05mm")
    return float(length)
