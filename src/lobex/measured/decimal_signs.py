"""Cells of a text and their numbers, which have one decimal sign throughout and none between thousands."""

import csv
import re
from collections.abc import Iterable

_NUMBER = r"[+-]?(?:\d+{sign}?\d*|{sign}\d+)(?:[eEdD][+-]?\d+)?"
_WITH = {"point": re.compile(_NUMBER.format(sign=r"\.")), "comma": re.compile(_NUMBER.format(sign=","))}
# Such as 6,000 or 1.234.567,8.
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(?:[.,]\d{3})+(?:[.,]\d*)?")
_SHOWN = 40


def cells_of(line: str, separator: str | None) -> list[str]:
    """The cells of a line between signs that stand in no quotes; between spaces of None."""
    if separator is None:
        parts = line.split()
    elif '"' in line:
        parts = next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])
    else:
        parts = line.split(separator)
    return [part.strip().strip('"').strip() for part in parts]


def number_of(cell: str, decimal: str) -> float | None:
    """The number of a cell with a decimal sign, "point" or "comma"; None of words, and of the other sign."""
    if _WITH[decimal].fullmatch(cell) is None:
        return None
    return float(re.sub("[dD]", "e", cell.replace(",", ".")))


def decimal_of(cells: Iterable[str]) -> str:
    """The decimal sign of all numbers among cells, "point" or "comma".

    Raises:
        ValueError: in the end of a line, for numbers with either sign, and commas that may stand between thousands.
    """
    cells = tuple(cells)
    points = [cell for cell in cells if "." in cell and _WITH["point"].fullmatch(cell)]
    commas = [cell for cell in cells if "," in cell and _WITH["comma"].fullmatch(cell)]
    if points and commas:
        raise ValueError(
            f"has numbers with a point, {points[0][:_SHOWN]!r}, and with a comma, {commas[0][:_SHOWN]!r}; write all "
            "with one decimal sign, and none between thousands"
        )
    if commas and all(map(_THOUSANDS.fullmatch, commas)):
        one = commas[0][:_SHOWN]
        raise ValueError(
            f"has commas that may stand before decimals or between thousands, as in {one!r}; write "
            f"{one.replace(',', '.')} or {one.replace(',', '')}"
        )
    return "comma" if commas else "point"


def no_number(cell: str) -> str:
    """That a cell holds no number, and what would make it one."""
    thousands = ": write it without signs between thousands" if _THOUSANDS.fullmatch(cell) else ""
    return f"{cell[:_SHOWN]!r} is no number{thousands}"
