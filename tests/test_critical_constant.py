"""Critical gains of constant coefficients: every crossing of the imaginary axis, against closed forms and operators."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lobex
from cases import ROD

# Two modes that calm each other between 1.8 and 2.1 MN/m around 229 Hz, above the first limit.
PAIR = lobex.Rub(
    lobex.Modes(2 * np.pi * np.array([159.6, 221.4]), np.array([0.0118, 0.0593]), np.array([[0.439], [0.738]]))
)


def test_a_thousand_speeds_of_the_rod_are_the_closed_form_cusps_included():
    speed = np.linspace(50, 400, 1000)
    exact = lobex.exact_limit(ROD, speed)
    limit = lobex.critical_gain(ROD, speed, (4.5e4, 4.5e6))
    assert limit.method["type"] == "CharacteristicRoots"
    inside = exact.gain < 4.5e6
    assert inside.sum() > 900
    assert limit.gain[inside] == pytest.approx(exact.gain[inside], rel=1e-12)
    assert limit.chatter_frequency[inside] == pytest.approx(exact.chatter_frequency[inside], rel=1e-12)
    assert set(limit.status[~inside]) == {"none in range"}
    assert np.all(limit.error[inside] < 1e-11 * limit.gain[inside])


def test_every_interval_is_that_of_the_operator_re_entrant_ones_included():
    speed = np.linspace(60, 300, 41)
    bounds = 1e3, 4e6
    limit = lobex.critical_gain(PAIR, speed, bounds)
    other = lobex.critical_gain(PAIR, speed, bounds, lobex.Duhamel(nodes=24), scan=257)
    several = np.isfinite(limit.intervals[..., 0]).sum(axis=1) > 1
    assert several.any()
    assert limit.intervals == pytest.approx(other.intervals, rel=1e-9, nan_ok=True)
    assert limit.gain == pytest.approx(other.gain, rel=1e-9, nan_ok=True)
    assert limit.status.tolist() == other.status.tolist()


def test_random_structures_have_their_closed_form():
    random = np.random.default_rng(1)
    for _ in range(20):
        shape, frequency = random.uniform(0.05, 1, (3, 1)), np.sort(random.uniform(50, 600, 3))
        process = lobex.Rub(lobex.Modes(2 * np.pi * frequency, 10 ** random.uniform(-3, -0.7, 3), shape))
        speed = np.sort(random.uniform(20, 900, 64))
        exact = lobex.exact_limit(process, speed).gain
        highest = float(np.quantile(exact, 0.8))
        limit = lobex.critical_gain(process, speed, (1e-6 * highest, highest))
        assert limit.gain == pytest.approx(np.where(exact < highest, exact, np.nan), rel=1e-10, nan_ok=True)


def test_a_cusp_between_two_lobes_is_a_tie():
    grid = np.linspace(100, 140, 41)
    lobe = lobex.exact_limit(ROD, grid).lobe
    first = int(np.flatnonzero(np.diff(lobe))[0])
    low, high = grid[first], grid[first + 1]
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if lobex.exact_limit(ROD, middle).lobe[0] == lobe[first] else (low, middle)
    assert lobex.critical_gain(ROD, low, (4.5e4, 4.5e6)).status.tolist() == ["tie"]
    assert lobex.critical_gain(ROD, 0.999 * low, (4.5e4, 4.5e6)).status.tolist() == ["found"]


def test_gains_of_both_signs():
    # Hayes (1950): ẋ = −x + b x(t − τ) is stable up to b = 1, from a negative b on that depends on τ.
    speed = np.array([0.2, 0.5, 1.0, 3.0])
    process = lobex.Scalar(a=-1.0)
    exact = lobex.exact_limit(process, speed)
    limit = lobex.critical_gain(process, speed, (-20.0, 20.0))
    assert set(limit.status) == {"unstable at the lower bound"}
    assert limit.intervals == pytest.approx(exact.intervals, rel=1e-12)
    upper = lobex.critical_gain(process, speed, (-1.1, 20.0))
    assert upper.gain == pytest.approx(exact.gain, rel=1e-12)
    assert set(upper.kind) == {"fold"}
    # An unstable open loop is stabilised by a negative gain alone, and not by slow sampling.
    unstable = lobex.critical_gain(lobex.Scalar(a=1.0), [0.6, 2.0], (-20.0, 20.0))
    assert np.isnan(unstable.intervals[0]).all()
    assert unstable.intervals[1, 0] == pytest.approx(lobex.exact_limit(lobex.Scalar(a=1.0), 2.0).intervals[0, 0])


def test_poles_on_the_axis_are_left_to_the_operator():
    process = lobex.Rub(lobex.Rod(1).modes(0.0))
    speed = np.linspace(100, 400, 7)
    exact = lobex.exact_limit(process, speed).gain
    assert np.any(exact == 0)
    limit = lobex.critical_gain(process, speed, (1e4, 4e6))
    assert limit.gain == pytest.approx(np.where(exact > 1e4, exact, np.nan), rel=1e-8, nan_ok=True)
    assert set(limit.status[exact == 0]) == {"unstable at the lower bound"}


@settings(max_examples=15)
@given(st.floats(0.5, 2.0), st.floats(0.5, 2.0))
def test_stiffness_and_mass_scale_limits_and_speeds(stiffness, mass):
    speed = np.linspace(60, 400, 32)
    limit = lobex.critical_gain(ROD, speed, (4.5e4, 4.5e6))
    scaled = lobex.Rub(lobex.Rod(young_modulus=210e7 * stiffness, density=4600.0 * mass).modes(0.03))
    factor = np.sqrt(stiffness / mass)
    other = lobex.critical_gain(scaled, factor * speed, (4.5e4 * stiffness, 4.5e6 * stiffness))
    assert other.gain == pytest.approx(stiffness * limit.gain, rel=1e-10, nan_ok=True)
    assert other.chatter_frequency == pytest.approx(factor * limit.chatter_frequency, rel=1e-10, nan_ok=True)
