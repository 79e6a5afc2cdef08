"""Lobes and limits of a blade whose modes follow its speed."""

import jax
import numpy as np
import pytest

import lobex
from lobex.processes.at_speeds import tabled
from test_rotating_beam import CONTACT, blade

TURNING = blade(1).rotating(0.01, [1, 2, 3], **CONTACT)
RUB = lobex.Rub(TURNING)
SPEEDS = np.array([70.0, 95.0, 140.0])


def test_the_exact_limit_is_that_of_the_modes_at_each_speed():
    limit = lobex.exact_limit(RUB, SPEEDS)
    for i, speed in enumerate(SPEEDS):
        alone = lobex.exact_limit(lobex.Rub(TURNING.at(speed)), speed)
        assert limit.gain[i] == pytest.approx(alone.gain[0], rel=1e-13)
        assert limit.status[i] == alone.status[0]
        assert limit.chatter_frequency[i] == pytest.approx(alone.chatter_frequency[0], rel=1e-12)
    table = lobex.exact_limit(tabled(RUB, SPEEDS), SPEEDS)
    assert table.gain == pytest.approx(limit.gain, rel=1e-10)


def test_verbs_meet_at_the_limit():
    limit = lobex.exact_limit(RUB, SPEEDS)
    found = lobex.critical_gain(RUB, SPEEDS, (0.1 * limit.gain.min(), 2 * limit.gain.max()))
    assert found.gain == pytest.approx(limit.gain, rel=1e-11)
    chart = lobex.sweep(RUB, SPEEDS, np.sort(limit.gain))
    assert np.diag(chart.spectral_radius[:, np.argsort(np.argsort(limit.gain))]) == pytest.approx(1.0, abs=1e-9)


def test_the_limit_has_a_derivative_by_the_speed_with_that_of_the_modes():
    def gain(speed):
        return lobex.exact_limit(RUB, speed).gain[0]

    with jax.enable_x64(True):
        slope = jax.jit(jax.grad(gain))(95.0)
    assert float(slope) == pytest.approx((gain(95.001) - gain(94.999)) / 2e-3, rel=1e-6)


def test_tables_of_few_sizes_hold_the_modes_at_every_speed():
    table = tabled(RUB, [140.0, 70.0, 95.0]).modes
    assert isinstance(table, lobex.ModesOverSpeed)
    assert table.speed.tolist() == [70.0, 95.0, 140.0, 280.0]
    for speed in SPEEDS:
        assert table.at(speed).angular_frequency == pytest.approx(TURNING.at(speed).angular_frequency, rel=1e-14)
    assert isinstance(tabled(RUB, 95.0).modes, lobex.Modes)
    steady = lobex.Rub(TURNING.at(95.0))
    assert tabled(steady, SPEEDS) is not None
    assert tabled(steady, SPEEDS).modes.angular_frequency is steady.modes.angular_frequency
