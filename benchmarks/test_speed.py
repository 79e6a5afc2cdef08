"""Timings for pytest-benchmark: ``pytest benchmarks --benchmark-only`` (a plain run of the tests skips them)."""

import numpy as np
import pytest

import lobex
import measure


@pytest.mark.parametrize("name", measure.GRIDS)
def test_sweep(benchmark, name):
    process, speeds, gains, method = measure.GRIDS[name]
    few = (speeds[::10], gains[::10])
    lobex.sweep(process, *few, method)
    chart = benchmark(lobex.sweep, process, *few, method)
    benchmark.extra_info["points"] = chart.spectral_radius.size
    assert np.isfinite(chart.spectral_radius).all()
