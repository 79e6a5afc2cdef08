"""Charts of systems whose delay is not their period, with their time and their error: GENERAL.md.

make bench
"""

from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

import lobex
from machine import machine
from timed_chart import measured

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
        best, compiling, estimate, error = measured(*chart, ROUNDS, (SAMPLE, SAMPLE), FINE)
        lines.append(f"| {name} | {best:.2f} | {compiling:.0f} | {estimate:.0e} | {error:.0e} |")
        print(lines[-1])
    (HERE / "GENERAL.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
