"""``lobex lobes``: a stability lobe diagram as a file, a picture and a summary."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lobex.processes.quantity import hertz
from lobex.shell import arguments
from lobex.shell.models import check_discretization, method_of, output_files, process_of, speeds_and_gains
from lobex.shell.shares import shared

if TYPE_CHECKING:
    from lobex.results.chart import Chart


def run_lobes(command: arguments.Lobes) -> None:
    """Check everything, sweep, then write PATH.nc and PATH.png."""
    flags = command.process
    speed, gain = speeds_and_gains(flags)
    files = output_files(flags, (".nc", ".png"))
    check_discretization(flags)

    with shared(flags.storage) as share:
        # JAX is slow to import: only now.
        from lobex.shell.environment import prepare_jax

        prepare_jax()
        import lobex

        method, shown = method_of(flags.discretization), not flags.output.quiet
        chart = lobex.sweep(process_of(flags), speed, gain, method, **share.arguments, progress=shown)
    if not share.writes:
        return
    chart.save(files[0])
    _draw(chart, files[1])
    if shown:
        print(f"{chart!r}\n{_summary(chart)}\n  written          {files[0]}, {files[1]}")


def _summary(chart: "Chart") -> str:
    critical = chart.critical_gain()
    quantity = chart.quantity
    scale, unit = (60, " rpm") if chart.speed_unit == "rpm" else (1, hertz(chart.speed_unit))
    missing = int(np.sum(np.isnan(critical)))
    if missing == len(critical):
        return "  no stability limit could be read from the grid of gains, at any speed"
    lowest = int(np.nanargmin(critical))
    line = (
        f"  smallest limit   {quantity.symbol} = {critical[lowest]:.6g} {quantity.unit} at "
        f"{chart.speed[lowest] * scale:.6g}{unit} (read from the grid)"
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
