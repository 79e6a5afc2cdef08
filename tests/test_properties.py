"""Properties that hold whatever the numbers."""

import jax
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lobex
from cases import MILL, MULTIPLIER_TOOLS, ROD, milling, rub

steady = settings(max_examples=15, derandomize=True)
factor = st.floats(0.1, 2.0)
rub_speed = st.floats(60.0, 400.0)
rub_gain = st.floats(0.0, 4.5e6)
METHODS = [lobex.Chebyshev(24), lobex.SemiDiscretization(24)]


@steady
@given(factor, rub_speed, rub_gain)
def test_stiffness_scales_limits_by_alpha_and_speeds_by_its_root(alpha, speed, gain):
    plain = lobex.spectral_radius(ROD, speed, gain)
    scaled = lobex.spectral_radius(rub(young_modulus=alpha * 210e7), speed * np.sqrt(alpha), gain * alpha)
    assert scaled == pytest.approx(plain, rel=1e-9)


@steady
@given(factor, rub_speed, rub_gain)
def test_mass_moves_lobes_and_not_their_size(beta, speed, gain):
    plain = lobex.spectral_radius(ROD, speed, gain)
    scaled = lobex.spectral_radius(rub(density=beta * 4600), speed / np.sqrt(beta), gain)
    assert scaled == pytest.approx(plain, rel=1e-9)


@pytest.mark.parametrize("method", METHODS, ids=repr)
@steady
@given(st.floats(2000, 25000), st.floats(0, 5e-3))
def test_multipliers_of_a_real_system_come_in_conjugate_pairs_largest_first(method, rpm, depth):
    mu = lobex.multipliers(MILL, rpm / 60, depth, method)
    leading = mu[np.abs(mu) > 1e-3 * abs(mu[0])]
    for value in leading:
        assert np.min(np.abs(mu - value.conj())) < 1e-6 * abs(value)
    assert np.all(np.diff(np.abs(mu)) <= 1e-12 * abs(mu[0]))
    assert mu[0].imag >= 0


@pytest.mark.parametrize(("rows", "columns"), [(1, 1), (1, 3), (4, 1), (3, 2)])
def test_a_batch_is_its_single_points(rows, columns):
    rng = np.random.default_rng(rows)
    speeds, gains = rng.uniform(60, 400, (rows, 1)), rng.uniform(0, 4e6, columns)
    batch = lobex.spectral_radius(ROD, speeds, gains)
    single = [[lobex.spectral_radius(ROD, s, g) for g in gains] for s in speeds[:, 0]]
    assert batch.shape == (rows, columns)
    assert batch == pytest.approx(np.array(single), rel=1e-12)


# Without jit each operation is a program of its own, over and over: few nodes and steps.
@pytest.mark.parametrize(
    ("process", "speed", "gain", "method"),
    [(rub(2), 150.0, 8e5, lobex.Chebyshev(8)), (MILL, 80.0, 2e-3, lobex.SemiDiscretization(6))],
)
def test_jit_changes_nothing(process, speed, gain, method):
    with jax.enable_x64(True):
        with jax.disable_jit():
            plain = np.asarray(method.operator(process.system(speed, gain)).matrix)
        traced = np.asarray(jax.jit(lambda s, g: method.operator(process.system(s, g)).matrix)(speed, gain))
    assert traced == pytest.approx(plain, rel=1e-10, abs=1e-10 * np.abs(plain).max())


@steady
@given(st.floats(3000, 20000), st.floats(1e-4, 4e-3), st.integers(1, 3))
def test_teeth_and_speed_enter_by_the_tooth_period_alone_at_tiny_arcs(rpm, depth, teeth):
    # With t teeth at speed/t the tooth period is the same; the arc in cut differs, so the free parts agree
    # only through the structure: at zero depth the radius is exactly that of the free decay.
    process = milling({**MULTIPLIER_TOOLS["Insperger-Stepan"], "teeth": teeth}, 0.05, "up")
    free = lobex.spectral_radius(process, rpm / 60 / teeth, 0.0, lobex.Duhamel(nodes=30))
    rate = process.modes.damping_ratio[0] * process.modes.angular_frequency[0]
    assert free == pytest.approx(np.exp(-rate * 60 / rpm), rel=1e-10)


@steady
@given(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(0.3, 3.0))
def test_scalar_equation_depends_on_products_with_the_delay(a, b, delay):
    method = lobex.Chebyshev(24)
    scaled = lobex.spectral_radius(lobex.Scalar(a * delay), 1.0, b * delay, method)
    assert lobex.spectral_radius(lobex.Scalar(a), 1 / delay, b, method) == pytest.approx(scaled, rel=1e-9, abs=1e-9)


def test_broadcasting_shapes():
    speeds, gains = np.full((2, 1, 3), 100.0), np.full((4, 1), 1e6)
    assert lobex.spectral_radius(ROD, speeds, gains).shape == (2, 4, 3)
    assert lobex.spectral_radius(ROD, 100.0, 1e6).shape == ()
    assert lobex.spectral_radius(ROD, [100.0], [1e6]).shape == (1,)
    assert lobex.multipliers(ROD, [100.0, 110.0], 1e6).shape == (2, 50)
    assert lobex.monodromy(ROD, 100.0, [1e6, 2e6]).shape == (2, 50, 50)
