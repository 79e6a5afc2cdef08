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


def rod_modes_of(flags: arguments.Rod) -> Any:
    """The modes of the rod that the flags describe."""
    import lobex

    rod = lobex.Rod(flags.elements, flags.young_modulus, flags.density, flags.length, flags.area)
    return rod.modes(flags.damping_ratio, keep=flags.keep or None)


def process_of(flags: Any) -> Any:
    """The process that the flags describe."""
    import lobex

    if isinstance(flags, arguments.Rub):
        return lobex.Rub(rod_modes_of(flags))
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


# The flags of each method.
_FLAGS = {"roots": (), "duhamel": ("nodes",), "chebyshev": ("nodes",), "sdm": ("steps", "order")}


def check_discretization(process: Any) -> None:
    """Refuse an unknown method, one that does not serve the process, and flags that the method does not have."""
    flags = process.discretization
    constant = isinstance(process, arguments.Rub | arguments.Turning)
    allowed = tuple(name for name in _FLAGS if constant or name != "roots")
    if flags.method is not None:
        _checks.choice("method", flags.method, allowed)
    name = _method_name(flags)
    for flag in ("nodes", "steps", "order"):
        if getattr(flags, flag) is not None and flag not in _FLAGS.get(name or "", ()):
            owners = " or ".join(method for method, own in _FLAGS.items() if flag in own)
            raise ValueError(f"{flag} = {getattr(flags, flag)} has no meaning here; drop it or give --method {owners}")


def method_of(flags: arguments.Discretization) -> Any:
    """The method that the flags describe; None where the verb chooses."""
    import lobex

    name = _method_name(flags)
    if name is None:
        return None
    given = {n: v for n in ("nodes", "steps", "order") if (v := getattr(flags, n)) is not None}
    if name == "chebyshev":
        return lobex.Chebyshev(aligned=flags.aligned, **given)
    return {"roots": lobex.CharacteristicRoots, "duhamel": lobex.Duhamel, "sdm": lobex.SemiDiscretization}[name](
        **given
    )


def _method_name(flags: arguments.Discretization) -> str | None:
    """The method named, or the one whose flag is given."""
    if flags.method is not None:
        return flags.method
    return "chebyshev" if flags.nodes is not None or not flags.aligned else None
