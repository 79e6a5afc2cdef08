"""A blade and its contact from a TOML file: its beam, where it rubs and how, and which modes are kept."""

import inspect
import os
from typing import Any

from lobex.processes.tables_of_file import in_metres, known, made, naming, read_tables
from lobex.structures.beam import Beam

LENGTHS = ("length", "width", "thickness", "hub_radius", "chord")
_BEAM = {*inspect.signature(Beam.rectangular).parameters, "poisson_ratio", "hub_radius", "root_stiffness"} - {"others"}
_CONTACT = {*inspect.signature(Beam.contact).parameters} - {"self"}
_MODES = {"damping_ratio", "keep", "basis"}


def read_blade(path: str | os.PathLike[str]) -> dict[str, Any]:
    """What a TOML file says of a blade: arguments of ``Rub``, the modes of a turning ``Beam`` as its contact sees them.

    The tables are ``[beam]``, of ``Beam.rectangular``; ``[modes]``, of ``Beam.rotating``, with the damping ratio; and
    ``[contact]``, of ``Beam.contact``, by default radially in the middle of the tip. Lengths are metres, or text such
    as "200 mm", along the span also lists from root to tip; all else is as in Python.

    Args:
        path: of the file.

    Returns:
        ``modes``: ``lobex.Rub(**lobex.read_blade("blade.toml"))``.

    Raises:
        ValueError: for a file that cannot be read or is no TOML, tables and keys that are none of these, and values
            that ``Beam`` refuses; the message names the table.
    """

    def keys(names: set[str]) -> Any:
        def own(table: dict[str, Any]) -> dict[str, Any]:
            known("it", table, names)
            return in_metres(table, LENGTHS)

        return own

    makers = {
        "beam": lambda table: made(Beam.rectangular, table, LENGTHS, _BEAM),
        "contact": keys(_CONTACT),
        "modes": keys(_MODES),
    }
    found = read_tables(path, makers, ("beam", "modes"), "lobex.read_blade")
    contact = found.get("contact", {})
    with naming(path, "contact"):
        found["beam"].contact(**contact)
    with naming(path, "modes"):
        if "damping_ratio" not in found["modes"]:
            raise ValueError("it has no damping_ratio; give one number, or one per mode of keep")
        return {"modes": found["beam"].rotating(**found["modes"], **contact)}
