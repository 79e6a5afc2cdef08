"""Milling limits from receptances: against the whole state by collocation, closed forms, and modes fitted to noise."""

from functools import partial

import numpy as np
import pytest

import lobex
from lobex.limits.tooth_harmonics import harmonics_of
from milling_collocation import multipliers
from refusals import refused
from tap_test import FREQUENCY, OMEGA, RATIO, SHAPE, noisy

TANGENTIAL, NORMAL = 6.79e8, 1.73824e8
# Of two directions, as an end mill in its spindle.
PLANE = lobex.Modes.plane(
    x=lobex.Modes.single(frequency=563.6, damping_ratio=0.0558, mass=1.4986),
    y=lobex.Modes.single(frequency=516.21, damping_ratio=0.025, mass=1.199),
)
FLAT = lobex.Modes.single(frequency=146.5, damping_ratio=0.0032, mass=2.573)
CASES = {
    "half immersion": (PLANE, 4, 0.5, "down", [2500.0, 5000.0, 9000.0]),
    "small immersion": (PLANE, 2, 0.1, "up", [2500.0, 4000.0, 9000.0]),
    "with flips": (FLAT, 1, 0.5, "down", [4000.0, 5000.0, 15000.0]),
}


def milling(modes, teeth, immersion, direction):
    return lobex.Milling(modes, teeth, TANGENTIAL, NORMAL, immersion, direction)


def dominant(case, speed, depth):
    """The largest multiplier of an independent code."""
    modes, teeth, immersion, direction, _ = CASES[case]
    cutter = {"omega": modes.angular_frequency, "ratio": modes.damping_ratio, "shape": modes.shape, "teeth": teeth}
    cutter |= {"radial_immersion": immersion, "direction": direction, "tangential": TANGENTIAL, "normal": NORMAL}
    return multipliers(cutter, speed, depth)[0]


@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=pytest.mark.slow if case == "small immersion" else ()) for case in CASES]
)
def test_all_harmonics_are_on_the_boundary_of_an_independent_code(case):
    *numbers, rpm = CASES[case]
    top = float(np.max(numbers[0].frequency))
    limit = lobex.multi_frequency_limit(
        milling(*numbers), np.array(rpm) / 60, reach=(8 if numbers[0] is FLAT else 4) * top
    )
    for speed, gain, kind, frequency in zip(limit.speed, limit.gain, limit.kind, limit.chatter_frequency, strict=True):
        below, above = (abs(dominant(case, speed, gain * (1 + share))) for share in (-2e-3, 2e-3))
        assert below < 1 < above
        mu = dominant(case, speed, gain)
        assert kind == ("flip" if abs(mu + 1) < 1e-2 else "hopf")
        # A wave of the chatter turns by the multiplier in a tooth pass, in one sense or the other.
        turns = frequency / (speed * numbers[1])
        angle = np.angle(mu) / (2 * np.pi)
        assert min(abs((turns - angle + 0.5) % 1 - 0.5), abs((turns + angle + 0.5) % 1 - 0.5)) < 2e-3
    assert set(limit.kind) == ({"hopf", "flip"} if case == "with flips" else {"hopf"})


@pytest.mark.slow
def test_what_the_mean_force_neglects_is_little_at_half_immersion_and_much_at_a_tenth_and_at_flips():
    def ratio(*numbers, rpm):
        process = milling(*numbers)
        both = [solve(process, rpm / 60).gain[0] for solve in (lobex.zero_order_limit, lobex.multi_frequency_limit)]
        return both[0] / both[1]

    assert ratio(PLANE, 4, 0.5, "down", rpm=5000.0) == pytest.approx(1.0, abs=0.01)
    assert ratio(PLANE, 2, 0.1, "down", rpm=2500.0) == pytest.approx(0.73, abs=0.02)
    assert ratio(FLAT, 1, 0.5, "down", rpm=5000.0) == pytest.approx(1.97, abs=0.03)


@pytest.mark.slow
def test_the_error_falls_with_the_third_power_of_the_reach():
    process, top = milling(PLANE, 4, 0.5, "down"), 563.6
    gain = [lobex.multi_frequency_limit(process, 9000 / 60, reach=k * top).gain[0] for k in (2, 4, 8, 24)]
    off = np.abs(np.array(gain[:3]) / gain[3] - 1)
    order = np.log2(off[:-1] / off[1:])
    assert np.mean(order) > 2.5


def test_the_mean_force_is_the_closed_form_of_the_source():
    start, stop, ratio, teeth = np.pi / 2, np.pi, NORMAL / TANGENTIAL, 3
    process = milling(PLANE, teeth, 0.5, "down")

    def alpha(angle):
        # Altintas and Budak (1995), with φ from the y axis: the force on the cutter is ½ b K_t A₀ Δ.
        cosine, sine = np.cos(2 * angle), np.sin(2 * angle)
        return 0.5 * np.array(
            [
                [cosine - 2 * ratio * angle + ratio * sine, -sine - 2 * angle + ratio * cosine],
                [-sine + 2 * angle + ratio * cosine, -cosine - 2 * ratio * angle - ratio * sine],
            ]
        )

    wanted = -TANGENTIAL / 2 * teeth / (2 * np.pi) * (alpha(stop) - alpha(start))
    np.testing.assert_allclose(harmonics_of(process, 0).mean, wanted, rtol=1e-12, atol=1e-4)


def test_zero_order_of_one_direction_is_turning_by_the_mean_force():
    process = milling(FLAT, 2, 0.3, "up")
    speed = np.array([1500.0, 4000.0, 9000.0]) / 60
    mean = float(harmonics_of(process, 0).mean[0, 0].real)
    turning = lobex.exact_limit(lobex.Turning(FLAT, radial=mean), speed * 2)
    limit = lobex.zero_order_limit(process, speed)
    np.testing.assert_allclose(limit.gain, turning.gain, rtol=1e-9)
    np.testing.assert_allclose(limit.chatter_frequency, turning.chatter_frequency, rtol=1e-9)


def test_where_the_force_is_constant_both_solutions_are_one():
    # A slot by four teeth.
    process, speed = milling(PLANE, 4, 1.0, "up"), np.array([3000.0, 7000.0]) / 60
    mean, all_of_it = lobex.zero_order_limit(process, speed), lobex.multi_frequency_limit(process, speed)
    np.testing.assert_allclose(all_of_it.gain, mean.gain, rtol=1e-9)


def uneven(*degrees):
    return lobex.Cutter.end_mill(0.02, pitch_degrees=degrees)


@pytest.mark.slow
def test_pitches_that_grow_alike_have_the_limits_of_even_ones():
    """Teeth at 90 degrees, each with a delay of its own and by the harmonics of a revolution, and as one."""
    speed, small, large = np.array([150.0]), 1e-4, 2e-4
    for solve in (lobex.zero_order_limit, partial(lobex.multi_frequency_limit, reach=900.0)):
        even = solve(milling(PLANE, 4, 0.5, "down"), speed)
        off = []
        for size in (small, large):
            one = solve(milling(PLANE, uneven(90 + size, 90 - size, 90 + size / 2, 90 - size / 2), 0.5, "down"), speed)
            assert one.chatter_frequency == pytest.approx(even.chatter_frequency, rel=1e-3)
            off.append(one.gain[0] / even.gain[0] - 1)
        assert np.max(np.abs(off)) < 1e-4


# By the operator, to a few 1e-7.
UNEVEN = {(70.0, 110.0, 70.0, 110.0): (6.0238190e-3, 571.2945), (75.0, 100.0, 88.0, 97.0): (2.1842684e-3, 535.4492)}


@pytest.mark.parametrize("degrees", UNEVEN)
def test_uneven_teeth_have_the_limit_of_the_operator(degrees):
    """To what frequencies above four times the highest leave out; the mean force alone is off by some per cent."""
    process, speed = milling(PLANE, uneven(*degrees), 0.5, "down"), [5000 / 60]
    depth, frequency = UNEVEN[degrees]
    all_of_it, mean = lobex.multi_frequency_limit(process, speed), lobex.zero_order_limit(process, speed)
    assert all_of_it.gain[0] == pytest.approx(depth, rel=2e-4)
    assert all_of_it.chatter_frequency[0] == pytest.approx(frequency, rel=1e-4)
    assert 1e-4 < abs(mean.gain[0] / depth - 1) < 1e-2


@pytest.mark.slow
@pytest.mark.parametrize("degrees", UNEVEN)
def test_limits_of_uneven_teeth_are_where_the_operator_has_its_multiplier_on_the_circle(degrees):
    process, (depth, frequency) = milling(PLANE, uneven(*degrees), 0.5, "down"), UNEVEN[degrees]
    limit = lobex.critical_gain(process, [5000 / 60], (1e-4, 1.2 * depth), scan=17)
    assert limit.gain[0] == pytest.approx(depth, rel=5e-7)
    assert limit.chatter_frequency[0] == pytest.approx(frequency, rel=1e-6)
    at = [lobex.spectral_radius(process, limit.speed[0], limit.gain[0], lobex.Duhamel(nodes=30))]
    assert at == pytest.approx([1.0], abs=1e-8)


@pytest.mark.slow
def test_measured_receptances_have_the_limits_of_the_modes_with_uneven_teeth():
    frf, speed = sampled(0.0), [5000 / 60]
    direct, modal = (
        milling(source, uneven(100.0, 120.0, 140.0), 0.5, "down") for source in (frf.receptance_matrix(), frf.modes())
    )
    zero = [lobex.zero_order_limit(process, speed).gain for process in (direct, modal)]
    np.testing.assert_allclose(*zero, rtol=1e-5)
    both = [lobex.multi_frequency_limit(process, speed, reach=FREQUENCY[-1]).gain for process in (direct, modal)]
    np.testing.assert_allclose(*both, rtol=2e-2)


def sampled(noise, **others):
    """Of the tap test's structure, measured at its lines."""
    natural = 2 * np.pi * np.array([180.0, 450.0, 900.0])
    terms = 1 / (natural**2 - OMEGA[:, None] ** 2 + 2j * RATIO * natural * OMEGA[:, None])
    values = np.einsum("nk,ki,kj->nij", terms, SHAPE, SHAPE)
    return lobex.Frf(FREQUENCY, noisy(values, noise), ("x", "y"), ("x", "y"), **others)


def test_measured_receptances_have_the_limits_of_the_modes():
    frf, speed = sampled(0.0), np.array([2000.0, 5000.0]) / 60
    direct, modal = (milling(source, 3, 0.5, "down") for source in (frf.receptance_matrix(), frf.modes()))
    zero = [lobex.zero_order_limit(process, speed).gain for process in (direct, modal)]
    np.testing.assert_allclose(*zero, rtol=1e-5)
    both = [lobex.multi_frequency_limit(process, speed, reach=FREQUENCY[-1]).gain for process in (direct, modal)]
    # Below the first line and above the last the modes go on.
    np.testing.assert_allclose(*both, rtol=2e-2)
    assert lobex.multi_frequency_limit(direct, speed).gain == pytest.approx(both[0], rel=1e-12)


def test_noise_moves_limits_of_samples_more_than_those_of_a_fit():
    speed = np.linspace(2000, 6000, 9) / 60
    clean = lobex.zero_order_limit(milling(sampled(0.0).modes(), 3, 0.5, "down"), speed).gain
    frf = sampled(0.01)
    samples, fit = (
        np.abs(lobex.zero_order_limit(milling(source, 3, 0.5, "down"), speed).gain / clean - 1)
        for source in (frf.receptance_matrix(), frf.modes())
    )
    assert np.max(fit) < 0.05
    assert np.median(fit) < np.median(samples)


def test_a_single_receptance_and_cross_receptances_that_were_not_measured():
    frf, speed = sampled(0.0), [80.0]
    one = frf.receptance("x")
    flat = milling(one, 2, 0.5, "down")
    assert lobex.zero_order_limit(flat, speed).gain[0] > 0
    only = np.where(np.eye(2, dtype=bool), frf.matrix, np.nan)
    apart = lobex.Frf(FREQUENCY, only, ("x", "y"), ("x", "y")).receptance_matrix()
    assert not np.any(apart.response[:, 0, 1])
    upper = np.where([[True, True], [False, True]], frf.matrix, np.nan)
    both = lobex.Frf(FREQUENCY, upper, ("x", "y"), ("x", "y")).receptance_matrix()
    np.testing.assert_array_equal(both.response[:, 1, 0], frf.matrix[:, 0, 1])


def test_lines_without_a_signal_are_left_out():
    frf = sampled(0.0).between(100.0, 1000.0)
    assert frf.frequency[[0, -1]].tolist() == [100.0, 1000.0]
    np.testing.assert_array_equal(frf.matrix, sampled(0.0).matrix[20:381])
    with refused("frequency has 0 lines above 0 Hz"):
        frf.between(2000.0, 3000.0)
    with refused("low, high = [300, 200] is not strictly increasing"):
        frf.between(300.0, 200.0)


def test_where_the_band_ends_the_status_says_so(tmp_path):
    limit = lobex.zero_order_limit(milling(sampled(0.0).receptance("x"), 3, 0.5, "up"), [80.0, 5e3 / 3])
    assert limit.status.tolist() == ["found", "beyond the measured frequencies"]
    limit.save(tmp_path / "limit.nc")
    assert lobex.load(tmp_path / "limit.nc").status.tolist() == limit.status.tolist()
    assert "ZeroOrder()" in repr(limit)
    limit.plot()


HELIX = lobex.Cutter.end_mill(0.016, teeth=4, helix_degrees=30)
RUNOUT = lobex.Cutter.end_mill(0.02, teeth=2, runout=[0, 1e-5])


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: lobex.zero_order_limit(lobex.Turning(FLAT, radial=1e8), 80.0),
            "Turning is no milling; give exact_limit",
        ),
        (lambda: lobex.zero_order_limit(milling(PLANE, HELIX, 0.5, "down"), 80.0), "has a helix, which this solution"),
        (
            lambda: lobex.zero_order_limit(
                milling(PLANE, lobex.Cutter.end_mill(0.02, teeth=2, runout=[0, 1e-5]), 0.5, "up"), 80.0
            ),
            "has runout, which this solution does not take",
        ),
        (
            lambda: lobex.multi_frequency_limit(milling(FLAT, 1, 0.5, "down"), 80.0, reach=100.0),
            "reach = 100 Hz is not",
        ),
        (lambda: lobex.multi_frequency_limit(milling(FLAT, 1, 0.5, "down"), -1.0), "speed = -1 must be positive"),
        (
            lambda: lobex.spectral_radius(milling(sampled(0).receptance_matrix(), 2, 0.5, "up"), 80.0, 1e-3),
            "multi_freq",
        ),
        (
            lambda: lobex.ReceptanceMatrix(FREQUENCY, np.ones((len(FREQUENCY), 2, 3))),
            "has shape (460, 2, 3); give (460",
        ),
        (lambda: lobex.ReceptanceMatrix(FREQUENCY, np.zeros((len(FREQUENCY), 1, 1))), "has zeros at a driving point"),
        (lambda: lobex.ReceptanceMatrix(FREQUENCY[:3], np.ones((3, 1, 1))), "has 3 samples; give at least 4"),
    ],
)
def test_what_these_solutions_do_not_take_is_refused(call, words):
    with refused(words):
        call()
