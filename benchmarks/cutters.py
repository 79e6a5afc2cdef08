"""Charts of cutters as shops have them, with their time and error, beside semi-discretization in numba: CUTTERS.md.

make bench
"""

import time
import warnings
from pathlib import Path
from typing import Any

import jax
import numpy as np

import lobex
from machine import machine
from pitched_numba import spectral_radii
from timed_chart import measured, sampled

HERE = Path(__file__).parent
ROUNDS, SAMPLE = 3, (10, 5)
FINE = lobex.Duhamel(nodes=30)
PITCH = [70.0, 110.0, 70.0, 110.0]
TOOL = lobex.Modes.from_table(
    frequency=[510.0, 802.0, 525.0, 770.0],
    damping_ratio=[0.02, 0.018, 0.022, 0.02],
    mass=[0.5, 1.0, 0.55, 0.8],
    direction=["x", "x", "y", "y"],
)
FORCE = 6e8, 2e8
DIAMETER, IMMERSION = 0.019, 0.5
SPEEDS, DEPTHS = np.linspace(3000, 15000, 200) / 60, np.linspace(2e-5, 4e-3, 100)
CUTTERS: dict[str, dict[str, Any]] = {
    "90-90-90-90": {"teeth": 4},
    "70-110-70-110": {"pitch_degrees": PITCH},
    "90-90-90-90, helix 30°": {"teeth": 4, "helix_degrees": 30.0},
    "70-110-70-110, helix 30°": {"pitch_degrees": PITCH, "helix_degrees": 30.0},
}
STEPS = 40, 80, 160
# Gains of a scan, and of one that tells whether it missed an island.
SCAN, FINER = 65, 257


def milling(cutter: dict[str, Any]) -> lobex.Milling:
    """Half immersion down-milling of aluminium."""
    return lobex.Milling(TOOL, lobex.Cutter.end_mill(DIAMETER, **cutter), *FORCE, IMMERSION, "down")


def limit(process: lobex.Milling) -> tuple[float, int, int]:
    """Best of a few times s of the limit at all speeds with its islands, and how many stable intervals it and a finer
    scan find.
    """

    def found(scan: int) -> tuple[float, int]:
        begun = time.perf_counter()
        intervals = lobex.critical_gain(process, SPEEDS, (DEPTHS[0], DEPTHS[-1]), scan=scan).intervals
        return time.perf_counter() - begun, int(np.sum(np.isfinite(intervals[..., 0])))

    best, count = min(found(SCAN) for _ in range(ROUNDS + 1))
    return best, count, found(FINER)[1]


def usual(process: lobex.Milling, steps: int) -> tuple[float, float]:
    """Seconds that semi-discretization takes for a chart, from a sample of its points, and its largest error there."""
    rows, columns, fine = sampled(process, SPEEDS, DEPTHS, SAMPLE, FINE)
    speed, depth = (part.ravel() for part in np.meshgrid(SPEEDS[rows], DEPTHS[columns], indexing="ij"))
    modes, (entry, exit_) = process.modes, map(float, process.engagement)
    numbers = (
        np.asarray(modes.angular_frequency, dtype=float),
        np.asarray(modes.damping_ratio, dtype=float),
        np.asarray(modes.shape, dtype=float),
        np.radians(PITCH[:2]),
        *FORCE,
        entry,
        exit_,
    )
    spectral_radii(*numbers, speed[:1], depth[:1], steps)
    begun = time.perf_counter()
    found = spectral_radii(*numbers, speed, depth, steps)
    seconds = (time.perf_counter() - begun) * len(SPEEDS) * len(DEPTHS) / len(speed)
    return seconds, float(np.max(np.abs(found / fine.ravel() - 1)))


def main() -> None:
    """Measure, and write the tables."""
    warnings.simplefilter("ignore", lobex.SweepWarning)
    lines = [
        "# Cutters",
        "",
        f"Measured by `benchmarks/cutters.py` with jax {jax.__version__} on {machine()}:",
        f"charts of {len(SPEEDS)} × {len(DEPTHS)} points of a tool with two modes in each of two directions,",
        f"by default, the best of {ROUNDS}; errors of {SAMPLE[0]} × {SAMPLE[1]} points against 30 nodes a piece.",
        "",
        "| teeth | time, s | compiling, s | largest estimated error | largest error |",
        "|---|---|---|---|---|",
    ]
    for name, cutter in CUTTERS.items():
        best, compiling, estimate, error = measured(milling(cutter), SPEEDS, DEPTHS, ROUNDS, SAMPLE, FINE)
        lines.append(f"| {name} | {best:.2f} | {compiling:.0f} | {estimate:.0e} | {error:.0e} |")
        print(lines[-1], flush=True)
    seconds, intervals, finer = limit(milling(CUTTERS["70-110-70-110"]))
    lines += [
        "",
        f"The limit of 70-110-70-110 at {len(SPEEDS)} speeds with all islands, by `critical_gain`, takes {seconds:.2f}",
        f"s with its scan of {SCAN} gains. It finds {intervals} stable intervals, one of {FINER} gains {finer}.",
        "",
        "The chart of 70-110-70-110 by zeroth-order semi-discretization in numba (`benchmarks/pitched_numba.py`), on",
        "every core, from the time of the same sample of points:",
        "",
        "| steps a period | time, s | largest error |",
        "|---|---|---|",
    ]
    for steps in STEPS:
        seconds, error = usual(milling(CUTTERS["70-110-70-110"]), steps)
        lines.append(f"| {steps} | {seconds:.0f} | {error:.0e} |")
        print(lines[-1], flush=True)
    (HERE / "CUTTERS.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
