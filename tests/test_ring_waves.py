"""The waves of a ring as several contacts meet them, against its receptance in their frame."""

import numpy as np
import pytest

import lobex
from lobex.structures.ring_waves import RingWaves
from receptance_of_modes import of_modes
from refusals import refused

ANGLE = np.array([0.0, 0.7, 2.1])
SPEED = 37.0
RING = lobex.Ring([0, 2, 3], [280.0, 300.0, 410.0], [0.03, 0.02, 0.01], [5.0, 3.0, 4.0])
# At which the backward wave of two nodal diameters stands still before the contacts.
STILL = 150.0 * np.sqrt(1 - 0.02**2)


def of_states(waves, s):
    """The same, from the states of the waves."""
    state, pushed, seen = waves.states()
    return np.sum(seen @ np.linalg.solve(s * np.eye(2) - state, pushed), axis=0)


def of_ring(s, speed):
    """G(s) of all contacts, from the ring's definition."""
    apart, total = ANGLE[:, None] - ANGLE, 0
    for n, frequency, ratio, mass in zip(
        RING.nodal_diameter, RING.frequency, RING.damping_ratio, RING.mass, strict=True
    ):
        omega = 2 * np.pi * frequency
        waves = [
            np.exp(sign * 1j * n * apart)
            / ((z := s - sign * 2j * np.pi * n * speed) ** 2 + 2 * ratio * omega * z + omega**2)
            for sign in (1, -1)
        ]
        total = total + sum(waves) / (2 * mass)
    return total


@pytest.mark.parametrize("s", [100 + 900j, 5 + 2400j])
def test_waves_have_the_rings_receptance(s):
    waves = RingWaves(RING, ANGLE)
    for found in (of_modes(waves.at(SPEED), s), of_states(waves.passing(SPEED), s)):
        assert found == pytest.approx(of_ring(s, SPEED), rel=1e-12, abs=1e-20)


@pytest.mark.parametrize("beside", [0.0, 1e-13, 1e-9, 1e-5])
def test_a_wave_that_stands_still_before_the_contacts_has_it_too(beside):
    speed = STILL * (1 + beside)
    waves = RingWaves(RING, ANGLE).passing(speed)
    assert np.min(np.abs(waves.rotation)) <= 2e-12 + beside * 2000
    for s in (100 + 900j, 3j):
        assert of_states(waves, s) == pytest.approx(of_ring(s, speed), rel=1e-12, abs=1e-20)


def test_a_wave_that_stands_still_is_refused_where_it_is_no_answer():
    free = lobex.Ring([2, 3], [300.0, 410.0], [0.0, 0.01], [3.0, 4.0])
    blade = lobex.Modes.single(frequency=400.0, damping_ratio=0.01, mass=1.0)
    for modes in (blade, lobex.Blading(blade, 3)):
        with refused("speed = 150 Hz lets the wave of 2 nodal diameters stand still, which has no damping"):
            lobex.exact_limit(lobex.Rub(modes, casing=free), [140.0, 150.0])
    casing = lobex.Casing(3, structure=RING)
    with refused("speed = 149.97 Hz lets the wave of 2 nodal diameters stand still before the blades"):
        lobex.march_wear(lobex.Blading(blade, 3), casing, lobex.Linear(1e5), [140.0, STILL], 2, 512)


def test_one_contact_meets_the_ring_itself():
    ring = lobex.Ring([2, 5], [300.0, 410.0], [0.02, 0.01], [3.0, 4.0])
    one, same = RingWaves(ring, np.zeros(1)).at(SPEED), ring.at(SPEED)
    assert one.angular_frequency == pytest.approx(same.angular_frequency, rel=1e-14)
    assert one.shape * one.loading == pytest.approx(same.shape * same.loading, rel=1e-13)
    assert np.all(one.quadrature == 0)
