"""``exact_limit`` and ``exact_lobes`` as users call them, and ``critical_gain`` against them."""

import jax
import numpy as np
import pytest

import lobex
from cases import LIMIT_CASES, MILL, ROD, rub
from refusals import refused

RODS = [c for c in LIMIT_CASES if c["problem"] == "rod-rub"]


def measured(modes, frequency):
    """The modes' receptance as somebody would have measured it."""
    omega = 2 * np.pi * frequency[:, None]
    own, ratio = modes.angular_frequency, modes.damping_ratio
    response = np.sum(modes.shape[:, 0] ** 2 / (own**2 - omega**2 + 2j * ratio * own * omega), axis=1)
    return lobex.Receptance(frequency, response)


@pytest.mark.parametrize("ratio", [0.03, 0.0177])
def test_reference_limits_to_1e_9(ratio):
    cases = [c for c in RODS if c["damping_ratio"] == ratio]
    limit = lobex.exact_limit(rub(5, ratio), [c["speed_Hz"] for c in cases])
    expected = [c["critical_contact_stiffness_N_per_m"] for c in cases]
    # The reference gives ten digits.
    assert limit.gain == pytest.approx(expected, rel=1e-9)
    assert limit.chatter_frequency == pytest.approx([c["chatter_frequency_Hz"] for c in cases], rel=1e-7)
    assert set(limit.status) == {"found"}
    assert set(limit.kind) == {"hopf"}
    assert limit.lobe.tolist() == [6, 5, 4, 4, 3, 2, 1, 1, 0]
    assert limit.intervals[:, 0, 1] == pytest.approx(limit.gain)


# By roots at a thousand in test_critical_constant.py.
@pytest.mark.timeout(900)
@pytest.mark.parametrize(
    "count", [pytest.param(128, marks=pytest.mark.slow), pytest.param(1000, marks=pytest.mark.search)]
)
def test_critical_gain_agrees_at_many_speeds_cusps_included(count):
    speeds = np.linspace(50, 400, count)
    exact = lobex.exact_limit(ROD, speeds)
    searched = lobex.critical_gain(ROD, speeds, (1e5, 2.5e6), lobex.Chebyshev(56), scan=5)
    inside = exact.gain < 2.5e6
    assert set(searched.status[inside]) <= {"found", "tie"}
    assert searched.gain[inside] == pytest.approx(exact.gain[inside], rel=1e-8)
    assert searched.chatter_frequency[inside] == pytest.approx(exact.chatter_frequency[inside], rel=1e-6)
    assert np.isnan(searched.gain[~inside]).all()
    assert set(searched.status[~inside]) == {"none in range"}


def test_a_measured_receptance_stands_in_for_the_modes():
    frf = measured(ROD.modes, np.linspace(150, 2500, 4000))
    speeds = np.array([60.0, 85.0, 150.0, 200.0])
    modal = lobex.exact_limit(ROD, speeds).gain
    assert lobex.exact_limit(lobex.Rub(frf), speeds).gain == pytest.approx(modal, rel=1e-6)
    assert lobex.exact_limit(lobex.Turning(frf, radial=3e8), speeds).gain * 3e8 == pytest.approx(modal, rel=1e-6)
    assert lobex.exact_limit(lobex.Rub(frf), speeds).process["modes"]["type"] == "Receptance"


def test_hayes_limits_through_the_verb():
    limit = lobex.exact_limit(lobex.Scalar(-1.5), [0.5, 2.0])
    assert limit.gain == pytest.approx([1.5, 1.5])
    assert set(limit.kind) == {"fold"}
    radius = lobex.spectral_radius(lobex.Scalar(-1.5), limit.speed, limit.intervals[:, 0, 0], lobex.Chebyshev(32))
    assert radius == pytest.approx(1, abs=1e-10)
    assert lobex.exact_limit(lobex.Scalar(3.0), [1.0]).status.tolist() == ["none in range"]


def test_lobes_as_curves_pass_through_the_limit():
    lobes = lobex.exact_lobes(ROD, lobes=6)
    below = np.nanmin(lobes.gain)
    assert lobes.minimum.gain == pytest.approx(below, rel=1e-3)
    assert lobes.minimum.gain <= below
    at_minimum = lobex.exact_limit(ROD, lobes.minimum.speed)
    assert at_minimum.gain == pytest.approx(np.full(6, lobes.minimum.gain), rel=1e-11)
    assert lobes.speed.shape == (6, *lobes.gain.shape)
    # No point of a lobe lies under the limit at its speed.
    speed, gain = lobes.speed[1][::7], lobes.gain[::7]
    shown = np.isfinite(gain)
    assert np.all(lobex.exact_limit(ROD, speed[shown]).gain <= gain[shown] * (1 + 1e-10))


def test_derivative_by_the_damping_of_the_whole_chain():
    with jax.enable_x64(True):

        def limit(ratio):
            return lobex.exact_limit(lobex.Rub(lobex.Rod(5).modes(ratio)), 85.0).gain[0]

        slope = float(jax.jit(jax.grad(limit))(0.03))
    step = 1e-5
    difference = (float(limit(0.03 + step)) - float(limit(0.03 - step))) / (2 * step)
    assert slope == pytest.approx(difference, rel=1e-7)


def test_limits_save_load_and_print(tmp_path):
    limit = lobex.exact_limit(ROD, [85.0, 200.0])
    limit.save(tmp_path / "exact.nc")
    again = lobex.load(tmp_path / "exact.nc")
    assert again.gain.tolist() == limit.gain.tolist()
    assert again.bounds == (0.0, np.inf)
    assert "DSubdivision" in repr(again)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: lobex.exact_limit(MILL, [50.0]), "Milling has no exact limit"),
        (lambda: lobex.exact_limit(ROD, [0.0]), "speed = "),
        (lambda: lobex.exact_limit(ROD, []), "speed has shape (0,)"),
        (lambda: lobex.exact_limit(ROD.modes, [50.0]), "is no process"),
        (lambda: lobex.exact_lobes(ROD, lobes=0), "lobes = 0"),
        (lambda: lobex.exact_lobes(lobex.Scalar(1.0)), "Scalar has no exact limit"),
    ],
)
def test_bad_input_is_refused_in_one_line(call, words):
    with refused(words):
        call()
