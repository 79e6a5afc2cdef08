"""``lobex limit``: the stability limit over speeds as a file, a table, a picture and a summary."""

import dataclasses
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lobex import _checks
from lobex.shell.from_flags import (
    check_discretization,
    method_of,
    output_files,
    process_of,
    speed_text,
    speeds_and_gains,
)
from lobex.shell.limit_arguments import Limit as LimitCommand
from lobex.shell.pictures import drawn
from lobex.shell.storage import stored, written
from lobex.shell.values import is_range, parse_axes

if TYPE_CHECKING:
    from lobex.results.sensitivities import Sensitivities


def run_limit(command: LimitCommand) -> None:
    """Check everything, search, then write PATH.nc, PATH.csv and PATH.png, and the same of sensitivities."""
    flags = command.process
    speed, gain = speeds_and_gains(flags)
    _check_bounds(flags, gain)
    over = parse_axes(flags.axes.over)
    endings = (".nc", ".csv", ".png", *(("-sensitivity.csv", "-sensitivity.png") if flags.sensitivity else ()))
    files = output_files(flags, endings[:1] if over else endings)
    check_discretization(flags)

    exact, shown = getattr(flags, "exact", False), not flags.output.quiet
    studied = {"store": flags.storage.store, "over": " ".join(flags.axes.over) or None}
    for name, value in studied.items():
        if value is not None and (exact or flags.sensitivity):
            other = "exact" if exact else "sensitivity"
            raise ValueError(f"{name} = {value!r} has no use with --{other}; drop one of the two")
    # Points of a list are asked for themselves, and what is studied or differentiated keeps to what is asked for.
    followed = is_range(speed_text(flags)) and not any(studied.values())
    wanted = len(speed) if flags.curve.refine is None else _checks.integer("refine", flags.curve.refine, 0)
    budget = wanted if followed else 0
    with stored(flags.storage) as storage:
        # JAX is slow to import: only now.
        from lobex.shell.environment import prepare_jax

        prepare_jax()
        import lobex
        from lobex.limits.adaptive import limit_curve

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
            limit = limit_curve(partial(lobex.exact_limit, process_of(flags)), speed, budget)
        else:
            settings = {"method": method, "scan": len(gain), "progress": shown, **over, **storage}
            search: Any = partial(lobex.critical_gain, process_of(flags), bounds=bounds, **settings)
            limit = limit_curve(search, speed, budget) if budget else search(speed)
    if over:
        return written(limit, files[0], shown)
    pictures = [drawn(part.plot) for part in (limit, result) if part is not None]
    (limit if result is None else result).save(files[0])
    limit.save(files[1])
    files[2].write_bytes(pictures[0])
    if result is not None:
        _write_sensitivities(result, files[3])
        files[4].write_bytes(pictures[1])
    if shown:
        print(limit if result is None else f"{limit}\n{result}")
        print(f"  written          {', '.join(map(str, files))}")


def _check_bounds(flags: Any, gain: np.ndarray) -> None:
    if len(gain) < 3:
        raise ValueError(
            f"gain = {flags.gain!r} holds {len(gain)} values; a limit is searched for between two gains, and the scan "
            "takes three or more: give such as 0:5e-3:65"
        )


def _numbers_of(flags: Any) -> tuple[dict[str, float], Any]:
    """The flags that are numbers of the model, by name, and the process as a function of them."""
    names = [f.name for f in dataclasses.fields(flags) if isinstance(getattr(flags, f.name), float)]
    numbers: dict[str, Any] = {name: getattr(flags, name) for name in names}
    groups = {name: part for name in ("tool", "across") if (part := getattr(flags, name, None)) is not None}
    for group, part in groups.items():
        given = {name: values for name, values in vars(part).items() if values}
        numbers |= {f"{group}.{name}": v[0] if len(v) == 1 else v for name, v in given.items()}

    def build(numbers: dict[str, Any]) -> Any:
        changes = {name: numbers[name] for name in names}
        for group, part in groups.items():
            own = {n.partition(".")[2]: v for n, v in numbers.items() if n.startswith(f"{group}.")}
            changes[group] = dataclasses.replace(part, **own)
        return process_of(dataclasses.replace(flags, **changes))

    return numbers, build


def _write_sensitivities(result: "Sensitivities", path: Path) -> None:
    """One row per speed, one column per number: d ln K / d ln p."""
    limit = result.limit
    columns = ("speed_Hz", f"gain_{limit.quantity.unit}", *(f"dlnK_dln_{name}" for name in result.names))
    table = np.column_stack([limit.speed, limit.gain, result.logarithmic])
    rows = [",".join(columns), *(",".join(f"{v:.12g}" for v in row) for row in table)]
    path.write_text("\n".join(rows) + "\n")
