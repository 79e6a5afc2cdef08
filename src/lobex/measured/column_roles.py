"""What the columns of a table are: frequency, real and imaginary parts, magnitude and phase, coherence."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Complex, Float

from lobex import _checks
from lobex.measured.response_units import ResponseUnit, frequency_scale, response_unit
from lobex.measured.samples import Samples
from lobex.measured.text_table import TextTable, told

ROLES = (
    *("frequency", "real", "imaginary", "magnitude", "decibels", "phase_degrees", "phase_radians"),
    *("coherence", "unused"),
)
_PAIRS = (
    ("real", "imaginary"),
    *((m, p) for m in ("magnitude", "decibels") for p in ("phase_degrees", "phase_radians")),
)
_NAMES = {
    "coherence": r"coh\w*|γ²?|gamma2?",
    "phase": r"phase|phi|φ|angle|arg|deg(rees?)?|°",
    "decibels": r"dB",
    "imaginary": r"im|imag\w*|ℑ|\w*_im(ag)?",
    "real": r"re|real\w*|ℜ|\w*_re(al)?",
    "magnitude": r"mag\w*|abs\w*|ampl\w*|modul\w*|betrag",
    "frequency": r"f|freq\w*|frequenz|omega|ω|hz|khz|rad/s",
}
# Columns that a message names, and letters of a name in it.
_SHOWN, _LONGEST = 8, 60
# Of a format that has a unit by itself, where it says no more.
_CUTPRO = ("frequency", "real", "imaginary")
# Such as xy, X/Y, Hxy and FRF_xy.
_DIRECTIONS = re.compile(r"(?<![A-Za-z])(?:H|G|FRF)?([xyz])\s*[/_,]?\s*([xyz])(?![A-Za-z])", re.IGNORECASE)


class Column(NamedTuple):
    """What a column is: its role, the direction of response and reference, and its unit."""

    role: str
    directions: tuple[str, str] | None = None
    unit: str = ""


def samples_of(table: TextTable, columns: Any, path: Path, own: str | None = None) -> Samples:
    """The responses of a table.

    Args:
        table: of the file.
        columns: roles in order, or by what stands above each column, or None for what the head says.
        path: named in messages.
        own: the unit that the format has by itself.

    Raises:
        ValueError: for columns that are not told, in one line that says how to tell them.
    """
    count = table.numbers.shape[1]
    if columns is None and own is not None and count == len(_CUTPRO) and not any(_role(name) for name in table.head):
        columns = _CUTPRO
    found = _of_head(table, path) if columns is None else _given(columns, table.head, count, path)
    axis = [i for i, column in enumerate(found) if column.role == "frequency"]
    if len(axis) != 1:
        raise ValueError(f"path = {str(path)!r} has {len(axis)} columns of frequencies; {_remedy(count)}")
    value, coherence, response, reference = _matrix(table.numbers, found, path)
    units = {unit for column in found if (unit := response_unit(column.unit)) is not None}
    units |= {unit for word in re.split(r"[\s,;:\[\]=]+", table.words) if (unit := response_unit(word)) is not None}
    scales = {scale for word in _words_of(found[axis[0]], table) if (scale := frequency_scale(word)) is not None}
    return Samples(
        table.numbers[:, axis[0]],
        value,
        response,
        reference,
        coherence,
        _one(units, own, path),
        next(iter(scales)) if len(scales) == 1 else None,
        (*told(table), "columns are " + ", ".join(column.role.replace("_", " in ") for column in found)),
    )


def _one(units: set[ResponseUnit], own: str | None, path: Path) -> ResponseUnit | None:
    """The unit that a file says, which is one."""
    if len({unit[:2] for unit in units}) > 1:
        said = " and ".join(sorted(repr(unit.text) for unit in units))
        raise ValueError(f"path = {str(path)!r} says {said} of its responses; give unit=, that of all")
    return next(iter(units), None if own is None else response_unit(own))


def _words_of(column: Column, table: TextTable) -> list[str]:
    words = [column.unit, *column.unit.split()]
    return words if any(frequency_scale(word) for word in words) else [*table.words.split()]


def refuse_speeds(text: str, path: Path) -> None:
    """Say of a table whose head begins with speeds that it is none of frequency responses."""
    head = next((line.strip() for line in text.splitlines() if line.strip()), "")
    if re.match(r"[\W_]*(speed|rpm)(?![a-z])", head, re.IGNORECASE):
        raise ValueError(
            f"path = {str(path)!r} holds no frequency response but a table over speeds, such as that of a chart, a "
            f"limit or a list of cuts: it begins with {head[:_LONGEST]!r}; give the file of a measurement, or columns="
        )


def _of_head(table: TextTable, path: Path) -> list[Column]:
    count = table.numbers.shape[1]
    if not table.head:
        raise ValueError(f"path = {str(path)!r} has no head that says what its {count} columns are; {_remedy(count)}")
    found = [_column(name) for name in table.head]
    roles = {column.role for column in found}
    shown = ", ".join(repr(name[:_LONGEST]) for name in table.head[:_SHOWN]) + (", …" if count > _SHOWN else "")
    if "frequency" not in roles or not roles & {part for pair in _PAIRS for part in pair}:
        raise ValueError(
            f"path = {str(path)!r} is not seen to hold a frequency response, which takes a column of frequencies and "
            f"two of a response: its columns are {shown}; {_remedy(count)}, or the file of a measurement"
        )
    for name, column in zip(table.head, found, strict=True):
        if column.role == "":
            raise ValueError(
                f"path = {str(path)!r} has a column {name[:_LONGEST]!r} that is not understood; {_remedy(count)}"
            )
    return found


def _given(columns: Any, head: Sequence[str], count: int, path: Path) -> list[Column]:
    if isinstance(columns, Mapping):
        unknown = [name for name in columns if name not in head]
        if unknown:
            has = f"has {', '.join(map(repr, head))}" if head else "has no head"
            raise ValueError(f"columns names {unknown[0]!r}; path = {str(path)!r} {has}")
        roles = [columns.get(name, "unused") for name in head]
    else:
        roles = [columns] if isinstance(columns, str) else list(columns)
    if len(roles) != count:
        raise ValueError(f"columns has {len(roles)} roles, and path = {str(path)!r} {count} columns; {_remedy(count)}")
    for role in roles:
        _checks.choice("columns", role, ROLES)
    names = head or ("",) * count
    return [Column(role, _column(name).directions, _column(name).unit) for role, name in zip(roles, names, strict=True)]


def _remedy(count: int) -> str:
    usual = ("frequency", "real", "imaginary", "coherence", *("unused",) * min(count, _SHOWN))[: max(count, 3)]
    shown = repr(usual) if count <= len(usual) else f"{repr(usual)[:-1]}, …), {count} in all"
    return f"give columns={shown}, of {', '.join(ROLES)}"


def _column(name: str) -> Column:
    """What a name says of its column, such as "Real xx [m/N]"."""
    inside = re.search(r"[\[(](?!\s*[fω]\s*\))(.*)[\])]", name)
    unit = inside[1] if inside else ""
    words = name.replace(f"[{unit}]", " ").replace(f"({unit})", " ") if unit else name
    if not unit:
        unit = next((word for word in reversed(name.split()) if response_unit(word) or frequency_scale(word)), "")
        words = name.replace(unit, " ") if unit else name
    found = _DIRECTIONS.search(re.sub(r"[_|]", " ", words))
    directions = (found[1].lower(), found[2].lower()) if found else None
    return Column(_role(name), directions, unit)


def _role(name: str) -> str:
    """The role that a name has, or nothing."""
    words = [word for word in re.split(r"[\s()\[\]{}|,:_]+", name) if word]
    for role, pattern in _NAMES.items():
        if any(re.fullmatch(pattern, word, 0 if role == "decibels" else re.IGNORECASE) for word in words):
            if role != "phase":
                return role
            degrees = any(re.fullmatch(r"deg(rees?)?|°", word, re.IGNORECASE) for word in words)
            radians = any(re.fullmatch(r"rad(ians?)?", word, re.IGNORECASE) for word in words)
            return "phase_degrees" if degrees else "phase_radians" if radians else ""
    return "magnitude" if "|" in name else ""


def _matrix(
    numbers: Float[np.ndarray, "n columns"], columns: list[Column], path: Path
) -> tuple[
    Complex[np.ndarray, "n responses references"],
    Float[np.ndarray, "n responses references"] | None,
    tuple[str, ...],
    tuple[str, ...],
]:
    """The responses by the directions of their columns."""
    parts: dict[tuple[str, str] | None, dict[str, np.ndarray]] = {}
    for column, values in zip(columns, numbers.T, strict=True):
        if column.role in ("frequency", "unused"):
            continue
        own = parts.setdefault(column.directions, {})
        if column.role in own:
            raise ValueError(
                f"path = {str(path)!r} has two columns {column.role!r} of one response; name the directions above "
                "them, such as 'real xy' of response x to a force along y, or give columns= with 'unused'"
            )
        own[column.role] = values
    whole = {pair: _joined(part, path) for pair, part in parts.items() if set(part) != {"coherence"}}
    if not whole:
        raise ValueError(f"path = {str(path)!r} has no columns of a response; {_remedy(numbers.shape[1])}")
    if len(whole) > 1 and None in whole:
        raise ValueError(
            f"path = {str(path)!r} has responses with and without directions; name them above each column, such as "
            "'real xy', or give columns= with 'unused'"
        )
    response, reference = (tuple(sorted({pair[end] for pair in whole if pair})) for end in (0, 1))
    shape = len(numbers), max(len(response), 1), max(len(reference), 1)
    value, coherence = np.full(shape, np.nan, complex), np.full(shape, np.nan)
    for pair, samples in whole.items():
        place = (response.index(pair[0]), reference.index(pair[1])) if pair else (0, 0)
        value[:, *place] = samples
        coherence[:, *place] = parts[pair].get("coherence", np.nan)
    return value, None if np.isnan(coherence).all() else coherence, response, reference


def _joined(part: Mapping[str, np.ndarray], path: Path) -> Complex[np.ndarray, " n"]:
    """A response of its parts."""
    for first, second in _PAIRS:
        if first in part and second in part:
            one, other = part[first], part[second]
            # What is beyond floating point is a gap.
            with np.errstate(over="ignore", invalid="ignore"):
                if first == "real":
                    return one + 1j * other
                size = one if first == "magnitude" else 10 ** (one / 20)
                return size * np.exp(1j * (np.deg2rad(other) if second == "phase_degrees" else other))
    has = ", ".join(sorted(set(part) - {"coherence"}))
    raise ValueError(
        f"path = {str(path)!r} has {has} and no other part; a response takes real and imaginary columns, or magnitude "
        "and phase"
    )
