"""Bladings and flexible casings: against reference numbers, closed forms, the operator, and each other."""

import jax
import numpy as np
import pytest

import lobex
from lobex.structures.blading import Blading
from refusals import refused

# A ring of six blades of one mode, by the characteristic equation and by collocation of the pencil.
ONE = lobex.Modes.single(frequency=400.0, damping_ratio=0.005, mass=1 / 9)
MISTUNING = [0.013, -0.021, 0.004, 0.017, -0.009, -0.004]
GAPS = [56.0, 64.0, 61.0, 59.0, 66.0, 54.0]
SPEED = [55.0, 70.0, 85.0, 110.0, 150.0]
LIMITS = {
    "tuned": [7192.802046, 7267.646076, 7245.387648, 7138.4757773, 7171.41996],
    "tuned, coupled": [7421.65403802, 7486.5473505, 7245.387649, 7272.006197, 7568.068657],
    "mistuned": [16214.010966, 16101.76412, 16082.105147, 16038.717039, 16042.61122],
}
CHATTER = {
    "tuned": [402.4327888, 401.560145, 401.5806695, 401.70836629, 401.6619612],
    "tuned, coupled": [419.370063511, 405.932218891, 401.5806695, 406.1118826, 414.7917119],
    "mistuned": [405.58311435, 402.9245597, 403.01108641, 403.46712218, 403.3321323],
}
RANDOM = np.random.default_rng(20)


def blading(kind, **others):
    mistuning = MISTUNING if "mistuned" in kind else None
    return lobex.Rub(lobex.Blading(ONE, 6, mistuning, coupling=60.0 if "coupled" in kind else None, **others))


@pytest.mark.parametrize("kind", LIMITS)
def test_rings_of_six_blades_have_the_reference_limits(kind):
    limit = lobex.exact_limit(blading(kind), SPEED)
    np.testing.assert_allclose(limit.gain, LIMITS[kind], rtol=5e-10)
    np.testing.assert_allclose(limit.chatter_frequency, CHATTER[kind], rtol=5e-10)
    # Of the file the wave is that of the multiplier with a positive imaginary part.
    waves = limit.nodal_diameter if kind == "mistuned" else np.array([3, 5, 0, 1, 2])
    turned = limit.chatter_frequency / SPEED % 1 < 0.5
    np.testing.assert_array_equal(limit.nodal_diameter, np.where(turned, waves, -waves % 6) if waves[0] > 0 else -1)


@pytest.mark.slow
def test_spacing_alone_changes_nothing_of_blades_that_are_not_coupled():
    for kind in ("tuned", "mistuned"):
        even, uneven = (lobex.exact_limit(blading(kind, spacing=gaps), SPEED).gain for gaps in (None, GAPS))
        np.testing.assert_allclose(uneven, even, rtol=1e-12)


def test_tuned_blades_behave_as_one_at_as_many_times_the_speed_among_the_waves_around_the_disc():
    rod = lobex.Rod(elements=5).modes(0.03)
    alone = lobex.exact_limit(lobex.Rub(rod), [4 * 85.0])
    stage = lobex.exact_limit(lobex.Rub(lobex.Blading(rod, 4)), [85.0])
    # That of no wave around the disc is one of four.
    assert stage.gain[0] <= alone.gain[0]
    one = lobex.exact_limit(lobex.Rub(lobex.Blading(rod, 1)), [340.0])
    np.testing.assert_allclose(one.gain, alone.gain, rtol=1e-12)


def test_two_per_cent_of_mistuning_raise_the_limit_of_four_rods_by_ten_per_cent():
    # At 85 Hz, with the first mode of the thesis' rod.
    rod = lobex.Rod(elements=5).modes(0.03).select([1])
    tuned, spread, even = (
        lobex.exact_limit(lobex.Rub(lobex.Blading(rod, 4, shares)), [85.0]).gain[0]
        for shares in (None, [-0.02, -0.007, 0.007, 0.02], np.linspace(-0.02, 0.02, 4))
    )
    assert tuned == pytest.approx(319_979, rel=1e-5)
    assert spread == pytest.approx(353_877, rel=1e-5)
    assert 1.10 < even / tuned < 1.11


@pytest.mark.slow
def test_limits_of_mistuned_blades_are_where_the_operator_has_its_multiplier_on_the_circle():
    blade = lobex.Modes.from_table([300.0, 700.0], 0.01, mass=[0.2, 0.3])
    rub = lobex.Rub(lobex.Blading(blade, 5, 0.05 * RANDOM.normal(size=5)))
    speed = RANDOM.uniform(40, 90)
    gain = float(lobex.exact_limit(rub, speed).gain[0])
    share = np.array([0.3, 0.9, 0.999, 1.001])
    radius = lobex.sweep(rub, [speed], share * gain, lobex.Duhamel()).spectral_radius[0]
    assert np.all(radius[:3] < 1)
    assert radius[3] > 1
    # Linear between the two beside it.
    assert np.interp(0.0, np.log(radius[2:]), share[2:]) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.search
@pytest.mark.parametrize("seed", range(20))
def test_limits_of_random_stages_are_the_first_of_all(seed):
    random = np.random.default_rng(seed)
    modes, count = int(random.integers(1, 4)), int(random.integers(2, 9))
    frequency = np.sort(random.uniform(200, 2000, modes))
    blade = lobex.Modes.from_table(frequency, random.uniform(0.002, 0.05), mass=random.uniform(0.05, 0.5, modes))
    spread = 10 ** random.uniform(-3, -0.7)
    rub = lobex.Rub(lobex.Blading(blade, count, np.clip(spread * random.normal(size=count), -0.5, 0.5)))
    speed = float(random.uniform(0.05, 0.5) * frequency[0])
    limit = lobex.exact_limit(rub, speed)
    assert limit.status[0] == "found"
    below = np.append(np.linspace(0.05, 0.95, 10), [0.9999, 1.0001]) * limit.gain[0]
    radius = lobex.sweep(rub, [speed], below, lobex.Duhamel()).spectral_radius[0]
    assert np.all(radius[:-1] < 1)
    assert radius[-1] > 1


def test_a_stage_looks_the_same_from_every_blade():
    expected = lobex.exact_limit(blading("mistuned"), SPEED).gain
    turned = lobex.Rub(lobex.Blading(ONE, 6, np.roll(MISTUNING, 2)))
    np.testing.assert_allclose(lobex.exact_limit(turned, SPEED).gain, expected, rtol=1e-12)


def test_stiffer_blades_of_other_masses_scale():
    base = lobex.exact_limit(blading("mistuned"), SPEED).gain
    other = lobex.Modes.single(frequency=800.0, damping_ratio=0.005, mass=1 / 9)
    scaled = lobex.exact_limit(lobex.Rub(lobex.Blading(other, 6, MISTUNING)), 2 * np.array(SPEED)).gain
    np.testing.assert_allclose(scaled, 4 * base, rtol=1e-11)


def test_mistuning_that_vanishes_leaves_the_tuned_limit():
    # Off a cusp between two waves the limit is smooth, and by symmetry moves with the square of what adds up to zero.
    tuned = lobex.exact_limit(blading("tuned"), [85.0]).gain[0]
    moved = [
        lobex.exact_limit(lobex.Rub(lobex.Blading(ONE, 6, size * np.array(MISTUNING))), [85.0]).gain[0] - tuned
        for size in (1e-3, 5e-4)
    ]
    assert moved[0] / moved[1] == pytest.approx(4.0, rel=0.02)


@pytest.mark.slow
def test_gradients_by_mistuning_speed_and_damping_are_those_of_differences():
    mistuning = np.array(MISTUNING)

    def gain(numbers):
        blade = lobex.Modes.single(frequency=400.0, damping_ratio=numbers["ratio"], mass=1 / 9)
        return lobex.exact_limit(lobex.Rub(lobex.Blading(blade, 6, numbers["mistuning"])), numbers["speed"]).gain[0]

    at = {"mistuning": mistuning, "speed": np.array([85.0]), "ratio": 0.005}
    with jax.enable_x64(True):
        slope = jax.grad(gain)(at)
    for name, step in (("mistuning", 1e-7), ("speed", 1e-5), ("ratio", 1e-8)):
        size = np.size(at[name])
        for k in range(size):
            unit = (np.arange(size) == k).reshape(np.shape(at[name])) * step
            ends = [gain({**at, name: at[name] + sign * unit}) for sign in (1, -1)]
            expected = (ends[0] - ends[1]) / (2 * step)
            assert np.ravel(slope[name])[k] == pytest.approx(expected, rel=2e-5)


@pytest.mark.parametrize("kind", ["tuned", "mistuned, coupled"])
def test_blades_in_tracks_have_no_lobes_as_curves(kind):
    with refused("give exact_limit"):
        lobex.exact_lobes(blading(kind))


COUPLED = pytest.mark.parametrize(
    ("kind", "gaps", "gain"),
    [
        ("mistuned, coupled", None, 10508.685214),
        ("mistuned, coupled", GAPS, 12161.495062),
        ("coupled", GAPS, 7715.07172509),
    ],
)


@COUPLED
def test_coupled_blades_have_the_reference_limits(kind, gaps, gain):
    limit = lobex.exact_limit(blading(kind, spacing=gaps), 85.0)
    assert limit.gain[0] == pytest.approx(gain, rel=5e-10)
    assert (limit.mode[0], limit.nodal_diameter[0]) == (1, -1)


@pytest.mark.slow
@COUPLED
def test_coupled_blades_have_the_reference_limits_by_the_operator(kind, gaps, gain):
    limit = lobex.critical_gain(blading(kind, spacing=gaps), 85.0, (5000.0, 20000.0), scan=9)
    assert limit.gain[0] == pytest.approx(gain, rel=1e-8)
    assert (limit.mode[0], limit.nodal_diameter[0]) == (1, -1)


# A beam inclined by 30 degrees that rubs with friction in a casing of two nodal diameters.
def in_casing(casing):
    length, thickness, width, density, modulus = 0.2, 0.004, 0.05, 4430.0, 110e9
    beta = np.array([1.8751040687119611, 4.694091132974174, 7.854757438237613])
    omega = beta**2 / length**2 * thickness * np.sqrt(modulus / (12 * density))
    across = 2 / np.sqrt(density * width * thickness * length) * (-1.0) ** np.arange(3)
    tip = lobex.Modes(omega, np.full(3, 0.01), np.stack([np.zeros(3), across], axis=1))
    normal, along = (np.cos(np.pi / 6), np.sin(np.pi / 6)), (-np.sin(np.pi / 6), np.cos(np.pi / 6))
    return lobex.Rub(tip.in_contact(normal, along, 0.15), casing=casing)


RING = {"frequency": 350.0, "damping_ratio": 0.02, "mass": 1.5}


@pytest.mark.slow
def test_coupled_blades_take_as_few_nodes_as_those_that_are_not():
    """Far above the limit, too, where what the force might keep up beyond the nodes is much."""
    rub, gains = blading("mistuned, coupled"), np.array([1e4, 1e5, 3e5])
    coarse, fine = (lobex.sweep(rub, [72.0], gains, lobex.Duhamel(nodes)) for nodes in (16, 26))
    assert np.all(coarse.error < 1e-8)
    off = np.abs(coarse.multiplier / fine.multiplier - 1)
    assert np.all(off < np.maximum(10 * coarse.error, 1e-12))


def test_a_blade_in_a_ring_has_the_reference_limit():
    limit = lobex.exact_limit(in_casing(lobex.Ring(nodal_diameter=2, **RING)), [60.0])
    assert limit.gain[0] == pytest.approx(5343.42631014, rel=1e-11)
    assert limit.chatter_frequency[0] == pytest.approx(91.5005856041, rel=1e-11)
    local = lobex.exact_limit(in_casing(lobex.Modes.single(**RING)), [60.0])
    assert local.gain[0] == pytest.approx(5341.29535927, rel=1e-11)


def test_a_ring_is_what_its_poles_say():
    s, speed, waves = 30.0 + 1900j, 70.0, np.array([0, 2, 7])
    ring = lobex.Ring(nodal_diameter=waves, frequency=[500.0, 350.0, 300.0], damping_ratio=0.02, mass=[2.0, 1.5, 1.0])
    seen = ring.at(speed)
    parts = np.asarray(seen.shape * seen.loading)[:, 0]
    own = s**2 + 2 * seen.damping_ratio * seen.angular_frequency * s + seen.angular_frequency**2
    omega, swept = 2 * np.pi * np.array([500.0, 350.0, 300.0]), 2j * np.pi * speed * waves
    twice = [1 / ((s + way) ** 2 + 0.04 * omega * (s + way) + omega**2) for way in (swept, -swept)]
    expected = np.sum((twice[0] + twice[1]) / (2 * np.array([2.0, 1.5, 1.0])))
    assert np.sum(parts / own) == pytest.approx(expected, rel=1e-13)


def test_a_stiff_ring_is_a_rigid_casing_to_the_first_order():
    rigid = lobex.exact_limit(in_casing(None), [60.0]).gain[0]
    apart = [
        lobex.exact_limit(in_casing(lobex.Ring(nodal_diameter=2, **{**RING, "mass": mass})), [60.0]).gain[0] - rigid
        for mass in (1e3, 2e3)
    ]
    assert apart[0] / apart[1] == pytest.approx(2.0, rel=1e-3)


@pytest.mark.slow
def test_a_ring_in_its_own_frame_has_the_same_multipliers():
    # There the contact runs around it: coefficients cos² and sin cos of the angle that it has turned.
    waves, speed, gain = 2, 60.0, 2672.0
    rub = in_casing(lobex.Ring(nodal_diameter=waves, **RING))
    omega = np.append(rub.modes.angular_frequency, [2 * np.pi * 350.0] * 2)
    ratio = np.append(rub.modes.damping_ratio, [0.02, 0.02])
    shape, loading = (np.append(np.asarray(part)[:, 0], 0.0) for part in (rub.modes.shape, rub.modes.loading))

    def around(t, speed, gain, delayed):
        angle = 2 * np.pi * waves * speed * t
        place = jax.numpy.stack([jax.numpy.cos(angle), jax.numpy.sin(angle)])
        seen = jax.numpy.concatenate([shape[:3], -place])
        acting = jax.numpy.concatenate([loading[:3], -place / 1.5])
        # A whole number of waves: the place is the same a revolution ago.
        return (1 if delayed else -1) * gain * acting[:, None] * seen

    same = lobex.LinearDelay.second_order(
        np.eye(5),
        np.diag(2 * ratio * omega),
        lambda t, speed, gain: np.diag(omega**2) - around(t, speed, gain, False),
        delayed=[(lambda t, speed, gain: around(t, speed, gain, True), None)],
    )
    assert lobex.spectral_radius(same, speed, gain) == pytest.approx(0.81461766633, rel=1e-8)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Blading(ONE, 0), "count = 0"),
        (lambda: Blading(ONE, 2.5), "count = 2.5"),
        (lambda: Blading(lobex.Modes.plane(x=ONE, y=ONE), 3), "contact directions"),
        (lambda: Blading("rod", 3), "blade = 'rod': give lobex.Modes"),
        (lambda: Blading(ONE, 3, spacing=[100, 100, 100]), "adds up to 300°"),
        (lambda: Blading(ONE, 3, spacing=[2, 2, 2.283185]), "adds up to 6.283185°"),
        (lambda: Blading(ONE, 3, spacing=[180, 180]), "one angle per blade"),
        (lambda: Blading(ONE, 3, spacing=[-60, 210, 210]), "spacing"),
        (lambda: Blading(ONE, 3, [1, -2, 1]), "0.02 for 2 %"),
        (lambda: Blading(ONE, 3, [0.01, np.nan, 0.0]), "mistuning"),
        (lambda: Blading(ONE, 3, [0.01, 0.02]), "one number per blade"),
        (lambda: Blading(ONE, 3, coupling=-1.0), "coupling"),
        (lambda: lobex.Ring(nodal_diameter=1.5, **RING), "whole numbers"),
        (lambda: lobex.Ring(nodal_diameter=-1, **RING), "nodal_diameter"),
        (lambda: lobex.Ring(nodal_diameter=2, **{**RING, "damping_ratio": 2.0}), "less than 1"),
        (lambda: lobex.Ring(nodal_diameter=2, **{**RING, "mass": 0.0}), "mass"),
        (lambda: lobex.Ring(nodal_diameter=[2, 3], **{**RING, "mass": [1.0, 1.0, 1.0]}), "give one each"),
        (lambda: lobex.Rub(ONE, casing=3.0), "lobex.Ring"),
        (lambda: lobex.Rub(lobex.Blading(ONE, 3), casing=ONE), "modes has 3 contact directions and casing 1"),
        (lambda: lobex.Rub(lobex.Modes.plane(x=ONE, y=ONE), casing=ONE), "one each"),
    ],
)
def test_what_is_no_blading_or_ring_is_refused_in_one_line(make, words):
    with refused(words):
        make()
