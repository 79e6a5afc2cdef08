"""The wear march of a blading, 24 mistuned blades × 3 modes × 200 speeds × 20 revolutions × 2,048 cells, beside numba.

    python benchmarks/bladings.py

needs numba, which lobex itself does not. Prints times of both in turn and how far their results differ, and writes the
table to benchmarks/BLADINGS.md.
"""

import os
import platform
import time
from pathlib import Path

import jax
import numpy as np

import lobex

BLADES, REVOLUTIONS, CELLS, SAMPLES, STIFFNESS = 24, 20, 2048, 128, 1e6
SPEEDS = np.linspace(40, 240, 200)
ROUNDS = 5
MODES = lobex.Modes([2000.0, 5200.0, 9100.0], [0.01, 0.01, 0.01], [[1.0], [0.7], [0.5]])
BLADING = lobex.Blading(MODES, BLADES, mistuning=0.02 * np.random.default_rng(0).normal(size=BLADES))


def own() -> lobex.BladingWear:
    """By lobex."""
    made = lobex.march_wear(
        BLADING,
        lobex.Casing(),
        lobex.Linear(STIFFNESS),
        SPEEDS,
        REVOLUTIONS,
        CELLS,
        samples_per_revolution=SAMPLES,
    )
    assert isinstance(made, lobex.BladingWear)
    return made


def main() -> None:
    """Measure both in turn."""
    import numba

    from bladings_numba import march
    from lobex.marches.decimation import filter_matrix

    begun = time.perf_counter()
    result = own()
    cold = time.perf_counter() - begun
    factor = CELLS // result.samples_per_revolution
    row = filter_matrix(CELLS, factor)[0]
    taps = row[: np.flatnonzero(row)[-1] + 1]
    omega = np.asarray(MODES.angular_frequency)[:, None] * (1 + np.asarray(BLADING.mistuning))
    start = np.round(result.place / (2 * np.pi) * CELLS).astype(int)
    arguments = (omega, np.asarray(MODES.damping_ratio), np.ascontiguousarray(MODES.shape[:, 0]), start)
    arguments = (*arguments, result.unworn[0], STIFFNESS)
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
    apart = np.sum(np.abs(depth - result.depth[:, 0]), axis=1) / np.sum(depth, axis=1)
    energy = np.sum(totals[..., 6], axis=(1, 2)) / np.sum(result.damping_energy, axis=(1, 2)) - 1
    lines = [
        "# The wear march of a blading, measured",
        "",
        f"Made by `python benchmarks/bladings.py`: {BLADES} mistuned blades in one track × {MODES.count} modes × "
        f"{len(SPEEDS)} speeds × {REVOLUTIONS} revolutions × {CELLS:,} cells in float64, {ROUNDS} rounds of both in "
        "turn.",
        "",
        "| | fastest | median | speed against numba, median of rounds (least, most) |",
        "|---|---|---|---|",
        f"| lobex.march_wear | {mine.min():.2f} s | {np.median(mine):.2f} s | {np.median(ratio):.2f} "
        f"({ratio.min():.2f}, {ratio.max():.2f}) |",
        f"| numba, prange over speeds | {theirs.min():.2f} s | {np.median(theirs):.2f} s | 1 |",
        "",
        f"Depths agree to {np.median(apart):.0e} (median speed; {np.max(apart):.0e} at worst), damping losses to "
        f"{np.max(np.abs(energy)):.0e}. First call, with compiling: {cold:.1f} s. {os.cpu_count()} cores, "
        f"{platform.system()}, Python {platform.python_version()}, jax {jax.__version__}, numba {numba.__version__}.",
        "",
    ]
    Path(__file__).with_name("BLADINGS.md").write_text("\n".join(lines))
    print("\n".join(lines))


if __name__ == "__main__":
    main()
