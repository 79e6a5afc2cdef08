"""Contact laws against their formulas, quadrature and the physics of plasticity."""

import jax
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

import lobex
from refusals import refused

LAWS = {
    "linear": lobex.Linear(4.5e6),
    "cubic": lobex.Cubic(width=2e-3, first=3e8, second=-1e12, third=2e15),
    "threshold": lobex.Threshold(width=2e-3, offset=5e3, slope=4e8),
    "power": lobex.Power(width=2e-3, coefficient=8e7, exponent=0.75),
    "bilinear": lobex.Bilinear(stiffness=4.5e6, second_stiffness=1.5e6, transition=2.5e-5),
    "kelvin-voigt": lobex.KelvinVoigt(stiffness=4.5e6, viscosity=80.0),
    "plastic": lobex.Plastic(stiffness=4.5e6, yield_force=60.0, hardening=1.5e6),
}
PENETRATION = np.array([-1.0, -1e-12, 0.0, 1e-9, 1e-5, 4e-5, 1e-3])

in_float64 = pytest.mark.usefixtures("_wide")


@pytest.fixture
def _wide():
    with jax.enable_x64(True):
        yield


def test_forces_are_those_of_the_source():
    with jax.enable_x64(True):
        h = 3e-5
        assert LAWS["linear"].force(h) == pytest.approx(4.5e6 * h, rel=1e-15)
        assert LAWS["cubic"].force(h) == pytest.approx(2e-3 * (3e8 * h - 1e12 * h**2 + 2e15 * h**3), rel=1e-14)
        assert LAWS["threshold"].force(h) == pytest.approx(2e-3 * (5e3 + 4e8 * h), rel=1e-15)
        assert LAWS["power"].force(h) == pytest.approx(2e-3 * 8e7 * h**0.75, rel=1e-14)
        assert LAWS["bilinear"].force(h) == pytest.approx(4.5e6 * 2.5e-5 + 1.5e6 * 0.5e-5, rel=1e-14)
        assert LAWS["bilinear"].force(2e-5) == pytest.approx(4.5e6 * 2e-5, rel=1e-14)
        assert LAWS["kelvin-voigt"].force(h, 0.0, 0.2) == pytest.approx(4.5e6 * h + 80 * 0.2, rel=1e-14)
        # A tip that leaves quickly is let go, and never pulled.
        assert LAWS["kelvin-voigt"].force(h, 0.0, -2.0) == 0
        # 135 N of elastic force against a yield force of 60 N.
        flow = (4.5e6 * h - 60) / (4.5e6 + 1.5e6)
        assert LAWS["plastic"].force(h) == pytest.approx(4.5e6 * (h - flow), rel=1e-14)
        assert LAWS["plastic"].removed(h, 0.0, -1.0) == pytest.approx(flow, rel=1e-14)


@in_float64
@pytest.mark.parametrize("name", LAWS)
def test_nothing_happens_out_of_contact(name):
    law, out = LAWS[name], PENETRATION <= 0
    for depth in (0.0, 2e-5):
        for value in (law.force(PENETRATION, depth), law.energy(PENETRATION, depth)):
            assert np.all(np.asarray(value)[out] == 0)
            assert np.all(np.asarray(value)[~out] > 0)
        removed = np.asarray(law.removed(PENETRATION, depth, PENETRATION / 2))
        assert np.all(removed[out] == 0)
        assert np.all(removed >= 0)


@in_float64
@pytest.mark.parametrize("depth", [0.0, 3e-5])
@pytest.mark.parametrize("name", LAWS)
def test_energy_is_the_integral_of_the_force(name, depth):
    law = LAWS[name]
    yielding = (60 + 1.5e6 * depth) / 4.5e6
    for h in (5e-6, 2e-5, 2e-4):
        bends = {"plastic": yielding, "bilinear": 2.5e-5}
        kink = [bends[name]] if bends.get(name, h) < h else None
        work, error = quad(lambda x: float(law.force(x, depth)), 0, h, points=kink, epsabs=0, epsrel=1e-10)
        assert law.energy(h, depth) == pytest.approx(work, rel=1e-9, abs=10 * error)


@in_float64
@pytest.mark.parametrize("name", LAWS)
def test_derivatives_are_finite_everywhere_and_those_of_differences(name):
    law = LAWS[name]
    slopes = np.asarray(jax.vmap(jax.grad(law.force))(PENETRATION))
    assert np.all(np.isfinite(slopes))
    assert np.all(slopes[PENETRATION <= 0] == 0)
    assert np.all(np.isfinite(jax.tree.leaves(jax.grad(lambda law: law.force(0.0))(law))))
    h, step = 4e-5, 1e-9
    difference = (law.force(h + step) - law.force(h - step)) / (2 * step)
    assert jax.grad(law.force)(h) == pytest.approx(float(difference), rel=1e-5)


@in_float64
@pytest.mark.parametrize("name", LAWS)
def test_compiled_and_not_are_the_same(name):
    compiled = jax.jit(lambda law, h, depth: law.force(h, depth))
    force = np.asarray(compiled(LAWS[name], PENETRATION, 1e-5))
    assert force == pytest.approx(np.asarray(LAWS[name].force(PENETRATION, 1e-5)), rel=1e-14)


@in_float64
def test_penalty_laws_give_way_to_the_tip():
    removed = LAWS["linear"].removed(np.array([-1e-5, 1e-5, 1e-5]), 0.0, np.array([2e-5, 2e-5, -3e-5]))
    assert np.asarray(removed).tolist() == [0, 2e-5, 0]


@settings(max_examples=50)
@given(st.floats(1e-6, 1e-3), st.floats(0.01, 0.99), st.floats(0, 1e7), st.floats(1.0, 500.0))
def test_plastic_loading_in_two_stages_is_loading_in_one(whole, share, hardening, yield_force):
    law = lobex.Plastic(4.5e6, yield_force, hardening)
    with jax.enable_x64(True):
        first = float(law.removed(share * whole, 0.0, 0.0))
        second = float(law.removed(whole - first, first, 0.0))
        # Penetrations of 1e-3 m leave forces of 1e-12 · 4.5e3 N to rounding.
        assert first + second == pytest.approx(float(law.removed(whole, 0.0, 0.0)), rel=1e-9, abs=1e-17)
        assert law.force(whole - first, first) == pytest.approx(float(law.force(whole, 0.0)), rel=1e-9, abs=1e-8)
        done = first + second
        assert law.force(whole, 0.0) <= (yield_force + hardening * done) * (1 + 1e-12) + 1e-8
        # The tip comes back to where it was: elastic, nothing more is removed.
        assert law.removed(whole - done, done, 0.0) == pytest.approx(0, abs=1e-15)
        # All the work went into elastic energy and plastic flow.
        spent = float(law.force(whole, 0.0)) ** 2 / (2 * 4.5e6) + done * (yield_force + hardening * done / 2)
        assert law.energy(whole, 0.0) == pytest.approx(spent, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: lobex.Linear(-1.0), "stiffness = -1"),
        (lambda: lobex.Linear(np.nan), "stiffness = nan"),
        (lambda: lobex.Linear([1.0, 2.0]), "stiffness has shape (2,)"),
        (lambda: lobex.Linear("stiff"), "stiffness = 'stiff'"),
        (lambda: lobex.Cubic(1e-3, 1.0, -3.0, 1.0), "negative force"),
        (lambda: lobex.Cubic(1e-3, -1.0, 0.0, 1.0), "negative force"),
        (lambda: lobex.Cubic(-1e-3, 1.0, 0.0, 1.0), "width = -0.001"),
        (lambda: lobex.Threshold(1e-3, -1.0, 1.0), "offset = -1"),
        (lambda: lobex.Power(1e-3, 1e8, 0.0), "exponent = 0"),
        (lambda: lobex.Power(1e-3, np.inf, 0.7), "coefficient = inf"),
        (lambda: lobex.Bilinear(1.0, -1.0, 1e-5), "second_stiffness = -1"),
        (lambda: lobex.Bilinear(1.0, 1.0, np.inf), "transition = inf"),
        (lambda: lobex.KelvinVoigt(1.0, -2.0), "viscosity = -2"),
        (lambda: lobex.Plastic(0.0, 1.0), "stiffness = 0"),
        (lambda: lobex.Plastic(1.0, -1.0), "yield_force = -1"),
        (lambda: lobex.Plastic(1.0, 1.0, -1.0), "hardening = -1"),
    ],
)
def test_bad_laws_are_refused_in_one_line(make, words):
    with refused(words):
        make()
