"""A blade from a TOML file, with its stage, its casing and its contact."""

import inspect
import os
from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any, NamedTuple

from lobex import _checks
from lobex.contact.casing import Casing
from lobex.contact.laws import KINDS
from lobex.processes.tables_of_file import in_metres, known, made, naming, read_tables
from lobex.structures.beam import Beam
from lobex.structures.blading import Blading
from lobex.structures.ring import Ring

LENGTHS = ("length", "width", "thickness", "hub_radius", "chord")
_LENGTHS = (*LENGTHS, "amplitude", "clearance", "radius", "axial_width", "transition")
_BEAM = {*inspect.signature(Beam.rectangular).parameters, "poisson_ratio", "hub_radius", "root_stiffness"} - {"others"}
_CONTACT = {*inspect.signature(Beam.contact).parameters} - {"self"}
_MODES = {"damping_ratio", "keep", "basis"}
_STAGE = {"count", "mistuning", "spacing", "coupling"}
_CASING = {field.name for field in fields(Casing)} - {"structure"}


class BladeFile(NamedTuple):
    """What a file says.

    Attributes:
        modes: those of the turning beam as its contacts see them, or a ``Blading`` of them.
        ring: the flexible casing, or None.
        casing: its profile before wear, without what carries it, or a list of one for each track; None of none.
        law: the contact law, or a list of one for each contact; None of none.
    """

    modes: Any
    ring: Ring | None
    casing: Any
    law: Any


def read_blade(path: str | os.PathLike[str]) -> dict[str, Any]:
    """What a TOML file says of a blade: arguments of ``Rub``, the modes of a turning ``Beam`` as its contact sees them.

    The tables are ``[beam]``, of ``Beam.rectangular``; ``[modes]``, of ``Beam.rotating``, with the damping ratio;
    ``[contact]``, of ``Beam.contact``, by default radially in the middle of the tip; ``[stage]``, of ``Blading``, for a
    whole one of such blades; and ``[ring]``, of ``Ring``, for a casing that gives way. ``[casing]`` and ``[law]`` are
    for ``read_wear``. Lengths are metres, or text such as "200 mm", along the span also lists from root to tip; all
    else is as in Python.

    Args:
        path: of the file.

    Returns:
        ``modes``, and ``casing`` of one that gives way: ``lobex.Rub(**lobex.read_blade("blade.toml"))``.

    Raises:
        ValueError: for a file that cannot be read or is no TOML, tables and keys that are none of these, and values
            that the classes refuse; the message names the table.
    """
    found = read_blade_file(path, "lobex.read_blade")
    return {"modes": found.modes} | ({} if found.ring is None else {"casing": found.ring})


def read_wear(path: str | os.PathLike[str]) -> dict[str, Any]:
    """What a TOML file says of a blade and its coating: arguments of ``march_wear``.

    Beside the tables of ``read_blade`` there are ``[law]``, with ``kind``, such as "linear" or "kelvin-voigt", and the
    numbers of that law, and ``[casing]``, of ``Casing``. ``[[law]]`` are those of one contact each, and ``[[casing]]``
    those of one track each.

    Args:
        path: of the file.

    Returns:
        ``modes``, ``casing`` and ``law``: ``lobex.march_wear(**lobex.read_wear("stage.toml"), speed=[80.0, 90.0])``.

    Raises:
        ValueError: as ``read_blade``, and for a file without a law.
    """
    found = read_blade_file(path, "lobex.read_wear")
    if found.law is None:
        raise ValueError(f"path = {str(path)!r} has no [law]; see lobex.read_wear")
    casing = Casing() if found.casing is None else found.casing
    return {"modes": found.modes, "casing": carried(casing, found.ring), "law": found.law}


def read_blade_file(path: str | os.PathLike[str], reader: str) -> BladeFile:
    """All that a file says, for the function that tells of its tables; arguments and errors as of ``read_wear``."""
    makers = {
        "beam": lambda table: made(Beam.rectangular, table, LENGTHS, _BEAM),
        "contact": lambda table: _keys(table, _CONTACT),
        "modes": lambda table: _keys(table, _MODES),
        "stage": lambda table: _keys(table, _STAGE),
        "ring": lambda table: made(Ring, table, ()),
        "casing": lambda table: _each(table, lambda one: made(Casing, one, _LENGTHS, _CASING)),
        "law": lambda table: _each(table, _law),
    }
    found = read_tables(path, makers, ("beam", "modes"), reader, either=("casing", "law"))
    contact = found.get("contact", {})
    with naming(path, "contact"):
        found["beam"].contact(**contact)
    with naming(path, "modes"):
        if "damping_ratio" not in found["modes"]:
            raise ValueError("it has no damping_ratio; give one number, or one per mode of keep")
        modes = found["beam"].rotating(**found["modes"], **contact)
    if "stage" in found:
        with naming(path, "stage"):
            modes = made(Blading, {"blade": modes, **found["stage"]}, (), {"blade", *_STAGE})
    return BladeFile(modes, found.get("ring"), found.get("casing"), found.get("law"))


def carried(casing: Any, ring: Ring | None) -> Any:
    """A casing, or those of all tracks, that a ring carries."""
    if ring is None:
        return casing
    return (
        [replace(one, structure=ring) for one in casing]
        if isinstance(casing, list)
        else replace(casing, structure=ring)
    )


def _keys(table: dict[str, Any], names: set[str]) -> dict[str, Any]:
    known("it", table, names)
    return in_metres(table, LENGTHS)


def _each(given: Any, make: Callable[[dict[str, Any]], Any]) -> Any:
    """Of one table what it makes, of several a list."""
    return [make(table) for table in given] if isinstance(given, list) else make(given)


def _law(table: dict[str, Any]) -> Any:
    kind: Any = table.get("kind")
    _checks.choice("kind", kind, tuple(KINDS))
    return made(KINDS[kind], {name: value for name, value in table.items() if name != "kind"}, _LENGTHS)
