"""From flags to models: grids, files, processes and methods, checked before JAX is imported where that can be."""

from collections.abc import Callable, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from lobex import _checks
from lobex.shell import arguments
from lobex.shell.from_measured import modes_measured
from lobex.shell.values import in_metres, parse_grid

Parse = Callable[[str, str, str], np.ndarray]


def speeds_and_gains(flags: Any, parse: Parse = parse_grid) -> tuple[np.ndarray, np.ndarray]:
    """The speeds of a command, in Hz, and its gains."""
    name, scale = ("rpm", 60.0) if hasattr(flags, "rpm") else ("speed", 1.0)
    unit = "rpm" if name == "rpm" else "Hz"
    speed = parse(name, speed_text(flags), unit)
    _checks.positive(name, speed, unit)
    return speed / scale, parse("gain", gain_text(flags), "SI units")


def speed_text(flags: Any) -> str:
    """What was said for the speeds."""
    return flags.rpm if hasattr(flags, "rpm") else flags.speed


def gain_text(flags: Any) -> str:
    """What was said for the gains, in SI units: depths of cut may have others."""
    return in_metres("gain", flags.gain) if hasattr(flags, "rpm") else flags.gain


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

    if isinstance(flags, arguments.Mathieu):
        return lobex.DelayedMathieu(delta=flags.delta, epsilon=flags.epsilon, damping=flags.damping)
    measured = modes_measured(flags)
    if measured is not None:
        _only_measured(flags)
    if isinstance(flags, arguments.Rub):
        if flags.blade_file is not None:
            return _of_blade_file(flags)
        return lobex.Rub(rod_modes_of(flags) if measured is None else measured)
    if flags.tool_file is not None:
        return _of_file(flags, {} if measured is None else {"modes": measured})
    modes = _tool_modes(flags.tool) if measured is None else measured
    if isinstance(flags, arguments.Turning):
        return lobex.Turning(modes, radial=flags.radial)
    _checks.choice("directions", flags.directions, (1, 2))
    across = {name: values for name, values in vars(flags.across).items() if np.size(values)}
    if across and flags.directions == 1:
        named = ", ".join(f"{name}_y" for name in across)
        raise ValueError(f"directions = 1 has no modes across the feed; give --directions 2 or drop {named}")
    if flags.directions == 2 and measured is None:
        modes = lobex.Modes.plane(x=modes, y=_tool_modes(flags.tool, across))
    return lobex.Milling(
        modes,
        _cutter(flags),
        tangential=flags.tangential,
        normal=flags.normal,
        radial_immersion=flags.radial_immersion,
        direction=flags.direction,
        feed_per_tooth=_feed(flags),
    )


def _feed(flags: arguments.Milling) -> float | None:
    """Feed per tooth, m; None where none is given."""
    from lobex._lengths import metres

    return None if flags.feed is None else metres("feed", flags.feed)


def _of_blade_file(flags: Any) -> Any:
    """The process of a file of a blade, whose flags are left as they come."""
    import lobex

    usual = arguments.Rod()
    if given := [field.name for field in fields(usual) if getattr(flags, field.name) != getattr(usual, field.name)]:
        raise ValueError(f"blade = {flags.blade_file!r} says what flags of {given[0]} say; drop one of the two")
    if getattr(flags, "sensitivity", False):
        raise ValueError(f"blade = {flags.blade_file!r} has no use with --sensitivity; ask lobex.sensitivities")
    return lobex.Rub(**lobex.read_blade(flags.blade_file))


def _only_measured(flags: Any) -> None:
    """Refuse flags that tell of modes beside a measurement."""
    told: dict[str, tuple[str, ...]] = {
        "rub": ("elements", "damping_ratio", "keep", "young_modulus", "density", "length", "area", "blade_file"),
        "turning": ("tool",),
        "milling": ("tool", "across", "directions"),
    }
    kinds = {"rub": arguments.Rub, "turning": arguments.Turning, "milling": arguments.Milling}
    name, kind = next((name, kind) for name, kind in kinds.items() if isinstance(flags, kind))
    usual: Any = kind()
    if given := [field for field in told[name] if getattr(flags, field) != getattr(usual, field)]:
        raise ValueError(f"frf = {flags.measured.file!r} says what flags of {given[0]} say; drop one of the two")


def _of_file(flags: Any, others: dict[str, Any]) -> Any:
    """The process of a file of a tool, whose flags are left as they come, with ``others`` in place of what it says."""
    import lobex

    turning = isinstance(flags, arguments.Turning)
    usual: Any = arguments.Turning() if turning else arguments.Milling()
    milling = "teeth", "directions", "tangential", "normal", "edges", "tool", "across"
    given = [
        name for name in (("radial", "tool") if turning else milling) if getattr(flags, name) != getattr(usual, name)
    ]
    if given:
        raise ValueError(f"tool = {flags.tool_file!r} says what flags of {given[0]} say; drop one of the two")
    if getattr(flags, "sensitivity", False):
        raise ValueError(f"tool = {flags.tool_file!r} has no use with --sensitivity; ask lobex.sensitivities")
    said = lobex.read_tool(flags.tool_file) | others
    if turning:
        cutter = said.pop("cutter", None)
        return lobex.Turning(**said, diameter=None if cutter is None else cutter.diameter)
    if "cutter" not in said:
        raise ValueError(f"tool = {flags.tool_file!r} has no [cutter]; milling takes one")
    cut = {"radial_immersion": flags.radial_immersion, "direction": flags.direction, "feed_per_tooth": _feed(flags)}
    return lobex.Milling(**said, **cut)


def _cutter(flags: arguments.Milling) -> Any:
    """The cutter that the flags describe."""
    import lobex
    from lobex._lengths import metres

    edges, teeth = flags.edges, flags.teeth
    if edges == arguments.Edges():
        return 1 if teeth is None else teeth
    if edges.pitch and teeth not in (None, len(edges.pitch)):
        raise ValueError(f"teeth = {teeth} with {len(edges.pitch)} pitch angles; drop one of the two")
    helix: Any = edges.helix[0] if len(edges.helix) == 1 else edges.helix or None
    return lobex.Cutter.end_mill(
        None if edges.diameter is None else metres("diameter", edges.diameter),
        teeth=None if edges.pitch else teeth or 1,
        pitch_degrees=edges.pitch or None,
        helix_degrees=helix,
        serration=_serration(edges),
    )


def _serration(edges: arguments.Edges) -> Any:
    """The wave along the edges; None of smooth ones."""
    import lobex
    from lobex._lengths import metres

    if edges.serration is None:
        if edges.serration_phase:
            raise ValueError(f"serration_phase = {edges.serration_phase} without a serration; give --serration, too")
        return None
    parts = edges.serration.split(",")
    if len(parts) != 2:
        raise ValueError(f"serration = {edges.serration!r}; give amplitude and wave length, such as 0.3mm,2mm")
    amplitude, wave_length = (metres("serration", part) for part in parts)
    return lobex.Serration(amplitude, wave_length, np.array(edges.serration_phase) if edges.serration_phase else None)


def _tool_modes(tool: arguments.Tool, across: Mapping[str, Any] | None = None) -> Any:
    """The modes of the tool, or those across the feed: as ``tool`` says, but for what ``across`` says."""
    import jax
    import jax.numpy as jnp

    import lobex

    values = {**vars(tool), **(across or {})}
    columns = {name: [value] if np.ndim(value) == 0 else list(value) for name, value in values.items()}
    count = len(columns["frequency"])
    for name, column in columns.items():
        if len(column) not in (1, count):
            flag = f"{name}_y" if across else name
            raise ValueError(
                f"{flag} has {len(column)} values for {count} natural frequencies; give as many, or one for all modes"
            )
        columns[name] = column * count if len(column) == 1 else column
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    modes = [lobex.Modes.single(**row) for row in rows]
    lib = jnp if any(map(_checks.is_traced, jax.tree.leaves(modes))) else np
    return modes[0] if count == 1 else jax.tree.map(lambda *parts: lib.concatenate(parts), *modes)


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
    """The method that the flags describe."""
    import lobex

    name = _method_name(flags)
    if name is None:
        return lobex.Auto()
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
