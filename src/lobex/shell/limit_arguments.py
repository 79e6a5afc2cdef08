"""The flags of ``lobex limit``: the same processes, how the limit is searched for, and where speeds are added."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import tyro

from lobex.shell.arguments import Milling, Rub, Turning, count_hint
from lobex.shell.values import Range


@dataclass(frozen=True)
class Curve:
    """How finely the curve is drawn."""

    refine: Annotated[int | None, count_hint("as many as given")] = None
    """Most speeds to add where the limit of a range of speeds bends, ends or jumps, until no corner of the line stands
    out; 0 for none. Not with --sensitivity, --store and --over, which keep to the speeds given."""


@dataclass(frozen=True)
class LimitRub(Rub):
    """A blade rubbing an abradable casing in permanent contact: the thesis' clamped rod.

    Example: lobex limit rub --speed 50:400:351 --gain 4.5e4:4.5e6:65 --out rub-limit
    """

    gain: Range = "4.5e4:4.5e6:65"
    """Lowest and highest contact stiffness K_e, N/m, and how many gains the scan between them takes."""

    exact: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """In closed form (D-subdivision), at every gain; --gain and the discretization are not used then."""

    sensitivity: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Also d ln limit / d ln p for every number p given here: to PATH-sensitivity.csv and .png, and into PATH.nc."""

    curve: Curve = Curve()

    name: ClassVar[str] = "rub-limit"


@dataclass(frozen=True)
class LimitMilling(Milling):
    """Milling with a flexible tool; the defaults are §3.4's.

    Example: lobex limit milling --rpm 2000:25000:301 --gain 0:5mm:65 --nodes 24
    """

    gain: Range = "0:5mm:65"
    """Smallest and largest depth of cut b, m, or with a unit, and how many depths the scan between them takes."""

    sensitivity: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Also d ln limit / d ln p for every number p given here: to PATH-sensitivity.csv and .png, and into PATH.nc."""

    curve: Curve = Curve()

    name: ClassVar[str] = "milling-limit"


@dataclass(frozen=True)
class LimitTurning(Turning):
    """Turning with a flexible tool.

    Example: lobex limit turning --rpm 2000:12000:301 --gain 0:0.5mm:65
    """

    gain: Range = "0:0.5mm:65"
    """Smallest and largest depth of cut b, m, or with a unit, and how many depths the scan between them takes."""

    exact: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """In closed form (D-subdivision), at every gain; --gain and the discretization are not used then."""

    sensitivity: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Also d ln limit / d ln p for every number p given here: to PATH-sensitivity.csv and .png, and into PATH.nc."""

    curve: Curve = Curve()

    name: ClassVar[str] = "turning-limit"


LimitCommand = (
    Annotated[LimitRub, tyro.conf.subcommand("rub")]
    | Annotated[LimitMilling, tyro.conf.subcommand("milling")]
    | Annotated[LimitTurning, tyro.conf.subcommand("turning")]
)


@dataclass(frozen=True)
class Limit:
    """Find the stability limit: the lowest unstable gain per speed, to PATH.nc, PATH.csv and PATH.png."""

    process: tyro.conf.OmitSubcommandPrefixes[tyro.conf.OmitArgPrefixes[LimitCommand]]
