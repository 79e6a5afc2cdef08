"""Maps of periodic motions, with their time: MOTION.md.

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

HERE = Path(__file__).parent
ROUNDS = 4
TOOL = lobex.Modes.plane(
    x=lobex.Modes.single(frequency=563.6, damping_ratio=0.0558, mass=1.4986),
    y=lobex.Modes.single(frequency=516.21, damping_ratio=0.025, mass=1.199),
)
SPEED, DEPTH = np.linspace(4000, 12000, 100) / 60, np.linspace(0, 4e-3, 50)
CUTTERS: dict[str, dict[str, Any]] = {
    "four teeth": {"teeth": 4},
}


def milling(cutter: dict[str, Any]) -> lobex.Milling:
    """Half immersion down-milling, fed by 0.1 mm a tooth."""
    made = lobex.Cutter.end_mill(0.016, **cutter)
    return lobex.Milling(TOOL, made, 6.79e8, 1.73824e8, 0.5, "down", feed_per_tooth=1e-4)


def measured(process: lobex.Milling) -> tuple[float, float, float, float, float]:
    """Best of a few times s, processor time of it s, compiling s, share of stable points, largest estimated error."""
    found = lobex.orbits(process, SPEED, DEPTH)
    compiling, best, least = found.compiling, np.inf, np.inf
    for _ in range(ROUNDS):
        begun, used = time.perf_counter(), time.process_time()
        found = lobex.orbits(process, SPEED, DEPTH)
        best, least = min(best, time.perf_counter() - begun), min(least, time.process_time() - used)
    return best, least, compiling, float(np.mean(found.spectral_radius < 1)), float(np.nanmax(found.error))


def main() -> None:
    """Measure, and write the table."""
    lines = [
        "# Maps of the motion",
        "",
        f"Measured by `benchmarks/motion.py` with jax {jax.__version__} on {machine()}:",
        f"location error, deflection, torque and power over {len(SPEED)} × {len(DEPTH)} speeds and depths",
        f"where the cut is stable, by default, the best of {ROUNDS}.",
        "",
        "| cutter | time, s | processor time, s | compiling, s | stable | largest estimated error |",
        "|---|---|---|---|---|---|",
    ]
    warnings.simplefilter("ignore", lobex.SweepWarning)
    for name, cutter in CUTTERS.items():
        best, used, compiling, stable, error = measured(milling(cutter))
        lines.append(f"| {name} | {best:.2f} | {used:.2f} | {compiling:.0f} | {stable:.0%} | {error:.0e} |")
        print(lines[-1], flush=True)
    (HERE / "MOTION.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
