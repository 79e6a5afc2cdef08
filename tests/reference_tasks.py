"""What is wanted of lobex by a file of reference numbers, case by case."""

from math import ceil
from typing import Any, NamedTuple

Case = dict[str, Any]
Numbers = Any


class Multiplier(NamedTuple):
    """A multiplier wanted, over a period of the process."""

    group: str
    name: str
    process: Any
    speed: float
    gain: float
    case: Case
    # Of how many periods of the process the file tells it.
    periods: int = 1


class Limits(NamedTuple):
    """Changes of stability wanted: gain, what the process becomes, kind and chatter frequency (None where not told).

    ``scan`` is None where the limit has a closed form; ``lowest`` where the file tells that one alone.
    """

    group: str
    name: str
    process: Any
    speed: float
    bounds: tuple[float, float]
    scan: int | None
    changes: list[tuple[float, str, str | None]]
    frequency: float | None
    rel_diff: float
    lowest: bool = False


class Motion(NamedTuple):
    """A periodic motion wanted: its extremes by axis, and y where teeth pass the finished wall, at heights that are
    shares of the depth: of every tooth at one height, or of one tooth at several.
    """

    group: str
    name: str
    process: Any
    speed: float
    gain: float
    heights: Numbers
    case: Case
    # Of how many periods of the process the file tells the radius.
    periods: int = 1


class Inexpressible(NamedTuple):
    """A case that no verb takes yet, and why."""

    group: str
    name: str
    reason: str


Task = Multiplier | Limits | Motion | Inexpressible


def name(case: Case) -> str:
    """What tells a case from others: its numbers, less those that are wanted."""
    wanted = ("mu", "second", "spectral_radius", "crossings", "points", "scan", "scan_m", "changes", "kind")
    ends = ("rel_diff", "points", "discs", "_min_m", "_max_m", "surface_m")
    told = {k: v for k, v in case.items() if k not in wanted and not k.endswith(ends) and not k.startswith("peak")}
    return " ".join(f"{k}={v:.6g}" if isinstance(v, float) else f"{k}={v}" for k, v in told.items())


def crossings(group: str, process: Any, speed: float, case: Case, gain: str) -> Limits:
    """The limits of a case that lists every crossing of a scan."""
    low, high, count = case.get("scan") or case["scan_m"]
    changes = [(c[gain], c["becomes"], c["kind"]) for c in case["crossings"]]
    rel_diff = max([c["rel_diff"] for c in case["crossings"]], default=0.0)
    return Limits(group, name(case), process, speed, (low, high), int(count), changes, None, rel_diff)


def lowest(
    group: str,
    process: Any,
    speed: float,
    case: Case,
    gain: float | None,
    bounds: tuple[float, float],
    scan: int | None,
) -> Limits:
    """The limit of a case that tells the lowest alone."""
    changes = [] if gain is None else [(gain, "unstable", case.get("kind"))]
    found = case.get("chatter_Hz")
    return Limits(group, name(case), process, speed, bounds, scan, changes, found, case.get("rel_diff", 0.0), True)


def whole_parts(shortest: float, longest: float) -> tuple[float, float]:
    """A range of delays that holds the one given, of few values: what is compiled depends on it."""
    parts = ceil(1 / shortest - 1e-9)
    return 1 / parts, ceil(longest * parts - 1e-9) / parts
