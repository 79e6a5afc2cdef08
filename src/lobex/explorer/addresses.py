"""A state as the query string of a link, and back: numbers to the last bit, and nothing else is taken."""

import re
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from typing import Any
from urllib.parse import parse_qsl, urlencode

from lobex.explorer.state import (
    STARTS,
    Blade,
    BladingNumbers,
    Measured,
    MillingNumbers,
    Mode,
    Point,
    Rod,
    RubNumbers,
    State,
    Table,
    Tooth,
    TurningNumbers,
    View,
)

_NUMBERS = {kind.name: kind for kind in (RubNumbers, TurningNumbers, MillingNumbers, BladingNumbers)}
_STRUCTURES = {kind.name: kind for kind in (Rod, Table, Measured)}
_ROWS = {"modes": Mode, "teeth": Tooth, "blades": Blade}
_DEVIATION = "deviation."
_LONGEST = 16_384
_NAME = re.compile(r"[A-Za-z_][\w.]*(\[\d+\])?")
_DIGEST = re.compile(r"[0-9a-f]{64}")


def query_of(state: State) -> str:
    """Such as "process=turning&structure=table&modes=146.5,0.0032,2.573,1.0,0.0,0.0&radial=2e8…"."""
    pairs: list[tuple[str, str]] = [("process", state.kind), ("structure", state.structure.name)]
    for part in (state.structure, state.numbers, state.view):
        pairs += [(f.name, _text(getattr(part, f.name))) for f in fields(part)]
    pairs += [(_DEVIATION + name, repr(value)) for name, value in state.deviation]
    if state.point is not None:
        pairs.append(("point", f"{state.point.speed!r},{state.point.gain!r}"))
    pairs.append(("periods", str(state.periods)))
    if state.heard is not None:
        pairs.append(("heard", repr(state.heard)))
    return urlencode(pairs, safe=",;:[]")


def state_of_query(query: str) -> State:
    """What ``query_of`` wrote; what is left out is as a page begins with.

    Raises:
        ValueError: for names that are none, values that are no numbers, and what a state refuses.
    """
    if len(query) > _LONGEST:
        raise ValueError(f"the link has {len(query)} characters; give one of up to {_LONGEST}")
    try:
        pairs = parse_qsl(
            query.removeprefix("?"), keep_blank_values=True, strict_parsing=bool(query), max_num_fields=200
        )
    except ValueError:
        raise ValueError("the link holds no list of names and values; copy it again") from None
    given: dict[str, str] = {}
    for name, value in pairs:
        if name in given:
            raise ValueError(f"the link says {name} twice; copy it again")
        given[name] = value
    kind = given.pop("process", "rub")
    if kind not in _NUMBERS:
        raise ValueError(f"process = {kind[:40]!r} is unknown; choose one of {', '.join(_NUMBERS)}")
    start = STARTS[kind]
    structure = given.pop("structure", start.structure.name)
    if structure not in _STRUCTURES:
        raise ValueError(f"structure = {structure[:40]!r} is unknown; choose one of {', '.join(_STRUCTURES)}")
    usual: Any = start.structure if structure == start.structure.name else None
    parts = {
        "structure": _part(_STRUCTURES[structure], given, usual),
        "numbers": _part(_NUMBERS[kind], given, start.numbers),
        "view": _part(View, given, start.view),
    }
    names = [name for name in given if name.startswith(_DEVIATION)]
    for name in names:
        if not _NAME.fullmatch(name.removeprefix(_DEVIATION)):
            raise ValueError(f"{name[:60]!r} names no number")
    deviation = tuple((name.removeprefix(_DEVIATION), _number(name, given.pop(name))) for name in names)
    more: dict[str, Any] = {}
    if "point" in given:
        more["point"] = Point(*_numbers("point", given.pop("point"), 2))
    if "periods" in given:
        more["periods"] = _whole("periods", given.pop("periods"))
    if "heard" in given:
        more["heard"] = _number("heard", given.pop("heard"))
    if given:
        raise ValueError(f"the link says {next(iter(given))[:60]!r}, which a {kind} does not have")
    return State(**parts, deviation=deviation, **more)


def _part(kind: type, given: dict[str, str], usual: Any) -> Any:
    """A part of a state from its names, which are taken out of ``given``."""
    values = {}
    for f in fields(kind):
        if f.name in given:
            values[f.name] = _read(f.name, given.pop(f.name), f.type)
        elif usual is not None:
            values[f.name] = getattr(usual, f.name)
        elif f.default is MISSING:
            raise ValueError(f"the link has no {f.name}; copy it again")
    return kind(**values)


def _read(name: str, text: str, kind: Any) -> Any:
    if name in _ROWS:
        row = _ROWS[name]
        return tuple(row(*_numbers(name, part, len(fields(row)))) for part in text.split(";"))
    if name == "digest" and not _DIGEST.fullmatch(text):
        raise ValueError("digest is no SHA-256 of a file; copy the link again")
    readers: Mapping[type, Callable[[str, str], Any]] = {float: _number, int: _whole, str: lambda _, value: value}
    return readers[kind](name, text)


def _text(value: Any) -> str:
    if isinstance(value, tuple):
        return ";".join(",".join(repr(float(getattr(row, f.name))) for f in fields(row)) for row in value)
    return value if isinstance(value, str) else repr(value)


def _numbers(name: str, text: str, count: int) -> list[float]:
    parts = text.split(",")
    if len(parts) != count:
        raise ValueError(f"{name} = {text[:60]!r} is not {count} numbers with commas between")
    return [_number(name, part) for part in parts]


def _number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{name} = {text[:40]!r} is no number") from None


def _whole(name: str, text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise ValueError(f"{name} = {text[:40]!r} is no whole number") from None
