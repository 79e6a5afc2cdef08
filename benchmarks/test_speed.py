"""Timings for pytest-benchmark: ``pytest benchmarks --benchmark-only`` (a plain run of the tests skips them)."""

import numpy as np
import pytest

import lobex
from measured_charts import PROBLEMS


@pytest.mark.parametrize("name", PROBLEMS)
def test_sweep(benchmark, name):
    problem = PROBLEMS[name]
    arguments = problem.process, problem.speeds[::10], problem.gains[::10], problem.own[0]
    lobex.sweep(*arguments)
    chart = benchmark(lobex.sweep, *arguments)
    benchmark.extra_info["points"] = chart.spectral_radius.size
    assert np.isfinite(chart.spectral_radius).all()
