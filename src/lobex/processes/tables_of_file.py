"""Tables of a TOML file as models: read, checked by name, lengths in metres."""

import inspect
import os
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from lobex import _checks
from lobex._lengths import metres


def read_tables(
    path: str | os.PathLike[str],
    makers: Mapping[str, Callable[[Any], Any]],
    needed: Sequence[str],
    reader: str,
    listed: Sequence[str] = (),
    either: Sequence[str] = (),
) -> dict[str, Any]:
    """What each table of a file makes, by its name.

    Args:
        path: of the file.
        makers: what makes something of each table that there may be.
        needed: tables that there must be.
        reader: the name of the function that tells of them.
        listed: of which there are several, in a list.
        either: of which there is one, or a list of several.

    Raises:
        ValueError: for a file that cannot be read or is no TOML, tables that are missing or unknown, and what the
            makers refuse; the message names the table.
    """
    place = _checks.place("path", path)
    try:
        content = tomllib.loads(place.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"path = {str(path)!r} cannot be read ({error.strerror}); give a TOML file") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"path = {str(path)!r} is no TOML ({error}); see {reader}") from None
    known(f"path = {str(path)!r}", content, makers)
    missing = [name for name in needed if name not in content]
    if missing:
        raise ValueError(f"path = {str(path)!r} has no [{missing[0]}]; see {reader}")
    found = {}
    for name, table in content.items():
        with naming(path, name):
            several = name in listed or (name in either and isinstance(table, list))
            if not isinstance(table, list if several else dict):
                raise ValueError(f"it is no table; write {f'[[{name}]]' if several else f'[{name}]'}")
            if name in either and several and not all(isinstance(one, dict) for one in table):
                raise ValueError(f"it is no list of tables; write [[{name}]] above each")
            found[name] = makers[name](table)
    return found


@contextmanager
def naming(path: str | os.PathLike[str], table: str) -> Iterator[None]:
    """Say of what is refused in which table of a file it is."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"path = {str(path)!r}, [{table}]: {error}") from None


def made(make: Callable[..., Any], table: dict[str, Any], lengths: Sequence[str], takes: Any = None) -> Any:
    """What a function makes of a table, of which it takes its parameters or those named, in metres those of lengths."""
    known("it", table, inspect.signature(make).parameters if takes is None else takes)
    try:
        return make(**in_metres(table, lengths))
    except TypeError as error:
        raise ValueError(str(error).partition(" ")[2]) from None


def in_metres(table: dict[str, Any], lengths: Sequence[str]) -> dict[str, Any]:
    """The table with its lengths, and lists of them, in metres."""

    def length(name: str, value: Any) -> Any:
        return [metres(name, part) for part in value] if isinstance(value, list) else metres(name, value)

    return {name: length(name, value) if name in lengths else value for name, value in table.items()}


def known(what: str, table: Mapping[str, Any], names: Any) -> None:
    """Require keys of these names alone."""
    for name in table:
        if name not in names:
            raise ValueError(f"{what} has {name!r}, which is none of {', '.join(sorted(names))}")
