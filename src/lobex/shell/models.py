"""From flags to models: grids, files, processes and methods, checked before JAX is imported where that can be."""

from pathlib import Path
from typing import Any

import numpy as np

from lobex import _checks
from lobex.shell import arguments


def speeds_and_gains(flags: Any) -> tuple[np.ndarray, np.ndarray]:
    """The grids of a command, speeds in Hz."""
    name, unit, scale = ("rpm", "rpm", 60.0) if hasattr(flags, "rpm") else ("speed", "Hz", 1.0)
    speed = arguments.parse_range(name, getattr(flags, name), unit) / scale
    _checks.positive(name, speed * scale, unit)
    return speed, arguments.parse_range("gain", flags.gain, "SI units")


def output_files(flags: Any, endings: tuple[str, ...]) -> list[Path]:
    """The files that a command writes, all of them writable."""
    path = Path(flags.output.out if flags.output.out is not None else flags.name)
    if not path.name:
        raise ValueError(f"out = {flags.output.out!r} is not a file name; give a path without ending, such as rub")
    return [_checks.writable("out", path.with_name(path.name + ending)) for ending in endings]


def process_of(flags: Any) -> Any:
    """The process that the flags describe."""
    import lobex

    if isinstance(flags, arguments.Rub):
        rod = lobex.Rod(flags.elements, flags.young_modulus, flags.density, flags.length, flags.area)
        return lobex.Rub(rod.modes(flags.damping_ratio, keep=flags.keep or None))
    if isinstance(flags, arguments.Mathieu):
        return lobex.DelayedMathieu(delta=flags.delta, epsilon=flags.epsilon, damping=flags.damping)
    tool = flags.tool
    modes = lobex.Modes.single(frequency=tool.frequency, damping_ratio=tool.damping_ratio, mass=tool.mass)
    if isinstance(flags, arguments.Turning):
        return lobex.Turning(modes, radial=flags.radial)
    _checks.choice("directions", flags.directions, (1, 2))
    return lobex.Milling(
        lobex.Modes.plane(x=modes, y=modes) if flags.directions == 2 else modes,
        teeth=flags.teeth,
        tangential=flags.tangential,
        normal=flags.normal,
        radial_immersion=flags.radial_immersion,
        direction=flags.direction,
    )


def check_discretization(flags: arguments.Discretization) -> None:
    """Refuse an unknown method, and flags that the method does not have."""
    _checks.choice("method", flags.method, ("chebyshev", "sdm"))
    strangers = {"chebyshev": ("steps", "order"), "sdm": ("nodes",)}[flags.method]
    for name in strangers:
        if getattr(flags, name) is not None:
            raise ValueError(f"{name} = {getattr(flags, name)} has no meaning with --method {flags.method}; drop it")


def method_of(flags: arguments.Discretization) -> Any:
    """The method that the flags describe."""
    import lobex

    given = {n: v for n in ("nodes", "steps", "order") if (v := getattr(flags, n)) is not None}
    if flags.method == "sdm":
        return lobex.SemiDiscretization(**given)
    return lobex.Chebyshev(aligned=flags.aligned, **given)
