"""The flags of ``lobex severity``: those of a wear march, over the initial penetration, and what the lobes foretell."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import tyro

from lobex.shell.arguments import Output, Storage, count_hint, file_of
from lobex.shell.values import Range
from lobex.shell.wear_arguments import BladeFlags, CasingFlags, ContactFlags, Process

_BLADE, _CONTACT, _OUTPUT = BladeFlags(), ContactFlags(), Output()
_STORAGE = Storage()


@dataclass(frozen=True)
class SeverityCasing(CasingFlags):
    """The casing before wear, whose bumps reach beyond the clearance by the penetration."""

    amplitude: Annotated[float, tyro.conf.Fixed, tyro.conf.Suppress] = CasingFlags.amplitude


@dataclass(frozen=True)
class SeverityFlags:
    """How long and how finely to march, and what is drawn and written."""

    process: Process = "rub"
    """What is marched, of which there is one kind: a rub."""
    speed: Range = "50:400:71"
    """Rotational frequencies, Hz."""
    penetration: Range = "1e-5:1e-4:10"
    """By how much the bumps of the casing reach beyond the tip at rest, m."""
    of: Annotated[str, tyro.conf.arg(metavar="amplitude|wear")] = "amplitude"
    """Drawn: the largest motion of a tip in the last revolution, or the cross-section that all revolutions remove."""
    revolutions: int = 20
    """Revolutions to march."""
    steps: int = 2048
    """Time steps per revolution, and casing cells."""
    lobes: Annotated[int | None, count_hint("401, or as many as speeds by an operator")] = None
    """At how many speeds the limit is found that the lobes foretell; 0 for no prediction."""
    blade_file: Annotated[str | None, file_of("blade")] = None
    """TOML file of a blade or a whole stage, its casing and law, in place of their flags
    (docs/howto/wear_of_real_blades.md)."""
    blade: BladeFlags = _BLADE
    casing: SeverityCasing = SeverityCasing()
    contact: ContactFlags = _CONTACT
    output: Output = _OUTPUT
    storage: Storage = _STORAGE

    name: ClassVar[str] = "severity"


@dataclass(frozen=True)
class Severity:
    """Draw how bad a rub gets over speed and initial penetration, with what the lobes foretell over it: PATH.nc with
    all marches, PATH-limit.nc with the prediction, and the map PATH.png.

    Example: lobex severity rub --speed 50:400:71 --penetration 1e-5:1e-4:10 --stiffness 1.35e6 --out severity
    """

    march: tyro.conf.OmitArgPrefixes[SeverityFlags]
