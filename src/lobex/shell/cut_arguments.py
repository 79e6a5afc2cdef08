"""The flags of ``lobex orbit`` and ``lobex recommend``: a milling cut that is fed."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

import tyro

from lobex.shell import arguments

_Length = tyro.conf.arg(metavar="LENGTH")
_Points = Annotated[str, tyro.conf.arg(metavar="VALUE[,VALUE...]")]
_Ends = Annotated[str, tyro.conf.arg(metavar="LOW:HIGH")]
# The motion has one method, and a few points have nothing to store.
_Fixed = Annotated[arguments.Discretization, tyro.conf.Fixed, tyro.conf.Suppress]
_DISCRETIZATION = arguments.Discretization()
_Unstored = Annotated[arguments.Storage, tyro.conf.Fixed, tyro.conf.Suppress]
_STORAGE = arguments.Storage()


def _no_limit(metavar: str = "FLOAT") -> Any:
    return tyro.conf.arg(metavar=metavar, help_behavior_hint="(default: no limit)")


@dataclass(frozen=True)
class OrbitMilling(arguments.Milling):
    """The periodic motion that a stable cut comes to, with its forces, torque, power and the wall that it leaves.

    Example: lobex orbit milling --tool docs/howto/tool.toml --rpm 5400 --gain 2mm --feed 0.1mm
    """

    rpm: _Points = "20000"
    """Spindle speeds, rpm."""
    gain: _Points = "0.2mm"
    """Axial depths of cut b, m, or with a unit."""
    feed: Annotated[str, _Length] = "0.1mm"
    """Feed per tooth, m, or with a unit."""
    discretization: _Fixed = _DISCRETIZATION
    storage: _Unstored = _STORAGE

    name: ClassVar[str] = "milling-orbit"


@dataclass(frozen=True)
class RecommendMilling(arguments.Milling):
    """The cuts of highest removal rate that keep all limits, with the margins that are left.

    Example: lobex recommend milling --tool docs/howto/tool.toml --rpm 3000:9000 --gain 0.1:6mm --power 2000
    """

    rpm: _Ends = "3000:12000"
    """Lowest and highest spindle speed, rpm."""
    gain: _Ends = "0.1:5mm"
    """Smallest and largest axial depth of cut b, m, or with a unit."""
    feed: Annotated[str, _Length] = "0.1mm"
    """Feed per tooth, m, or with a unit."""
    power: Annotated[float | None, _no_limit()] = None
    """Mean power of the spindle, W."""
    torque: Annotated[float | None, _no_limit()] = None
    """Largest torque of the spindle, N m."""
    location_error: Annotated[str | None, _no_limit("LENGTH")] = None
    """So far at most the wall lies from where it should, m, or with a unit such as 10um; with modes along x and y."""
    margin: float = 0.1
    """The share of every limit, that of stability included, that is left."""
    count: int = 3
    """Cuts, at most."""
    discretization: _Fixed = _DISCRETIZATION
    storage: _Unstored = _STORAGE

    name: ClassVar[str] = "milling-recommendation"


_Milling = Annotated[Literal["milling"], tyro.conf.Positional]


@dataclass(frozen=True)
class Orbit:
    """Find the periodic motion of a stable cut at a few points, to PATH.nc and PATH.png."""

    kind: _Milling
    """The process."""
    process: tyro.conf.OmitArgPrefixes[OrbitMilling] = OrbitMilling()


@dataclass(frozen=True)
class Recommend:
    """Recommend the cuts of highest removal rate that keep all limits, to PATH.nc and PATH.png."""

    kind: _Milling
    """The process."""
    process: tyro.conf.OmitArgPrefixes[RecommendMilling] = RecommendMilling()
