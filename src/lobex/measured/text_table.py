"""A table of numbers in a text file: what separates its columns, its decimal sign and its head are found, and told."""

import re
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from lobex import _checks
from lobex.measured.decimal_signs import cells_of, decimal_of, no_number, number_of

_SEPARATORS = {"tab": "\t", "semicolon": ";", "comma": ",", "space": None}
# What programs write where there is no number: C, Fortran, spreadsheets.
_MISSING = re.compile(r"[+-]?(nan(\(\w+\))?|inf(inity)?|1\.#\w+)|\*+|n/?a|#\S+[!?a]|null|none|-|", re.IGNORECASE)
_COMPLEX = re.compile(r"\d[+-][\d.]+([eE][+-]?\d+)?\s*\*?[ij]\b")
_COMMENT = ("#", "%", "//")
_LARGEST = 512 * 2**20


class TextTable(NamedTuple):
    """The numbers of a text file, and what it says of them.

    Attributes:
        numbers: (rows, columns); NaN where the file has no number.
        line: the line of each row in the file, counted from 1.
        head: what stands above each column, or nothing where no row of the file is a head.
        words: all other text of the file.
        separator: "tab", "semicolon", "comma" or "space"; "" of an array.
        decimal: "point" or "comma".
    """

    numbers: Float[np.ndarray, "rows columns"]
    line: tuple[int, ...]
    head: tuple[str, ...]
    words: str
    separator: str
    decimal: str


def read_text(path: Path, what: str) -> str:
    """The text of a file of UTF-8, UTF-16 with its mark, or Latin-1.

    Raises:
        ValueError: for a file that cannot be read, is empty, or is no text.
    """
    try:
        if path.stat().st_size > _LARGEST:
            raise ValueError(f"path = {str(path)!r} has {path.stat().st_size / 2**20:.0f} MiB; give a smaller {what}")
        content = path.read_bytes()
    except OSError as error:
        raise ValueError(f"path = {str(path)!r} cannot be read ({error.strerror}); give {what}") from None
    if not content.strip():
        raise ValueError(f"path = {str(path)!r} is empty; give {what}")
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16", errors="replace")
    if b"\0" in content:
        raise ValueError(
            f"path = {str(path)!r} is no text; give {what}, such as .csv, or with the ending that its format has"
        )
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def table_of(text: str, path: Path, least: int = 3) -> TextTable:
    """The table in a text, by the separator and the decimal sign with which most of its lines are numbers.

    Args:
        text: all lines.
        path: named in messages.
        least: columns that there must be.

    Raises:
        ValueError: where no lines are numbers, some have other columns than the rest, or commas may stand between
            thousands.
    """
    lines = [(number, line.strip("\r\n")) for number, line in enumerate(text.splitlines(), 1) if line.strip()]
    best: tuple[int, str, str] | None = None
    for decimal in ("point", "comma"):
        for separator in _SEPARATORS:
            width = Counter(len(_row(line, separator, decimal)[0]) for _, line in lines)
            rows = max((count for columns, count in width.items() if columns >= least), default=0)
            if rows and (best is None or rows > best[0]):
                best = rows, separator, decimal
    if best is None:
        raise ValueError(f"path = {str(path)!r} has no lines of {least} or more numbers{_instead(text)}")
    found = _with_head(lines, *best[1:], path, least)
    own = set(found.line)
    try:
        decimal_of(cell for number, line in lines if number in own for cell in _cells(line, found.separator))
    except ValueError as error:
        raise ValueError(f"path = {str(path)!r} {error}") from None
    return found


def _instead(text: str) -> str:
    """What a text has in the place of a table."""
    if _COMPLEX.search(text):
        return ", but complex ones; save real and imaginary parts in columns of their own"
    try:
        decimal_of(re.split(r"[;\s]+", text))
    except ValueError as error:
        return f", and {error}"
    return "; give a table of frequencies and the two parts of a response"


def _with_head(lines: list[tuple[int, str]], separator: str, decimal: str, path: Path, least: int) -> TextTable:
    split = [(number, *_row(line, separator, decimal)) for number, line in lines]
    common = Counter(len(row) for _, row, _ in split if len(row) >= least).most_common(1)[0][0]
    first = next(i for i, (_, row, _) in enumerate(split) if len(row) == common)
    sign = _SEPARATORS[separator]
    above, words = [], []
    rows, places = [], []
    for i, (number, row, rest) in enumerate(split):
        if i < first:
            above.append(_cells(lines[i][1], separator))
            words.append(lines[i][1])
        elif len(row) == common - 1 and not rest and sign is not None and lines[i][1].endswith(sign):
            # What is missing is the last number.
            rows.append([*row, np.nan])
            places.append(number)
        elif len(row) == common and (i == first or not rest):
            rows.append(row)
            places.append(number)
            words += [" ".join(rest)] if rest else []
        elif lines[i][1].lstrip().startswith(_COMMENT):
            words.append(lines[i][1])
        elif not row and all(_MISSING.fullmatch(cell) for cell in rest):
            continue
        elif rest and len(row) == common:
            raise ValueError(
                f"path = {str(path)!r}, line {number}: {rest[0][:40]!r} behind {common} numbers; give a table of which "
                "all below its head are numbers"
            )
        elif rest:
            raise ValueError(f"path = {str(path)!r}, line {number}: {no_number(rest[0])}; mend or remove that line")
        else:
            raise ValueError(
                f"path = {str(path)!r}, line {number}: {len(row)} numbers, where other lines have {common}; the file "
                "may have been cut short: mend or remove that line"
            )
    return TextTable(np.array(rows), tuple(places), _head(above, common), "\n".join(words), separator, decimal)


def _head(above: list[list[str]], columns: int) -> tuple[str, ...]:
    """What stands above each column in the last rows before the numbers that have as many cells."""
    found: list[list[str]] = []
    for cells in reversed(above):
        if len(cells) != columns:
            break
        found.insert(0, cells)
    # Names, and units below them, are the last two.
    return tuple(" ".join(parts).strip() for parts in zip(*found[-2:], strict=True)) if found else ()


def _cells(line: str, separator: str) -> list[str]:
    """The cells of a line, without comment signs and quotes."""
    plain = re.sub(r"^\s*(#|%|//)\s*", "", line)
    sign = _SEPARATORS[separator]
    cells = cells_of(plain.rstrip(sign) if sign == "\t" else plain, sign)
    # A separator that ends every line has no cell behind it.
    return cells[:-1] if sign is not None and len(cells) > 1 and not cells[-1] else cells


def _row(line: str, separator: str, decimal: str) -> tuple[list[float], list[str]]:
    """The numbers that a line begins with, and the words behind them."""
    cells = _cells(line, separator)
    if line.lstrip().startswith(_COMMENT):
        return [], cells
    row: list[float] = []
    for i, cell in enumerate(cells):
        number = _number(cell, decimal)
        if number is None:
            return row, cells[i:]
        row.append(number)
    return (row, []) if not np.isnan(row).all() else ([], cells)


def _number(cell: str, decimal: str) -> float | None:
    """A number, NaN where the cell says that there is none, None for words."""
    return np.nan if _MISSING.fullmatch(cell) else number_of(cell, decimal)


def told(table: TextTable) -> tuple[str, ...]:
    """How the table was read, in words; nothing of one that is no text."""
    return (f"columns separated by {table.separator}, decimal {table.decimal}",) if table.separator else ()


def existing_file(path: Any) -> Path:
    """A path of a file that there is."""
    place = _checks.place("path", path)
    if not place.is_file():
        raise ValueError(f"path = {str(path)!r}: there is no such file; give the path of one")
    return place
