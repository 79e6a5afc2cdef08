"""``lobex lobes``: a stability lobe diagram as a file, a picture and a summary."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lobex import _checks
from lobex.shell import arguments

if TYPE_CHECKING:
    from lobex.results.chart import Chart


def run_lobes(command: arguments.Lobes) -> None:
    """Check everything, sweep, then write PATH.nc and PATH.png."""
    flags = command.process
    unit = "rpm" if hasattr(flags, "rpm") else "Hz"
    name = "rpm" if unit == "rpm" else "speed"
    speed = arguments.parse_range(name, getattr(flags, name), unit) / (60 if unit == "rpm" else 1)
    _checks.positive(name, speed, unit)
    gain = arguments.parse_range("gain", flags.gain, "SI units")
    path = Path(flags.output.out if flags.output.out is not None else flags.name)
    files = [_checks.writable("out", path.with_name(path.name + ending)) for ending in (".nc", ".png")]
    _check_discretization(flags.discretization)

    # JAX is slow to import: only now.
    from lobex.shell.environment import keep_compilations

    keep_compilations()
    import lobex

    chart = lobex.sweep(_process(flags), speed, gain, _method(flags.discretization), progress=not flags.output.quiet)
    chart.save(files[0])
    _draw(chart, files[1])
    if not flags.output.quiet:
        print(f"{chart!r}\n{_summary(chart)}\n  written          {files[0]}, {files[1]}")


def _process(flags: Any) -> Any:
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


def _check_discretization(flags: arguments.Discretization) -> None:
    _checks.choice("method", flags.method, ("chebyshev", "sdm"))
    strangers = {"chebyshev": ("steps", "order"), "sdm": ("nodes",)}[flags.method]
    for name in strangers:
        if getattr(flags, name) is not None:
            raise ValueError(f"{name} = {getattr(flags, name)} has no meaning with --method {flags.method}; drop it")


def _method(flags: arguments.Discretization) -> Any:
    import lobex

    given = {n: v for n in ("nodes", "steps", "order") if (v := getattr(flags, n)) is not None}
    if flags.method == "sdm":
        return lobex.SemiDiscretization(**given)
    return lobex.Chebyshev(aligned=flags.aligned, **given)


def _summary(chart: "Chart") -> str:
    critical = chart.critical_gain()
    quantity, scale = chart.quantity, (60 if chart.speed_unit == "rpm" else 1)
    missing = int(np.sum(np.isnan(critical)))
    if missing == len(critical):
        return "  no stability limit in the range of gains, at any speed"
    lowest = int(np.nanargmin(critical))
    line = (
        f"  smallest limit   {quantity.symbol} = {critical[lowest]:.6g} {quantity.unit} at "
        f"{chart.speed[lowest] * scale:.6g} {chart.speed_unit} (read from the grid)"
    )
    return line + (f"\n  no limit found   at {missing} of {len(critical)} speeds in this range" if missing else "")


def _draw(chart: "Chart", path: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(7.0, 4.4), layout="constrained")
    chart.plot(ax=axes)
    figure.savefig(path, dpi=150)
    plt.close(figure)
