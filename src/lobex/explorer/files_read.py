"""Files that are brought in: a tool, a measured frequency response, a modal table, a list of cuts.

They are small and hold text and numbers alone; none of their readers runs what is in them.
"""

import hashlib
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import lobex
from lobex.explorer.started import state_of, table_of
from lobex.explorer.state import Measured, MillingNumbers, State, Table, TurningNumbers
from lobex.explorer.tried_cuts import MOST_CUTS, Cuts

MOST_BYTES = 8_000_000
TOOL, FITTED, AS_IT_IS, MODES = KINDS = (
    "tool (TOML)",
    "measured response, fitted",
    "measured response, as it is",
    "modal table",
)
UNITS = ("as the file says", "m/N", "um/N", "m/s/N", "m/s^2/N", "g/N")
_SHOWN = 60


class Read(NamedTuple):
    """A state with what a file says in the place of its structure.

    Attributes:
        state: itself.
        told: what is to be said of the file.
        response: the ``lobex.Receptance``, where it is taken as it is.
    """

    state: State
    told: str = ""
    response: Any = None


def read_model(name: str, content: bytes, state: State, kind: str = TOOL, unit: str = UNITS[0]) -> Read:
    """What a file says in the place of a state's structure.

    Args:
        name: of the file, whose ending tells its format.
        content: of it.
        state: what is shown so far.
        kind: what it holds, one of ``KINDS``.
        unit: of a response over the force, one of ``UNITS``.

    Raises:
        ValueError: for files that are too large, and those that their readers refuse.
    """
    with _file(name, content) as path:
        if kind == TOOL:
            return Read(of_tool(path, state))
        if kind == AS_IT_IS:
            return _as_it_is(name, content, path, state, unit)
        return Read(*of_response(path, state, unit)) if kind == FITTED else Read(of_table(path, state))


def of_tool(path: Path, state: State) -> State:
    """The state of a tool's file, in turning or, of another state than that, in milling."""
    told = lobex.read_tool(path)
    if isinstance(state.numbers, TurningNumbers):
        cutter = told.pop("cutter", None)
        return state_of(lobex.Turning(**told, diameter=None if cutter is None else cutter.diameter))
    if "cutter" not in told:
        raise ValueError(f"tool = {str(path)!r} has no [cutter]; milling takes one")
    own = state.numbers if isinstance(state.numbers, MillingNumbers) else MillingNumbers()
    cut = {"radial_immersion": own.radial_immersion, "direction": own.direction}
    return state_of(lobex.Milling(**told, **cut, feed_per_tooth=own.feed_per_tooth or None))


def of_response(path: Path, state: State, unit: str = UNITS[0]) -> tuple[State, str]:
    """The state with modes fitted to a measured response and their deviations, and the report of the fit."""
    frf = lobex.read_frf(path, unit=None if unit == UNITS[0] else unit)
    if not isinstance(state.numbers, MillingNumbers):
        _check_one(frf, path)
    fit = frf.fit()
    shown = _with_table(state, table_of(fit.modes))
    return replace(shown, deviation=_deviation(fit.relative_standard_deviation)), repr(fit)


def _as_it_is(name: str, content: bytes, path: Path, state: State, unit: str) -> Read:
    """The state with a measured response in the place of modes."""
    said = "" if unit == UNITS[0] else unit
    frf = lobex.read_frf(path, unit=said or None)
    _check_one(frf, path)
    structure = Measured(Path(name).name, hashlib.sha256(content).hexdigest(), said)
    shown = replace(state, structure=structure, deviation=(), point=None, heard=None)
    return Read(shown, repr(frf), frf.receptance())


def _check_one(frf: lobex.Frf, path: Path) -> None:
    """Require one response, where the process has one direction."""
    if len(frf.pairs) > 1:
        named = ", ".join(f"{response} to {reference}" for response, reference in frf.pairs)
        raise ValueError(
            f"path = {str(path)!r} holds several responses, {named}, of which this process takes one; keep that in the "
            "direction of its force in the file"
        )


def of_table(path: Path, state: State) -> State:
    """The state with the modes of a table."""
    return _with_table(state, table_of(lobex.read_modes(path)))


def read_cuts_of(name: str, content: bytes) -> Cuts:
    """The cuts of a table in a file, as ``lobex.read_cuts`` reads it."""
    with _file(name, content) as path:
        rows = np.asarray(lobex.read_cuts(path))
    if len(rows) > MOST_CUTS:
        raise ValueError(f"{name[:_SHOWN]!r} holds {len(rows)} cuts; give at most {MOST_CUTS}")
    return Cuts(rows[:, 0], rows[:, 1], rows[:, 2] == 1)


def _with_table(state: State, table: Table) -> State:
    """The state with other modes, and the diagram around their lobes."""
    from lobex.explorer.recipes import process_of

    shown = replace(state, structure=table, deviation=(), point=None)
    return replace(shown, view=state_of(process_of(shown)).view)


def _deviation(relative: dict[str, float]) -> tuple[tuple[str, float], ...]:
    """Of all modes the largest, by the names of a page: a modal mass goes with the square of the shape."""
    names = {"angular_frequency": ("frequency", 1.0), "damping_ratio": ("damping_ratio", 1.0), "shape": ("mass", 2.0)}
    found: dict[str, float] = {}
    for name, value in relative.items():
        stem = name.partition("[")[0].rpartition(".")[2]
        if stem in names and np.isfinite(value) and value > 0:
            own, times = names[stem]
            found[own] = max(found.get(own, 0.0), float(times * value))
    return tuple(sorted(found.items()))


@contextmanager
def _file(name: str, content: bytes) -> Iterator[Path]:
    """The content as a file of its own, whose place messages do not tell."""
    if len(content) > MOST_BYTES:
        raise ValueError(f"{name[:_SHOWN]!r} has {len(content)} bytes; give a file of up to {MOST_BYTES}")
    ending = Path(name).suffix
    safe = ending if ending.isascii() and ending[1:].isalnum() else ""
    # What the name says of folders is not followed.
    stem = re.sub(r"[^A-Za-z0-9_-]+", "_", Path(name).stem)[:_SHOWN] or "file"
    with tempfile.TemporaryDirectory(prefix="lobex-") as folder:
        path = Path(folder) / f"{stem}{safe}"
        path.write_bytes(content)
        try:
            yield path
        except ValueError as error:
            raise ValueError(str(error).replace(str(path), Path(name).name[:_SHOWN])) from None
