"""All that a screen of the explorer shows follows from its state: plain numbers, in SI units."""

from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar, NamedTuple

from lobex import _checks

MOST_MODES, MOST_TEETH, MOST_BLADES, MOST_ELEMENTS, MOST_SPEEDS, MOST_PERIODS = 40, 32, 48, 50, 5000, 2000
"""What a page takes; a script has no such ends."""
DIRECTIONS = ("down", "up")
# Angles that people write down add up to a turn within this, in degrees.
_ROUNDING = 1e-6


class Knob(NamedTuple):
    """How a number is shown and moved.

    Attributes:
        label: in words.
        unit: that it is shown in, and ``scale``, its size in SI.
        low, high: ends of its slider, in SI; numbers beyond are typed.
        signed: may be below zero.
        zero: may be zero, where what it stands for is left out.
    """

    label: str
    unit: str
    scale: float
    low: float
    high: float
    signed: bool = False
    zero: bool = True


def _knob(default: float, *how: Any, **more: Any) -> Any:
    return field(default=default, metadata={"knob": Knob(*how, **more)})


def knobs_of(part: Any) -> dict[str, Knob]:
    """The knobs of a part of a state, by the name of the number."""
    return {f.name: f.metadata["knob"] for f in fields(part) if "knob" in f.metadata}


@dataclass(frozen=True)
class Rod:
    """The thesis' clamped rod, as ``lobex.Rod``."""

    elements: int = 5
    young_modulus: float = _knob(210e7, "Young's modulus E", "GPa", 1e9, 0.5e9, 8e9, zero=False)
    density: float = _knob(4600.0, "density ρ", "kg/m³", 1.0, 1e3, 9e3, zero=False)
    length: float = _knob(0.5, "length L", "mm", 1e-3, 0.2, 1.0, zero=False)
    area: float = _knob(10e-4, "cross-section S", "mm²", 1e-6, 2e-4, 4e-3, zero=False)
    damping_ratio: float = _knob(0.03, "damping ratio ξ", "%", 1e-2, 1e-3, 0.1)

    name: ClassVar[str] = "rod"


@dataclass(frozen=True)
class Mode:
    """A row of a modal table: frequency in Hz, damping ratio, modal mass in kg, and the axes along which it moves."""

    frequency: float = _knob(146.5, "frequency", "Hz", 1.0, 10.0, 3000.0, zero=False)
    damping_ratio: float = _knob(0.0032, "damping ratio ξ", "%", 1e-2, 1e-4, 0.1)
    mass: float = _knob(2.573, "modal mass", "kg", 1.0, 0.01, 20.0, zero=False)
    x: float = 1.0
    y: float = 0.0
    z: float = 0.0

    columns: ClassVar[tuple[str, ...]] = ("frequency", "damping_ratio", "mass")


@dataclass(frozen=True)
class Table:
    """Modes of a tool, or of tool and workpiece together."""

    modes: tuple[Mode, ...] = (Mode(),)

    name: ClassVar[str] = "table"

    @property
    def directions(self) -> int:
        """Up to the last axis along which a mode moves."""
        return 3 if any(mode.z for mode in self.modes) else 2 if any(mode.y for mode in self.modes) else 1


@dataclass(frozen=True)
class Measured:
    """A measured frequency response, in a file: a link and a script tell of it by its name and what is in it.

    Attributes:
        file: its name.
        digest: SHA-256 of its content, in hexadecimal digits.
        unit: of the response over the force, as ``lobex.read_frf`` takes it; "" for what the file says.
    """

    file: str
    digest: str
    unit: str = ""

    name: ClassVar[str] = "measured"


@dataclass(frozen=True)
class RubNumbers:
    """A rub has no numbers beside those of its structure."""

    name: ClassVar[str] = "rub"


@dataclass(frozen=True)
class Blade:
    """A blade of a stage: by what share its frequencies are higher, and the angle to the one before it, degrees."""

    mistuning: float = 0.0
    spacing: float = 60.0


@dataclass(frozen=True)
class BladingNumbers:
    """Those of ``lobex.Blading``: blades, of which each rubs in the track of the one before it."""

    coupling: float = _knob(60.0, "coupling through the disc", "Hz", 1.0, 0.0, 400.0)
    blades: tuple[Blade, ...] = (Blade(),) * 6

    name: ClassVar[str] = "blading"

    @property
    def tuned(self) -> bool:
        """Whether all blades are alike."""
        return len({blade.mistuning for blade in self.blades}) == 1

    @property
    def even(self) -> bool:
        """Whether they follow each other at equal angles."""
        return len({blade.spacing for blade in self.blades}) == 1


@dataclass(frozen=True)
class TurningNumbers:
    """Those of ``lobex.Turning``; process damping with a coefficient above zero alone."""

    radial: float = _knob(2e8, "radial force Kᵣ", "N/mm²", 1e6, 2e7, 3e9, zero=False)
    diameter: float = _knob(0.05, "diameter", "mm", 1e-3, 0.005, 0.3, zero=False)
    damping_coefficient: float = _knob(0.0, "process damping C", "N/mm", 1e3, 0.0, 5e5)

    name: ClassVar[str] = "turning"


@dataclass(frozen=True)
class Tooth:
    """A tooth: the angle to the next and its helix angle, degrees, and what its radius has above the nominal one, m."""

    pitch: float = 360.0
    helix: float = 0.0
    runout: float = 0.0


@dataclass(frozen=True)
class MillingNumbers:
    """Those of ``lobex.Milling`` and its cutter; what is zero and may be so is left out."""

    tangential: float = _knob(5.5e8, "tangential force Kₜ", "N/mm²", 1e6, 5e7, 4e9, zero=False)
    normal: float = _knob(2e8, "normal force Kₙ", "N/mm²", 1e6, 0.0, 3e9)
    axial: float = _knob(0.0, "axial force Kₐ", "N/mm²", 1e6, 0.0, 2e9, signed=True)
    radial_immersion: float = _knob(0.5, "radial immersion", "%", 1e-2, 0.01, 1.0, zero=False)
    direction: str = "down"
    feed_per_tooth: float = _knob(1e-4, "feed per tooth", "mm", 1e-3, 0.0, 4e-4)
    tangential_edge: float = _knob(0.0, "tangential edge force", "N/mm", 1e3, 0.0, 6e4, signed=True)
    normal_edge: float = _knob(0.0, "normal edge force", "N/mm", 1e3, 0.0, 6e4, signed=True)
    axial_edge: float = _knob(0.0, "axial edge force", "N/mm", 1e3, 0.0, 6e4, signed=True)
    diameter: float = _knob(0.012, "diameter", "mm", 1e-3, 0.002, 0.08, zero=False)
    corner_radius: float = _knob(0.0, "corner radius", "mm", 1e-3, 0.0, 0.006)
    lead_degrees: float = _knob(90.0, "lead angle", "°", 1.0, 10.0, 90.0, zero=False)
    damping_coefficient: float = _knob(0.0, "process damping C", "N/mm", 1e3, 0.0, 5e5)
    damping_friction: float = _knob(0.0, "flank friction", "1", 1.0, 0.0, 0.6)
    speed_amplitude: float = _knob(0.0, "speed variation", "%", 1e-2, 0.0, 0.3)
    speed_frequency_ratio: float = 0.1
    teeth: tuple[Tooth, ...] = (Tooth(),)

    name: ClassVar[str] = "milling"


Structure = Rod | Table | Measured
Numbers = RubNumbers | TurningNumbers | MillingNumbers | BladingNumbers


@dataclass(frozen=True)
class View:
    """Between which speeds, Hz, and gains, N/m or m, at how many speeds, and how many gains a search scans."""

    speed_low: float
    speed_high: float
    speeds: int
    gain_low: float
    gain_high: float
    scan: int = 33


@dataclass(frozen=True)
class Point:
    """A speed, Hz, and a gain that were clicked at."""

    speed: float
    gain: float


@dataclass(frozen=True)
class State:
    """What a screen is made of.

    Attributes:
        structure: what vibrates.
        numbers: of the process, whose kind they tell.
        view: what is drawn.
        deviation: relative standard deviations of numbers, by name, above zero, in the order of the names.
        point: what was clicked at, if anything was.
        periods: of the march there.
        heard: a chatter frequency that was heard, Hz; None for none.
    """

    structure: Structure
    numbers: Numbers
    view: View
    deviation: tuple[tuple[str, float], ...] = ()
    point: Point | None = None
    periods: int = 100
    heard: float | None = None

    def __post_init__(self) -> None:
        _check_structure(self.structure, self.numbers)
        _check_numbers(self.numbers)
        _check_view(self.view)
        for name, value in self.deviation:
            _checks.positive(f"deviation of {name}", value)
        object.__setattr__(self, "deviation", tuple(sorted(self.deviation)))
        if self.point is not None:
            _checks.positive("point, its speed", self.point.speed, "Hz")
            _checks.not_negative("point, its gain", self.point.gain)
        _checks.integer("periods", self.periods, 4, MOST_PERIODS)
        if self.heard is not None:
            _checks.positive("heard", self.heard, "Hz")

    @property
    def kind(self) -> str:
        """Of the process: "rub", "turning", "milling" or "blading"."""
        return self.numbers.name

    def changed(self, name: str, value: Any) -> "State":
        """The same with another number of its process, its rod, or its view, by name."""
        for part in ("numbers", "structure", "view"):
            whole = getattr(self, part)
            if name in {f.name for f in fields(whole)}:
                return replace(self, **{part: replace(whole, **{name: value})})
        return replace(self, **{name: value})


def _check_structure(structure: Structure, numbers: Numbers) -> None:
    if isinstance(structure, Measured):
        if isinstance(numbers, MillingNumbers | BladingNumbers):
            raise ValueError(
                f"structure = measured serves rub and turning; give modes for {numbers.name}, such as fitted ones"
            )
        return
    if isinstance(structure, Rod):
        if not isinstance(numbers, RubNumbers):
            raise ValueError(f"structure = rod is the blade of a rub; give modes for {numbers.name}")
        _checks.integer("elements", structure.elements, 1, MOST_ELEMENTS)
        _check_knobs(structure)
        return
    if not 1 <= len(structure.modes) <= MOST_MODES:
        raise ValueError(f"modes has {len(structure.modes)} rows; give 1 to {MOST_MODES}")
    for number, mode in enumerate(structure.modes, 1):
        try:
            _check_knobs(mode)
            for axis in ("x", "y", "z"):
                _checks.as_numbers(axis, getattr(mode, axis))
            if not (mode.x or mode.y or mode.z):
                raise ValueError("it has no direction; give x, y or z another number than 0")
        except ValueError as error:
            raise ValueError(f"modes, row {number}: {error}") from None
    if structure.directions > 1 and not isinstance(numbers, MillingNumbers):
        raise ValueError(f"modes has rows along y or z; {numbers.name} takes one direction, x")


def _check_numbers(numbers: Numbers) -> None:
    _check_knobs(numbers)
    if isinstance(numbers, BladingNumbers):
        _check_blades(numbers.blades)
    if not isinstance(numbers, MillingNumbers):
        return
    _checks.choice("direction", numbers.direction, DIRECTIONS)
    if numbers.radial_immersion > 1:
        raise ValueError(f"radial_immersion = {numbers.radial_immersion:.6g}; give a share above 0 and up to 1")
    if not 1 <= len(numbers.teeth) <= MOST_TEETH:
        raise ValueError(f"teeth has {len(numbers.teeth)} rows; give 1 to {MOST_TEETH}")
    for number, tooth in enumerate(numbers.teeth, 1):
        _checks.positive(f"teeth, row {number}: pitch", tooth.pitch, "degrees")
        _checks.not_negative(f"teeth, row {number}: helix", tooth.helix, "degrees")
        _checks.as_numbers(f"teeth, row {number}: runout", tooth.runout, "m")


def _check_blades(blades: tuple[Blade, ...]) -> None:
    if not 1 <= len(blades) <= MOST_BLADES:
        raise ValueError(f"blades has {len(blades)} rows; give 1 to {MOST_BLADES}")
    for number, blade in enumerate(blades, 1):
        _checks.as_numbers(f"blades, row {number}: mistuning", blade.mistuning)
        if abs(blade.mistuning) >= 1:
            raise ValueError(f"blades, row {number}: mistuning = {100 * blade.mistuning:.6g} % is 100 % or more")
        _checks.positive(f"blades, row {number}: spacing", blade.spacing, "degrees")
    whole = sum(blade.spacing for blade in blades)
    if abs(whole - 360) > _ROUNDING:
        raise ValueError(f"blades: spacing adds up to {whole:.9g}°; give angles that make 360°")


def _check_knobs(part: Any) -> None:
    for name, knob in knobs_of(part).items():
        value = getattr(part, name)
        _checks.scalar(name, value)
        if knob.signed:
            _checks.as_numbers(name, value)
        elif knob.zero:
            _checks.not_negative(name, value)
        else:
            _checks.positive(name, value)


def _check_view(view: View) -> None:
    _checks.positive("speed_low", view.speed_low, "Hz")
    _checks.positive("speed_high", view.speed_high, "Hz")
    _checks.not_negative("gain_low", view.gain_low)
    _checks.positive("gain_high", view.gain_high)
    for name, low, high in (
        ("speed", view.speed_low, view.speed_high),
        ("gain", view.gain_low, view.gain_high),
    ):
        if low >= high:
            raise ValueError(f"{name}_low = {low:.6g} must be below {name}_high = {high:.6g}; give the lower end first")
    _checks.integer("speeds", view.speeds, 2, MOST_SPEEDS)
    _checks.integer("scan", view.scan, 5, 513)


STARTS = {
    "rub": State(Rod(), RubNumbers(), View(50.0, 400.0, 1000, 0.0, 2.5e6)),
    "turning": State(Table(), TurningNumbers(), View(2000 / 60, 12000 / 60, 1000, 0.0, 2e-3)),
    "milling": State(Table(), MillingNumbers(), View(5000 / 60, 25000 / 60, 301, 0.0, 5e-3)),
    "blading": State(Table((Mode(400.0, 0.005, 0.11),)), BladingNumbers(), View(40.0, 160.0, 1000, 0.0, 3e4)),
}
"""What a page begins with: the thesis' rod, its tool of §3.4, and a stage of six blades."""
