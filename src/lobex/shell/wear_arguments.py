"""The flags of ``lobex wear``: the blade, its casing, the contact law, and how long and how finely to march."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

import tyro

from lobex.shell.arguments import Axes, Output, Rod, Storage, file_of
from lobex.shell.values import Range

LAWS: dict[str, tuple[str, ...]] = {
    "linear": ("stiffness",),
    "cubic": ("width", "first", "second", "third"),
    "threshold": ("width", "offset", "slope"),
    "power": ("width", "coefficient", "exponent"),
    "bilinear": ("stiffness", "second_stiffness", "transition"),
    "kelvin-voigt": ("stiffness", "viscosity"),
    "plastic": ("stiffness", "yield_force", "hardening"),
}
DEFAULTS = {"stiffness": 4.5e6, "hardening": 0.0, "width": 1.0, "second": 0.0, "third": 0.0}


def _number(hint: str) -> Any:
    return tyro.conf.arg(metavar="FLOAT", help_behavior_hint=f"(default: {hint})")


_NEEDED = _number("none, needed by its law")
_AXES = Axes()
_OUTPUT = Output()
_STORAGE = Storage()


@dataclass(frozen=True)
class ContactFlags:
    """The contact law."""

    law: Annotated[str, tyro.conf.arg(metavar="linear|cubic|threshold|power|bilinear|kelvin-voigt|plastic")] = "linear"
    """F = K h, b (ρ₁h + ρ₂h² + ρ₃h³), b (K₀ + K_s h), b K h^p, of two slopes, K h + C ḣ, or elastic-plastic."""
    stiffness: Annotated[float | None, _number("4.5e6")] = None
    """Contact stiffness of linear, bilinear, kelvin-voigt and plastic, N/m."""
    width: Annotated[float | None, _number("1")] = None
    """Width b of cubic, threshold and power, m."""
    first: Annotated[float | None, _NEEDED] = None
    """ρ₁ of cubic, N/m²."""
    second: Annotated[float | None, _number("0")] = None
    """ρ₂ of cubic, N/m³."""
    third: Annotated[float | None, _number("0")] = None
    """ρ₃ of cubic, N/m⁴."""
    offset: Annotated[float | None, _NEEDED] = None
    """K₀ of threshold, N/m."""
    slope: Annotated[float | None, _NEEDED] = None
    """K_s of threshold, N/m²."""
    coefficient: Annotated[float | None, _NEEDED] = None
    """K of power, N/m^(1 + p)."""
    exponent: Annotated[float | None, _NEEDED] = None
    """p of power."""
    second_stiffness: Annotated[float | None, _NEEDED] = None
    """Contact stiffness of bilinear beyond its transition, N/m."""
    transition: Annotated[float | None, _NEEDED] = None
    """Penetration at which the slope of bilinear changes, m."""
    viscosity: Annotated[float | None, _NEEDED] = None
    """Viscosity of kelvin-voigt, N s/m."""
    yield_force: Annotated[float | None, _NEEDED] = None
    """Yield force of plastic, N."""
    hardening: Annotated[float | None, _number("0")] = None
    """Hardening of plastic, N/m."""


@dataclass(frozen=True)
class CasingFlags:
    """The casing before wear."""

    nodal_diameters: int = 2
    """Bumps per revolution."""
    amplitude: float = 1e-4
    """Height of the bumps, m."""
    clearance: float = 0.0
    """Gap between the tip at rest and the casing between bumps, m."""
    bump: Annotated[str, tyro.conf.arg(metavar="cosine|gaussian|ovoid")] = "cosine"
    """Shape of the bumps."""
    bump_width: float = 0.5
    """Width of the bumps, in pitches from bump to bump."""
    radius: float = 0.5
    """Radius of the casing, m."""
    axial_width: float = 1.0
    """Axial length of the rub track, m."""


@dataclass(frozen=True)
class BladeFlags(Rod):
    """The thesis' clamped rod."""

    elements: int = 10
    """Truss elements of the rod, which is also its number of modes."""


Process = Annotated[Literal["rub"], tyro.conf.Positional]


@dataclass(frozen=True)
class WearFlags:
    """How long and how finely to march, and what is written."""

    process: Process = "rub"
    """What is marched, of which there is one kind: a rub."""
    speed: Range = "30:1500:1471"
    """Rotational frequencies, Hz."""
    revolutions: int = 20
    """Revolutions to march."""
    steps: int = 4096
    """Time steps per revolution, and casing cells."""
    ramp: float = 0.0
    """Change of every speed from one revolution to the next, Hz."""
    incursion: float = 0.0
    """By how much blades and casing come closer in every revolution, m."""
    blade_file: Annotated[str | None, file_of("blade")] = None
    """TOML file of a blade or a whole stage, its casing and law, in place of their flags
    (docs/howto/wear_of_real_blades.md)."""
    blade: BladeFlags = BladeFlags()
    casing: CasingFlags = CasingFlags()
    contact: ContactFlags = ContactFlags()
    axes: Axes = _AXES
    output: Output = _OUTPUT
    storage: Storage = _STORAGE

    name: ClassVar[str] = "wear"


@dataclass(frozen=True)
class Wear:
    """March a rubbing blade and wear its casing at many speeds: PATH.nc, the map PATH.png, PATH-casing.png of
    the speed of most wear, and PATH-spectrum.png, or PATH-history.png where the speeds change.

    Of several contacts the casing and the spectrum are those of the one that moves most.

    Example: lobex wear --speed 30:1500:1471 --revolutions 20 --out wear
    """

    march: tyro.conf.OmitArgPrefixes[WearFlags]
