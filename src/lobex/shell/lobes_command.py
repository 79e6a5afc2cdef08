"""``lobex lobes``: a stability lobe diagram as a file, a picture and a summary."""

from typing import TYPE_CHECKING, Any

import numpy as np

from lobex.results.units import shown_gain, shown_speed
from lobex.shell import arguments
from lobex.shell.from_flags import check_discretization, method_of, output_files, process_of, speeds_and_gains
from lobex.shell.pictures import drawn
from lobex.shell.storage import stored, written
from lobex.shell.values import parse_axes

if TYPE_CHECKING:
    from lobex.results.chart import Chart


def run_lobes(command: arguments.Lobes) -> None:
    """Check everything, sweep, then write PATH.nc and, of one diagram, PATH.png."""
    flags = command.process
    speed, gain = speeds_and_gains(flags)
    over = parse_axes(flags.axes.over)
    files = output_files(flags, (".nc",) if over else (".nc", ".png"))
    check_discretization(flags)

    with stored(flags.storage) as storage:
        # JAX is slow to import: only now.
        from lobex.shell.environment import prepare_jax

        prepare_jax()
        import lobex

        method, shown = method_of(flags.discretization), not flags.output.quiet
        chart: Any = lobex.sweep(process_of(flags), speed, gain, method, **over, **storage, progress=shown)
    if over:
        return written(chart, files[0], shown)
    picture = drawn(chart.plot)
    chart.save(files[0])
    files[1].write_bytes(picture)
    if shown:
        print(f"{chart!r}\n{_summary(chart)}\n  written          {files[0]}, {files[1]}")


def _summary(chart: "Chart") -> str:
    if len(chart.gain) == 1:
        stable = int(np.sum(chart.spectral_radius < 1))
        return f"  stable           at {stable} of {len(chart.speed)} speeds"
    if chart.quantity.signed:
        # It begins nowhere, so that it has no smallest limit.
        return f"  stable           at {np.sum(chart.spectral_radius < 1)} of {chart.spectral_radius.size} points"
    critical = chart.critical_gain()
    first = np.argmax(~(chart.spectral_radius < 1), axis=1)
    # Unstable in or below the first cell, where no limit can be read.
    early = (first < 2) & (chart.spectral_radius[np.arange(len(first)), first] >= 1)
    missing = int(np.sum(np.isnan(critical) & ~early))
    if missing == len(critical):
        return "  smallest limit   none in this range of gains, at any speed"
    if early.any():
        end, at = chart.gain[first[early].min()], chart.speed[early][np.argmin(first[early])]
        line = (
            f"  smallest limit   {chart.quantity.symbol} is at most {shown_gain(end, chart.quantity)}, such as at "
            f"{shown_speed(at, chart.speed_unit)}: at {np.sum(early)} of {len(critical)} speeds it is below the second "
            "gain of the grid, where it cannot be read"
        )
    else:
        lowest = int(np.nanargmin(critical))
        line = (
            f"  smallest limit   {chart.quantity.symbol} = {shown_gain(critical[lowest], chart.quantity)} at "
            f"{shown_speed(chart.speed[lowest], chart.speed_unit)} (read from the grid)"
        )
    return line + (f"\n  no limit found   at {missing} of {len(critical)} speeds in this range" if missing else "")
