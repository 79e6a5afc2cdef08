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
