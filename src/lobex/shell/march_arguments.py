"""The flags of ``lobex march``: the same processes at single points, and how long and how finely to march."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import tyro

from lobex.shell import arguments

MOST_LANES = 6

_Points = Annotated[str, tyro.conf.arg(metavar="VALUE[,VALUE...]")]
# The march has steps of its own; a monodromy operator is only what it is compared to.
_Fixed = Annotated[arguments.Discretization, tyro.conf.Fixed, tyro.conf.Suppress]
_DISCRETIZATION = arguments.Discretization()
# A march of a few lanes has nothing to store.
_Unstored = Annotated[arguments.Storage, tyro.conf.Fixed, tyro.conf.Suppress]
_STORAGE = arguments.Storage()


@dataclass(frozen=True)
class MarchRub(arguments.Rub):
    """A blade rubbing an abradable casing in permanent contact: the thesis' clamped rod, §4.4.

    It starts with (4.3), a motion that grows during one revolution.

    Example: lobex march rub --speed 112 --gain 4.5e5,1.35e6 --periods 10 --steps 12000 --out march
    """

    speed: _Points = "112"
    """Rotational frequencies, Hz."""
    gain: _Points = "4.5e5,1.35e6"
    """Contact stiffnesses K_e, N/m."""
    periods: int = 10
    """Revolutions to march."""
    steps: int = 12000
    """Time steps per revolution."""
    start: float = 1e-7
    """Displacement of the tip one revolution before t = 0, m."""
    discretization: _Fixed = _DISCRETIZATION
    storage: _Unstored = _STORAGE

    name: ClassVar[str] = "rub-march"


@dataclass(frozen=True)
class MarchMilling(arguments.Milling):
    """Milling with a flexible tool around its steady vibration; it starts from a deflection.

    Example: lobex march milling --rpm 8000 --gain 0.5,2mm --periods 40
    """

    rpm: _Points = "8000"
    """Spindle speeds, rpm."""
    gain: _Points = "0.5,2mm"
    """Axial depths of cut b, m, or with a unit."""
    periods: int = 40
    """Tooth passes to march."""
    steps: int = 1000
    """Time steps per tooth pass."""
    start: float = 1e-6
    """Deflection of the tool until t = 0, m."""
    discretization: _Fixed = _DISCRETIZATION
    storage: _Unstored = _STORAGE

    name: ClassVar[str] = "milling-march"


@dataclass(frozen=True)
class MarchTurning(arguments.Turning):
    """Turning with a flexible tool: around its steady deflection or, with --feed, from the first chip on.

    With --feed the tool may leave the cut and meets what all earlier passes left.

    Example: lobex march turning --rpm 5000 --gain 0.05,0.4mm --feed 0.1mm --periods 60
    """

    rpm: _Points = "5000"
    """Spindle speeds, rpm."""
    gain: _Points = "0.05,0.4mm"
    """Depths of cut b, m, or with a unit."""
    periods: int = 60
    """Revolutions to march."""
    steps: int = 1000
    """Time steps per revolution."""
    start: float = 1e-6
    """Deflection of the tool until t = 0, m; with --feed it is not deflected."""
    feed: Annotated[str | None, tyro.conf.arg(metavar="LENGTH", help_behavior_hint="(default: around the mean)")] = None
    """Feed per revolution h₀, m, or with a unit."""
    discretization: _Fixed = _DISCRETIZATION
    storage: _Unstored = _STORAGE

    name: ClassVar[str] = "turning-march"


@dataclass(frozen=True)
class MarchMathieu(arguments.Mathieu):
    """The damped delayed Mathieu equation ẍ + c ẋ + (δ + ε cos 2πt/T) x = b x(t − T), T = 1/speed.

    Example: lobex march mathieu --speed 0.159155 --gain -0.15,0.5 --periods 10
    """

    speed: _Points = "0.159155"
    """Speeds 1/T, Hz."""
    gain: _Points = "-0.15,0.5"
    """Delayed gains b, of either sign."""
    periods: int = 10
    """Periods to march."""
    steps: int = 1000
    """Time steps per period."""
    start: float = 1.0
    """Displacement until t = 0."""
    discretization: _Fixed = _DISCRETIZATION
    storage: _Unstored = _STORAGE

    name: ClassVar[str] = "mathieu-march"


MarchFlags = MarchRub | MarchMilling | MarchTurning | MarchMathieu
MarchCommand = (
    Annotated[MarchRub, tyro.conf.subcommand("rub")]
    | Annotated[MarchMilling, tyro.conf.subcommand("milling")]
    | Annotated[MarchTurning, tyro.conf.subcommand("turning")]
    | Annotated[MarchMathieu, tyro.conf.subcommand("mathieu")]
)


@dataclass(frozen=True)
class March:
    """March a process in time at a few points, and compare its growth with max|μ|, to PATH.nc and PATH.png."""

    process: tyro.conf.OmitSubcommandPrefixes[tyro.conf.OmitArgPrefixes[MarchCommand]]
