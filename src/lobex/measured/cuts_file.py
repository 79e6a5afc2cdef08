"""Cuts that were made, from a table in a file."""

import os

import numpy as np
from jaxtyping import Float

from lobex.measured.cell_table import CellTable, as_number, read_cells

SPEED_UNITS = {
    "rpm": 1 / 60,
    "1/min": 1 / 60,
    "rev/min": 1 / 60,
    "min^-1": 1 / 60,
    "Hz": 1.0,
    "1/s": 1.0,
    "krpm": 1e3 / 60,
}
GAIN_UNITS = {"mm": 1e-3, "m": 1.0, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "in": 0.0254}
GAIN_UNITS |= {"N/m": 1.0, "kN/m": 1e3, "MN/m": 1e6, "N/mm": 1e3, "N/um": 1e6, "N/µm": 1e6}
_NAMES = {
    "speed": r"n|(spindle )?speed|(spindel)?drehzahl",
    "gain": r"b|ap|a p|(axial )?depth( of cut)?|gain|(contact )?stiffness|schnitttiefe",
    "outcome": r"chatter(ed)?|unstable|stable|stability|outcome|result|cut|rattern",
}
_QUIET = {"stable", "quiet", "ok", "good", "stabil"}
_CHATTERED = {"unstable", "chatter", "chattered", "instabil", "rattern"}
_NO, _YES = {"no", "false", "nein", "n"}, {"yes", "true", "ja", "y"}


def read_cuts(path: str | os.PathLike[str]) -> Float[np.ndarray, "k 3"]:
    """Cuts of a table, one a row, as ``Chart.compare`` takes them: .csv or other text, or the first sheet of an .xlsx.

    Columns are found by what stands above them, with units in brackets: ``speed [rpm]`` or ``speed [Hz]``,
    ``depth [mm]`` (or ``stiffness [N/m]`` of a rub), and ``chatter`` with yes or no, 1 or 0, or ``stable`` with the
    same, or words such as stable, chatter and unstable in either. Others are passed over.

    Args:
        path: of the file.

    Returns:
        Rows of speed in Hz, gain in m or N/m, and 1 where the cut chattered or 0, (k, 3).

    Raises:
        ValueError: for a file that cannot be read, columns that are missing or twice there, units that are not said,
            cells that cannot be understood, speeds that are not above zero, and depths below it.
    """
    table = read_cells(path, "a table of cuts")
    speed = table.scaled(table.needed(_NAMES["speed"], "speed", "speed [rpm]"), SPEED_UNITS)
    gain = table.scaled(table.needed(_NAMES["gain"], "depth of cut", "depth [mm]"), GAIN_UNITS)
    for name, values, wrong in (("speed", speed, speed <= 0), ("depth or stiffness", gain, gain < 0)):
        if np.any(wrong):
            row = int(np.argmax(wrong))
            raise ValueError(
                f"path = {str(table.path)!r}, row {row + 1} below the head: the {name} is {values[row]:.6g} in SI "
                "units, and no cut has that; mend that cell"
            )
    column = table.needed(_NAMES["outcome"], "chatter", "chatter")
    return np.stack([speed, gain, _chattered(table, column)], axis=1)


def _chattered(table: CellTable, column: int) -> Float[np.ndarray, " k"]:
    """1 where a cut chattered, by words that say so themselves, or yes and no of what stands above."""
    name = table.heading[column].name
    asks_for_quiet = name.lower() in ("stable", "stability")
    told = []
    for number, row in enumerate(table.rows, 1):
        cell = row[column]
        word = str(cell).strip().lower()
        value = float(cell) if isinstance(cell, bool) else as_number(cell)
        said = 1.0 if word in _YES else 0.0 if word in _NO else value
        if word in _QUIET | _CHATTERED:
            told.append(float(word in _CHATTERED))
        elif said in (0.0, 1.0):
            told.append(1 - said if asks_for_quiet else said)
        else:
            raise ValueError(
                f"path = {str(table.path)!r}, row {number} below the head, column {name!r}: {str(cell)!r} does not say "
                "whether the cut chattered; write yes or no, 1 or 0, or stable or chatter"
            )
    return np.array(told)
