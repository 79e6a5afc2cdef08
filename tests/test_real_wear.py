"""Wear marches of real blades: with friction, complex modes, several contacts, a flexible casing, a whole blading."""

from dataclasses import replace

import numpy as np
import pytest

import lobex
from real_blades import (
    CASING,
    PLAIN,
    RUBBING,
    TURNING,
    TWO,
    family_multiplier,
    grown,
    in_permanent_contact,
    multiplier,
    ring_multiplier,
    viscous_multiplier,
)

SPEED = 85.0
MISTUNED = lobex.Blading(PLAIN, 4, mistuning=[0.0, 0.02, -0.01, 0.01])


def limit(modes, speed=SPEED):
    return float(lobex.exact_limit(lobex.Rub(modes), [speed]).gain[0])


@pytest.mark.parametrize(
    ("marched", "structure", "delayed"),
    [
        (RUBBING, None, RUBBING),
        (TURNING, None, TURNING.at(SPEED)),
        (TWO, None, TWO),
        (PLAIN, CASING, lobex.Modes.relative(tool=PLAIN, workpiece=CASING)),
    ],
    ids=["friction", "complex modes", "two contacts", "flexible casing"],
)
def test_growth_of_a_march_is_the_multiplier(marched, structure, delayed):
    stiffness = 1.02 * limit(delayed)
    march = in_permanent_contact(marched, stiffness, SPEED, 1024, structure=structure)
    assert np.abs(grown(march)) == pytest.approx([multiplier(delayed, stiffness, SPEED, 1024)], rel=1e-4)
    assert np.max(np.abs(march.energy_error)) < 1e-6


def test_growth_of_blades_in_one_track_is_the_multiplier():
    stiffness = 0.5 * limit(PLAIN, 4 * SPEED)
    march = in_permanent_contact(MISTUNED, stiffness, SPEED, 1024, incursion=4e-5)
    expected = family_multiplier(PLAIN, MISTUNED.mistuning, stiffness, SPEED, 1024)
    assert np.abs(grown(march)) == pytest.approx([expected], rel=1e-4)
    assert np.max(np.abs(march.energy_error)) < 1e-5


def test_growth_of_blades_on_a_ring_is_the_multiplier():
    """Its waves go past them, and each blade meets what the others do to it."""
    ring = lobex.Ring([2], [330.0], [0.02], [0.8])
    stiffness = 0.35 * limit(PLAIN, 4 * SPEED)
    march = in_permanent_contact(MISTUNED, stiffness, SPEED, 1024, 80, ring, incursion=4e-5)
    expected, rigid = (
        ring_multiplier(PLAIN, MISTUNED.mistuning, casing, stiffness, SPEED, 1024)
        for casing in (ring, replace(ring, mass=[3e6]))
    )
    assert np.abs(grown(march)) == pytest.approx([expected], rel=1e-4)
    assert abs(expected / rigid - 1) > 1e-3
    assert np.max(march.casing_amplitude) > 1e-9


def test_growth_under_a_law_that_follows_the_rate_is_the_multiplier():
    law = lobex.KelvinVoigt(1.3 * limit(RUBBING), viscosity=15.0)
    march = in_permanent_contact(RUBBING, law, SPEED, 1024)
    expected = viscous_multiplier(RUBBING, law, SPEED, 1024)
    # What the rate takes makes the difference.
    assert abs(expected / viscous_multiplier(RUBBING, replace(law, viscosity=0.0), SPEED, 1024) - 1) > 1e-2
    assert np.abs(grown(march)) == pytest.approx([expected], rel=1e-4)


# --- symmetries


def bumpy(steps, turned=0):
    """A casing of your own with a single bump, turned by so many cells."""
    place = np.arange(steps)
    bump = -5e-5 * np.where((place > 60) & (place < 110), np.sin(np.pi * (place - 60) / 50) ** 2, 0) + 1e-6
    return lobex.Casing(surface=np.roll(bump, turned))


def test_blades_turned_by_one_pitch_wear_the_casing_turned():
    """Blade j in the place of blade j + 1, before a casing that is turned along."""
    steps, pitch = 480, 120
    plain, turned = (
        lobex.march_wear(
            MISTUNED if shift == 0 else rolled(), bumpy(steps, shift), lobex.Linear(1e6), [60.0, 85.0], 3, steps
        )
        for shift in (0, pitch)
    )
    assert turned.depth == pytest.approx(np.roll(plain.depth, pitch, axis=2), rel=1e-12, abs=1e-20)
    assert np.max(plain.depth) > 1e-6
    for name in ("amplitude", "force", "contact", "input_energy", "displacement"):
        moved = np.roll(getattr(plain, name), -1, axis=1)
        assert getattr(turned, name) == pytest.approx(moved, rel=1e-9, abs=1e-15), name
        assert np.any(np.abs(moved - getattr(plain, name)) > 1e-3 * np.max(np.abs(moved)))


def rolled():
    """The blading with each blade in the place of the one before it."""
    return replace(MISTUNED, mistuning=np.roll(MISTUNED.mistuning, -1))
