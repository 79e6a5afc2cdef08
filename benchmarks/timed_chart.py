"""A chart timed, and a sample of its points held against many nodes."""

import time
from typing import Any

import numpy as np

import lobex


def sampled(
    process: Any, speeds: np.ndarray, gains: np.ndarray, sample: tuple[int, int], fine: lobex.Duhamel
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows and columns of a sample of a grid, and |μ| there with many nodes."""
    rows, columns = (np.linspace(0, len(a) - 1, n).astype(int) for a, n in zip((speeds, gains), sample, strict=True))
    return rows, columns, lobex.sweep(process, speeds[rows], gains[columns], fine).spectral_radius


def measured(
    process: Any, speeds: np.ndarray, gains: np.ndarray, rounds: int, sample: tuple[int, int], fine: lobex.Duhamel
) -> tuple[float, float, float, float]:
    """Best of a few times s, compiling s, largest estimated error, and largest error of a sample of points."""
    chart = lobex.sweep(process, speeds, gains)
    compiling, best = chart.compiling, np.inf
    for _ in range(rounds):
        begun = time.perf_counter()
        chart = lobex.sweep(process, speeds, gains)
        best = min(best, time.perf_counter() - begun)
    rows, columns, radius = sampled(process, speeds, gains, sample, fine)
    error = np.abs(chart.spectral_radius[np.ix_(rows, columns)] / radius - 1)
    return best, compiling, float(np.nanmax(chart.error)), float(np.max(error))
