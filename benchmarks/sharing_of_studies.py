"""What more processes gain for a study, against one; writes WORKERS.md.

    python benchmarks/sharing_of_studies.py

The study of growth_of_studies.py's blade rub, to a store, by pools of processes with one thread each. A pool is
measured twice: from its start, with all that its processes import and compile, and once they are warm. Pools take
turns, and the medians are told. The efficiency is the time of one process over that of the pool, over the cores that
the pool can use: what those of one machine cannot give, more processes cannot either.
"""

import os
import statistics
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np

import lobex
from machine import machine

HERE = Path(__file__).parent
POOLS = (1, 2, 8)
SPEEDS, GAINS, COMBINATIONS, TURNS = 250, 400, 60, 3
# Chunks for every process to compile what it needs.
WARM = 6


def seconds(combinations: int, pool: ProcessPoolExecutor, folder: str) -> float:
    """Wall time of a study of so many combinations, of a chunk each."""
    rub = lobex.Rub(lobex.Rod(5).modes(0.03))
    axis = {"modes.damping_ratio": np.linspace(0.01, 0.05, combinations)}
    speed, gain = np.linspace(50, 400, SPEEDS), np.linspace(4.5e4, 4.5e6, GAINS)
    begun = time.perf_counter()
    lobex.sweep(rub, speed, gain, over=axis, store=folder, executor=pool)
    return time.perf_counter() - begun


def measured(processes: int) -> tuple[float, float]:
    """Wall time from the start of a pool, and of one that is warm."""
    with tempfile.TemporaryDirectory() as folder, ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        cold = seconds(COMBINATIONS, pool, f"{folder}/cold")
        seconds(WARM * processes, pool, f"{folder}/warming")
        return cold, seconds(COMBINATIONS, pool, f"{folder}/warm")


def main() -> None:
    """Measure every pool in turn, and write."""
    # A process for each core: none takes the threads of another's.
    os.environ["NPROC"] = "1"
    found: dict[int, list[tuple[float, float]]] = {processes: [] for processes in POOLS}
    for _ in range(TURNS):
        for processes in POOLS:
            found[processes].append(measured(processes))
            print(processes, found[processes][-1], file=sys.stderr, flush=True)
    medians = {n: [statistics.median(times) for times in zip(*turns, strict=True)] for n, turns in found.items()}
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    rows = []
    for processes, (cold, warm) in medians.items():
        usable = min(processes, cores)
        gains = [medians[1][i] / value for i, value in enumerate((cold, warm))]
        rows.append(
            f"| {processes} | {usable} | {cold:.1f} s | {gains[0]:.2f} | {100 * gains[0] / usable:.0f} % | "
            f"{warm:.1f} s | {gains[1]:.2f} | {100 * gains[1] / usable:.0f} % |"
        )
    points = SPEEDS * GAINS * COMBINATIONS
    text = [
        "# Studies by several processes, measured",
        "",
        f"Made by `python benchmarks/sharing_of_studies.py`: a blade rub by characteristic roots, {points:.0e} points "
        f"in {COMBINATIONS} chunks, to a store on disk, by `ProcessPoolExecutor` with one thread a process. Medians of "
        f"{TURNS} turns. Efficiency is the gain over one process, for every core that the pool can use.",
        "",
        "| processes | cores used | from the start | gain | efficiency | warm | gain | efficiency |",
        "|---|---|---|---|---|---|---|---|",
        *rows,
        "",
        f"Machine: {machine()}.",
        "",
    ]
    (HERE / "WORKERS.md").write_text("\n".join(text))
    print("\n".join(text))


if __name__ == "__main__":
    main()
