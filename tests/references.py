"""Compare lobex with a file of reference numbers, such as one of several delays, varying delays or several contacts.

    python tests/references.py FILE [--groups c,d] [--verbose]

Every case is computed with the public verbs and the method that they choose. Printed are, for each group, the number of
cases, the worst relative error and the case that it belongs to. The exit code is 0 if every case agrees within the
tolerance: 1e-8 on multipliers, relative to their modulus, and 1e-7 on limits, or what a case states its own numbers to
be good to (rel_diff), if that is more.
"""

import argparse
import json
import sys
import time
import warnings
from collections import defaultdict
from typing import Any

import numpy as np

import lobex
from reference_cases import Inexpressible, Limits, Multiplier, Task, cases_of

MULTIPLIERS, LIMITS = 1e-8, 1e-7


def error_of_multiplier(task: Multiplier) -> float:
    """The difference of the complex multiplier, or of its modulus if that is more, relative to the modulus."""
    chart = lobex.sweep(task.process, [task.speed], [task.gain])
    value = complex(chart.multiplier[0, 0]) ** task.passes
    wanted = complex(*task.case["mu"])
    size = task.case.get("spectral_radius", abs(wanted))
    apart = abs(complex(value.real, abs(value.imag)) - wanted)
    return max(apart, abs(abs(value) - size)) / size


def kind_of(process: Any, speed: float, gains: list[float]) -> list[str]:
    """How the dominant multiplier crosses the unit circle at each of increasing gains."""
    values = lobex.sweep(process, [speed], gains).multiplier[0] if gains else []
    return ["hopf" if abs(v.imag) > 1e-6 else "flip" if v.real < 0 else "fold" for v in values]


def error_of_limits(task: Limits) -> float:
    """The worst relative difference of the gains; infinite where there is another number or order of changes."""
    if task.scan is None:
        limit = lobex.exact_limit(task.process, [task.speed])
        found = [(float(limit.gain[0]), "unstable")]
    else:
        limit = lobex.critical_gain(task.process, [task.speed], task.bounds, scan=task.scan)
        edges = limit.intervals[0].ravel()
        found = [(float(g), ("stable", "unstable")[i % 2]) for i, g in enumerate(edges) if np.isfinite(g)]
        found = [change for change in found if change[0] not in task.bounds]
        if limit.status[0] in ("not converged", "undefined"):
            return np.inf
    if task.frequency is not None or task.scan is None:
        found = found[:1]
    if [becomes for _, becomes in found] != [becomes for _, becomes, _ in task.changes]:
        return np.inf
    error = max([abs(gain / change[0] - 1) for (gain, _), change in zip(found, task.changes, strict=True)], default=0.0)
    wanted = [kind for *_, kind in task.changes]
    if all(wanted) and kind_of(task.process, task.speed, [gain for gain, _ in found]) != wanted:
        return np.inf
    if task.frequency is not None:
        error = max(error, abs(float(limit.chatter_frequency[0]) / task.frequency - 1))
    return error


def compare(task: Task) -> tuple[float, float]:
    """The error of a case and its tolerance; what cannot be expressed has no error at all."""
    if isinstance(task, Inexpressible):
        return np.nan, 0.0
    if isinstance(task, Multiplier):
        return error_of_multiplier(task), max(MULTIPLIERS, task.case.get("rel_diff", 0.0))
    return error_of_limits(task), max(LIMITS, task.rel_diff)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("file", help="a file of the shape of general.json")
    parser.add_argument("--groups", default="", help="those groups alone, such as c,d or g3; all by default")
    parser.add_argument("--verbose", action="store_true", help="print every case")
    given = parser.parse_args()
    with open(given.file) as file:
        reference = json.load(file)
    if given.groups:
        reference = {group: reference[group] for group in given.groups.split(",")}
    results: dict[str, list[tuple[float, float, str]]] = defaultdict(list)
    reasons: dict[str, str] = {}
    for task in cases_of(reference):
        began = time.perf_counter()
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            error, tolerance = compare(task)
        results[task.group].append((error, tolerance, task.name))
        if isinstance(task, Inexpressible):
            reasons[task.group] = task.reason
        elif given.verbose:
            bad = "" if error <= tolerance else "  WRONG"
            told = "".join(f"\n    {w.message}" for w in said)
            took = f"{time.perf_counter() - began:.1f} s"
            print(f"{task.group} | {task.name}: {error:.1e}{bad} ({took}){told}", flush=True)
    print(f"{'group':32} {'cases':>5} {'wrong':>5} {'worst':>8}  worst case")
    for group, rows in results.items():
        if group in reasons:
            print(f"{group:32} {len(rows):5} {'-':>5} {'-':>8}  not expressible: {reasons[group]}")
            continue
        wrong = sum(not error <= tolerance for error, tolerance, _ in rows)
        error, _, case = max(rows, key=lambda row: row[0] if np.isfinite(row[0]) else np.inf)
        print(f"{group:32} {len(rows):5} {wrong:5} {error:8.1e}  {case}", flush=True)
    return int(any(not error <= tolerance for rows in results.values() for error, tolerance, _ in rows))


if __name__ == "__main__":
    sys.exit(main())
