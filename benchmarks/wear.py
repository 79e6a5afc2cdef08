"""The full wear map, 1,471 speeds × 20 revolutions × 4,096 cells × 10 modes, beside the same loops in numba.

    python benchmarks/wear.py

needs numba, which lobex itself does not. Prints the peak memory of lobex alone, then times of both in turn, how far
their results differ, and writes the table to benchmarks/WEAR.md.
"""

import os
import platform
import resource
import time
from pathlib import Path

import jax
import numpy as np

import lobex

SPEEDS = np.linspace(30, 1500, 1471)
REVOLUTIONS, CELLS, MODES, STIFFNESS = 20, 4096, 10, 4.5e6
ROUNDS = 5


def own() -> lobex.WearMap:
    """By lobex."""
    return lobex.march_wear(
        lobex.Rod(MODES).modes(0.03), lobex.Casing(), lobex.Linear(STIFFNESS), SPEEDS, REVOLUTIONS, CELLS
    )


def main() -> None:
    """Measure memory, then both in turn."""
    begun = time.perf_counter()
    result = own()
    cold = time.perf_counter() - begun
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(f"lobex, with compiling: {cold:.2f} s, peak memory {memory:.2f} GB", flush=True)

    import numba

    from lobex.marches.decimation import filter_matrix
    from wear_numba import march

    modes = lobex.Rod(MODES).modes(0.03)
    factor = CELLS // result.samples_per_revolution
    row = filter_matrix(CELLS, factor)[0]
    taps = row[: np.flatnonzero(row)[-1] + 1]
    arguments = (
        np.asarray(modes.angular_frequency),
        np.asarray(modes.damping_ratio),
        np.ascontiguousarray(modes.shape[:, 0]),
        result.unworn,
        STIFFNESS,
    )
    march(*arguments, SPEEDS[:4], 1, taps, factor)
    times: list[tuple[float, float]] = []
    for _ in range(ROUNDS):
        begun = time.perf_counter()
        result = own()
        middle = time.perf_counter()
        depth, _, totals = march(*arguments, SPEEDS, REVOLUTIONS, taps, factor)
        times.append((middle - begun, time.perf_counter() - middle))
        print("lobex {:.2f} s, numba {:.2f} s".format(*times[-1]), flush=True)
    mine, theirs = (np.array(column) for column in zip(*times, strict=True))
    ratio = theirs / mine
    quiet = np.sum(np.abs(depth - result.depth), axis=1) / np.sum(depth, axis=1)
    energy = np.sum(totals[:, :, 5], axis=1) / np.sum(result.damping_energy, axis=1) - 1
    lines = [
        "# The wear march, measured",
        "",
        f"Made by `python benchmarks/wear.py`: {len(SPEEDS):,} speeds × {REVOLUTIONS} revolutions × {CELLS:,} cells × "
        f"{MODES} modes in float64, {ROUNDS} rounds of both in turn.",
        "",
        "| | fastest | median | speed against numba, median of rounds (least, most) |",
        "|---|---|---|---|",
        f"| lobex.march_wear | {mine.min():.2f} s | {np.median(mine):.2f} s | {np.median(ratio):.2f} "
        f"({ratio.min():.2f}, {ratio.max():.2f}) |",
        f"| numba, prange over speeds | {theirs.min():.2f} s | {np.median(theirs):.2f} s | 1 |",
        "",
        f"Depths agree to {np.median(quiet):.0e} (median speed; {np.max(quiet):.0e} at worst), damping losses to "
        f"{np.max(np.abs(energy)):.0e}. Peak memory of lobex: {memory:.2f} GB; first call, with compiling: "
        f"{cold:.1f} s. {os.cpu_count()} cores, {platform.system()}, Python {platform.python_version()}, "
        f"jax {jax.__version__}, numba {numba.__version__}.",
        "",
    ]
    Path(__file__).with_name("WEAR.md").write_text("\n".join(lines))
    print("\n".join(lines))


if __name__ == "__main__":
    main()
