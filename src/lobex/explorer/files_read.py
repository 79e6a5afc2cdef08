"""Files that are brought in: a tool, or a measured frequency response; small ones, of text and numbers alone."""

import hashlib
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import lobex
from lobex.explorer.started import state_of, table_of
from lobex.explorer.state import MillingNumbers, State, TurningNumbers

MOST_BYTES = 8_000_000
_TOOL = ".toml"


def read_model(name: str, content: bytes, state: State) -> State:
    """The state with what a file says in the place of its structure.

    Args:
        name: of the file, whose ending tells what it is.
        content: of it.
        state: what is shown so far.

    Raises:
        ValueError: for files that are too large, and those that their readers refuse.
    """
    if len(content) > MOST_BYTES:
        raise ValueError(f"{name[:60]!r} has {len(content)} bytes; give a file of up to {MOST_BYTES}")
    ending = Path(name).suffix.lower()
    # Its name goes no further than a message: what it says of folders is not followed.
    with tempfile.TemporaryDirectory(prefix="lobex-") as folder:
        path = Path(folder) / f"file{ending if ending.isascii() and ending[1:].isalnum() else ''}"
        path.write_bytes(content)
        try:
            return of_tool(path, state) if ending == _TOOL else of_response(path, state)
        except ValueError as error:
            raise ValueError(str(error).replace(str(path), Path(name).name[:60])) from None


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


def of_response(path: Path, state: State) -> State:
    """The state with modes fitted to a measured response, and a view of their lobes."""
    if not hasattr(lobex, "read_frf"):
        raise ValueError(f"{str(path)!r} is no tool's file (.toml)")
    fitted = lobex.read_frf(path).modes()
    modes: Any = fitted[0] if isinstance(fitted, tuple) else fitted
    return replace(state, structure=table_of(modes), deviation=(), point=None)


def digest_of(content: bytes) -> str:
    """SHA-256, in hexadecimal digits."""
    return hashlib.sha256(content).hexdigest()
