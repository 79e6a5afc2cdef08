"""The waves of a ring as several contacts meet them, against its receptance in their frame."""

import numpy as np
import pytest

import lobex
from lobex.structures.ring_waves import RingWaves

ANGLE = np.array([0.0, 0.7, 2.1])
SPEED = 37.0


def of_modes(modes, s):
    """G(s) of all contacts, from the states of complex modes as ``Modes`` defines them."""
    sides = (modes.shape, modes.loading, modes.quadrature, modes.force_quadrature)
    total = 0
    for omega, ratio, *shapes in zip(modes.angular_frequency, modes.damping_ratio, *sides, strict=True):
        seen, acting, seen_aside, acting_aside = shapes
        state = np.array([[0, omega], [-omega, -2 * ratio * omega]])
        pushed = np.stack([acting_aside, acting]) / omega
        total = total + np.stack([seen, seen_aside], axis=1) @ np.linalg.solve(s * np.eye(2) - state, pushed)
    return total


@pytest.mark.parametrize("s", [100 + 900j, 5 + 2400j])
def test_waves_have_the_rings_receptance(s):
    ring = lobex.Ring([0, 2, 3], [280.0, 300.0, 410.0], [0.03, 0.02, 0.01], [5.0, 3.0, 4.0])
    apart, expected = ANGLE[:, None] - ANGLE, 0
    for n, frequency, ratio, mass in zip(
        ring.nodal_diameter, ring.frequency, ring.damping_ratio, ring.mass, strict=True
    ):
        omega = 2 * np.pi * frequency
        waves = [
            np.exp(sign * 1j * n * apart)
            / ((z := s - sign * 2j * np.pi * n * SPEED) ** 2 + 2 * ratio * omega * z + omega**2)
            for sign in (1, -1)
        ]
        expected = expected + sum(waves) / (2 * mass)
    assert of_modes(RingWaves(ring, ANGLE).at(SPEED), s) == pytest.approx(expected, rel=1e-12, abs=1e-20)


def test_one_contact_meets_the_ring_itself():
    ring = lobex.Ring([2, 5], [300.0, 410.0], [0.02, 0.01], [3.0, 4.0])
    one, same = RingWaves(ring, np.zeros(1)).at(SPEED), ring.at(SPEED)
    assert one.angular_frequency == pytest.approx(same.angular_frequency, rel=1e-14)
    assert one.shape * one.loading == pytest.approx(same.shape * same.loading, rel=1e-13)
    assert np.all(one.quadrature == 0)
