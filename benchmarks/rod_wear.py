"""The full wear map, 1,471 speeds × 20 revolutions × 4,096 cells × 10 modes, beside the same loops in numba.

    python benchmarks/rod_wear.py

needs numba, which lobex itself does not. Prints the peak memory of lobex alone, then times of both in turn, how far
their results differ, and writes the table to benchmarks/WEAR.md.
"""

import resource
import time

import numpy as np

import lobex
from beside_numba import in_turn, taps_of, write_table

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

    from wear_numba import march

    modes = lobex.Rod(MODES).modes(0.03)
    factor = CELLS // result.samples_per_revolution
    taps = taps_of(CELLS, factor)
    arguments = (
        np.asarray(modes.angular_frequency),
        np.asarray(modes.damping_ratio),
        np.ascontiguousarray(modes.shape[:, 0]),
        result.unworn,
        STIFFNESS,
    )
    march(*arguments, SPEEDS[:4], 1, taps, factor)
    result, (depth, _, totals), times = in_turn(
        own, lambda: march(*arguments, SPEEDS, REVOLUTIONS, taps, factor), ROUNDS
    )
    write_table(
        "WEAR.md",
        "The wear march, measured",
        f"Made by `python benchmarks/rod_wear.py`: {len(SPEEDS):,} speeds × {REVOLUTIONS} revolutions × {CELLS:,} "
        f"cells × {MODES} modes in float64, {ROUNDS} rounds of both in turn.",
        times,
        np.sum(np.abs(depth - result.depth), axis=1) / np.sum(depth, axis=1),
        np.sum(totals[:, :, 5], axis=1) / np.sum(result.damping_energy, axis=1) - 1,
        [f"Peak memory of lobex: {memory:.2f} GB; first call, with compiling: {cold:.1f} s."],
    )


if __name__ == "__main__":
    main()
