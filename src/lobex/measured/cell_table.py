"""A table of numbers and words with a head, from a text file or a sheet of an .xlsx."""

import re
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from lobex._optional import needed
from lobex.measured.decimal_signs import cells_of, decimal_of, no_number, number_of
from lobex.measured.text_table import existing_file, read_text
from lobex.measured.unpacked import check_archive

_SEPARATORS = ("\t", ";", ",", None)
_UNIT = re.compile(r"^(.*?)\s*[\[(]([^\[\]]*)[\])]\s*$")
_MOST_ROWS = 100_000
# MiB that a sheet unpacks to, of which its reader makes many times as much.
_MOST_UNPACKED = 64


class Heading(NamedTuple):
    """What stands above a column: its name, and its unit in brackets, or nothing."""

    name: str
    unit: str


class CellTable(NamedTuple):
    """Cells below what stands above them.

    Attributes:
        path: of the file.
        heading: of each column.
        rows: cells, text or numbers, as many in each row.
    """

    path: Path
    heading: tuple[Heading, ...]
    rows: list[list[Any]]

    def find(self, pattern: str) -> list[int]:
        """Columns whose name matches a pattern."""
        return [i for i, heading in enumerate(self.heading) if re.fullmatch(pattern, heading.name, re.IGNORECASE)]

    def one(self, pattern: str, what: str, example: str) -> int | None:
        """The column whose name matches, None of none.

        Raises:
            ValueError: for several.
        """
        found = self.find(pattern)
        if len(found) > 1:
            names = " and ".join(repr(self.heading[i].name) for i in found)
            raise ValueError(f"path = {str(self.path)!r} has {names} for the {what}; keep one, such as {example!r}")
        return found[0] if found else None

    def needed(self, pattern: str, what: str, example: str) -> int:
        """As ``one``, where there must be one."""
        found = self.one(pattern, what, example)
        if found is None:
            has = ", ".join(repr(heading.name) for heading in self.heading)
            raise ValueError(f"path = {str(self.path)!r} has no column of the {what} among {has}; name it {example!r}")
        return found

    def numbers(self, column: int) -> Float[np.ndarray, " rows"]:
        """A column of numbers.

        Raises:
            ValueError: for a cell that is none.
        """
        values = []
        for number, row in enumerate(self.rows, 1):
            value = as_number(row[column])
            if value is None:
                raise ValueError(
                    f"path = {str(self.path)!r}, row {number} below the head, column {self.heading[column].name!r}: "
                    f"{no_number(str(row[column]))}; mend that cell"
                )
            values.append(value)
        return np.array(values)

    def scaled(self, column: int, units: Mapping[str, float]) -> Float[np.ndarray, " rows"]:
        """A column in SI, by the unit in its head.

        Raises:
            ValueError: for a head without a unit, or with another.
        """
        name, unit = self.heading[column]
        scale = units.get(unit.replace(" ", ""))
        if scale is None:
            said = f"the unit {unit!r}" if unit else "no unit"
            raise ValueError(
                f"path = {str(self.path)!r} has {said} above {name!r}; write one of {', '.join(units)} "
                f"there, such as '{name} [{next(iter(units))}]'"
            )
        return scale * self.numbers(column)


def read_cells(path: Any, what: str) -> CellTable:
    """The table of a file: text, or the first sheet of an .xlsx.

    Raises:
        ValueError: for a file that cannot be read, has no head, rows of other lengths, or two decimal signs, and an
            .xlsx that unpacks to more than 64 MiB.
    """
    place = existing_file(path)
    lines = _of_sheet(place, what) if place.suffix.lower() in (".xlsx", ".xlsm") else _of_text(place, what)
    # Above the first row of several numbers.
    first = next((i for i, row in enumerate(lines) if sum(as_number(cell) is not None for cell in row) > 1), 0)
    if first == 0:
        raise ValueError(f"path = {str(place)!r} has no head with rows below it; give {what}, one a row")
    head, rows = _head(lines[:first]), lines[first:]
    for number, row in enumerate(rows, 1):
        if len(row) != len(head):
            raise ValueError(
                f"path = {str(place)!r}, row {number} below the head: {len(row)} cells, where the head has "
                f"{len(head)}; mend or remove that row"
            )
    try:
        decimal_of(str(cell).strip() for row in rows for cell in row if isinstance(cell, str))
    except ValueError as error:
        raise ValueError(f"path = {str(place)!r} {error}") from None
    return CellTable(place, tuple(map(_heading, head)), rows)


def as_number(cell: Any) -> float | None:
    """The number of a cell, with either decimal sign; None of words and of nothing."""
    if isinstance(cell, bool) or cell is None:
        return None
    if isinstance(cell, int | float):
        return float(cell)
    text = str(cell).strip()
    return number_of(text, "comma" if "," in text else "point")


def _head(above: list[list[Any]]) -> list[str]:
    """What stands above each column, with units of a row of their own behind the names."""
    *names, last = [["" if cell is None else str(cell).strip() for cell in row] for row in above[-2:]]
    of_units = all(found is not None and not found[1] for cell in last if cell for found in [_UNIT.match(cell)])
    if of_units and names and len(names[0]) == len(last):
        return [f"{name} {unit}" for name, unit in zip(names[0], last, strict=True)]
    return last


def _heading(text: str) -> Heading:
    found = _UNIT.match(text.strip())
    name, unit = (found[1], found[2]) if found else (text, "")
    return Heading(re.sub(r"[\s_]+", " ", name).strip(), unit.strip())


def _of_text(path: Path, what: str) -> list[list[Any]]:
    lines = [line for line in read_text(path, what).splitlines() if line.strip() and not line.lstrip().startswith("#")]
    best: list[list[str]] = []
    for separator in _SEPARATORS:
        rows = [cells_of(line, separator) for line in lines]
        width, count = Counter(map(len, rows)).most_common(1)[0]
        if width > 1 and count > len(lines) / 2:
            best = rows
            break
    if not best:
        raise ValueError(f"path = {str(path)!r} is no table; give {what} in columns between tabs, semicolons or commas")
    return [list(row) for row in best]


def _of_sheet(path: Path, what: str) -> list[list[Any]]:
    openpyxl = needed("openpyxl", "an .xlsx", "measured")
    try:
        check_archive(path, _MOST_UNPACKED)
        # Formulas as the numbers that they last were.
        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
        rows = [list(row) for row in book.worksheets[0].iter_rows(values_only=True, max_row=_MOST_ROWS)]
        book.close()
    # Its reader tells of damaged files in many ways.
    except Exception as error:
        why = str(error).partition("\n")[0] or type(error).__name__
        raise ValueError(f"path = {str(path)!r} cannot be read as .xlsx ({why}); give {what}") from None
    filled = [row for row in rows if any(cell is not None for cell in row)]
    if not filled:
        raise ValueError(f"path = {str(path)!r} has an empty first sheet; give {what} there")
    used = [i for i in range(len(filled[0])) if any(row[i] is not None for row in filled)]
    return [[row[i] for i in used] for row in filled]
