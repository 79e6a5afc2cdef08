"""Marches of whole stages in casings that give way: growth against the operator, energy, and turns by a pitch."""

from dataclasses import replace

import numpy as np
import pytest

import lobex
from real_blades import PLAIN
from stage_marches import growth, marched_growth, stiffness_of

SPEED, STEPS = 85.0, 1024
RING = lobex.Ring([2, 3], [330.0, 520.0], [0.02, 0.01], [0.8, 1.1])
# What goes round with the contacts, with a direction for each blade.
RIG = lobex.Modes([2600.0, 4100.0], [0.02, 0.02], [[0.3, 0.2, -0.3, 0.1], [0.2, -0.2, 0.2, 0.3]])
MISTUNED = lobex.Blading(PLAIN, 4, mistuning=[0.0, 0.02, -0.01, 0.01])
# Whole cells of 1024 and of 2048.
UNEVEN = np.array([228, 284, 270, 242]) * 360 / 1024
COUPLING = [60.0, 30.0]
KINDS = {
    "mistuned on a ring": (MISTUNED, RING),
    "mistuned on a rig": (MISTUNED, RIG),
    "uneven on a ring": (replace(MISTUNED, spacing=UNEVEN), RING),
    "coupled on a ring": (replace(MISTUNED, coupling=COUPLING), RING),
    "uneven and coupled on a rig": (replace(MISTUNED, spacing=UNEVEN, coupling=COUPLING), RIG),
}
# On the boundary of stability, to a thousandth or two.
STIFFNESS = dict(zip(KINDS, (2.03e5, 2.87e5, 2.17e5, 2.17e5, 3.0e5), strict=True))
SLOW = pytest.mark.slow


@SLOW
@pytest.mark.parametrize("kind", KINDS)
def test_growth_of_a_stage_is_the_multiplier(kind):
    blading, casing = KINDS[kind]
    stiffness = STIFFNESS[kind]
    expected, rigid = (growth(blading, one, stiffness, SPEED, STEPS) for one in (casing, None))
    found = marched_growth(blading, casing, stiffness, SPEED, STEPS, 60)
    assert found == pytest.approx(expected, rel=1e-4)
    assert expected == pytest.approx(1.0, abs=3e-3)
    # The casing makes a difference.
    assert abs(rigid / expected - 1) > 5e-3


POINTS = 6
"""Of each kind, times five kinds."""


@pytest.mark.search
@pytest.mark.parametrize("seed", range(POINTS))
@pytest.mark.parametrize("kind", KINDS)
def test_growth_of_random_stages_is_the_multiplier(kind, seed):
    """Of two numbers of steps, since what is left of the step is of its second order."""
    random = np.random.default_rng([seed, list(KINDS).index(kind)])
    omega = np.sort(random.uniform(1500.0, 4000.0, 2)) * [1.0, 1.3]
    blade = lobex.Modes(omega, random.uniform(0.01, 0.04, 2), random.uniform(0.4, 1.0, (2, 1)))
    given, casing = KINDS[kind]
    blading = replace(given, blade=blade, mistuning=random.uniform(-0.03, 0.03, 4))
    if blading.spacing is not None:
        places = np.sort(256 * np.arange(1, 4) + random.integers(-40, 41, 3))
        blading = replace(blading, spacing=np.diff(places, prepend=0, append=1024) * 360 / 1024)
    if blading.coupling is not None:
        blading = replace(blading, coupling=random.uniform(20.0, 80.0, 2))
    if casing is RING:
        mass = random.uniform(0.6, 3.0, 2)
        casing = lobex.Ring([2, 3], random.uniform(250.0, 600.0, 2), random.uniform(0.01, 0.03, 2), mass)
    else:
        casing = replace(
            RIG, angular_frequency=random.uniform(2000.0, 5000.0, 2), shape=random.uniform(-0.4, 0.4, (2, 4))
        )
    speed = random.uniform(70.0, 130.0)
    wanted = random.uniform(0.95, 1.03)
    stiffness = stiffness_of(blading, casing, speed, STEPS, wanted)
    # So many that another multiplier, of a wave that blades hardly see, has died out, and that no contact is lost yet.
    revolutions = min(150, int(np.log(15) / max(np.log(wanted), 1e-3)))
    off = []
    for steps in (STEPS, 2 * STEPS):
        found = marched_growth(blading, casing, stiffness, speed, steps, revolutions)
        off.append(found / growth(blading, casing, stiffness, speed, steps) - 1)
    assert abs((4 * off[1] - off[0]) / 3) < 1e-4


BUMPS = lobex.Casing(4, amplitude=5e-5)
SPEEDS = np.linspace(70, 100, 4)


def balanced(kind, steps):
    """What the balance of eight revolutions leaves open, root mean square over the lanes."""
    blading, casing = KINDS[kind]
    coated = replace(BUMPS, structure=casing)
    march = lobex.march_wear(blading, coated, lobex.Linear(1e6), SPEEDS, 8, steps, samples_per_revolution=16)
    assert np.all(march.input_energy.reshape(4, -1).sum(axis=1) > 0)
    assert np.all(march.casing_amplitude.reshape(4, -1).max(axis=1) > 1e-7)
    return float(np.sqrt(np.mean(march.energy_error**2)))


@pytest.mark.parametrize("kind", ["coupled on a ring", *(pytest.param(kind, marks=SLOW) for kind in list(KINDS)[:3])])
def test_the_energy_balance_of_a_stage_closes_with_the_square_of_the_step(kind):
    coarse, fine = (balanced(kind, steps) for steps in (2400, 4800))
    assert coarse / fine == pytest.approx(4, rel=0.15)
    assert fine < 1e-6


# Of modes that are complex, as those of blades that turn: what springs between them pull at turns with the modes.
TURNED = lobex.Blading(
    replace(PLAIN, force_shape=PLAIN.shape, quadrature=[[0.2], [-0.1]], force_quadrature=[[-0.2], [0.1]]),
    4,
    mistuning=[0.0, 0.02, -0.01, 0.01],
    coupling=COUPLING,
)


@pytest.mark.slow
def test_growth_of_coupled_complex_modes_is_the_multiplier():
    stiffness = stiffness_of(TURNED, None, SPEED, STEPS, 0.99)
    found = [
        marched_growth(TURNED, None, stiffness, SPEED, steps, 60) / growth(TURNED, None, stiffness, SPEED, steps) - 1
        for steps in (STEPS, 2 * STEPS)
    ]
    assert abs((4 * found[1] - found[0]) / 3) < 1e-5


@pytest.mark.parametrize("law", [lobex.Linear(2e5), pytest.param(lobex.KelvinVoigt(2e5, 20.0), marks=SLOW)])
def test_the_energy_balance_of_coupled_complex_modes_closes_with_the_square_of_the_step(law):
    coarse, fine = (
        np.max(np.abs(lobex.march_wear(TURNED, BUMPS, law, [80.0], 4, steps, samples_per_revolution=16).energy_error))
        for steps in (2048, 4096)
    )
    assert coarse / fine == pytest.approx(4, rel=0.15)
    assert fine < 1e-6


def test_energies_of_a_ring_are_those_of_one_contact_whatever_blades_there_are():
    """Of one blade that is a stage, and of one that is none."""
    law, casing = lobex.Linear(1e6), lobex.Casing(1, amplitude=5e-5, structure=RING)
    one, stage = (
        lobex.march_wear(modes, casing, law, [SPEED], 3, STEPS, samples_per_revolution=16)
        for modes in (PLAIN, lobex.Blading(PLAIN, 1))
    )
    assert np.max(one.stored_energy) > 1e-6
    for name in ("stored_energy", "damping_energy", "input_energy"):
        assert getattr(stage, name) == pytest.approx(getattr(one, name), rel=1e-9), name


def turned_march(blading, casing, steps, pitches):
    """Every blade that many places on, before a casing with a single bump that is turned along."""
    place = np.arange(steps) / steps
    bump = -5e-5 * np.where((place > 0.125) & (place < 0.23), np.sin(np.pi * (place - 0.125) / 0.105) ** 2, 0) + 1e-6
    surface = np.roll(bump, pitches * steps // 4)
    turned = replace(blading, mistuning=np.roll(blading.mistuning, -pitches))
    coated = lobex.Casing(surface=surface, structure=casing)
    march = lobex.march_wear(turned, coated, lobex.Linear(1e6), [60.0, 85.0], 3, steps, samples_per_revolution=480)
    return {
        "depth": np.roll(march.depth, -pitches * steps // 4, axis=2),
        **{name: np.roll(getattr(march, name), pitches, axis=1) for name in ("amplitude", "force", "displacement")},
    }


@pytest.mark.slow
def test_a_stage_turned_by_one_pitch_wears_the_casing_turned():
    """Up to the square of the step: what a wave is told as goes by where the first blade stands."""
    blading, ring = KINDS["coupled on a ring"]
    off = {}
    for steps in (960, 3840):
        plain, turned = (turned_march(blading, ring, steps, pitches) for pitches in (0, 1))
        for name, one in plain.items():
            off[name, steps] = np.linalg.norm(turned[name] - one) / np.linalg.norm(one)
    # Where contacts begin and end goes by whole steps.
    for name in plain:
        assert off[name, 3840] < 2e-5, name
        assert off[name, 960] / off[name, 3840] > 10, name
    # Of half the turn a wave of two nodal diameters is the same, and one of three is with its sign.
    half = turned_march(blading, ring, 960, 2)
    for name, one in turned_march(blading, ring, 960, 0).items():
        assert half[name] == pytest.approx(one, rel=1e-9, abs=1e-9 * np.max(np.abs(one))), name
