"""Modes of a table in a file, as a modal test or a catalogue lists them."""

import os
import re
from typing import Any

import numpy as np

from lobex import _checks
from lobex.measured.cell_table import CellTable, read_cells
from lobex.structures.modes import Modes

_FREQUENCY = {"Hz": 1.0, "kHz": 1e3, "rad/s": 1 / (2 * np.pi)}
_DAMPING = {"%": 0.01, "1": 1.0, "-": 1.0}
_STIFFNESS = {"N/m": 1.0, "kN/m": 1e3, "MN/m": 1e6, "N/mm": 1e3, "kN/mm": 1e6, "N/um": 1e6, "N/µm": 1e6, "N/μm": 1e6}
_STIFFNESS |= {"lbf/in": 4.4482216152605 / 0.0254, "lb/in": 4.4482216152605 / 0.0254}
_MASS = {"kg": 1.0, "g": 1e-3, "t": 1e3, "lb": 0.45359237}
_NAMES = {
    "frequency": r"f|fn|(natural |eigen)?freq\w*|eigenfrequenz|natural frequency|frequenz|omega|ω",
    "damping": r"d|damp\w*( ratio)?|modal damping( ratio)?|ξ|ζ|xi|zeta|dämpfung\w*",
    "stiffness": r"k|(modal )?stiff\w*|steifigkeit",
    "mass": r"m|(modal )?mass|masse",
    "direction": r"dir\w*|ax(is|e)|achse|richtung",
}
_SHAPE = r"(?:mode ?)?(?:shape|phi|φ|direction|vector)[ _]?([xyz])"
_NORMED = {"1/√kg", "1/sqrt(kg)", "kg^-0.5", "kg^-1/2"}
_AXES = ("x", "y", "z")


def read_modes(path: str | os.PathLike[str], *, damping_unit: str | None = None) -> Modes:
    """The modes of a table, one a row: .csv or other text, or the first sheet of an .xlsx (by openpyxl).

    Columns are found by what stands above them, with units in brackets: ``frequency [Hz]``, ``damping [%]`` or
    ``damping [1]``, one of ``stiffness [N/m]`` (N/um, N/mm, kN/mm) and ``mass [kg]``, and, of more than one direction,
    ``direction`` with x, y or z; or vectors along which the modes move, ``shape x`` and so on. Without stiffness and
    mass ``shape x [1/√kg]`` and so on are mass-normalised shapes. Others are passed over.

    Args:
        path: of the file.
        damping_unit: "%" or "1", where the head does not say it.

    Raises:
        ValueError: for a file that cannot be read, columns that are missing or twice there, units that are not said,
            cells that are no numbers, and what ``Modes`` refuses.
    """
    if damping_unit is not None:
        _checks.choice("damping_unit", damping_unit, ("%", "1"))
    table = read_cells(path, "a modal table")
    frequency = table.scaled(table.needed(_NAMES["frequency"], "frequency", "frequency [Hz]"), _FREQUENCY)
    damping = _damping(table, damping_unit)
    inertia = {
        name: table.scaled(column, units)
        for name, units in (("stiffness", _STIFFNESS), ("mass", _MASS))
        if (column := table.one(_NAMES[name], name, name)) is not None
    }
    if len(inertia) > 1:
        raise ValueError(f"path = {str(path)!r} has stiffness and mass, of which one follows from the other; keep one")
    shape, normed = _shape(table)
    if inertia:
        return Modes.from_table(frequency, damping, **inertia, direction=_direction(table) if shape is None else shape)
    if shape is None:
        raise ValueError(
            f"path = {str(path)!r} has no column of the stiffness or the mass; name one 'stiffness [N/m]' or "
            "'mass [kg]'"
        )
    if not normed:
        raise ValueError(
            f"path = {str(path)!r} has shapes without a scale; write 'shape x [1/√kg]' above those that are "
            "mass-normalised, or add a column 'stiffness [N/m]' or 'mass [kg]'"
        )
    return Modes(2 * np.pi * frequency, damping, shape)


def _damping(table: CellTable, unit: str | None) -> np.ndarray:
    """Shares of critical damping."""
    column = table.needed(_NAMES["damping"], "damping", "damping [%]")
    said = table.heading[column].unit
    if unit is not None and said not in _DAMPING:
        return _DAMPING[unit] * table.numbers(column)
    if said not in _DAMPING:
        name = table.heading[column].name
        raise ValueError(
            f"path = {str(table.path)!r} does not say whether {name!r} is in per cent or a share of 1; write "
            f"'{name} [%]' or '{name} [1]' there, or give damping_unit='%' or '1'"
        )
    return table.scaled(column, _DAMPING)


def _shape(table: CellTable) -> tuple[Any, bool]:
    """Vectors of the columns that are parts of them, None without, and whether they are mass-normalised."""
    found = {}
    for i, heading in enumerate(table.heading):
        part = re.fullmatch(_SHAPE, heading.name, re.IGNORECASE)
        if part:
            found[part[1].lower()] = i
    if not found:
        return None, False
    last = max(_AXES.index(axis) for axis in found)
    columns = [table.numbers(found[axis]) if axis in found else np.zeros(len(table.rows)) for axis in _AXES[: last + 1]]
    units = {table.heading[i].unit.replace(" ", "") for i in found.values()}
    return np.stack(columns, axis=1), units <= _NORMED


def _direction(table: CellTable) -> Any:
    """The axis of each mode, None where no column tells it."""
    column = table.one(_NAMES["direction"], "direction", "direction")
    if column is None:
        return None
    named = [str(row[column]).strip().lower() for row in table.rows]
    for number, name in enumerate(named, 1):
        if name not in _AXES:
            raise ValueError(
                f"path = {str(table.path)!r}, row {number} below the head: direction {name!r} is none of x, y and "
                "z; mend it"
            )
    return named
