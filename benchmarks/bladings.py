"""The wear march of a blading, 24 mistuned blades × 3 modes × 200 speeds × 20 revolutions × 2,048 cells, beside numba.

    python benchmarks/bladings.py

needs numba, which lobex itself does not. Prints times of both in turn and how far their results differ, and writes the
table to benchmarks/BLADINGS.md.
"""

import time

import numpy as np

import lobex
from beside_numba import in_turn, taps_of, write_table

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
    from bladings_numba import march

    begun = time.perf_counter()
    result = own()
    cold = time.perf_counter() - begun
    factor = CELLS // result.samples_per_revolution
    taps = taps_of(CELLS, factor)
    omega = np.asarray(MODES.angular_frequency)[:, None] * np.asarray(BLADING.detuned).T
    start = np.round(result.place / (2 * np.pi) * CELLS).astype(int)
    arguments = (omega, np.asarray(MODES.damping_ratio), np.ascontiguousarray(MODES.shape[:, 0]), start)
    arguments = (*arguments, result.unworn[0], STIFFNESS)
    march(*arguments, SPEEDS[:4], 1, taps, factor)
    result, (depth, _, totals), times = in_turn(
        own, lambda: march(*arguments, SPEEDS, REVOLUTIONS, taps, factor), ROUNDS
    )
    write_table(
        "BLADINGS.md",
        "The wear march of a blading, measured",
        f"Made by `python benchmarks/bladings.py`: {BLADES} mistuned blades in one track × {MODES.count} modes × "
        f"{len(SPEEDS)} speeds × {REVOLUTIONS} revolutions × {CELLS:,} cells in float64, {ROUNDS} rounds of both in "
        "turn.",
        times,
        np.sum(np.abs(depth - result.depth[:, 0]), axis=1) / np.sum(depth, axis=1),
        np.sum(totals[..., 6], axis=(1, 2)) / np.sum(result.damping_energy, axis=(1, 2)) - 1,
        [f"First call, with compiling: {cold:.1f} s."],
    )


if __name__ == "__main__":
    main()
