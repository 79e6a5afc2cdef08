"""Charts of systems whose delay is not their period, with their time and their error: GENERAL.md.

make bench
"""

import time
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

import lobex
from machine import machine

HERE = Path(__file__).parent
ROUNDS, SAMPLE = 4, 8
FINE = lobex.Duhamel(nodes=42)


def pulling(t: Any, speed: Any, gain: Any) -> Any:
    """δ + ε cos t with ε = 1 and δ + 2 in the place of the speed."""
    return speed - 2 + jnp.cos(t)


def fed_back(t: Any, speed: Any, gain: Any) -> Any:
    """The delayed gain itself."""
    return gain


def revolution(t: Any, speed: Any, gain: Any) -> Any:
    """The delay of a spindle whose speed goes up and down by a tenth, ten revolutions a time."""
    return (1 + 0.1 * jnp.sin(0.2 * jnp.pi * speed * t)) / speed


def ten_revolutions(speed: Any, gain: Any) -> Any:
    """The period of that."""
    return 10 / speed


def mathieu(share: float) -> lobex.LinearDelay:
    """The damped delayed Mathieu equation with T = 2π and a delay of a share of it."""
    delay = 2 * np.pi * share
    return lobex.LinearDelay.second_order(1.0, 0.1, pulling, [(fed_back, delay)], period=2 * np.pi)


DELTA, MATHIEU_GAIN = np.linspace(-1, 5, 100) + 2, np.linspace(-2, 1.5, 100)
CHARTS = {
    "delayed Mathieu, T = 2τ": (mathieu(0.5), DELTA, MATHIEU_GAIN),
    "delayed Mathieu, τ = 2T": (mathieu(2.0), DELTA, MATHIEU_GAIN),
    "speed variation": (
        lobex.LinearDelay.second_order(
            1.0, 0.1, 1.2, [(fed_back, revolution)], period=ten_revolutions, delay_range=(0.0899, 0.1101)
        ),
        np.linspace(0.2, 1, 100) / (2 * np.pi),
        np.linspace(0, 0.4, 100),
    ),
}


def measured(process: lobex.LinearDelay, speeds: np.ndarray, gains: np.ndarray) -> tuple[float, float, float, float]:
    """Best of a few times s, compiling s, largest estimated error, and largest error of a sample of points."""
    chart = lobex.sweep(process, speeds, gains)
    compiling, best = chart.compiling, np.inf
    for _ in range(ROUNDS):
        begun = time.perf_counter()
        chart = lobex.sweep(process, speeds, gains)
        best = min(best, time.perf_counter() - begun)
    rows, columns = (np.linspace(0, len(a) - 1, SAMPLE).astype(int) for a in (speeds, gains))
    fine = lobex.sweep(process, speeds[rows], gains[columns], FINE)
    error = np.abs(chart.spectral_radius[np.ix_(rows, columns)] / fine.spectral_radius - 1)
    return best, compiling, float(np.max(chart.error)), float(np.max(error))


def main() -> None:
    """Measure, and write the table."""
    lines = [
        "# Delays apart from the period",
        "",
        f"Measured by `benchmarks/general.py` with jax {jax.__version__} on {machine()}: charts of 100 × 100 points by",
        f"default, the best of {ROUNDS}; errors of {SAMPLE}² points against 42 nodes a piece.",
        "",
        "| chart | time, s | compiling, s | largest estimated error | largest error |",
        "|---|---|---|---|---|",
    ]
    for name, chart in CHARTS.items():
        best, compiling, estimate, error = measured(*chart)
        lines.append(f"| {name} | {best:.2f} | {compiling:.0f} | {estimate:.0e} | {error:.0e} |")
        print(lines[-1])
    (HERE / "GENERAL.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
