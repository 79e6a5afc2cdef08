"""Orbits: against Fourier series, independent codes, and marches that come to them."""

from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.tree_util import Partial

import lobex
from refusals import refused
from test_general_error import JUMPS, KINDS, SMOOTH

PERIOD, DELAY, DAMPING = 2.0, 1.7, 0.3
WAVE, STEP, SHARE = 1.3, 0.9, 0.3
NUMBERS = np.array([WAVE, STEP])
GAINS = np.array([0.4, 0.3, 0.6])
PHASE = np.arange(60) / 60
FOURTEEN = lobex.Duhamel(nodes=14)


def pushing(numbers, t, speed, gain):
    """A wave and a step."""
    return numbers[0] * jnp.cos(2 * jnp.pi * t / PERIOD) + jnp.where(t < SHARE * PERIOD, numbers[1], 0.0)


def fed_back(t, speed, gain):
    return gain


def oscillator(stiffness: Any = 2.0, numbers: Any = NUMBERS) -> lobex.LinearDelay:
    """ẍ + c ẋ + k x = b x(t − τ) + g(t)."""
    return lobex.LinearDelay.second_order(
        1.0,
        DAMPING,
        stiffness,
        delayed=[(fed_back, DELAY)],
        period=PERIOD,
        breaks=[0.0, SHARE],
        forcing=Partial(pushing, numbers),
    )


def by_series(gain, phase, derivative=None, stiffness=2.0, terms=20_000):
    """x as a Fourier series, or its derivative by the stiffness, the gain or the wave."""
    k = np.arange(1, terms)
    s = 2j * np.pi * k / PERIOD
    force = STEP * (1 - np.exp(-2j * np.pi * k * SHARE)) / (1j * np.pi * k) + WAVE * (k == 1)
    receptance = 1 / (s**2 + DAMPING * s + stiffness - gain * np.exp(-s * DELAY))
    still, mean = 1 / (stiffness - gain), STEP * SHARE
    if derivative == "stiffness":
        receptance, still = -(receptance**2), -(still**2)
    if derivative == "gain":
        receptance, still = receptance**2 * np.exp(-s * DELAY), still**2
    if derivative == "wave":
        force, mean = 1.0 * (k == 1), 0.0
    return mean * still + np.real(np.exp(2j * np.pi * np.outer(phase, k)) @ (force * receptance))


@pytest.fixture(scope="module")
def found():
    return lobex.orbit(oscillator(), 1.0, GAINS, FOURTEEN, phase=PHASE)


def test_a_forced_oscillator_with_a_delay_moves_as_its_fourier_series(found):
    assert found.displacement.shape == (3, 60, 1)
    for lane, gain in enumerate(GAINS):
        assert found.displacement[lane, :, 0] == pytest.approx(by_series(gain, PHASE), abs=1e-11)
    assert np.all((found.error > 0) & (found.error < 1e-8))
    assert set(found.status) == {"good"}
    assert found.time[0] == pytest.approx(PERIOD * PHASE)


def test_extremes_lie_between_the_samples(found):
    near = np.argmax(found.displacement[:, :, 0], axis=1)
    for lane, gain in enumerate(GAINS):
        fine = PHASE[near[lane]] + np.linspace(-1, 1, 201) / 60
        assert found.highest[lane, 0] == pytest.approx(by_series(gain, fine, terms=4000).max(), rel=1e-7)
        assert found.highest[lane, 0] >= found.displacement[lane].max()
    assert found.peak[:, 0] == pytest.approx(np.maximum(-found.lowest, found.highest)[:, 0])


def test_the_motion_about_it_dies_out_as_multipliers_say_which_know_nothing_of_the_forcing(found):
    with jax.enable_x64(True):
        forced = oscillator().system(1.0, 0.4)
        free = replace(forced, terms=forced.feedback)
        told, known = (jax.make_jaxpr(FOURTEEN.operator)(one).jaxpr.eqns for one in (forced, free))
    assert [str(one.primitive) for one in told] == [str(one.primitive) for one in known]
    free = replace(oscillator(), forcing=None)
    chart = lobex.sweep(free, [1.0], np.sort(GAINS))
    assert found.spectral_radius == pytest.approx(chart.spectral_radius[0, [1, 0, 2]], rel=1e-8)


@pytest.mark.slow
def test_a_march_comes_to_the_orbit_with_the_square_of_the_step(found):
    apart, fitted = [], []
    for steps in (120, 240):
        march = lobex.march_delay(oscillator(), 1.0, GAINS, lambda t: 0 * t, 40, steps, state=np.zeros(2))
        last = march.displacement[:, -steps - 1 : -1 : steps // 60]
        apart.append(last - found.displacement)
        fitted.append(march.growth)
    size = found.peak[:, None]
    assert np.max(np.abs(apart[1]) / size) < 2e-4
    # Richardson's extrapolation leaves what is beyond the second order.
    assert np.max(np.abs(4 * apart[1] - apart[0]) / 3 / size) < 1e-6
    assert fitted[1] == pytest.approx(found.spectral_radius, rel=2e-5)


@pytest.mark.slow
def test_a_march_that_has_come_to_its_orbit_or_hardly_begun_has_no_growth():
    for periods in (1, 2, 150):
        march = lobex.march_delay(oscillator(), 1.0, 0.4, lambda t: 0 * t, periods, 120, state=np.zeros(2))
        assert np.isnan(march.growth)


@pytest.mark.slow
def test_derivatives_are_those_of_the_series():
    place = 0.37

    def at(stiffness, gain, wave):
        process = oscillator(stiffness, jnp.stack([wave, jnp.asarray(STEP)]))
        motion = lobex.orbit(process, 1.0, gain, lobex.Duhamel(nodes=9), phase=[place])
        both = motion.displacement[0, 0], motion.peak[0]
        return both, both

    with jax.enable_x64(True):
        derivatives = jax.jit(jax.jacrev(at, argnums=(0, 1, 2), has_aux=True))
        (slopes, of_peak), (value, peak) = derivatives(2.0, 0.4, WAVE)
    phase = np.linspace(0, 1, 20_001)
    coarse = by_series(0.4, phase, terms=400)
    top = phase[np.argmax(np.abs(coarse))]
    assert value == pytest.approx(by_series(0.4, [place])[0], rel=1e-9)
    assert peak == pytest.approx(np.max(np.abs(coarse)), rel=1e-6)
    for slope, peaks, name in zip(slopes, of_peak, ("stiffness", "gain", "wave"), strict=True):
        assert slope == pytest.approx(by_series(0.4, [place], name)[0], rel=1e-8)
        assert peaks == pytest.approx(np.sign(by_series(0.4, [top])[0]) * by_series(0.4, [top], name)[0], rel=1e-3)


def test_what_no_motion_comes_to_is_not_told(found):
    with pytest.warns(lobex.SweepWarning, match="1 of 3 points are unstable: no motion comes to their orbit"):
        motion = lobex.orbit(oscillator(), 1.0, [0.4, 1.99, 2.3], FOURTEEN, phase=PHASE)
    assert list(motion.status) == ["good", "good", "unstable"]
    assert np.isnan(motion.displacement[2]).all()
    assert np.isnan(motion.peak[2]).all()
    assert motion.spectral_radius[2] > 1 > motion.spectral_radius[1]
    # Nearly at the limit, where x would be pushed ever further by the mean force.
    assert motion.displacement[1, :, 0] == pytest.approx(by_series(1.99, PHASE), abs=1e-9)


def test_too_few_nodes_say_so():
    # Of a stiff oscillator, which vibrates ten times between the jumps.
    with pytest.warns(lobex.SweepWarning, match="1 of 1 points have an estimated error above 1e-08"):
        motion = lobex.orbit(oscillator(2000.0), 1.0, 4.0, FOURTEEN, phase=PHASE)
    assert motion.status == "above tolerance"
    true = np.max(np.abs(motion.displacement[:, 0] - by_series(4.0, PHASE, stiffness=2000.0))) / motion.peak[0]
    assert true > 1e-8
    assert true <= 10 * motion.error


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"process": lobex.Scalar(-1.0)}, "process has no forcing"),
        ({"method": lobex.Chebyshev()}, "makes no orbit; give lobex.Duhamel"),
        ({"phase": [[0.1]]}, r"phase = \[\[0.1\]\] must be a list of phases"),
        ({"phase": [np.nan]}, "phase = .* has NaN"),
        ({"gain": [0.1, 0.2], "speed": [1.0, 1.0, 1.0]}, "give shapes that broadcast"),
        ({"gain": []}, "speed and gain have no values"),
    ],
)
def test_bad_input_is_one_line(changed, message):
    given = {"process": oscillator(), "speed": 1.0, "gain": 0.1} | changed
    with refused(match=message):
        lobex.orbit(**given)


def test_forces_of_a_wrong_shape_are_refused():
    with pytest.raises(ValueError, match=r"forcing has shape \(3,\); give \(2,\)"):
        lobex.LinearDelay(np.eye(2), forcing=np.ones(3))
    process = lobex.LinearDelay(np.eye(2), forcing=lambda t, speed, gain: jnp.ones(3))
    with pytest.raises(ValueError, match=r"forcing returns the shape \(3,\); return \(2,\)"):
        process.system(1.0, 0.0)


MILL = lobex.Milling(
    lobex.Modes.plane(
        x=lobex.Modes.single(frequency=563.6, damping_ratio=0.0558, mass=1.4986),
        y=lobex.Modes.single(frequency=516.21, damping_ratio=0.025, mass=1.199),
    ),
    teeth=4,
    tangential=6.79e8,
    normal=1.73824e8,
    radial_immersion=0.5,
    feed_per_tooth=1e-4,
)


@pytest.mark.slow
def test_even_teeth_push_the_free_structure_as_they_do_without_vibration():
    """The delayed displacement is the present one and drops out: a Fourier series of the nominal force."""
    speed, depth, k = 4000 / 60, np.array([5e-4, 1e-3]), np.arange(-20_000, 20_001)

    def turning(n):
        """∫ exp(−i n φ) dφ over the arc."""
        safe = np.where(n == 0, 1, n)
        return np.where(n == 0, np.pi / 2, (np.exp(-0.5j * n * np.pi) - np.exp(-1j * n * np.pi)) / (1j * safe))

    # sin φ (cos φ, sin φ) by its harmonics.
    with_cosine = (turning(4 * k - 2) - turning(4 * k + 2)) / 4j
    with_sine = turning(4 * k) / 2 - (turning(4 * k - 2) + turning(4 * k + 2)) / 4
    along = MILL.tangential * with_cosine + MILL.normal * with_sine
    across = MILL.normal * with_cosine - MILL.tangential * with_sine
    motion = lobex.orbit(MILL, speed, depth, FOURTEEN, phase=PHASE)
    for output, force in enumerate((along, across)):
        omega = 2 * np.pi * k * 4 * speed
        own, ratio = MILL.modes.angular_frequency[output], MILL.modes.damping_ratio[output]
        receptance = MILL.modes.shape[output, output] ** 2 / (own**2 - omega**2 + 2j * ratio * own * omega)
        harmonics = -1e-4 * 4 / (2 * np.pi) * force * receptance
        series = np.real(np.exp(2j * np.pi * np.outer(PHASE, k)) @ harmonics)
        for lane in range(2):
            wanted = depth[lane] * series
            assert motion.displacement[lane, :, output] == pytest.approx(wanted, abs=1e-9 * np.abs(wanted).max())
    assert motion.displacement[1] == pytest.approx(2 * motion.displacement[0], rel=1e-6, abs=1e-14)


@pytest.mark.slow
def test_twice_the_feed_moves_twice_as_far():
    twice = lobex.orbit(replace(MILL, feed_per_tooth=2e-4), 4000 / 60, [5e-4, 1e-3], FOURTEEN, phase=PHASE)
    once = lobex.orbit(MILL, 4000 / 60, [5e-4, 1e-3], FOURTEEN, phase=PHASE)
    assert twice.highest == pytest.approx(2 * once.highest, rel=1e-9)
    assert twice.spectral_radius == pytest.approx(once.spectral_radius, rel=1e-12)


def test_a_feed_of_nothing_is_refused():
    with pytest.raises(ValueError, match="feed_per_tooth = 0 must be positive; give a number above 0 in m"):
        replace(MILL, feed_per_tooth=0.0)


def three_waves(numbers, t, speed, gain):
    phase = 2 * jnp.pi * t * speed
    return numbers[0] * jnp.cos(phase) + numbers[1] * jnp.sin(3 * phase) + numbers[2]


@pytest.mark.search
@pytest.mark.filterwarnings("ignore::lobex.SweepWarning")
@pytest.mark.parametrize("kind", [*SMOOTH, *JUMPS])
def test_errors_of_random_orbits_are_honest(kind):
    """Of nine nodes, against four times as many, which the series and codes above vouch for."""
    rng, apart, stated = np.random.default_rng(17), [], []
    for _ in range(20):
        process, speed, gains, _ = KINDS[kind](rng)
        process = replace(process, forcing=Partial(three_waves, rng.normal(size=3)))
        few, many = (lobex.orbit(process, speed, gains, lobex.Duhamel(nodes=nodes)) for nodes in (9, 36))
        error = np.max(np.abs(few.displacement - many.displacement), axis=(-1, -2)) / np.max(many.peak, axis=-1)
        known = np.isfinite(error)
        apart, stated = apart + error[known].tolist(), stated + few.error[known].tolist()
    assert len(apart) > 3
    assert np.mean(np.array(apart) > 10 * np.maximum(stated, 1e-11)) <= 0.01
