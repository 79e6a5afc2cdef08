"""Blades of a stage in a casing that gives way, against the determinant of their receptances and each other."""

from dataclasses import replace

import jax
import numpy as np
import pytest

import lobex
from real_blades import PLAIN, receptance
from refusals import refused

SPEED = 85.0
RING = lobex.Ring([2, 3], [330.0, 520.0], [0.02, 0.01], [0.8, 1.1])
SHARES = np.array([0.0, 0.02, -0.01, 0.01])
GAPS = [80.0, 100.0, 95.0, 85.0]
TUNED = lobex.Blading(PLAIN, 4)
KINDS = {
    "tuned": TUNED,
    "mistuned": replace(TUNED, mistuning=SHARES),
    "mistuned, uneven": replace(TUNED, mistuning=SHARES, spacing=GAPS),
    "tuned, coupled": replace(TUNED, coupling=60.0),
    "mistuned, coupled": replace(TUNED, mistuning=SHARES, coupling=[60.0, 30.0]),
    "coupled, uneven": replace(TUNED, coupling=[60.0, 30.0], spacing=GAPS),
}


def determinant(blading, ring, stiffness, speed, s):
    """det(I + K G (I − P)) of blades on a ring, with G of both and P from each blade to the one before it."""
    blades = blading.count
    gaps = np.full(blades, 1 / blades) if blading.spacing is None else np.asarray(blading.spacing) / 360
    angle = -2 * np.pi * np.append(0.0, np.cumsum(gaps[1:]))
    apart = angle[:, None] - angle
    own = np.zeros((blades, blades), dtype=complex)
    shares = np.zeros(blades) if blading.mistuning is None else np.asarray(blading.mistuning)
    modes = blading.blade
    springs = np.broadcast_to(0.0 if blading.coupling is None else 2 * np.pi * np.asarray(blading.coupling), (2,)) ** 2
    around = 2 * np.eye(blades) - np.roll(np.eye(blades), 1, axis=0) - np.roll(np.eye(blades), -1, axis=0)
    for omega, ratio, shape, spring in zip(
        modes.angular_frequency, modes.damping_ratio, modes.shape[:, 0], springs, strict=True
    ):
        each = omega * (1 + shares)
        own += shape**2 * np.linalg.inv(np.diag(s**2 + 2 * ratio * each * s + each**2) + spring * around)
    for waves, frequency, ratio, mass in zip(
        ring.nodal_diameter, ring.frequency, ring.damping_ratio, ring.mass, strict=True
    ):
        for way in (1, -1):
            z, omega = s - way * 2j * np.pi * waves * speed, 2 * np.pi * frequency
            own += np.exp(way * 1j * waves * apart) / (z**2 + 2 * ratio * omega * z + omega**2) / (2 * mass)
    before = np.roll(np.eye(blades), 1, axis=0) * np.exp(-s * gaps / speed)[:, None]
    return np.linalg.det(np.eye(blades) + stiffness * own @ (np.eye(blades) - before))


def root_beside(blading, ring, stiffness, speed, s):
    """The root of the determinant that Newton's iteration comes to."""
    for _ in range(20):
        value, ahead, behind = (determinant(blading, ring, stiffness, speed, s + step) for step in (0, 1e-4, -1e-4))
        s = s - value * 2e-4 / (ahead - behind)
    return s


def dominant(rub, speed, gain):
    """s of the dominant multiplier."""
    chart = lobex.sweep(rub, [speed], [gain], lobex.Duhamel())
    period = float(rub.system(speed, gain).period)
    rate = np.log(np.abs(chart.multiplier[0, 0])) / period
    return rate + 2j * np.pi * chart.chatter_frequency[0, 0]


SLOW = pytest.mark.slow


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["mistuned, uneven", "tuned", "mistuned", "tuned, coupled", "mistuned, coupled"])
def test_dominant_multipliers_are_roots_of_the_determinant(kind):
    blading = KINDS[kind]
    rub = lobex.Rub(blading, casing=RING)
    s = dominant(rub, SPEED, 2e5)
    root = root_beside(blading, RING, 2e5, SPEED, s)
    assert s == pytest.approx(root, rel=1e-8)
    # The casing makes a difference.
    assert abs(root_beside(blading, replace(RING, mass=[1e9, 1e9]), 2e5, SPEED, s) / root - 1) > 1e-4
    # So it does where a wave stands still before the blades.
    still = 165.0 * np.sqrt(1 - 0.02**2)
    s = dominant(rub, still, 2e5)
    assert s == pytest.approx(root_beside(blading, RING, 2e5, still, s), rel=1e-8)


SPEEDS = np.array([61.0, 85.0, 103.0])
SHARE = np.array([0.05, 0.35, 0.7, 0.9, 0.9999, 1.0001])


@pytest.mark.parametrize("casing", [RING, None], ids=["on a ring", "rigid"])
@pytest.mark.parametrize("kind", ["mistuned", "mistuned, uneven", "mistuned, coupled", "coupled, uneven"])
def test_stages_of_any_kind_have_an_exact_limit(kind, casing):
    blading = KINDS[kind]
    limit = lobex.exact_limit(lobex.Rub(blading, casing=casing), SPEEDS)
    assert list(limit.status) == ["found"] * 3
    ring = replace(RING, mass=[1e30, 1e30]) if casing is None else casing
    for speed, gain, frequency in zip(limit.speed, limit.gain, limit.chatter_frequency, strict=True):
        s = 2j * np.pi * frequency
        assert root_beside(blading, ring, gain, speed, s) == pytest.approx(s, rel=1e-11)
    assert np.all((limit.mode >= 1) & (limit.mode <= 6))
    assert np.all(limit.nodal_diameter == -1)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["mistuned, uneven", "mistuned, coupled"])
def test_below_the_exact_limit_a_stage_is_stable(kind):
    rub = lobex.Rub(KINDS[kind], casing=RING)
    limit = lobex.exact_limit(rub, SPEEDS[1:2])
    radius = lobex.sweep(rub, SPEEDS[1:2], SHARE * limit.gain[0], lobex.Duhamel()).spectral_radius[0]
    assert np.all(radius[:-1] < 1)
    assert radius[-1] > 1


# Far below the limit multipliers may lie so near to each other that their errors are said.
@pytest.mark.filterwarnings("ignore::lobex.SweepWarning")
@pytest.mark.search
@pytest.mark.parametrize("seed", range(20))
def test_exact_limits_of_random_stages_are_the_first_of_all(seed):
    random = np.random.default_rng(seed)
    modes, count, waves = int(random.integers(1, 3)), int(random.integers(2, 7)), int(random.integers(1, 3))
    frequency = np.sort(random.uniform(200, 1000, modes))
    blade = lobex.Modes.from_table(frequency, random.uniform(0.003, 0.05), mass=random.uniform(0.05, 0.5, modes))
    gaps = 1 + random.uniform(-0.3, 0.3, count) if random.random() < 0.5 else np.ones(count)
    stage = lobex.Blading(
        blade,
        count,
        mistuning=10 ** random.uniform(-3, -1) * random.uniform(-1, 1, count),
        spacing=None if np.all(gaps == 1) else 360 * gaps / np.sum(gaps),
        coupling=random.uniform(10.0, 100.0) if random.random() < 0.5 else None,
    )
    numbers = random.uniform(200, 1500, waves), random.uniform(0.005, 0.05, waves), random.uniform(0.2, 4.0, waves)
    ring = lobex.Ring(random.integers(0, 6, waves), *numbers) if random.random() < 0.7 else None
    rub = lobex.Rub(stage, casing=ring)
    speed = float(random.uniform(0.1, 0.5) * frequency[0])
    limit = lobex.exact_limit(rub, speed)
    assert limit.status[0] == "found"
    radius = lobex.sweep(rub, [speed], SHARE * limit.gain[0], lobex.Duhamel()).spectral_radius[0]
    assert np.all(radius[:-1] < 1)
    assert radius[-1] > 1


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["tuned", "tuned, coupled"])
def test_equal_blades_have_an_exact_limit_by_the_waves_that_they_move_in(kind):
    blading = KINDS[kind]
    rub = lobex.Rub(blading, casing=RING)
    # At the last of these a wave stands still before the blades.
    limit = lobex.exact_limit(rub, np.append(SPEEDS, 165.0 * np.sqrt(1 - 0.02**2)))
    assert list(limit.status) == ["found"] * 4
    for speed, gain, frequency in zip(limit.speed, limit.gain, limit.chatter_frequency, strict=True):
        s = 2j * np.pi * frequency
        assert root_beside(blading, RING, gain, speed, s) == pytest.approx(s, rel=1e-11)
    # Stable below, and not above: no other root comes before.
    radius = lobex.sweep(rub, SPEEDS[1:2], SHARE * limit.gain[1], lobex.Duhamel()).spectral_radius[0]
    assert np.all(radius[:-1] < 1)
    assert radius[-1] > 1
    assert np.all((limit.nodal_diameter >= 0) & (limit.nodal_diameter < 4))
    assert np.all((limit.mode >= 1) & (limit.mode <= 6))
    apart = lobex.exact_limit(lobex.Rub(blading), SPEEDS).gain
    assert np.all(np.abs(limit.gain[:3] / apart - 1) > 1e-3)


@pytest.mark.slow
def test_one_blade_of_a_stage_is_a_blade():
    one = lobex.exact_limit(lobex.Rub(PLAIN, casing=RING), SPEEDS)
    same = lobex.exact_limit(lobex.Rub(lobex.Blading(PLAIN, 1), casing=RING), SPEEDS)
    np.testing.assert_allclose(same.gain, one.gain, rtol=1e-11)
    np.testing.assert_allclose(same.chatter_frequency, one.chatter_frequency, rtol=1e-11)


@pytest.mark.slow
def test_a_stiff_casing_is_a_rigid_one_to_the_first_order():
    rigid = lobex.exact_limit(lobex.Rub(TUNED), [SPEED]).gain
    apart = [
        lobex.exact_limit(lobex.Rub(TUNED, casing=replace(RING, mass=mass)), [SPEED]).gain - rigid
        for mass in (1e4, 2e4)
    ]
    assert apart[0] / apart[1] == pytest.approx([2.0], rel=1e-2)
    mistuned = KINDS["mistuned"]
    still = lobex.spectral_radius(lobex.Rub(mistuned, casing=replace(RING, mass=1e12)), SPEED, 2e5)
    assert still == pytest.approx(lobex.spectral_radius(lobex.Rub(mistuned), SPEED, 2e5), rel=1e-8)


@pytest.mark.slow
def test_a_stage_in_a_casing_looks_the_same_from_every_blade():
    """Blade j in the place of blade j + 1, which a casing of whole waves does not tell from it."""
    blading = KINDS["mistuned, uneven"]
    turned = replace(blading, mistuning=np.roll(SHARES, -1), spacing=np.roll(GAPS, -1))
    own, same, other = (
        lobex.spectral_radius(lobex.Rub(one, casing=RING), SPEED, 2e5)
        for one in (blading, turned, replace(turned, spacing=GAPS))
    )
    assert same == pytest.approx(own, rel=1e-9)
    assert abs(other / own - 1) > 1e-6


@pytest.mark.slow
def test_mistuning_that_vanishes_leaves_the_limit_of_equal_blades():
    """Found by the waves that equal blades move in, and by all of them together: to the square of what adds to zero."""
    exact, none, some, less = (
        lobex.exact_limit(lobex.Rub(replace(TUNED, mistuning=size * shares), casing=RING), [SPEED]).gain[0]
        for shares in [np.array([1.0, -2.0, 0.5, 0.5])]
        for size in (0.0, 1e-9, 1e-3, 5e-4)
    )
    assert none == pytest.approx(exact, rel=1e-9)
    assert (some - exact) / (less - exact) == pytest.approx(4.0, rel=0.02)


@pytest.mark.slow
def test_gradients_of_a_stage_without_symmetry_are_those_of_differences():
    def gain(numbers):
        stage = replace(KINDS["mistuned, uneven"], mistuning=numbers["mistuning"], spacing=numbers["spacing"])
        ring = replace(RING, frequency=numbers["frequency"])
        return lobex.exact_limit(lobex.Rub(stage, casing=ring), numbers["speed"]).gain[0]

    at = {"mistuning": SHARES, "spacing": np.array(GAPS), "frequency": np.array([330.0, 520.0]), "speed": [SPEED]}
    at = {name: np.asarray(value) for name, value in at.items()}
    with jax.enable_x64(True):
        slope = jax.tree.map(np.asarray, jax.grad(gain)(at))
    for name, step in (("mistuning", 1e-7), ("spacing", 1e-5), ("frequency", 1e-3), ("speed", 1e-4)):
        for k in range(len(at[name])):
            # Of angles that make a turn.
            unit = np.roll([1.0, -1.0, 0, 0], k) if name == "spacing" else 1.0 * (np.arange(len(at[name])) == k)
            ends = [gain({**at, name: at[name] + sign * step * unit}) for sign in (1, -1)]
            assert slope[name] @ unit == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=2e-5), name


@pytest.mark.slow
def test_gradients_by_the_casing_and_the_blades_are_those_of_differences():
    def gain(numbers):
        ring = replace(RING, frequency=numbers["frequency"], mass=numbers["mass"])
        blade = replace(PLAIN, damping_ratio=numbers["ratio"])
        blading = lobex.Blading(blade, 4, mistuning=numbers["mistuning"])
        return lobex.exact_limit(lobex.Rub(blading, casing=ring), numbers["speed"]).gain[0]

    at = {
        "frequency": np.array([330.0, 520.0]),
        "mass": np.array([0.8, 1.1]),
        "ratio": np.array([0.03, 0.02]),
        "mistuning": np.zeros(4),
        "speed": np.array([SPEED]),
    }
    with jax.enable_x64(True):
        slope = jax.grad(gain)(at)
    steps = {"frequency": 1e-3, "mass": 1e-5, "ratio": 1e-7, "speed": 1e-4}
    for name, step in steps.items():
        for k in range(len(at[name])):
            unit = step * (np.arange(len(at[name])) == k)
            ends = [gain({**at, name: at[name] + sign * unit}) for sign in (1, -1)]
            assert slope[name][k] == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=2e-5, abs=1e-3), name
    # Of all blades together; of one alone it is its share.
    ends = [gain({**at, "mistuning": np.full(4, sign * 1e-7)}) for sign in (1, -1)]
    np.testing.assert_allclose(slope["mistuning"], (ends[0] - ends[1]) / 8e-7, rtol=1e-5)


def test_what_turns_with_a_stage_has_a_direction_for_each_blade():
    rig = lobex.Modes([3000.0], [0.02], np.ones((1, 4)))
    assert lobex.Rub(TUNED, casing=rig).system(SPEED, 1e5).output_size == 4
    with refused("modes has 4 contact directions and casing 1"):
        lobex.Rub(TUNED, casing=lobex.Modes([3000.0], [0.02], [[1.0]]))


def test_several_contacts_of_one_tip_meet_the_ring_at_one_place():
    two = lobex.Modes([2000.0, 3300.0], [0.03, 0.02], [[1.0, 1.0], [0.5, 0.5]])
    limit = lobex.exact_limit(lobex.Rub(two, casing=RING), [SPEED]).gain
    # Alike, they are one of twice the stiffness.
    assert 2 * limit == pytest.approx(lobex.exact_limit(lobex.Rub(PLAIN, casing=RING), [SPEED]).gain, rel=1e-10)


def test_the_oracle_is_the_receptance_of_the_blades():
    s = 30.0 + 1900j
    rigid = replace(RING, mass=[1e30, 1e30])
    expected = np.prod([1 + 1e5 * receptance(PLAIN, np.array([s]), 1 + share)[0] for share in SHARES]) - np.exp(
        -s / SPEED
    ) * np.prod([1e5 * receptance(PLAIN, np.array([s]), 1 + share)[0] for share in SHARES])
    assert determinant(KINDS["mistuned"], rigid, 1e5, SPEED, s) == pytest.approx(expected, rel=1e-10)
