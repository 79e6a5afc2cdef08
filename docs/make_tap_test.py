"""Writes an example tap test, the accelerances of a tool along two axes with noise: howto/tap_test.csv."""

from pathlib import Path

import numpy as np

import lobex

PATH = Path(__file__).parent / "howto" / "tap_test.csv"
NOISE = 0.01
"""Of the largest accelerance of each axis, in the root mean square over all lines."""


def modes() -> dict[str, lobex.Modes]:
    """The modes of the tool along each axis."""
    return {
        "x": lobex.Modes.single(frequency=563.6, damping_ratio=0.0558, mass=1.4986),
        "y": lobex.Modes.single(frequency=516.21, damping_ratio=0.025, mass=1.199),
    }


def text() -> str:
    """The file: frequency in Hz and accelerances in m/s²/N, 4 Hz apart."""
    random = np.random.default_rng(7)
    frequency = np.arange(100.0, 1400.0, 4.0)
    omega = 2 * np.pi * frequency
    columns, head = [frequency], ["Frequency [Hz]"]
    for axis, own in modes().items():
        natural, ratio, shape = (
            float(np.ravel(part)[0]) for part in (own.angular_frequency, own.damping_ratio, own.shape)
        )
        clean = -(omega**2) * shape**2 / (natural**2 - omega**2 + 2j * ratio * natural * omega)
        noise = NOISE * np.abs(clean).max() * (random.standard_normal((2, len(omega))) / np.sqrt(2))
        columns += [clean.real + noise[0], clean.imag + noise[1]]
        head += [f"Real {axis}{axis} [m/s^2/N]", f"Imag {axis}{axis} [m/s^2/N]"]
    rows = [",".join([f"{row[0]:.0f}", *(f"{value:.4g}" for value in row[1:])]) for row in zip(*columns, strict=True)]
    return "\n".join([",".join(head), *rows]) + "\n"


if __name__ == "__main__":
    PATH.write_text(text())
