"""Compare lobex with a file of reference numbers, such as one of several delays, varying delays or several contacts.

    python tests/references.py FILE [--groups c,d] [--verbose]

Every case is computed with the public verbs and the method that they choose. Printed are, for each group, the number of
cases, the worst relative error and the case that it belongs to. The exit code is 0 if every case agrees within the
tolerance: 1e-8 on multipliers, relative to their modulus, 1e-7 on limits, and 5e-9 on motions, relative to the peak of
the axis, or what a case states its own numbers to
be good to (rel_diff, and half a unit of the last digit printed), if that is more.
"""

import argparse
import json
import sys
import time
import warnings
from collections import defaultdict
from decimal import Decimal
from typing import Any

import jax
import numpy as np

import lobex
from reference_cases import cases_of
from reference_tasks import Inexpressible, Limits, Motion, Multiplier, Task

MULTIPLIERS, LIMITS, MOTIONS = 1e-8, 1e-7, 5e-9
# Zeros at the end of a number are not printed, and then it tells nothing of its digits.
MOST_PRINTED = 1e-7


def alike(task: Task) -> Any:
    """What tasks of one call share: the process with all its numbers, and the scan of limits."""
    if isinstance(task, Inexpressible):
        return task.group
    leaves, tree = jax.tree.flatten(task.process)
    numbers = tuple(np.asarray(leaf, dtype=float).tobytes() for leaf in leaves)
    return type(task), task.group, tree, numbers, (task.bounds, task.scan) if isinstance(task, Limits) else None


def errors(tasks: list[Any]) -> list[float]:
    """The errors of tasks that are alike; what cannot be expressed has none at all."""
    if isinstance(tasks[0], Multiplier):
        return of_multipliers(tasks)
    if isinstance(tasks[0], Motion):
        return [of_motion(task) for task in tasks]
    return of_limits(tasks) if isinstance(tasks[0], Limits) else [np.nan] * len(tasks)


def of_multipliers(tasks: list[Multiplier]) -> list[float]:
    """Differences of complex multipliers, or of their moduli where that is more, relative to the modulus."""
    speeds, gains = (sorted({getattr(task, name) for task in tasks}) for name in ("speed", "gain"))
    chart = lobex.sweep(tasks[0].process, speeds, gains)
    found = []
    for task in tasks:
        value = complex(chart.multiplier[speeds.index(task.speed), gains.index(task.gain)]) ** task.periods
        wanted = complex(*task.case["mu"])
        size = task.case.get("spectral_radius", abs(wanted))
        apart = abs(complex(value.real, abs(value.imag)) - wanted)
        found.append(float(max(apart, abs(abs(value) - size)) / size))
    return found


def of_motion(task: Motion) -> float:
    """The error of a motion, as ``apart``."""
    return apart(lobex.orbit(task.process, task.speed, task.gain, height=task.heights), task.case, task.periods)


def apart(motion: Any, case: dict[str, Any], periods: int = 1) -> float:
    """The worst difference of extremes and of y at the wall, relative to the peak of the axis, and of the radius."""
    found = [abs(float(motion.spectral_radius) ** periods / case["spectral_radius"] - 1)]
    for index, axis in enumerate("xy"):
        if peak := case.get(f"peak_{axis}_m"):
            names = {"lowest": f"{axis}_min_m", "highest": f"{axis}_max_m", "peak": f"peak_{axis}_m"}
            found += [abs(getattr(motion, own)[index] - case[name]) / peak for own, name in names.items()]
    # What lies on the side of the wall is left, of up-milling at larger y; all teeth are told of, or one at heights.
    side = -1 if case["direction"] == "up" else 1
    left = motion.surface_location_error
    left = left[:, 0] if np.shape(left)[1] == 1 else left[0]
    wall = np.abs(side * left - case["y_at_surface_m"]) / case["peak_y_m"]
    # NaN is no agreement.
    return float(np.nan_to_num(np.max([*found, *wall]), nan=np.inf))


def of_limits(tasks: list[Limits]) -> list[float]:
    """Worst relative differences of the gains; infinite where another number, order or kind of changes is found."""
    first, speeds = tasks[0], [task.speed for task in tasks]
    if first.scan is None:
        limit = lobex.exact_limit(first.process, speeds)
        changes = [[(float(gain), "unstable")] for gain in limit.gain]
    else:
        limit = lobex.critical_gain(first.process, speeds, first.bounds, scan=first.scan)
        changes = [edges(intervals, first.bounds) for intervals in limit.intervals]
    return [of_limit(task, found, limit, i) for i, (task, found) in enumerate(zip(tasks, changes, strict=True))]


def edges(intervals: np.ndarray, bounds: tuple[float, float]) -> list[tuple[float, str]]:
    """Where stability changes within the bounds, and what the process becomes there."""
    ends = [(float(gain), ("stable", "unstable")[i % 2]) for i, gain in enumerate(intervals.ravel())]
    return [end for end in ends if np.isfinite(end[0]) and end[0] not in bounds]


def of_limit(task: Limits, found: list[tuple[float, str]], limit: lobex.Limit, lane: int) -> float:
    """As ``of_limits``, of one of them."""
    if limit.status[lane] in ("not converged", "undefined"):
        return np.inf
    found = found[:1] if task.lowest else found
    if [becomes for _, becomes in found] != [becomes for _, becomes, _ in task.changes]:
        return np.inf
    error = max([abs(gain / change[0] - 1) for (gain, _), change in zip(found, task.changes, strict=True)], default=0.0)
    told = {float(limit.gain[lane]): str(limit.kind[lane])}
    if others := [gain for gain, _ in found if gain not in told]:
        values = lobex.sweep(task.process, [task.speed], others).multiplier[0]
        told |= dict(zip(others, map(kind_of, values), strict=True))
    if any(change[2] and told[gain] != change[2] for (gain, _), change in zip(found, task.changes, strict=True)):
        return np.inf
    if task.frequency is not None:
        error = max(error, abs(float(limit.chatter_frequency[lane]) / task.frequency - 1))
    return error


def kind_of(multiplier: complex) -> str:
    """How a multiplier crosses the unit circle."""
    return "hopf" if abs(multiplier.imag) > 1e-6 else "flip" if multiplier.real < 0 else "fold"


def printed(case: dict[str, Any]) -> float:
    """Half a unit of the last digit that stands in the file for each part of a multiplier, relative to its modulus."""
    parts = [part for part in (*case["mu"], case.get("spectral_radius")) if part]
    last = min(Decimal(repr(part)).as_tuple().exponent for part in parts)
    half = float(Decimal(5).scaleb(int(last) - 1)) * np.sqrt(np.count_nonzero(case["mu"]))
    return min(half / abs(complex(*case["mu"])), MOST_PRINTED)


def tolerance_of(task: Task) -> float:
    """What is asked of a case."""
    if isinstance(task, Multiplier):
        return max(MULTIPLIERS, task.case.get("rel_diff", 0.0), printed(task.case))
    if isinstance(task, Motion):
        return max(MOTIONS, task.case["rel_diff"])
    return max(LIMITS, task.rel_diff) if isinstance(task, Limits) else 0.0


def computed(tasks: list[Task], verbose: bool) -> list[tuple[float, Task]]:
    """The errors of a group's tasks, those that are alike being computed by one call."""
    batches: dict[Any, list[Task]] = defaultdict(list)
    for task in tasks:
        batches[alike(task)].append(task)
    results: list[tuple[float, Task]] = []
    for batch in batches.values():
        began = time.perf_counter()
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            try:
                found = errors(batch)
            except Exception as failure:  # One case that fails leaves the others to be told of.
                found = [np.inf] * len(batch)
                warnings.warn(f"{type(failure).__name__}: {str(failure).splitlines()[0]}", stacklevel=1)
        results += zip(found, batch, strict=True)
        if not verbose or isinstance(batch[0], Inexpressible):
            continue
        for error, task in zip(found, batch, strict=True):
            print(f"{task.group} | {task.name}: {error:.1e}{'' if error <= tolerance_of(task) else '  WRONG'}")
        print(*[f"    {w.message}" for w in said], f"    {time.perf_counter() - began:.1f} s", sep="\n", flush=True)
    return results


def line_of(group: str, rows: list[tuple[float, Task]]) -> str:
    """The line of a group."""
    wrong = sum(not error <= tolerance_of(task) for error, task in rows)
    error, task = max(rows, key=lambda row: row[0])
    if isinstance(task, Inexpressible):
        return f"{group:32} {len(rows):5} {'-':>5} {'-':>8}  not expressible: {task.reason}"
    return f"{group:32} {len(rows):5} {wrong:5} {error:8.1e}  {task.name}"


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("file", help="a file of the shape of general.json")
    parser.add_argument("--groups", default="", help="those groups alone, such as c,d or g3; all by default")
    parser.add_argument("--verbose", action="store_true", help="print every case")
    given = parser.parse_args(arguments)
    with open(given.file) as file:
        reference = json.load(file)
    if given.groups:
        reference = {group: reference[group] for group in given.groups.split(",")}
    groups: dict[str, list[Task]] = defaultdict(list)
    for task in cases_of(reference):
        groups[task.group].append(task)
    print(f"{'group':32} {'cases':>5} {'wrong':>5} {'worst':>8}  worst case", flush=True)
    agree = True
    for group, tasks in groups.items():
        rows = computed(tasks, given.verbose)
        print(line_of(group, rows), flush=True)
        agree &= all(error <= tolerance_of(task) for error, task in rows)
    return int(not agree)


if __name__ == "__main__":
    sys.exit(main())
