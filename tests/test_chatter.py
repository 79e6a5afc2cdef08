"""The chatter frequency is that of the motion, however few nodes the operator has."""

import numpy as np
import pytest

import lobex

CUTTER = lobex.Modes.single(frequency=922.0, damping_ratio=0.011, mass=0.03993)


@pytest.mark.parametrize(("immersion", "rpm"), [(0.1, 13800), (0.1, 4600), (0.3, 2000), (0.05, 25000)])
def test_few_nodes_in_contact_do_not_alias_the_free_vibration(immersion, rpm):
    process = lobex.Milling(CUTTER, teeth=2, tangential=6e8, normal=2e8, radial_immersion=immersion, direction="up")
    speed, gain = [rpm / 60], np.linspace(5e-4, 1.2e-2, 6)
    few = lobex.sweep(process, speed, gain)
    many = lobex.sweep(process, speed, gain, lobex.Chebyshev(90))
    assert few.chatter_frequency == pytest.approx(many.chatter_frequency, rel=1e-6)
    # A vibration of a tool with one mode is near its frequency.
    assert np.all(np.abs(many.chatter_frequency / 922.0 - 1) < 0.6)


@pytest.mark.parametrize("rpm", [1500.0, 900.0])
def test_a_stiff_tool_at_slow_speeds_has_its_own_frequency(rpm):
    """Some hundred waves between two teeth: the samples of the free vibration follow the highest mode."""
    tool = lobex.Modes.single(frequency=4000.0, damping_ratio=0.011, mass=0.03993)
    process = lobex.Milling(tool, teeth=2, tangential=6e8, normal=2e8, radial_immersion=0.05, direction="down")
    chart = lobex.sweep(process, [rpm / 60], [1e-5, 5e-4, 2e-3, 8e-3])
    assert np.all(np.abs(chart.chatter_frequency / 4000.0 - 1) < 0.05)
    assert chart.chatter_frequency[0, 0] == pytest.approx(4000.0, rel=1e-3)


def test_the_limit_of_a_stiff_tool_names_its_frequency():
    tool = lobex.Modes.single(frequency=4000.0, damping_ratio=0.0011, mass=0.002)
    process = lobex.Milling(tool, teeth=2, tangential=6e8, normal=2e8, radial_immersion=0.05, direction="down")
    limit = lobex.critical_gain(process, np.array([1500.0, 1600.0]) / 60, (0, 8e-3))
    assert np.all(np.abs(limit.chatter_frequency / 4000.0 - 1) < 0.05)
