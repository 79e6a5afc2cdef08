"""``lobex limit``: the stability limit over speeds as a file, a table, a picture and a summary."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lobex.shell import arguments
from lobex.shell.models import check_discretization, method_of, output_files, process_of, speeds_and_gains

if TYPE_CHECKING:
    from lobex.results.limit import Limit


def run_limit(command: arguments.Limit) -> None:
    """Check everything, search, then write PATH.nc, PATH.csv and PATH.png."""
    flags = command.process
    speed, gain = speeds_and_gains(flags)
    files = output_files(flags, (".nc", ".csv", ".png"))
    check_discretization(flags.discretization)

    # JAX is slow to import: only now.
    from lobex.shell.environment import prepare_jax

    prepare_jax()
    import lobex

    method, process = method_of(flags.discretization), process_of(flags)
    if getattr(flags, "exact", False):
        limit = lobex.exact_limit(process, speed)
    else:
        bounds, shown = (gain[0], gain[-1]), not flags.output.quiet
        limit = lobex.critical_gain(process, speed, bounds, method, scan=len(gain), progress=shown)
    limit.save(files[0])
    _write_table(limit, files[1])
    _draw(limit, files[2])
    if not flags.output.quiet:
        print(f"{limit!r}\n  written          {', '.join(map(str, files))}")


def _write_table(limit: "Limit", path: Path) -> None:
    columns = ("speed_Hz", f"gain_{limit.quantity.unit}", "chatter_frequency_Hz", "lobe", "error", "kind", "status")
    values = (limit.speed, limit.gain, limit.chatter_frequency, limit.lobe, limit.error, limit.kind, limit.status)
    rows = [",".join(columns)]
    for row in zip(*values, strict=True):
        rows.append(",".join(f"{v:.12g}" if isinstance(v, np.floating) else str(v) for v in row))
    path.write_text("\n".join(rows) + "\n")


def _draw(limit: "Limit", path: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure = limit.plot()
    figure.savefig(path, dpi=150)
    plt.close(figure)
