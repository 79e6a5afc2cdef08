"""Sizes of operators, limits and marches of delays that are not the period, and delays that are not what was said."""

import jax
import numpy as np
import pytest

import lobex
from cases import GENERAL
from problems import ACT_AND_WAIT, Damper, mathieu

METHODS = [lobex.Chebyshev(28), lobex.SemiDiscretization(64, order=1)]


def test_a_march_refuses_delays_shorter_than_a_step():
    with pytest.raises(
        ValueError, match=r"steps_per_period = 3 is too few for a delay of 0\.3 periods.*give 4 or more"
    ):
        lobex.march_delay(ACT_AND_WAIT, 1.0, 0.5, np.cos, 4, 3)


@pytest.mark.slow
def test_charts_and_limits_of_a_delay_that_is_not_the_period():
    case = GENERAL["mathieu_limits"][0]
    process, method, speeds = mathieu(case), METHODS[0], [1 / (2 * np.pi)]
    limit = lobex.critical_gain(process, speeds, (-1.5, 1.5), method, scan=17)
    assert limit.intervals[0] == pytest.approx(np.array([case["b"]]), rel=1e-8)
    chart = lobex.sweep(process, speeds, limit.intervals[0, 0], method)
    assert chart.spectral_radius[0] == pytest.approx(1, abs=1e-8)


@pytest.mark.parametrize("method", METHODS, ids=repr)
@pytest.mark.parametrize(
    "process", [ACT_AND_WAIT, Damper(), mathieu(GENERAL["mathieu"][2])], ids=["jumps", "two", "long"]
)
def test_sizes_are_those_of_the_operators(process, method):
    with jax.enable_x64(True):
        system = process.system(1.0, 0.5)
        matrix = jax.eval_shape(lambda: method.operator(system).matrix)
        assert matrix.shape == (method.size(system), method.size(system))


@pytest.mark.parametrize(("delay", "said"), [(0.02, (0.9, 1.1)), (0.35, (0.1, 0.2))], ids=["shorter", "longer"])
@pytest.mark.parametrize("method", [*METHODS, lobex.Duhamel(12)], ids=repr)
def test_a_delay_that_is_not_what_was_said_makes_no_number(method, delay, said):
    process = lobex.LinearDelay([[-0.5]], [([[0.5]], delay)], period=1.0, delay_range=said)
    matrix = jax.jit(lambda speed: method.operator(process.system(speed, 0.0)).matrix)(1.0)
    assert np.isnan(np.asarray(matrix)).any()
