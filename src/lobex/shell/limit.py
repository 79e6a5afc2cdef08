"""``lobex limit``: the stability limit over speeds as a file, a table, a picture and a summary."""

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lobex.shell import arguments
from lobex.shell.models import check_discretization, method_of, output_files, process_of, speeds_and_gains
from lobex.shell.shares import shared

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lobex.results.sensitivities import Sensitivities


def run_limit(command: arguments.Limit) -> None:
    """Check everything, search, then write PATH.nc, PATH.csv and PATH.png, and the same of sensitivities."""
    flags = command.process
    speed, gain = speeds_and_gains(flags)
    endings = (".nc", ".csv", ".png", *(("-sensitivity.csv", "-sensitivity.png") if flags.sensitivity else ()))
    files = output_files(flags, endings)
    check_discretization(flags)

    exact, shown = getattr(flags, "exact", False), not flags.output.quiet
    if flags.storage.store is not None and (exact or flags.sensitivity):
        other = "exact" if exact else "sensitivity"
        raise ValueError(f"store = {flags.storage.store!r} has no use with --{other}; drop one of the two")
    with shared(flags.storage) as share:
        # JAX is slow to import: only now.
        from lobex.shell.environment import prepare_jax

        prepare_jax()
        import lobex

        method = method_of(flags.discretization)
        bounds = None if exact else (gain[0], gain[-1])
        result = None
        if flags.sensitivity:
            # The process itself first: what is wrong with a flag is said of the flag.
            process_of(flags)
            numbers, build = _numbers_of(flags)
            result = lobex.sensitivities(build, speed, bounds, method, at=numbers, scan=len(gain), progress=shown)
            limit = result.limit
        elif bounds is None:
            limit = lobex.exact_limit(process_of(flags), speed)
        else:
            limit = lobex.critical_gain(
                process_of(flags), speed, bounds, method, scan=len(gain), **share.arguments, progress=shown
            )
    if not share.writes:
        return
    (limit if result is None else result).save(files[0])
    limit.save(files[1])
    _draw(limit.plot, files[2])
    if result is not None:
        _write_sensitivities(result, files[3])
        _draw(lambda: result.plot().get_figure(root=True), files[4])
    if shown:
        print(limit if result is None else f"{limit}\n{result}")
        print(f"  written          {', '.join(map(str, files))}")


def _numbers_of(flags: Any) -> tuple[dict[str, float], Any]:
    """The flags that are numbers of the model, by name, and the process as a function of them."""
    names = [f.name for f in dataclasses.fields(flags) if isinstance(getattr(flags, f.name), float)]
    tool = getattr(flags, "tool", None)
    parts = [] if tool is None else [f.name for f in dataclasses.fields(tool)]
    numbers = {name: getattr(flags, name) for name in names}
    numbers |= {f"tool.{name}": getattr(tool, name) for name in parts}

    def build(numbers: dict[str, Any]) -> Any:
        changes = {name: numbers[name] for name in names}
        if tool is not None:
            changes["tool"] = dataclasses.replace(tool, **{name: numbers[f"tool.{name}"] for name in parts})
        return process_of(dataclasses.replace(flags, **changes))

    return numbers, build


def _write_sensitivities(result: "Sensitivities", path: Path) -> None:
    """One row per speed, one column per number: d ln K / d ln p."""
    limit = result.limit
    columns = ("speed_Hz", f"gain_{limit.quantity.unit}", *(f"dlnK_dln_{name}" for name in result.names))
    table = np.column_stack([limit.speed, limit.gain, result.logarithmic])
    rows = [",".join(columns), *(",".join(f"{v:.12g}" for v in row) for row in table)]
    path.write_text("\n".join(rows) + "\n")


def _draw(plot: Any, path: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure: Figure = plot()
    figure.savefig(path, dpi=150)
    plt.close(figure)
