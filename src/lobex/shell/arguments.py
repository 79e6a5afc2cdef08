"""The commands and their flags, as dataclasses whose docstrings are the manual."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import tyro

from lobex.shell.measured_arguments import Measured, MeasuredInPlane
from lobex.shell.values import Range, Values

_MEASURED, _IN_PLANE = Measured(), MeasuredInPlane()


def count_hint(hint: str) -> Any:
    """How a whole number is shown whose default is in words."""
    return tyro.conf.arg(metavar="INT", help_behavior_hint=f"(default: {hint})")


def _choice(names: str) -> Any:
    return tyro.conf.arg(metavar=names, help_behavior_hint="(default: see text)")


def _none_given(hint: str, metavar: str | None = None) -> Any:
    return tyro.conf.arg(metavar=metavar, help_behavior_hint=f"(default: {hint})")


@dataclass(frozen=True)
class Discretization:
    """How the monodromy operator is built."""

    method: Annotated[str | None, _choice("roots|duhamel|chebyshev|sdm")] = None
    """Characteristic roots (constant coefficients, no discretisation), exact structure with nodes chosen by the
    error, Chebyshev collocation, or semi-discretization (second order). If not given, the first of these that
    serves."""
    nodes: Annotated[int | None, count_hint("40; duhamel: chosen")] = None
    """Nodes per smooth piece of the delay, for chebyshev (taken with --nodes alone) and duhamel."""
    aligned: bool = True
    """End the Chebyshev pieces where a tooth enters or leaves; --no-aligned is the thesis' single interval."""
    steps: Annotated[int | None, count_hint("40")] = None
    """Semi-discretization steps per period."""
    order: Annotated[int | None, count_hint("0")] = None
    """Semi-discretization order, 0, 1 or 2; 0 is the thesis' mean of two samples."""


@dataclass(frozen=True)
class Output:
    """What is written and shown."""

    out: Annotated[str | None, tyro.conf.arg(metavar="PATH", help_behavior_hint="(default: the process' name)")] = None
    """Path without ending of the two files, PATH.nc and PATH.png."""
    quiet: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """No progress bar and no summary."""


@dataclass(frozen=True)
class Storage:
    """Runs that outlast a session, and who computes them (docs/cluster.md)."""

    store: Annotated[str | None, tyro.conf.arg(metavar="DIR", help_behavior_hint="(default: none)")] = None
    """Folder that chunks of the work go to as they are done. The same command goes on where it was ended."""
    processes: Annotated[int | None, count_hint("1")] = None
    """Processes of this machine that compute chunks of the store; each has a GPU of its own where there are several."""
    dask: Annotated[str | None, tyro.conf.arg(metavar="ADDRESS", help_behavior_hint="(default: none)")] = None
    """Address of a dask scheduler, whose workers compute the chunks, such as tcp://node:8786; all see DIR."""


@dataclass(frozen=True)
class Axes:
    """Further axes: the work is done at every combination of some numbers of the model, and PATH.nc holds all of it."""

    over: Annotated[tuple[str, ...], _none_given("none", "NAME=VALUES ...")] = ()
    """Numbers of the model and the values that each takes, such as modes.damping_ratio=0.01,0.02,0.04; a wrong name is
    answered with those that there are (docs/cluster.md). No picture is drawn."""


@dataclass(frozen=True)
class Rod:
    """The thesis' clamped rod."""

    elements: int = 5
    """Truss elements of the rod, which is also its number of modes."""
    damping_ratio: float = 0.03
    """Modal damping ratio ξ (0.03 in the thesis' text, 0.0177 in its Appendix B)."""
    keep: Annotated[tuple[int, ...], tyro.conf.arg(metavar="MODE ...")] = ()
    """Mode numbers to keep, counted from 1, such as '--keep 1 2'; all if not given."""
    young_modulus: float = 210e7
    """Young's modulus E, Pa."""
    density: float = 4600.0
    """Density ρ, kg/m³."""
    length: float = 0.5
    """Length L, m."""
    area: float = 10e-4
    """Cross-section S, m²."""


def file_of(name: str) -> Any:
    """How the flag of a file is shown."""
    return tyro.conf.arg(name=name, metavar="FILE", help_behavior_hint="(default: flags)")


@dataclass(frozen=True)
class Rub(Rod):
    """A blade rubbing an abradable casing in permanent contact: the thesis' clamped rod, or that of a file.

    Axes: rotational frequency (Hz) and contact stiffness K_e (N/m). The defaults are Appendix B's grid.

    Example: lobex lobes rub --speed 50:400:351 --gain 4.5e4:4.5e6:401 --elements 5 --out rub
    """

    speed: Range = "50:400:351"
    """Rotational frequencies, Hz."""
    gain: Range = "4.5e4:4.5e6:401"
    """Contact stiffnesses K_e, N/m."""
    blade_file: Annotated[str | None, file_of("blade")] = None
    """TOML file of a blade that bends, twists and turns, or of a whole stage, in place of the rod's flags
    (docs/howto/blades.md)."""
    measured: Measured = _MEASURED
    discretization: Discretization = Discretization()
    axes: Axes = Axes()
    output: Output = Output()
    storage: Storage = Storage()

    name: ClassVar[str] = "rub"


@dataclass(frozen=True)
class Tool:
    """The modes of the tool; several with commas, such as '--frequency 146.5,920 --damping-ratio .0032,.01 --mass
    2.573,5'."""

    frequency: Annotated[tuple[float, ...], Values] = (146.5,)
    """Natural frequencies of the tool, Hz."""
    damping_ratio: Annotated[tuple[float, ...], Values] = (0.0032,)
    """Damping ratios of the tool, one of each mode or one for all."""
    mass: Annotated[tuple[float, ...], Values] = (2.573,)
    """Modal masses of the tool, kg."""


def _along(name: str) -> Any:
    return tyro.conf.arg(name=name, help_behavior_hint="(default: as along the feed)")


@dataclass(frozen=True)
class Across:
    """The modes of the tool across the feed, where they are others than along it; with --directions 2."""

    frequency: Annotated[tuple[float, ...], Values, _along("frequency-y")] = ()
    """Natural frequencies across the feed, Hz."""
    damping_ratio: Annotated[tuple[float, ...], Values, _along("damping-ratio-y")] = ()
    """Damping ratios across the feed."""
    mass: Annotated[tuple[float, ...], Values, _along("mass-y")] = ()
    """Modal masses across the feed, kg."""


@dataclass(frozen=True)
class Edges:
    """The cutter's edges, where they are other than straight teeth at equal angles."""

    diameter: Annotated[str | None, tyro.conf.arg(metavar="LENGTH", help_behavior_hint="(default: none)")] = None
    """Diameter of the cutter, m, or with a unit, such as 19.05mm; a helix asks for it."""
    pitch: Annotated[tuple[float, ...], Values, _none_given("equal angles")] = ()
    """Angles from each tooth to the next, degrees, of one turn together, such as 70,110,70,110."""
    helix: Annotated[tuple[float, ...], Values, _none_given("straight teeth")] = ()
    """Helix angle, degrees: one of all teeth, or one of each."""
    serration: Annotated[str | None, tyro.conf.arg(metavar="LENGTH,LENGTH", help_behavior_hint="(default: none)")] = (
        None
    )
    """Amplitude and wave length of serrated edges, m, or with units, such as 0.3mm,2mm; they ask for --feed."""
    serration_phase: Annotated[tuple[float, ...], Values, _none_given("equal parts of a wave")] = ()
    """Phase of each tooth's wave, degrees, such as 0,180."""


_ToolFile = Annotated[str | None, file_of("tool")]


@dataclass(frozen=True)
class Milling:
    """Milling with a flexible tool. Axes: spindle speed (rpm) and axial depth of cut b (m).

    The defaults are §3.4's tool and grid.

    Example: lobex lobes milling --rpm 2000:25000:301 --gain 0:5mm:301 --teeth 1 --radial-immersion 0.5
    """

    rpm: Range = "2000:25000:301"
    """Spindle speeds, rpm."""
    gain: Range = "0:5mm:301"
    """Axial depths of cut b, m, or with a unit."""
    tool_file: _ToolFile = None
    """TOML file of a tool: cutter, modes and forces, in place of their flags (docs/howto/cutters.md)."""
    teeth: Annotated[int | None, count_hint("1, or those of --pitch")] = None
    """Number of teeth at equal angles."""
    radial_immersion: float = 0.5
    """Radial depth of cut divided by tool diameter, above 0 and up to 1."""
    direction: str = "down"
    """'down' or 'up' milling."""
    directions: int = 1
    """1: the tool bends along the feed; 2: across the feed, too."""
    tangential: float = 5.5e8
    """Tangential specific cutting force K_t, N/m²."""
    normal: float = 2e8
    """Normal specific cutting force K_n, N/m²."""
    edges: Edges = Edges()
    feed: Annotated[str | None, tyro.conf.arg(metavar="LENGTH", help_behavior_hint="(default: none)")] = None
    """Feed per tooth, m, or with a unit, such as 0.1mm; serrated edges ask for it."""
    tool: Tool = Tool()
    across: Across = Across()
    measured: MeasuredInPlane = _IN_PLANE
    discretization: Discretization = Discretization()
    axes: Axes = Axes()
    output: Output = Output()
    storage: Storage = Storage()

    name: ClassVar[str] = "milling"


@dataclass(frozen=True)
class Turning:
    """Turning with a flexible tool. Axes: spindle speed (rpm) and depth of cut b (m).

    The tool's defaults are §3.4's.

    Example: lobex lobes turning --rpm 2000:12000:301 --gain 0:0.5mm:301 --radial 2e8
    """

    rpm: Range = "2000:12000:301"
    """Spindle speeds, rpm."""
    gain: Range = "0:0.5mm:301"
    """Depths of cut b, m, or with a unit."""
    tool_file: _ToolFile = None
    """TOML file of a tool, whose modes and normal force these are, in place of their flags (docs/howto/cutters.md)."""
    radial: float = 2e8
    """Radial specific cutting force K_r, N/m²."""
    tool: Tool = Tool()
    measured: Measured = _MEASURED
    discretization: Discretization = Discretization()
    axes: Axes = Axes()
    output: Output = Output()
    storage: Storage = Storage()

    name: ClassVar[str] = "turning"


@dataclass(frozen=True)
class Mathieu:
    """The damped delayed Mathieu equation ẍ + c ẋ + (δ + ε cos 2πt/T) x = b x(t − T), T = 1/speed.

    Axes: speed (Hz; the field's T = 2π is speed 1/2π = 0.159) and delayed gain b.

    Example: lobex lobes mathieu --delta 3 --epsilon 2 --damping 0.1 --gain -1.5:1.5:201
    """

    speed: Range = "0.08:0.5:201"
    """Speeds 1/T, Hz."""
    gain: Range = "-1.5:1.5:201"
    """Delayed gains b, of either sign."""
    delta: float = 3.0
    """Stiffness δ."""
    epsilon: float = 2.0
    """Amplitude ε of the stiffness' variation."""
    damping: float = 0.1
    """Damping c."""
    discretization: Discretization = Discretization()
    axes: Axes = Axes()
    output: Output = Output()
    storage: Storage = Storage()

    name: ClassVar[str] = "mathieu"


LobeCommand = (
    Annotated[Rub, tyro.conf.subcommand("rub")]
    | Annotated[Milling, tyro.conf.subcommand("milling")]
    | Annotated[Turning, tyro.conf.subcommand("turning")]
    | Annotated[Mathieu, tyro.conf.subcommand("mathieu")]
)


@dataclass(frozen=True)
class Lobes:
    """Draw a stability lobe diagram: max|μ| over a grid of speeds and gains, to PATH.nc and PATH.png."""

    process: tyro.conf.OmitSubcommandPrefixes[tyro.conf.OmitArgPrefixes[LobeCommand]]
