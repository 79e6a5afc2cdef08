"""What the second core gains for a chart: CORES.md.

make bench
"""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import lobex
from machine import machine
from measured_charts import PROBLEMS

HERE = Path(__file__).parent
ROUNDS, REPEATS = 2, 6


def spent(name: str) -> float:
    """The fastest of a few charts in this process, s, once one has compiled everything."""
    problem = PROBLEMS[name]
    times = []
    for _ in range(REPEATS + 1):
        begun = time.perf_counter()
        lobex.sweep(problem.process, problem.speeds, problem.gains)
        times.append(time.perf_counter() - begun)
    return min(times[1:])


def in_a_process(name: str, cores: int) -> float:
    """The same in a process of its own, which is held to so many cores before anything starts in it."""
    held = sorted(os.sched_getaffinity(0))[:cores]
    done = subprocess.run(
        [sys.executable, __file__, name],
        capture_output=True,
        text=True,
        check=True,
        preexec_fn=lambda: os.sched_setaffinity(0, held),
    )
    return float(json.loads(done.stdout))


def main() -> None:
    """Measure, one core and all in turn, and write the table."""
    every = len(os.sched_getaffinity(0))
    lines = [
        "# Cores",
        "",
        f"Measured by `benchmarks/cores.py`: the fastest of {ROUNDS * REPEATS} charts in {ROUNDS} processes that are "
        f"held to one core, and in as many that have {every}, in turn, compiling apart.",
        "",
        f"| chart | one core, s | {every} cores, s | ratio |",
        "|---|---|---|---|",
    ]
    for name in PROBLEMS:
        rounds = [(in_a_process(name, 1), in_a_process(name, every)) for _ in range(ROUNDS)]
        alone, together = map(min, zip(*rounds, strict=True))
        lines.append(f"| {name} | {alone:.3f} | {together:.3f} | {alone / together:.2f} |")
        print(lines[-1], flush=True)
    (HERE / "CORES.md").write_text("\n".join([*lines, "", f"Machine: {machine()}.", ""]))


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(json.dumps(spent(sys.argv[1])))
    else:
        main()
