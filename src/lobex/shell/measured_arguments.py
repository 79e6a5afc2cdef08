"""The flags of modes that a tap test measured."""

from dataclasses import dataclass
from typing import Annotated, Any

import tyro


def _none(name: str, metavar: str, hint: str) -> Any:
    return tyro.conf.arg(name=name, metavar=metavar, help_behavior_hint=f"(default: {hint})")


@dataclass(frozen=True)
class Measured:
    """Modes fitted to measured frequency responses, in place of those that flags or a file tell
    (docs/howto/measured.md)."""

    file: Annotated[str | None, _none("frf", "FILE", "none")] = None
    """File of the responses: universal (.uff, .unv), CutPro's .frf, .csv, .npz, .npy or .mat."""
    unit: Annotated[str | None, _none("frf-unit", "UNIT", "what the file says")] = None
    """Their unit, which says what was measured: m/N, um/N, m/s/N, m/s^2/N, g/N."""
    columns: Annotated[str | None, _none("frf-columns", "ROLE,...", "what the head says")] = None
    """What the columns of a table are: frequency,real,imaginary or frequency,magnitude,phase_degrees."""
    band: Annotated[str | None, _none("frf-band", "LOW:HIGH", "all lines")] = None
    """Lowest and highest frequency of the fit, Hz."""
    modes: Annotated[int | None, _none("frf-modes", "INT", "chosen")] = None
    """Number of modes."""


@dataclass(frozen=True)
class MeasuredInPlane(Measured):
    """Modes fitted to measured frequency responses, in place of those that flags or a file tell
    (docs/howto/measured.md)."""

    across: Annotated[str | None, _none("frf-y", "FILE", "none")] = None
    """File of the responses across the feed, where --frf has those along it alone."""
