"""Wear marches of real blades: with friction, complex modes, several contacts, a flexible casing, a whole blading."""

from dataclasses import replace

import numpy as np
import pytest

import lobex
from real_blades import (
    CASING,
    EACH,
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
        pytest.param(TURNING, None, TURNING.at(SPEED), marks=pytest.mark.slow),
        pytest.param(TWO, None, TWO, marks=pytest.mark.slow),
        pytest.param(EACH, None, EACH, marks=pytest.mark.slow),
        (PLAIN, CASING, lobex.Modes.relative(tool=PLAIN, workpiece=CASING)),
    ],
    ids=["friction", "complex modes", "two contacts", "friction of each", "flexible casing"],
)
def test_growth_of_a_march_is_the_multiplier(marched, structure, delayed):
    stiffness = 1.02 * limit(delayed)
    march = in_permanent_contact(marched, stiffness, SPEED, 1024, structure=structure)
    assert np.abs(grown(march)) == pytest.approx([multiplier(delayed, stiffness, SPEED, 1024)], rel=1e-4)
    assert np.max(np.abs(march.energy_error)) < 1e-6


@pytest.mark.slow
def test_contacts_have_laws_of_several_kinds():
    """What is linear by another name is marched as linear, each contact on its own profile."""
    casings = [BUMPS, lobex.Casing(3, amplitude=3e-5)]
    marches = [
        lobex.march_wear(EACH, casings, laws, SPEEDS, 3, 960, samples_per_revolution=16)
        for laws in (
            [lobex.Linear(1e6), lobex.Linear(2e6)],
            [lobex.Bilinear(1e6, 1e6, 2e-5), lobex.Linear(2e6)],
            [lobex.Linear(1e6), lobex.KelvinVoigt(2e6, 0.0)],
            [lobex.Linear(1e6), lobex.Plastic(2e6, 1.0)],
        )
    ]
    plain, *same, other = marches
    assert np.all(plain.force.max(axis=2) > 0)
    for march in same:
        for name in ("depth", "force", "displacement", "friction_energy"):
            expected = getattr(plain, name)
            assert getattr(march, name) == pytest.approx(expected, rel=1e-8, abs=1e-9 * np.max(np.abs(expected))), name
    assert np.max(np.abs(other.depth[:, 1] - plain.depth[:, 1])) > 1e-6
    assert other.of(1).model["law"]["type"] == "Plastic"


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


@pytest.mark.slow
def test_growth_of_blades_coupled_through_the_disc_is_the_multiplier():
    blading = replace(MISTUNED, coupling=60.0)
    steps, stiffness = 1024, 0.5 * limit(PLAIN, 4 * SPEED)
    march = in_permanent_contact(blading, stiffness, SPEED, steps, incursion=4e-5)
    expected = multiplier(blading, stiffness, SPEED, steps, 4)
    assert np.abs(grown(march)) == pytest.approx([expected], rel=1e-4)
    alone = family_multiplier(PLAIN, MISTUNED.mistuning, stiffness, SPEED, steps)
    assert abs(expected / alone - 1) > 5e-3


POINTS = 6
"""Of each kind, times five kinds."""


@pytest.mark.search
@pytest.mark.parametrize("seed", range(POINTS))
@pytest.mark.parametrize("kind", ["friction", "complex modes", "two contacts", "flexible casing", "blading"])
def test_growth_at_random_points_is_the_multiplier(kind, seed):
    """Of two numbers of steps, since what is left of the step is of its second order."""
    random = np.random.default_rng([seed, len(kind)])
    omega = np.sort(random.uniform(1500.0, 4000.0, 2)) * [1.0, 1.3]
    seen = random.uniform(0.3, 1.0, (2, 2)) * random.choice([-1.0, 1.0], (2, 2))
    two = lobex.Modes(omega, random.uniform(0.01, 0.05, 2), seen)
    one = lobex.Modes(two.angular_frequency, two.damping_ratio, seen[:, :1])
    speed, structure, passes = random.uniform(70.0, 130.0), None, 1
    marched = {
        "friction": two.in_contact((1, 0), (0, random.choice([-1, 1])), random.uniform(0.05, 0.3)),
        "complex modes": replace(
            one,
            force_shape=seen[:, :1],
            quadrature=0.2 * seen[:, 1:],
            force_quadrature=-0.2 * seen[:, 1:],
        ),
        "two contacts": two,
        "flexible casing": one,
        "blading": lobex.Blading(one, 3, mistuning=random.uniform(-0.02, 0.02, 3)),
    }[kind]
    delayed = marched
    if kind == "flexible casing":
        structure = lobex.Modes([random.uniform(2000.0, 5000.0)], [0.02], [[random.uniform(0.2, 0.8)]])
        delayed = lobex.Modes.relative(tool=one, workpiece=structure)
    if kind == "blading":
        passes = 3
    share = random.uniform(0.9, 1.03)
    stiffness = share * float(lobex.exact_limit(lobex.Rub(delayed), [speed]).gain[0])
    found = []
    for steps in (1024, 2048):
        march = in_permanent_contact(marched, stiffness, speed, steps, 60, structure)
        found.append(np.abs(grown(march))[0] / multiplier(delayed, stiffness, speed, steps, passes) - 1)
    assert abs((4 * found[1] - found[0]) / 3) < 1e-4


# --- energy

RING = lobex.Ring([2], [330.0], [0.02], [3.0])
BUMPS = lobex.Casing(amplitude=5e-5)
# Four blades begin between as many bumps, and are not pushed at once.
FOUR = lobex.Casing(4, amplitude=5e-5)
SPEEDS = np.linspace(70, 100, 4)


def balanced(modes, casing, law, steps, speed=SPEEDS, **options):
    """What the balance of a march of eight revolutions leaves open, root mean square over its lanes."""
    march = lobex.march_wear(modes, casing, law, speed, 8, steps, samples_per_revolution=16, **options)
    assert np.all(march.input_energy.reshape(4, -1).sum(axis=1) > 0)
    return float(np.sqrt(np.mean(march.energy_error**2)))


def test_the_energy_of_friction_closes():
    assert balanced(RUBBING, BUMPS, lobex.Linear(1e6), 2400) < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize(
    ("modes", "casing", "law", "options"),
    [
        (TURNING, BUMPS, lobex.Linear(1e6), {}),
        (TURNING, BUMPS, lobex.Linear(1e6), {"speed": SPEEDS[:, None] * np.linspace(1, 1.05, 8)}),
        (TWO, BUMPS, lobex.Linear(1e6), {"tracks": (0, 0), "angles_degrees": (0.0, 6.0)}),
        (PLAIN, replace(BUMPS, structure=CASING), lobex.Linear(1e6), {}),
        (MISTUNED, replace(FOUR, structure=RING), lobex.Linear(1e6), {}),
        (replace(MISTUNED, coupling=60.0), FOUR, lobex.Linear(1e6), {}),
        (PLAIN, BUMPS, lobex.KelvinVoigt(1e6, 20.0), {}),
        (PLAIN, BUMPS, lobex.Bilinear(1e6, 3e6, 1e-5), {}),
    ],
    ids=["complex", "ramp", "one track", "casing", "blading on a ring", "coupled", "rate", "bilinear"],
)
def test_the_energy_balance_closes_with_the_square_of_the_step(modes, casing, law, options):
    coarse, fine = (balanced(modes, casing, law, steps, **options) for steps in (2400, 4800))
    assert coarse / fine == pytest.approx(4, rel=0.15)
    assert fine < 1e-6


def test_what_friction_takes_is_what_goes_beyond_the_normal():
    """Of one mode, pushed along 0.3 and seen along 1.2, all motions are one: F (0.3 − 1.2) against 0.3 F."""
    modes = lobex.Modes([2000.0], [0.03], [[1.2]], [[0.3]])
    march = lobex.march_wear(modes, BUMPS, lobex.Linear(1e6), SPEEDS, 3, 2048)
    taken = march.removal_energy - march.input_energy
    assert march.friction_energy == pytest.approx(-3 * taken, rel=5e-4, abs=1e-6 * np.max(np.abs(taken)))
    assert np.all(np.abs(taken) > 0)


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
