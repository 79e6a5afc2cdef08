"""Growth beside a limit from its response: against multipliers of modes, and of samples against their modes."""

import numpy as np
import pytest

import lobex
from lobex.limits.receptance import receptance
from lobex.limits.tooth_harmonics import harmonics_of
from refusals import refused

ROD = lobex.Rod(elements=5).modes(damping_ratio=0.03)
SPEEDS = np.array([60.0, 85.0, 150.0, 330.0])
FREQUENCY = np.arange(280.0, 1600.0, 2.0)
SAMPLES = receptance(ROD, 2 * np.pi * FREQUENCY)
FLAT = lobex.Modes.single(frequency=146.5, damping_ratio=0.0032, mass=2.573)
PLANE = lobex.Modes.plane(
    x=lobex.Modes.single(frequency=563.6, damping_ratio=0.0558, mass=1.4986),
    y=lobex.Modes.single(frequency=516.21, damping_ratio=0.025, mass=1.199),
)


def slot(modes):
    """By four teeth, whose force is constant, so that its mean is all of it."""
    return lobex.Milling(modes, 4, 6.79e8, 1.73824e8, 1.0, "up")


@pytest.fixture(scope="module")
def rod():
    return lobex.exact_limit(lobex.Rub(ROD), SPEEDS).growth()


def growing(process, limit, excess, passes=1):
    """σ of the largest multiplier."""
    return np.log(lobex.spectral_radius(process, limit.speed, limit.gain * (1 + excess))) * limit.speed * passes


def test_rates_are_those_of_the_multipliers(rod):
    step = 1e-4
    up, down = (growing(lobex.Rub(ROD), rod.limit, excess) for excess in (step, -step))
    assert rod.rate == pytest.approx((up - down) / (np.log1p(step) - np.log1p(-step)), rel=1e-7)
    assert rod.per_pass == pytest.approx(rod.rate / SPEEDS, rel=1e-14)
    # The second order leaves the third.
    off = [np.abs(rod.at(excess) / growing(lobex.Rub(ROD), rod.limit, excess) - 1) for excess in (0.04, 0.01)]
    assert np.max(off[0]) < 1e-3
    assert np.log(off[0] / off[1]) / np.log(4) == pytest.approx(2.0, abs=0.1)
    # Beyond what is said nothing is.
    assert np.isnan(rod.at(0.6)[rod.reach < 0.6]).all()
    assert (rod.reach < 0.6).any()


def test_the_chatter_frequency_drifts_with_the_gain(rod):
    step = 1e-3
    lanes = []
    for excess in (step, -step):
        found = lobex.multipliers(lobex.Rub(ROD), SPEEDS, rod.limit.gain * (1 + excess))[:, 0]
        lanes.append(np.abs(np.angle(found)))
    # A wave turns by the multiplier in a pass, in one sense or the other.
    turns = (lanes[0] - lanes[1]) / (np.log1p(step) - np.log1p(-step)) * SPEEDS
    assert np.abs(turns) == pytest.approx(np.abs(rod.drift) * 2 * np.pi * rod.limit.chatter_frequency, rel=1e-3)


def test_samples_have_the_rates_of_their_modes(rod):
    found = lobex.exact_limit(lobex.Rub(lobex.Receptance(FREQUENCY, SAMPLES)), SPEEDS).growth()
    assert found.rate == pytest.approx(rod.rate, rel=1e-6)
    assert found.bend == pytest.approx(rod.bend, rel=1e-3)
    # What every second line changes is more than what all of them miss.
    assert np.all(np.abs(found.rate - rod.rate) < found.error)
    assert np.all(found.error < 1e-3 * found.rate)


@pytest.mark.slow
def test_noise_hides_rates_before_it_hides_limits(rod):
    random = np.random.default_rng(2)
    noise = 1e-3 * np.max(np.abs(SAMPLES)) * random.standard_normal((2, len(SAMPLES))) / np.sqrt(2)
    response = SAMPLES + noise[0] + 1j * noise[1]
    noisy = lobex.exact_limit(lobex.Rub(lobex.Receptance(FREQUENCY, response)), SPEEDS)
    with pytest.warns(lobex.LobexWarning, match="of 4 rates of growth are lost.*by Frf.modes"):
        found = noisy.growth()
    lost = np.isnan(found.rate)
    assert 0 < lost.sum() < 4
    assert np.all(found.error[lost] > 0)
    known = ~lost
    assert np.all(np.abs(found.rate / rod.rate - 1)[known] < 0.5)
    fitted = lobex.Frf(FREQUENCY, response).modes()
    again = lobex.exact_limit(lobex.Rub(fitted), SPEEDS).growth()
    # At the last speed a mode chatters that is as small as the noise.
    assert again.rate[:3] == pytest.approx(rod.rate[:3], rel=0.05)
    assert again.rate[3] == pytest.approx(rod.rate[3], rel=0.3)


def test_of_the_mean_force_of_one_direction_it_is_turning():
    process = lobex.Milling(FLAT, 2, 6.79e8, 1.73824e8, 0.3, "up")
    limit = lobex.zero_order_limit(process, np.array([1500.0, 4000.0, 9000.0]) / 60)
    radial = float(harmonics_of(process, 0).mean[0, 0].real)
    turning = lobex.exact_limit(lobex.Turning(FLAT, radial=radial), limit.speed * 2)
    one, other = limit.growth(), turning.growth()
    for name in ("rate", "bend", "drift", "delay"):
        assert getattr(one, name) == pytest.approx(getattr(other, name), rel=1e-6)


@pytest.mark.slow
def test_where_the_force_is_constant_it_is_that_of_milling():
    limit, step = lobex.zero_order_limit(slot(PLANE), np.array([3000.0, 7000.0]) / 60), 1e-4
    found = limit.growth()
    up, down = (growing(slot(PLANE), limit, excess, 4) for excess in (step, -step))
    assert found.rate == pytest.approx((up - down) / (np.log1p(step) - np.log1p(-step)), rel=1e-6)


def test_of_measured_receptances_it_is_that_of_their_modes():
    frequency = np.arange(100.0, 1500.0, 1.0)
    natural = np.asarray(PLANE.angular_frequency)
    omega = 2 * np.pi * frequency[:, None]
    each = np.asarray(PLANE.shape).max(axis=1) ** 2 / (
        natural**2 - omega**2 + 2j * np.asarray(PLANE.damping_ratio) * natural * omega
    )
    matrix = np.zeros((len(frequency), 2, 2), complex)
    matrix[:, 0, 0], matrix[:, 1, 1] = each.T
    speed = np.array([3000.0, 7000.0]) / 60
    measured = lobex.zero_order_limit(slot(lobex.ReceptanceMatrix(frequency, matrix)), speed).growth()
    modal = lobex.zero_order_limit(slot(PLANE), speed).growth()
    assert measured.rate == pytest.approx(modal.rate, rel=1e-6)
    assert measured.bend == pytest.approx(modal.bend, rel=1e-3)
    assert np.all(np.abs(measured.rate - modal.rate) <= measured.error)


UNEVEN = lobex.Cutter.end_mill(0.02, pitch_degrees=[75, 100, 88, 97])
PAIR = lobex.Cutter.end_mill(0.02, pitch_degrees=[160, 200])


def milling(modes, cutter, immersion=0.5):
    return lobex.Milling(modes, cutter, 6.79e8, 1.73824e8, immersion, "down")


def test_of_the_mean_force_of_uneven_teeth_it_is_that_of_the_root():
    """By Newton's steps on det(I + b Σ (1 − e^{−sτᵢ}) G(s) Hᵢ) at complex s, with G of the modes there."""
    process, speed = milling(PLANE, UNEVEN), 5000 / 60
    limit = lobex.zero_order_limit(process, [speed])
    forces, delay = harmonics_of(process, 0).harmonics[:, 0], np.array([75, 100, 88, 97]) / 360 / speed
    natural, ratio, shape = (np.asarray(part) for part in (PLANE.angular_frequency, PLANE.damping_ratio, PLANE.shape))

    def off(s, depth):
        response = np.einsum("n,ni,nj->ij", 1 / (s**2 + 2 * ratio * natural * s + natural**2), shape, shape)
        return np.linalg.det(np.eye(2) + depth * response @ np.einsum("t,tij->ij", 1 - np.exp(-s * delay), forces))

    def root(depth):
        s = 2j * np.pi * limit.chatter_frequency[0]
        for _ in range(30):
            slope = (off(s + 1e-3, depth) - off(s - 1e-3, depth)) / 2e-3
            s = s - off(s, depth) / slope
        return s

    step, depth, growth = 1e-3, limit.gain[0], limit.growth()
    low, middle, high = (root(depth * np.exp(share)) for share in (-step, 0.0, step))
    assert abs(middle.real) < 1e-6 * abs(middle)
    assert growth.rate[0] == pytest.approx((high - low).real / (2 * step), rel=1e-5)
    assert growth.drift[0] == pytest.approx((high - low).imag / (2 * step) / middle.imag, rel=1e-4)
    assert growth.bend[0] == pytest.approx((high - 2 * middle + low).real / step**2, rel=1e-3)
    assert growth.delay[0] == pytest.approx(1 / (4 * speed))


HARMONIC = {
    "even teeth": (milling(PLANE, 4), 5000.0, 4000.0, 4),
    "a flip": (milling(FLAT, 1), 5000.0, 2000.0, 1),
    "uneven teeth": (milling(PLANE, PAIR), 9000.0, 2500.0, 1),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", HARMONIC)
def test_with_all_harmonics_it_is_that_of_the_operator(case):
    process, rpm, reach, passes = HARMONIC[case]
    limit, step = lobex.multi_frequency_limit(process, [rpm / 60], reach=reach), 1e-3
    found = limit.growth()
    up, down = (growing(process, limit, excess, passes) for excess in (step, -step))
    assert found.rate == pytest.approx((up - down) / (np.log1p(step) - np.log1p(-step)), rel=2e-3)
    assert limit.kind[0] == ("flip" if case == "a flip" else "hopf")
    turns = []
    for excess in (step, -step):
        mu = lobex.multipliers(process, limit.speed[0], limit.gain[0] * (1 + excess))[0]
        turns.append(np.abs(np.angle(mu)) / (2 * np.pi))
    # A wave turns by the multiplier in a period, in one sense or the other.
    drift = (turns[0] - turns[1]) / (2 * step) * limit.speed * passes
    assert np.abs(drift) == pytest.approx(np.abs(found.drift) * limit.chatter_frequency, rel=1e-2, abs=1e-6)


def test_where_the_force_is_constant_harmonics_change_nothing():
    speed = np.array([3000.0, 7000.0]) / 60
    mean, all_of_it = (
        solve(slot(PLANE), speed).growth() for solve in (lobex.zero_order_limit, lobex.multi_frequency_limit)
    )
    for name in ("rate", "bend", "drift", "delay"):
        assert getattr(all_of_it, name) == pytest.approx(getattr(mean, name), rel=1e-6)


@pytest.mark.slow
def test_no_limit_has_no_rate():
    band = lobex.Receptance(FREQUENCY[:80], SAMPLES[:80])
    found = lobex.exact_limit(lobex.Rub(band), [200.0, 3000.0]).growth()
    assert np.isnan(found.rate).tolist() == [False, True]
    assert np.isnan(found.at(0.01)).tolist() == [False, True]
    assert "estimated error" in repr(found)
    # Below the first mode.
    below = lobex.Receptance(FREQUENCY[:8], SAMPLES[:8])
    nothing = lobex.exact_limit(lobex.Rub(below), [200.0]).growth()
    assert "no limit" in repr(nothing)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: lobex.critical_gain(lobex.Rub(ROD), [85.0], (4.5e4, 4.5e6)).growth(),
            "whose root is no function of one response; give lobex.spectral_radius",
        ),
        pytest.param(
            lambda: lobex.exact_limit(lobex.Rub(lobex.Blading(FLAT, 3)), [85.0]).growth(),
            "limit of Rub is not of one frequency response",
            marks=pytest.mark.slow,
        ),
        (lambda: lobex.exact_limit(lobex.Rub(ROD), [85.0]).growth().at(-1.0), "excess = -1 leaves no gain"),
    ],
)
def test_other_limits_are_refused_in_one_line(call, words):
    with refused(words):
        call()
