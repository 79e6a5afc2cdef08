"""A tool and its machine from a TOML file: cutter, modes, forces, and what damps or varies the cut."""

import inspect
import os
from collections.abc import Callable
from typing import Any

from lobex import _checks
from lobex.processes.cutter import Cutter
from lobex.processes.cutting_force import CuttingForce
from lobex.processes.process_damping import ProcessDamping
from lobex.processes.serration import Serration
from lobex.processes.speed_variation import SpeedVariation
from lobex.processes.tables_of_file import known, made, read_tables
from lobex.structures.modes import Modes

_LENGTHS = ("diameter", "corner_radius", "runout", "chip", "offset", "wear_land")
_SHAPES = ("end_mill", "ball", "bull_nose", "tapered", "inserts")
_ENDS = ("tool", "workpiece")
_MODE = {"axis", "frequency", "damping_ratio", "mass", "stiffness", "of"}
_AXES = ("x", "y", "z")


def read_tool(path: str | os.PathLike[str]) -> dict[str, Any]:
    """What a TOML file says of a tool: arguments of ``Milling`` and, but for the cutter, of ``Turning``.

    The tables are ``[cutter]`` (``shape``, one of the factories of ``Cutter`` and "end_mill" by default, and what that
    takes, its ``serration`` as a table of ``Serration``), ``[[modes]]`` (``axis`` "x", "y" or "z", and what
    ``Modes.from_table`` takes; ``of = "workpiece"`` for those of the other end), ``[force]`` (of ``CuttingForce``, or
    with ``law = "angle"`` or ``"kienzle"`` of ``CuttingForce.from_angle`` and ``.kienzle``), ``[process_damping]`` (of
    ``ProcessDamping``, or with ``wear_land`` of its ``from_wear_land``) and ``[speed_variation]``. Lengths are metres,
    or text such as "19.05 mm"; all else is as in Python.

    Args:
        path: of the file.

    Returns:
        ``modes`` and ``force``, and ``cutter``, ``process_damping`` and ``speed_variation`` where the file has them:
        ``lobex.Milling(**lobex.read_tool("tool.toml"), radial_immersion=0.5)``.

    Raises:
        ValueError: for a file that cannot be read or is no TOML, tables and keys that are none of these, and values
            that the classes refuse; the message names the table.
    """
    makers: dict[str, Callable[[Any], Any]] = {
        "cutter": _cutter,
        "modes": _modes,
        "force": _force,
        "process_damping": _damping,
        "speed_variation": lambda table: _made(SpeedVariation, table),
    }
    return read_tables(path, makers, ("modes", "force"), "lobex.read_tool", listed=("modes",))


def _cutter(table: dict[str, Any]) -> Cutter:
    shape = table.get("shape", "end_mill")
    _checks.choice("shape", shape, _SHAPES)
    own = getattr(Cutter, shape)
    takes = set(inspect.signature(own).parameters) | set(inspect.signature(Cutter.end_mill).parameters)
    given = {name: value for name, value in table.items() if name != "shape"}
    if "serration" in given:
        if not isinstance(given["serration"], dict):
            raise ValueError("serration is no table; write [cutter.serration]")
        given["serration"] = made(Serration, given["serration"], ("amplitude", "wave_length"))
    return _made(own, given, takes - {"edges"})


def _force(table: dict[str, Any]) -> CuttingForce:
    laws = {"linear": CuttingForce, "angle": CuttingForce.from_angle, "kienzle": CuttingForce.kienzle}
    law = table.get("law", "linear")
    _checks.choice("law", law, tuple(laws))
    return _made(laws[law], {name: value for name, value in table.items() if name != "law"})


def _damping(table: dict[str, Any]) -> ProcessDamping:
    worn = {"wear_land", "indentation_coefficient"} & set(table)
    return _made(ProcessDamping.from_wear_land if worn else ProcessDamping, table)


def _modes(rows: list[dict[str, Any]]) -> Modes:
    """Of both ends, in as many directions as the axes that are named."""
    if not rows or not all(isinstance(row, dict) for row in rows):
        raise ValueError("it is no list of tables; write [[modes]] above each mode")
    for number, row in enumerate(rows):
        known(f"mode {number + 1}", row, _MODE)
        _checks.choice("of", row.get("of", "tool"), _ENDS)
        _checks.choice("axis", row.get("axis"), _AXES)
    count = 1 + max(_AXES.index(row["axis"]) for row in rows)
    ends = [[row for row in rows if row.get("of", "tool") == end] for end in _ENDS]
    found = {end: _of_table(rows, count) for end, rows in zip(_ENDS, ends, strict=True) if rows}
    return Modes.relative(**found) if len(found) > 1 else next(iter(found.values()))


def _of_table(rows: list[dict[str, Any]], count: int) -> Any:
    inertia = [name for name in ("mass", "stiffness") if any(name in row for row in rows)]
    names = ("frequency", "damping_ratio", *inertia)
    for number, row in enumerate(rows):
        for name in names:
            if name not in row:
                raise ValueError(f"mode {number + 1} has no {name}; give it, and for all modes mass or stiffness")
    unit = [[float(axis == row["axis"]) for axis in _AXES[:count]] for row in rows]
    return Modes.from_table(**{name: [row[name] for row in rows] for name in names}, direction=unit)


def _made(make: Callable[..., Any], table: dict[str, Any], takes: Any = None) -> Any:
    return made(make, table, _LENGTHS, takes)
