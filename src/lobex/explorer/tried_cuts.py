"""Cuts that were made: read from text, and held against the model."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from lobex.measured.cuts_file import GAIN_UNITS, SPEED_UNITS
from lobex.measured.decimal_signs import cells_of, decimal_of
from lobex.processes.quantity import Quantity
from lobex.results.codes import Outcome
from lobex.verbs import spectral_radius

MOST_CUTS = 2000
_CHATTERED = {"1": True, "0": False, "true": True, "false": False, "yes": True, "no": False}
_CHATTERED |= {"chatter": True, "unstable": True, "stable": False, "quiet": False}


@dataclass(frozen=True, eq=False)
class Cuts:
    """Speeds, Hz, gains, N/m or m, and whether each cut chattered, (k,) each."""

    speed: Float[np.ndarray, " k"]
    gain: Float[np.ndarray, " k"]
    chattered: Bool[np.ndarray, " k"]


def cuts_of_text(text: str, speed_unit: str, quantity: Quantity) -> Cuts:
    """Rows of speed, gain, and chatter (1 or 0, yes or no), with commas, semicolons or tabs between.

    A first row may name the columns with their units, such as "rpm, mm, chatter" or "speed [Hz], depth [um], chatter";
    without them the units are those of the axes.

    Raises:
        ValueError: for text without rows, rows that are not such, by their number, units in brackets that are none, and
            two decimal signs.
    """
    rows = [(n, row.strip()) for n, row in enumerate(text.splitlines(), 1) if row.strip() and row.strip()[0] != "#"]
    if not rows:
        raise ValueError("cuts holds no rows; give speed, gain and chatter, such as 6000, 1.5, 1")
    if len(rows) > MOST_CUTS + 1:
        raise ValueError(f"cuts holds {len(rows)} rows; give at most {MOST_CUTS}")
    separator = next((mark for mark in ("\t", ";", ",") if mark in rows[0][1]), None)
    of_speed, of_gain = SPEED_UNITS.get(speed_unit, 1.0), quantity.scale
    head = _cells(rows[0][1], separator)
    if not _is_number(head[0]):
        of_speed = _unit(head[0], SPEED_UNITS, of_speed)
        gains = {unit: size for unit, size in GAIN_UNITS.items() if ("/" in unit) == ("/" in quantity.unit)}
        of_gain = _unit(head[1], gains, of_gain) if len(head) > 1 else of_gain
        rows = rows[1:]
    try:
        decimal_of(cell for _, row in rows for cell in cells_of(row, separator))
    except ValueError as error:
        raise ValueError(f"cuts {error}") from None
    found = [_row(number, _cells(row, separator)) for number, row in rows]
    if not found:
        raise ValueError("cuts holds a row of names alone; give speed, gain and chatter below it")
    speed, gain, chattered = (np.array(column) for column in zip(*found, strict=True))
    return Cuts(speed * of_speed, gain * of_gain, chattered.astype(bool))


def outcomes(cuts: Cuts, process: Any) -> np.ndarray:
    """What the model says of each, members of ``Outcome``, (k,)."""
    radius = np.asarray(spectral_radius(process, cuts.speed, cuts.gain))
    below, above = Outcome.QUIET_AS_SAID, Outcome.CHATTER_AS_SAID
    stable = np.where(cuts.chattered, Outcome.CHATTER_BELOW_THE_LIMIT, below)
    unstable = np.where(cuts.chattered, above, Outcome.QUIET_ABOVE_THE_LIMIT)
    told = np.where(radius < 1, stable, unstable)
    return np.where(np.isnan(radius), Outcome.OUTSIDE_THE_CHART, told).astype(np.int8)


def _cells(row: str, separator: str | None) -> list[str]:
    # Those that separate are gone; what is left are decimal commas.
    return [cell.replace(",", ".") for cell in cells_of(row, separator)]


def _unit(name: str, units: Mapping[str, float], otherwise: float) -> float:
    """The size in SI of the unit that a name of a column holds, or else of another."""
    sizes = {unit.lower(): size for unit, size in units.items()} | dict(units)
    within = re.search(r"[\[(](.*?)[\])]", name)
    words = [within[1].strip()] if within else re.split(r"[\s_]+", name)
    found = [sizes[form] for word in words for form in (word, word.lower()) if form in sizes]
    if within and not found:
        raise ValueError(f"cuts names {name[:40]!r}, in a unit that is none of {', '.join(units)}; write one of them")
    return found[0] if found else otherwise


def _row(number: int, cells: list[str]) -> tuple[float, float, bool]:
    if len(cells) != 3:
        raise ValueError(f"cuts, row {number}, has {len(cells)} columns; give three: speed, gain and chatter")
    numbers = []
    for name, cell in zip(("speed", "gain"), cells, strict=False):
        if not _is_number(cell) or float(cell) < 0 or (name == "speed" and float(cell) == 0):
            raise ValueError(f"cuts, row {number}: {name} = {cell[:40]!r} is no number above 0")
        numbers.append(float(cell))
    if cells[2].lower() not in _CHATTERED:
        raise ValueError(f"cuts, row {number}: {cells[2][:40]!r} says nothing of chatter; give 1 where it did, or 0")
    return *numbers, _CHATTERED[cells[2].lower()]  # pyright: ignore[reportReturnType]


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False
