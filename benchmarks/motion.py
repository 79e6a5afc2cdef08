"""Maps of periodic motions, with their time and their error: MOTION.md.

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
ROUNDS, SAMPLE = 4, 6
FINE = lobex.Duhamel(nodes=24)
TOOL = lobex.Modes.plane(
    x=lobex.Modes.single(frequency=563.6, damping_ratio=0.0558, mass=1.4986),
    y=lobex.Modes.single(frequency=516.21, damping_ratio=0.025, mass=1.199),
)
SPEED, DEPTH = np.linspace(4000, 12000, 100) / 60, np.linspace(0, 4e-3, 50)
CUTTERS: dict[str, dict[str, Any]] = {
    "four teeth": {"teeth": 4},
    "pitch 70-110-70-110": {"pitch_degrees": [70, 110, 70, 110]},
    "four teeth, helix 30°": {"teeth": 4, "helix_degrees": 30},
}


def milling(cutter: dict[str, Any]) -> lobex.Milling:
    """Half immersion down-milling, fed by 0.1 mm a tooth."""
    made = lobex.Cutter.end_mill(0.016, **cutter)
    return lobex.Milling(TOOL, made, 6.79e8, 1.73824e8, 0.5, "down", feed_per_tooth=1e-4)


def measured(process: lobex.Milling) -> tuple[float, float, float, float]:
    """Best of a few times s, compiling s, share of stable points, and largest error of a sample of them."""
    found = lobex.orbits(process, SPEED, DEPTH)
    compiling, best = found.compiling, np.inf
    for _ in range(ROUNDS):
        begun = time.perf_counter()
        found = lobex.orbits(process, SPEED, DEPTH)
        best = min(best, time.perf_counter() - begun)
    stable = np.argwhere(np.isfinite(found.location_error) & (DEPTH > 0))
    rows, columns = stable[np.linspace(0, len(stable) - 1, SAMPLE**2).astype(int)].T
    fine: Any = lobex.orbit(process, SPEED[rows], DEPTH[columns], FINE, phase=[0.0])
    walls = fine.surface_location_error.reshape(len(rows), -1)
    wanted = walls[np.arange(len(walls)), np.argmax(np.abs(walls), axis=1)]
    # Of two that are as far on either side one may be taken for the other.
    apart = np.abs(np.abs(found.location_error[rows, columns]) - np.abs(wanted)) / fine.peak[:, 1]
    return best, compiling, len(stable) / found.error.size, float(np.max(apart))


def main() -> None:
    """Measure, and write the table."""
    lines = [
        "# Maps of the motion",
        "",
        f"Measured by `benchmarks/motion.py` with jax {jax.__version__} on {machine()}:",
        f"location error, deflection, torque and power over {len(SPEED)} × {len(DEPTH)} speeds and depths where the",
        f"cut is stable, by default, the best of {ROUNDS}; errors of the location error, relative to the largest",
        f"displacement, of {SAMPLE**2} points against {FINE.nodes} nodes a piece.",
        "",
        "| cutter | time, s | compiling, s | stable | largest error |",
        "|---|---|---|---|---|",
    ]
    warnings.simplefilter("ignore", lobex.SweepWarning)
    for name, cutter in CUTTERS.items():
        best, compiling, stable, error = measured(milling(cutter))
        lines.append(f"| {name} | {best:.2f} | {compiling:.0f} | {stable:.0%} | {error:.0e} |")
        print(lines[-1], flush=True)
    (HERE / "MOTION.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
