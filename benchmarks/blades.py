"""Exact limits of real blades, with their time and how far the operator is from them: BLADES.md.

make bench
"""

import time
from pathlib import Path

import numpy as np

import lobex
from machine import machine

HERE = Path(__file__).parent
ROUNDS, SAMPLE = 5, 3
ONE = lobex.Modes.from_table([400.0, 1500.0, 2400.0], 0.005, mass=[0.1, 0.15, 0.2])
SHARES = 0.02 * np.random.default_rng(0).normal(size=24)
BEAM = lobex.Beam.rectangular(
    elements=6, length=0.18, width=0.065, thickness=0.005, young_modulus=110e9, density=4430.0, hub_radius=0.12
)
CASES = {
    "one blade, 3 modes": (lobex.Rub(ONE), 1000),
    "in a ring of 2 and 3 nodal diameters": (
        lobex.Rub(ONE, casing=lobex.Ring([2, 3], [350.0, 610.0], 0.02, 1.5)),
        200,
    ),
    "a beam that turns, 4 modes": (lobex.Rub(BEAM.rotating(0.005, [1, 2, 3, 4], normal=(0.97, 0.0, 0.24))), 200),
    "24 equal blades × 3 modes": (lobex.Rub(lobex.Blading(ONE, 24)), 200),
    "24 mistuned blades × 3 modes": (lobex.Rub(lobex.Blading(ONE, 24, SHARES)), 200),
}


def apart(process: lobex.Rub, limit: lobex.Limit) -> float:
    """The largest |ln|μ|| of the operator at the limits of some speeds."""
    chosen = np.linspace(0, len(limit.speed) - 1, SAMPLE).astype(int)
    radius = [float(lobex.spectral_radius(process, limit.speed[i], limit.gain[i], lobex.Duhamel())) for i in chosen]
    return float(np.max(np.abs(np.log(radius))))


def main() -> None:
    """Measure every case and write the table."""
    lines = [
        "# Exact limits of real blades",
        "",
        "Speeds from 50 to 200 revolutions per second. First call with its compiling; then the median of "
        f"{ROUNDS} further ones; and |ln&#124;μ&#124;| of `Duhamel` at the limits of {SAMPLE} speeds, at most.",
        "",
        "| blades | speeds | first call | another | a speed | operator there |",
        "|---|---|---|---|---|---|",
    ]
    for name, (process, count) in CASES.items():
        speed = np.linspace(50.0, 200.0, count)
        began = time.perf_counter()
        limit = lobex.exact_limit(process, speed)
        first = time.perf_counter() - began
        times = []
        for _ in range(ROUNDS):
            began = time.perf_counter()
            limit = lobex.exact_limit(process, speed)
            times.append(time.perf_counter() - began)
        median = float(np.median(times))
        row = f"| {name} | {count} | {first:.2f} s | {median:.2f} s | {1e3 * median / count:.2f} ms |"
        lines.append(f"{row} {apart(process, limit):.0e} |")
        print(lines[-1], flush=True)
    lines += ["", f"Machine: {machine()}.", "", "Written by `benchmarks/blades.py`."]
    (HERE / "BLADES.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
