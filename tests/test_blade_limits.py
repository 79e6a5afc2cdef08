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
RADIAL, TANGENT = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


@pytest.mark.slow
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


@pytest.mark.slow
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


# A titanium blade of four bending modes and one of stretch, its contact inclined: of speed, inclination in degrees and
# friction the limit, by D-subdivision and by Newton on the characteristic equation with closed forms of the modes.
INCLINED = [
    (60.0, 30.0, 0.0, 6719.30290802),
    (90.0, 30.0, 0.2, 1124.69200955),
    (125.0, 30.0, -0.2, 1704.4548753),
    (60.0, 8.0, -0.2, 30100.680902),
    (90.0, 8.0, -0.2, 473393.3639),
]


def test_a_blade_of_elements_meets_two_codes_with_friction():
    # The chord along the axis of the rotor, so that flap is along the motion: of modes by frequency the four that flap,
    # and the first that stretches.
    beam = lobex.Beam.rectangular(
        elements=24, length=0.2, width=0.05, thickness=0.004, young_modulus=110e9, density=4430.0
    )
    flap, stretch = (np.abs(beam.modes(0.01, range(1, 25), normal=way).shape[:, 0]) > 0.1 for way in (TANGENT, RADIAL))
    keep = np.sort(np.append(np.flatnonzero(flap)[:4], np.flatnonzero(stretch)[0])) + 1
    for speed, degrees, friction, expected in INCLINED:
        sine, cosine = np.sin(np.deg2rad(degrees)), np.cos(np.deg2rad(degrees))
        way = -1.0 if friction < 0 else 1.0
        modes = beam.modes(
            0.01,
            keep.tolist(),
            normal=(cosine, sine, 0.0),
            sliding=(-way * sine, way * cosine, 0.0),
            friction=abs(friction),
        )
        assert lobex.exact_limit(lobex.Rub(modes), speed).gain[0] == pytest.approx(expected, rel=1e-5)
