"""Matrices in a text file of Nastran: direct input at grid points (DMIG), as bulk data and punch files have it."""

import os
import re
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from jaxtyping import Int
from scipy import sparse

from lobex import _checks

SQUARE, SYMMETRIC = 1, 6
_REAL = (1, 2)
# Grid points have at most eight digits, and components are six.
_LAST = {"grid point": 10**8 - 1, "component": 6}
# Such as 1.5-3, which is 1.5e-3.
_SHORT = re.compile(r"(?<=[0-9.])([+-][0-9]+)$")


class Dmig(NamedTuple):
    """What a file has of matrices.

    Attributes:
        matrices: square ones by name, (dof, dof), each as scipy's sparse array, with rows of all degrees of freedom of
            the file.
        dof: of each row the grid point and its component (1 to 3 displacements, 4 to 6 rotations, 0 of a scalar point),
            in increasing order, (dof, 2).
    """

    matrices: dict[str, sparse.csc_array]
    dof: Int[np.ndarray, "dof 2"]


class _Matrix(NamedTuple):
    form: int
    entries: dict[tuple[tuple[int, int], tuple[int, int]], float]


def read_dmig(path: str | os.PathLike[str]) -> Dmig:
    """The real square matrices of all DMIG entries of a text file: small, large and free fields.

    Of symmetric ones (form 6) one triangle is there, and the other is filled in. All else in the file is left aside.

    Args:
        path: of the file, such as a ``.pch`` or ``.bdf``.

    Returns:
        The matrices, of which ``Modes.from_matrices`` takes mass and stiffness; a contact at component c of grid point
        g is ``(dof == [g, c]).all(axis=1)``.

    Raises:
        ValueError: for a file that cannot be read or has no matrix, matrices that are complex or rectangular, entries
            without a head, and fields that are no numbers, with the line.
    """
    place = _checks.place("path", path)
    try:
        lines = place.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise ValueError(f"path = {str(path)!r} cannot be read ({error.strerror}); give a text file") from None
    except UnicodeDecodeError:
        raise ValueError(f"path = {str(path)!r} is no text; give DMIG entries, not a binary file of results") from None
    found: dict[str, _Matrix] = {}
    for number, entry in _entries(lines):
        try:
            _take(found, [field for line in entry for field in _fields(line)])
        except ValueError as error:
            raise ValueError(f"path = {str(path)!r}, line {number}: {error}") from None
    if not any(matrix.entries for matrix in found.values()):
        raise ValueError(f"path = {str(path)!r} has no DMIG entries; punch the matrices, such as by EXTSEOUT(DMIGPCH)")
    dof = sorted({end for matrix in found.values() for entry in matrix.entries for end in entry})
    row = {end: index for index, end in enumerate(dof)}
    return Dmig({name: _array(matrix, row) for name, matrix in found.items()}, np.array(dof, dtype=int).reshape(-1, 2))


def _entries(lines: list[str]) -> Iterator[tuple[int, list[str]]]:
    """Of every DMIG entry the number of its first line, and its lines without comments."""
    first, entry = 0, []
    for number, line in enumerate(lines, 1):
        text = line.split("$")[0].rstrip()
        if not text:
            continue
        card = re.split(r"[ ,\t]", text[:8].strip() or " ")[0].upper()
        if card.rstrip("*") == "DMIG":
            if entry:
                yield first, entry
            first, entry = number, [text]
        elif entry and (text[0] in " +*,"):
            entry = [*entry, text]
        elif entry:
            yield first, entry
            entry = []
    if entry:
        yield first, entry


def _fields(line: str) -> list[str]:
    """What follows the first field of a line, 8 small ones or 4 large ones."""
    large = "*" in line[:8]
    count = 4 if large else 8
    if "," in line:
        # The field behind these names the continuation.
        parts = [part.strip() for part in line.split(",")][1:]
        if beyond := [part for part in parts[count + 1 :] if part]:
            raise ValueError(f"{beyond[0]!r} lies beyond the {count + 2} fields of a line; continue on another")
        parts = parts[:count]
    else:
        width = 64 // count
        body = line.expandtabs(8)[8:72]
        parts = [body[start : start + width].strip() for start in range(0, 64, width)]
    return parts + [""] * (count - len(parts))


def _take(found: dict[str, _Matrix], fields: list[str]) -> None:
    """One entry: the head of a matrix, whose second field is 0, or the terms of a column."""
    name = fields[0].upper()
    if _integer("grid point", fields[1]) == 0:
        if name in found:
            raise ValueError(f"matrix {name} has a second head; give one, and files of one model each")
        form, kind = _integer("form", fields[2]), _integer("type", fields[3])
        if form not in (SQUARE, SYMMETRIC):
            raise ValueError(f"matrix {name} has the form {form}; give square (1) or symmetric (6) ones")
        if kind not in _REAL:
            raise ValueError(f"matrix {name} has the type {kind}, which is complex; give real ones, 1 or 2")
        found[name] = _Matrix(form, {})
        return
    if name not in found:
        raise ValueError(f"matrix {name} has an entry before its head; give that first, with 0 for a grid point")
    matrix = found[name]
    column = _end(fields[1:])
    for start in range(4, len(fields) - 2, 4):
        if not any(fields[start : start + 3]):
            continue
        row = _end(fields[start:])
        for place in {(row, column), *([(column, row)] if matrix.form == SYMMETRIC else [])}:
            if place in matrix.entries:
                raise ValueError(f"matrix {name} has two entries of row {row} and column {column}; give one")
            matrix.entries[place] = _number(fields[start + 2])


def _end(fields: list[str]) -> tuple[int, int]:
    """A grid point and its component."""
    end = _integer("grid point", fields[0]), _integer("component", fields[1] or "0")
    for (what, last), number, least in zip(_LAST.items(), end, (1, 0), strict=True):
        if not least <= number <= last:
            raise ValueError(f"{what} = {number} is none; give {least} to {last}")
    return end


def _integer(what: str, text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise ValueError(f"{what} = {text!r} is no whole number") from None


def _number(text: str) -> float:
    plain = text.upper().replace("D", "E")
    try:
        number = float(plain if "E" in plain else _SHORT.sub(r"E\1", plain))
    except ValueError:
        number = np.nan
    if not np.isfinite(number):
        raise ValueError(f"value = {text!r} is no number")
    return number


def _array(matrix: _Matrix, row: dict[tuple[int, int], int]) -> sparse.csc_array:
    ends = [[row[end] for end in side] for side in zip(*matrix.entries, strict=True)] or [[], []]
    values = np.array(list(matrix.entries.values()))
    return sparse.csc_array(sparse.coo_array((values, (ends[0], ends[1])), shape=(len(row), len(row))))
