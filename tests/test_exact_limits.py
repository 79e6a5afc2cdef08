"""The exact limit against references, the monodromy operator, a scan that shares no code, and closed forms."""

from dataclasses import replace

import jax
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import lobex
from cases import LIMIT_CASES, ROD, label, point, rub
from lobex.limits.d_subdivision import exact_branches, exact_critical, exact_minimum
from lobex.limits.hayes import hayes_interval
from lobex.limits.receptance import Receptance, receptance
from refusals import refused

FINE = lobex.Chebyshev(64)
SINGLE = lobex.Modes.single(frequency=150.0, damping_ratio=0.02, mass=2.0)
STIFFNESS = 2.0 * (2 * np.pi * 150.0) ** 2
RUBS = [case for case in LIMIT_CASES if case["problem"] == "rod-rub"]


def structure(seed, count, least_damping, most_damping=0.1, span=3000.0):
    """Random modes; as many as the rod has, where their number is not the point: one program serves both."""
    rng = np.random.default_rng(seed)
    frequency = np.sort(rng.uniform(100.0, 100.0 + span, count))
    ratio = np.exp(rng.uniform(np.log(least_damping), np.log(most_damping), count))
    return lobex.Modes(2 * np.pi * frequency, ratio, rng.uniform(0.05, 1.0, (count, 1)))


def modal_sum(modes, omega):
    """G in NumPy, with the difference ωᵢ − ω taken first."""
    own, ratio = np.asarray(modes.angular_frequency), np.asarray(modes.damping_ratio)
    omega = np.asarray(omega)[..., None]
    spring, drag = (own - omega) * (own + omega), 2 * ratio * own * omega
    share = np.asarray(modes.shape)[:, 0] ** 2 / (spring**2 + drag**2)
    return np.sum(share * spring, axis=-1) - 1j * np.sum(share * drag, axis=-1)


def scan(modes, speeds):
    """The lowest limits by a dense scan of ω, dense at the resonances and at every lobe, and Brent's method."""
    own, ratio = np.asarray(modes.angular_frequency), np.asarray(modes.damping_ratio)
    fixed = [np.linspace(0.9 * own.min(), 1.5 * own.max(), 20000)]
    for centre, width in zip(own, ratio * own, strict=True):
        fixed.append(centre + np.geomspace(1e-3 * width, centre, 2000))
        fixed.append(centre - np.geomspace(1e-3 * width, centre / 2, 2000))
    fixed = np.concatenate(fixed)
    known = modal_sum(modes, fixed)

    def lowest(speed):
        top = max(20 * own.max(), 4 * np.pi * speed)
        lobes = np.arange(0.9 * own.min(), min(top, 3 * own.max()), 2 * np.pi * speed / 20)
        further = np.concatenate([lobes, np.geomspace(own.min(), top, 5000)])
        omega, first = np.unique(np.concatenate([fixed, further]), return_index=True)
        response = np.concatenate([known, modal_sum(modes, further)])[first]
        whole = np.floor(turns(omega, response, speed))
        negative = response.real < 0
        gain = np.where(negative, -0.5 / np.where(negative, response.real, -1.0), np.inf)
        crossing = np.flatnonzero((whole[1:] != whole[:-1]) & negative[1:] & negative[:-1])
        bound = np.minimum(gain[crossing], gain[crossing + 1])
        best = np.inf
        for i in crossing[np.argsort(bound)]:
            if min(gain[i], gain[i + 1]) > best:
                break
            level = max(whole[i], whole[i + 1])
            ends = omega[i], omega[i + 1]
            root = brentq(lambda w, n=level: turns(w, modal_sum(modes, w), speed) - n, *ends, xtol=1e-13, rtol=1e-15)
            best = min(best, -0.5 / modal_sum(modes, root).real)
        return best

    return np.array([lowest(speed) for speed in speeds])


def turns(omega, response, speed):
    return (omega / speed + 2 * np.arctan2(-response.imag, response.real) - np.pi) / (2 * np.pi)


@pytest.mark.parametrize("case", RUBS, ids=label)
def test_reference_limits(case):
    process, speed, _ = point(case)
    limit = exact_critical(process, speed)
    assert limit.gain == pytest.approx(case["critical_contact_stiffness_N_per_m"], rel=1e-9)
    # The file gives five decimals of the frequency.
    assert limit.chatter_frequency == pytest.approx(case["chatter_frequency_Hz"], abs=6e-6)
    assert not limit.tie


def test_monodromy_operator_is_at_the_limit_there_and_stable_below():
    speed = np.random.default_rng(5).uniform(50.0, 400.0, 50)
    limit = exact_critical(ROD, speed)
    assert lobex.spectral_radius(ROD, speed, limit.gain, FINE) == pytest.approx(np.ones(50), abs=1e-8)
    assert np.all(lobex.spectral_radius(ROD, speed, 0.999 * limit.gain, FINE) < 1)
    assert np.all(lobex.spectral_radius(ROD, speed, 1.001 * limit.gain, FINE) > 1)


# Some of these structures are slow, and said to be passed above every lobe.
@pytest.mark.filterwarnings("ignore:every speed")
@settings(max_examples=12, derandomize=True)
@given(st.integers(0, 10**6), st.floats(150.0, 2000.0))
def test_monodromy_operator_of_random_structures(seed, speed):
    process = lobex.Rub(structure(seed, 5, 0.005, span=500.0))
    limit = exact_critical(process, speed)
    assert lobex.spectral_radius(process, speed, limit.gain, FINE) == pytest.approx(1, abs=1e-8)
    assert lobex.spectral_radius(process, speed, 0.999 * limit.gain, FINE) < 1


@pytest.mark.parametrize(
    ("modes", "slowest", "fastest"),
    [
        (ROD.modes, 5.0, 8000.0),
        (structure(1, 30, 1e-3), 5.0, 8000.0),
        (structure(2, 5, 1e-5, 1e-4), 20.0, 8000.0),
        (structure(3, 30, 0.02, 0.5, span=200.0), 5.0, 100000.0),
        (lobex.Modes([1e3, 1e3, 1.0001e3], [1e-5, 3e-2, 2e-3], [[0.3], [1.0], [0.5]]), 5.0, 1000.0),
    ],
    ids=["rod", "30 modes", "tiny damping", "overlapping", "close"],
)
def test_no_crossing_is_missed(modes, slowest, fastest):
    speed = np.concatenate([np.geomspace(slowest, fastest, 38), [slowest * 1.0007, fastest * 0.9993]])
    found = exact_critical(modes, speed)
    assert found.gain == pytest.approx(scan(modes, speed), rel=1e-9)
    response = modal_sum(modes, found.angular_frequency)
    assert np.all(response.real < 0)
    turned = found.angular_frequency / speed - 2 * np.angle(response)
    assert turned == pytest.approx((2 * found.lobe + 1) * np.pi, rel=1e-11, abs=1e-8)
    assert np.all(found.lobe >= 1)


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 1e-18, reason="this platform has no extended precision")
def test_root_to_rounding_against_extended_precision():
    modes = structure(4, 5, 1e-6, 1e-5)
    wide = np.longdouble
    own, ratio, weight = (np.asarray(a, wide) for a in (modes.angular_frequency, modes.damping_ratio, modes.shape))

    def response(omega):
        real, imaginary = (own - omega) * (own + omega), 2 * ratio * own * omega
        share = weight[:, 0] ** 2 / (real**2 + imaginary**2)
        return np.sum(share * real), -np.sum(share * imaginary)

    for speed in (47.0, 210.0, 1900.0):
        limit = exact_critical(modes, speed)
        target = (2 * int(limit.lobe) + 1) * 4 * np.arctan(wide(1))

        def phase(omega, speed=speed, target=target):
            real, imaginary = response(omega)
            return omega / wide(speed) + 2 * np.arctan2(-imaginary, real) - target

        # The root lies within 1e-12 of the one found, or bisection ends at an end of this bracket.
        low, high = (wide(limit.angular_frequency) * (1 + wide(s) * wide(1e-12)) for s in (-1, 1))
        assert phase(low) < 0 < phase(high)
        for _ in range(40):
            middle = (low + high) / 2
            low, high = (middle, high) if phase(middle) < 0 else (low, middle)
        assert float(limit.gain) == pytest.approx(float(-1 / (2 * response(low)[0])), rel=1e-11)


def test_thousands_of_radians_per_delay():
    limit = exact_critical(ROD, [0.05, 0.3, 1.0])
    assert np.all(limit.angular_frequency / [0.05, 0.3, 1.0] > 2000)
    assert limit.gain == pytest.approx(np.full(3, exact_minimum(ROD).gain), rel=2e-3)
    assert np.all(limit.gain >= exact_minimum(ROD).gain)
    assert limit.gain == pytest.approx(scan(ROD.modes, (0.05, 0.3, 1.0)), rel=1e-9)


def test_far_above_the_modes_the_limit_is_that_of_a_free_mass():
    # G tends to −φ²/ω² and ωτ to π: K is π² speed²/(2φ²).
    speed = 1e6
    gain = exact_critical(SINGLE, speed).gain
    assert gain == pytest.approx(np.pi**2 * speed**2 * 2.0 / 2, rel=1e-3)
    assert exact_critical(SINGLE, speed).lobe == 1


def test_single_mode_minimum():
    least = exact_minimum(SINGLE, lobes=4)
    assert least.gain == pytest.approx(2 * STIFFNESS * 0.02 * 1.02, rel=1e-12)
    assert least.angular_frequency == pytest.approx(2 * np.pi * 150 * np.sqrt(1.04), rel=1e-12)
    assert least.speed.shape == (4,)
    there = exact_critical(SINGLE, least.speed)
    assert there.gain == pytest.approx(np.full(4, least.gain), rel=1e-12)
    assert np.all(there.lobe == [1, 2, 3, 4])


def test_no_speed_is_below_the_minimum():
    modes = structure(8, 5, 0.01)
    speed = np.geomspace(20.0, 5000.0, 3000)
    gain = exact_critical(modes, speed).gain
    least = exact_minimum(modes)
    assert np.min(gain) >= least.gain * (1 - 1e-13)
    omega = np.linspace(500.0, 25000.0, 2_000_001)
    assert least.gain == pytest.approx(-0.5 / modal_sum(modes, omega).real.min(), rel=1e-6)
    assert exact_critical(modes, least.speed).gain == pytest.approx(np.full(10, least.gain), rel=1e-12)


def test_branches_pass_through_the_limit():
    speed = np.array([60.0, 85.0, 150.0, 400.0])
    limit = exact_critical(ROD, speed)
    branches = exact_branches(ROD, limit.angular_frequency, lobes=8)
    assert branches.gain == pytest.approx(limit.gain, rel=1e-12)
    assert branches.speed.shape == (8, 4)
    assert branches.speed[limit.lobe - 1, np.arange(4)] == pytest.approx(speed, rel=1e-12)


def test_branches_are_nan_where_the_receptance_does_not_oppose():
    first = float(ROD.modes.angular_frequency[0])
    branches = exact_branches(ROD, [0.5 * first, 1.05 * first], lobes=2)
    assert list(np.isnan(branches.gain)) == [True, False]
    assert np.all(np.isnan(branches.speed) == [[True, False], [True, False]])


def test_turning_is_rubbing_per_radial_force():
    turning = lobex.Turning(ROD.modes, radial=3e8)
    speed = np.array([60.0, 112.0, 250.0])
    rubbing, cutting = exact_critical(ROD, speed), exact_critical(turning, speed)
    assert cutting.gain == pytest.approx(rubbing.gain / 3e8, rel=1e-14)
    assert exact_minimum(turning).gain == pytest.approx(exact_minimum(ROD).gain / 3e8, rel=1e-14)
    omega = rubbing.angular_frequency
    assert exact_branches(turning, omega).gain == pytest.approx(rubbing.gain / 3e8, rel=1e-12)
    assert exact_critical(ROD.modes, speed).gain == pytest.approx(rubbing.gain, rel=1e-14)


@settings(max_examples=15, derandomize=True)
@given(st.floats(0.1, 10.0), st.floats(0.1, 10.0), st.floats(40.0, 500.0))
def test_scaling_laws(alpha, beta, speed):
    # K(αK, βM; f √(α/β)) = α K(K, M; f).
    scaled = rub(young_modulus=alpha * 210e7, density=beta * 4600.0)
    there = exact_critical(scaled, speed * np.sqrt(alpha / beta))
    assert there.gain == pytest.approx(alpha * exact_critical(ROD, speed).gain, rel=1e-9)


def test_a_cusp_between_lobes_is_a_tie():
    speed = np.linspace(60.0, 300.0, 400)
    lobe = exact_critical(ROD, speed).lobe
    for i in np.flatnonzero(np.diff(lobe))[:3]:
        upper, lower = int(lobe[i]), int(lobe[i + 1])
        low, high = speed[i], speed[i + 1]
        for _ in range(50):
            middle = (low + high) / 2
            low, high = (middle, high) if exact_critical(ROD, middle).lobe == upper else (low, middle)
        cusp = exact_critical(ROD, (low + high) / 2)
        assert cusp.tie
        assert cusp.lobe in (upper, lower)
        aside = exact_critical(ROD, low * np.array([1 - 1e-6, 1 + 1e-6]))
        assert not np.any(aside.tie)
        assert list(aside.lobe) == [upper, lower]


def test_without_damping_the_limit_is_zero_or_the_formula():
    # A small gain feeds a mode without damping where sin(ωτ) < 0; else ωτ = (2j − 1)π at the limit.
    modes = lobex.Modes.single(frequency=100.0, damping_ratio=0.0, mass=1.0)
    speed = np.array([130.0, 180.0, 55.0, 220.0, 80.0])
    limit = exact_critical(modes, speed)
    own = 2 * np.pi * 100.0
    feeding = np.sin(own / speed) < 0
    assert list(feeding) == [True, True, True, False, False]
    assert np.all(limit.gain[feeding] == 0)
    assert limit.angular_frequency[feeding] == pytest.approx(np.full(3, own), rel=1e-15)
    omega = (2 * limit.lobe - 1) * np.pi * speed
    assert limit.angular_frequency[~feeding] == pytest.approx(omega[~feeding], rel=1e-13)
    assert limit.gain[~feeding] == pytest.approx((omega**2 - own**2)[~feeding] / 2, rel=1e-12)
    assert exact_minimum(modes).gain == 0
    nearly = exact_critical(replace(modes, damping_ratio=np.array([1e-13])), speed)
    assert nearly.gain == pytest.approx(limit.gain, rel=1e-9, abs=1e-12 * own**2 * 10)
    assert np.all(nearly.lobe == limit.lobe)


def test_damping_of_one_mode_of_two_missing():
    modes = lobex.Modes([600.0, 900.0], [0.02, 0.0], [[1.0], [0.4]])
    speed = np.linspace(60.0, 400.0, 60)
    feeding = np.sin(900.0 / speed) < 0
    gain = exact_critical(modes, speed).gain
    assert np.all(gain[feeding] == 0)
    assert np.all(gain[~feeding] > 0)
    assert 5 < np.sum(feeding) < 55


def test_a_contact_that_no_mode_moves_has_no_limit():
    limit = exact_critical(lobex.Modes([100.0], [0.1], [[0.0]]), [10.0, 20.0])
    assert np.all(np.isnan(limit.gain))
    assert np.all(np.isnan(limit.angular_frequency))
    assert np.all(limit.lobe == 0)
    assert not np.any(limit.tie)
    assert np.isnan(exact_minimum(lobex.Modes([100.0], [0.1], [[0.0]])).gain)


def central(function, at, direction, step):
    """Fourth-order central difference along a direction."""

    def along(t):
        return float(function(jax.tree.map(lambda a, d: a + t * step * d, at, direction)))

    return (8 * (along(1) - along(-1)) - (along(2) - along(-2))) / (12 * step)


def critical(at):
    return exact_critical(*at).gain


# Compiled once for all speeds and directions of a structure.
BOTH = jax.jit(jax.value_and_grad(critical))
FORWARD = jax.jit(lambda at, moved: jax.jvp(critical, (at,), (moved,))[1])


@pytest.mark.parametrize("speed", [60.0, 85.0, 250.0, 3000.0])
@pytest.mark.parametrize("modes", [ROD.modes, structure(6, 5, 0.002, 0.05, span=400.0)], ids=["rod", "random"])
def test_gradient_of_everything_against_differences(modes, speed):
    with jax.enable_x64(True):
        at = jax.tree.map(lambda leaf: np.asarray(leaf, dtype=float), (lobex.Turning(modes, radial=3e8), speed))
        assert not exact_critical(*at).tie
        value, gradient = BOTH(at)
        leaves, tree = jax.tree.leaves(at), jax.tree.structure(at)
        assert float(value) == pytest.approx(float(critical(at)), rel=1e-13)
        scale = float(value)
        rng = np.random.default_rng(1)
        for index, leaf in enumerate(leaves):
            direction = [np.zeros_like(other) for other in leaves]
            direction[index] = leaf * rng.uniform(0.5, 1.0, leaf.shape)
            moved = jax.tree.unflatten(tree, direction)
            exact = sum(np.sum(g * d) for g, d in zip(jax.tree.leaves(gradient), direction, strict=True))
            assert exact == pytest.approx(central(lambda x: BOTH(x)[0], at, moved, 1e-5), rel=1e-6, abs=1e-8 * scale)
            forward = FORWARD(at, moved)
            assert float(forward) == pytest.approx(float(exact), rel=1e-10, abs=1e-14 * scale)


def test_gradient_at_the_lobe_minimum_is_the_closed_form():
    # Where dK/dω = 0 the moving of ω does not count: dK/dp = ∂ₚ Re G/(2 (Re G)²), and dK/dspeed = 0.
    least = exact_minimum(ROD)
    omega = float(least.angular_frequency)

    def real_part(modes):
        return receptance(modes, omega).real

    with jax.enable_x64(True):
        modes = jax.tree.map(np.asarray, ROD.modes)
        value, partial = jax.jit(jax.value_and_grad(real_part))(modes)
        wanted = jax.tree.map(lambda slope: np.asarray(slope) / (2 * float(value) ** 2), partial)
        at_speed = float(least.speed[2])
        by_modes, by_speed = jax.jit(jax.grad(lambda m, s: exact_critical(m, s).gain, argnums=(0, 1)))(modes, at_speed)
        of_least = jax.jit(jax.grad(lambda m: exact_minimum(m).gain))(modes)
    for name in ("angular_frequency", "damping_ratio", "shape"):
        closed = np.asarray(getattr(wanted, name))
        assert np.max(np.abs(closed)) > 0
        assert np.asarray(getattr(by_modes, name)) == pytest.approx(closed, rel=1e-7, abs=1e-9 * np.abs(closed).max())
        assert np.asarray(getattr(of_least, name)) == pytest.approx(closed, rel=1e-9, abs=1e-12 * np.abs(closed).max())
    assert abs(float(by_speed)) * at_speed < 1e-6 * float(least.gain)


def twice(function):
    """Its value, first and second derivative of one number, compiled as one program."""
    return jax.jit(lambda x: (jax.value_and_grad(function)(x), jax.grad(jax.grad(function))(x)))


def test_gradient_through_a_loop_that_knows_no_implicit_rule():
    # Plain Newton steps from the root, differentiated as they stand.
    speed = 85.0
    start = exact_critical(ROD, speed)

    def unrolled(speed):
        omega = float(start.angular_frequency)

        def phase(omega):
            response = receptance(ROD.modes, omega)
            return omega / speed - 2 * jax.numpy.angle(response) - (2 * int(start.lobe) + 1) * np.pi

        for _ in range(4):
            omega = omega - phase(omega) / jax.grad(phase)(omega)
        return -0.5 / receptance(ROD.modes, omega).real

    with jax.enable_x64(True):
        implicit, second = twice(lambda s: exact_critical(ROD, s).gain)(speed)
        plain, bend = twice(unrolled)(speed)
    assert float(implicit[0]) == pytest.approx(float(plain[0]), rel=1e-12)
    assert float(implicit[1]) == pytest.approx(float(plain[1]), rel=1e-10)
    assert float(second) == pytest.approx(float(bend), rel=1e-8)


def test_derivative_by_damping_where_there_is_none():
    # K = 2kξ(1 + ξ) at its least, so dK/dξ = 2k at ξ = 0.
    modes = lobex.Modes.single(frequency=100.0, damping_ratio=0.0, mass=1.0)
    with jax.enable_x64(True):
        slope = jax.jit(jax.grad(lambda m: exact_minimum(m).gain))(jax.tree.map(np.asarray, modes))
    assert float(slope.damping_ratio[0]) == pytest.approx(2 * (2 * np.pi * 100) ** 2, rel=1e-9)


def test_jit_vmap_and_precision():
    speed = np.array([60.0, 85.0, 250.0])
    plain = exact_critical(ROD, speed)
    assert plain.gain.dtype == np.float64
    with jax.enable_x64(True):
        traced = jax.jit(exact_critical)(ROD, speed)
        ratios = np.array([0.01, 0.03])
        mapped = jax.jit(jax.vmap(lambda r: exact_critical(lobex.Rub(lobex.Rod().modes(r)), 85.0).gain))(ratios)
    assert np.asarray(traced.gain) == pytest.approx(plain.gain, rel=1e-13)
    assert np.asarray(mapped) == pytest.approx(np.array([exact_critical(rub(5, r), 85.0).gain for r in ratios]))
    single = jax.jit(exact_critical)(jax.tree.map(lambda a: np.asarray(a, np.float32), ROD), speed.astype(np.float32))
    assert single.gain.dtype == np.float32
    assert np.asarray(single.gain) == pytest.approx(plain.gain, rel=1e-3)


@pytest.mark.parametrize("shape", [(), (0,), (3,), (2, 3), (700,)])
def test_result_has_the_shape_of_the_speeds(shape):
    speed = np.random.default_rng(3).uniform(60, 400, shape)
    limit = exact_critical(ROD, speed)
    for value in (limit.gain, limit.angular_frequency, limit.chatter_frequency, limit.lobe, limit.tie):
        assert np.shape(value) == shape
    if speed.size:
        assert limit.gain.ravel()[-1] == pytest.approx(exact_critical(ROD, speed.ravel()[-1]).gain, rel=1e-13)


def sampled(modes, frequency):
    return Receptance(frequency, modal_sum(modes, 2 * np.pi * np.asarray(frequency)))


def test_measured_receptance_of_one_mode_is_interpolated_exactly():
    # 1/G of one mode is a parabola, which five samples fix.
    samples = sampled(SINGLE, [100.0, 130.0, 171.0, 260.0, 400.0, 600.0])
    omega = 2 * np.pi * np.linspace(100.0, 600.0, 301)
    with jax.enable_x64(True):
        between = np.asarray(receptance(samples, omega))
    assert between == pytest.approx(modal_sum(SINGLE, omega), rel=1e-11)
    speed = np.array([60.0, 75.0, 130.0])
    measured, modal = exact_critical(samples, speed), exact_critical(SINGLE, speed)
    assert measured.gain == pytest.approx(modal.gain, rel=1e-10)
    assert np.all(measured.lobe == modal.lobe)


def test_measured_receptance_converges_with_fourth_order():
    frequency = [np.linspace(300.0, 1300.0, n + 1) for n in (100, 200, 400)]
    omega = 2 * np.pi * np.linspace(330.0, 450.0, 2001)
    with jax.enable_x64(True):
        values = [np.asarray(receptance(sampled(ROD.modes, f), omega)) for f in frequency]
    exact = modal_sum(ROD.modes, omega)
    error = [np.max(np.abs(v - exact)) / np.max(np.abs(exact)) for v in values]
    assert error[2] < 1e-6
    assert np.all(np.log2(np.array(error[:-1]) / error[1:]) > 3.5)


def test_limits_of_a_measured_receptance():
    samples = sampled(ROD.modes, np.linspace(280.0, 1600.0, 661))
    speed = np.linspace(60.0, 400.0, 40)
    measured, modal = exact_critical(samples, speed), exact_critical(ROD, speed)
    assert measured.gain == pytest.approx(modal.gain, rel=1e-6)
    assert np.all(measured.lobe == modal.lobe)
    assert exact_minimum(samples).gain == pytest.approx(exact_minimum(ROD).gain, rel=1e-7)
    branches = exact_branches(samples, measured.angular_frequency)
    assert branches.gain == pytest.approx(measured.gain, rel=1e-11)


def test_limits_of_a_measurement_stay_in_its_band():
    samples = sampled(ROD.modes, np.linspace(345.0, 360.0, 31))
    speed = np.array([200.0, 3000.0, 85.0])
    limit = exact_critical(samples, speed)
    assert limit.gain[0] == pytest.approx(exact_critical(ROD, 200.0).gain, rel=1e-6)
    assert np.isnan(limit.gain[1])
    assert limit.lobe[1] == 0
    band = np.array([345.0, 360.0])
    inside = ~np.isnan(limit.gain)
    assert np.all((limit.chatter_frequency[inside] >= band[0]) & (limit.chatter_frequency[inside] <= band[1]))
    outside = exact_branches(samples, 2 * np.pi * np.array([344.0, 361.0]))
    assert np.all(np.isnan(outside.gain))


def test_noisy_measurement_has_no_crossing_missed():
    rng = np.random.default_rng(11)
    frequency = np.linspace(280.0, 700.0, 120)
    clean = modal_sum(ROD.modes, 2 * np.pi * frequency)
    noise = 0.02 * np.abs(clean) * (rng.standard_normal(120) + 1j * rng.standard_normal(120))
    samples = Receptance(frequency, clean + noise)
    omega = 2 * np.pi * np.linspace(280.0, 700.0, 400_001)
    with jax.enable_x64(True):
        response = np.asarray(receptance(samples, omega))
    angle = np.mod(np.angle(response), 2 * np.pi) - 2 * np.pi
    gain = np.where(response.real < 0, -0.5 / response.real, np.inf)
    for speed in (23.0, 60.0, 110.0, 170.0, 390.0):
        lobe = (omega / speed - 2 * angle - np.pi) / (2 * np.pi)
        whole = np.floor(lobe)
        i = np.flatnonzero((whole[1:] != whole[:-1]) & (response.real[1:] < 0) & (response.real[:-1] < 0))
        part = (np.maximum(whole[i], whole[i + 1]) - lobe[i]) / (lobe[i + 1] - lobe[i])
        there = gain[i] + part * (gain[i + 1] - gain[i])
        assert exact_critical(samples, speed).gain == pytest.approx(np.min(there), rel=1e-6)


def test_gradient_through_a_measurement():
    samples = sampled(ROD.modes, np.linspace(280.0, 1600.0, 200))

    def limit(scale):
        return exact_critical(Receptance(samples.frequency, samples.response * scale), 85.0).gain

    with jax.enable_x64(True):
        value, slope = jax.jit(jax.value_and_grad(limit))(1.0)
    assert float(slope) == pytest.approx(-float(value), rel=1e-10)


@pytest.mark.parametrize("theta", [1e-3, 0.3, 1.0, np.pi / 2, 2.8, 3.14])
@pytest.mark.parametrize("speed", [0.5, 1.0, 7.0])
def test_hayes_closed_form(theta, speed):
    interval = hayes_interval(theta / np.tan(theta) * speed, speed)
    assert interval.angular_frequency == pytest.approx(theta * speed, rel=1e-9)
    assert interval.lower == pytest.approx(-theta / np.sin(theta) * speed, rel=1e-11)
    assert interval.upper == -theta / np.tan(theta) * speed


def test_hayes_against_the_monodromy_operator():
    a = np.array([-30.0, -2.0, 0.0, 0.9, 1.7])
    interval = hayes_interval(a, 2.0)
    beside = 1e-3 * (interval.upper - interval.lower)
    for i, value in enumerate(a):
        ends = np.array([interval.lower[i], interval.upper[i]])
        inward = beside[i] * np.array([1, -1])
        gains = np.concatenate([ends, ends + inward, ends - inward])
        radius = lobex.spectral_radius(lobex.Scalar(float(value)), 2.0, gains, lobex.Chebyshev(32))
        assert radius[:2] == pytest.approx(1, abs=1e-9)
        assert np.all(radius[2:4] < 1)
        assert np.all(radius[4:] > 1)


def test_hayes_has_no_interval_from_one_and_keeps_its_digits_far_below():
    interval = hayes_interval([1.0, 1.5, -1e8], 1.0)
    for value in (interval.lower, interval.upper, interval.angular_frequency):
        assert list(np.isnan(value)) == [True, True, False]
    assert interval.lower[2] == pytest.approx(-1e8, rel=1e-14)
    assert np.pi - interval.angular_frequency[2] == pytest.approx(np.pi * 1e-8, rel=1e-6)


def test_hayes_gradient():
    # With θ cot θ = aτ: dθ/d(aτ) = 1/(cot θ − θ/sin² θ), and b = −θ/(τ sin θ).
    theta = 1.2
    a = theta / np.tan(theta)
    by_theta = -(np.sin(theta) - theta * np.cos(theta)) / np.sin(theta) ** 2
    wanted = by_theta / (1 / np.tan(theta) - theta / np.sin(theta) ** 2)
    with jax.enable_x64(True):
        slope = jax.jit(jax.grad(lambda a: hayes_interval(a, 1.0).lower))(a)
        none = jax.jit(jax.grad(lambda a: jax.numpy.nansum(hayes_interval(a, 1.0).lower)))(np.array([1.5, a]))
    assert float(slope) == pytest.approx(wanted, rel=1e-11)
    assert np.asarray(none) == pytest.approx(np.array([0.0, wanted]), rel=1e-11)


PLANE = lobex.Modes.plane(x=SINGLE, y=SINGLE)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: exact_critical(lobex.Scalar(0.5), 1.0), "lobex.limits.hayes"),
        (lambda: exact_critical("rod", 1.0), "source = 'rod'"),
        (lambda: exact_critical(lobex.Rub, 1.0), "has no exact limit"),
        (lambda: exact_minimum(PLANE), "2 contact directions"),
        (lambda: exact_critical(ROD, 0.0), "speed = 0"),
        (lambda: exact_critical(ROD, [60.0, np.nan]), "speed = [60, nan]"),
        (lambda: exact_critical(ROD, 300_000.0), "rpm/60"),
        (lambda: exact_branches(ROD, [0.0, 1.0]), "omega = [0, 1]"),
        (lambda: exact_branches(ROD, 2000.0), "omega has shape ()"),
        (lambda: exact_branches(ROD, [2000.0], lobes=0), "lobes = 0"),
        (lambda: exact_minimum(ROD, lobes=1.5), "lobes = 1.5"),
        (lambda: Receptance([1.0, 2.0, 3.0], [1, 1, 1]), "frequency has 3 samples"),
        (lambda: Receptance([1.0, 2.0, 2.0, 3.0], [1, 1, 1, 1]), "not strictly increasing"),
        (lambda: Receptance([1.0, 2.0, 3.0, np.inf], [1, 1, 1, 1]), "frequency = [1, 2, 3, inf]"),
        (lambda: Receptance([1.0, 2.0, 3.0, 4.0], [1, 1, 1]), "response has shape (3,)"),
        (lambda: Receptance([1.0, 2.0, 3.0, 4.0], [1, 1j, np.nan, 1]), "response has NaN"),
        (lambda: Receptance([1.0, 2.0, 3.0, 4.0], [1, 1j, 0, 1]), "response has zeros"),
        (lambda: Receptance([1.0, 2.0, 3.0, 4.0], "abcd"), "response = 'abcd'"),
        (lambda: hayes_interval(np.nan, 1.0), "a = nan"),
        (lambda: hayes_interval(0.5, -1.0), "speed = -1"),
        (lambda: hayes_interval([0.1, 0.2], [1.0, 2.0, 3.0]), "give shapes that broadcast"),
    ],
)
def test_bad_input_is_refused_in_one_line(call, words):
    with refused(words):
        call()
