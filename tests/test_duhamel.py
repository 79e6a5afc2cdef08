"""The exact structure and the Gauss points: against quadrature, independent codes and other methods."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.linalg import expm

import lobex
from cases import MILL, ROD, rub
from lobex.operators.elimination import inverse
from lobex.operators.exponential import exponential
from lobex.operators.moments import cell_phases, exponential_moments
from lobex.operators.response import forced_response, gauss_nodes, quickness
from lobex.systems.traits import Traits, traits_of


@jax.jit
def _moments(block):
    phases = cell_phases(np.ones(1)).ravel()
    samples = exponential(phases[:, None, None] * block)
    return exponential_moments(block, exponential(block), samples, 14)


@partial(jax.jit, static_argnames="samples")
def _response(speed, length, force, samples):
    response = forced_response(ROD.system(speed, 1e6), length, len(force), samples=samples)
    return response.forced @ force, response.push @ force, response.free, response.through


@pytest.mark.parametrize("frequency", [0.3, 5.0, 27.0, 29.0, 200.0])
def test_moments_of_an_oscillator_are_those_of_quadrature(frequency):
    block = frequency * np.array([[0.0, 1.0], [-1.0, -0.06]])
    with jax.enable_x64(True):
        moments = np.asarray(_moments(block))
    for k in (0, 1, 5, 13):
        legendre = np.polynomial.legendre.Legendre.basis(k, domain=[0, 1])
        for i, j in ((0, 1), (1, 1)):
            exact = quad(
                lambda s, i=i, j=j, p=legendre: float(expm(block * (1 - s))[i, j] * p(s)), 0, 1, limit=400, epsabs=1e-13
            )[0]
            assert moments[k][i, j] == pytest.approx(exact, abs=2e-13)


@pytest.mark.parametrize(
    ("speed", "length", "samples"), [(400.0, 1.0, None), (50.0, 1.0, None), (3.0, 1.0, None), (400.0, 0.02, 14)]
)
def test_response_to_a_polynomial_force_is_exact(speed, length, samples):
    # At 3 Hz the fifth mode turns 6,000 radians between nodes that know nothing of it; over the short piece the modes
    # turn by so little that a few samples tell all.
    modes, nodes = ROD.modes, 16
    omega, ratio, shape = (np.asarray(a).ravel() for a in (modes.angular_frequency, modes.damping_ratio, modes.shape))
    damped = omega * np.sqrt(1 - ratio**2)
    points = gauss_nodes(nodes)[0]
    force = np.polynomial.legendre.Legendre(np.random.default_rng(0).standard_normal(nodes - 2), domain=[0, 1])
    with jax.enable_x64(True):
        computed, ended, *flown = map(np.asarray, _response(speed, length, force(points), samples))
    duration = length / speed
    panels = np.arange(400) / 400
    inner, weights = gauss_nodes(24)
    fine, weights = (panels[:, None] + inner / 400).ravel(), np.tile(weights / 400, 400)

    def seen(place):
        """Of each mode, what it shows of the force at a place of the piece."""
        lag = duration * place * (1 - fine)
        waves = np.exp(-np.outer(ratio * omega, lag)) * np.sin(np.outer(damped, lag))
        return (shape**2 / damped) * (waves @ (weights * force(place * fine))) * duration * place

    for k in (1, nodes // 2, nodes - 1):
        assert computed[k] == pytest.approx(np.sum(seen(points[k])), abs=1e-11 * np.abs(computed).max())
    assert ended[::2] * shape == pytest.approx(seen(1.0), abs=1e-11 * np.abs(ended).max())
    block = np.array([[0.0, 1.0], [-1.0, -2 * ratio[1]]]) * omega[1]
    assert flown[0][3, 2:4] == pytest.approx(shape[1] * expm(duration * points[3] * block)[0], abs=1e-11)
    assert flown[1][2:4, 2:4] == pytest.approx(expm(duration * block), abs=1e-11)


@pytest.mark.parametrize(
    ("process", "speeds", "gains"),
    [
        (ROD, np.linspace(50, 400, 9), np.linspace(4.5e4, 4.5e6, 7)),
        (MILL, np.linspace(2000, 25000, 11) / 60, np.linspace(0, 5e-3, 9)),
        (lobex.DelayedMathieu(3.0, 2.0, 0.1), np.linspace(0.08, 0.5, 7), np.linspace(-1.5, 1.5, 8)),
    ],
    ids=["rub", "milling", "mathieu"],
)
def test_chosen_nodes_keep_the_tolerance_and_the_estimate_bounds_the_error(process, speeds, gains):
    chart = lobex.sweep(process, speeds, gains, lobex.Duhamel())
    exact = lobex.spectral_radius(process, speeds[:, None], gains, lobex.Chebyshev(90))
    error = np.abs(chart.spectral_radius / exact - 1)
    assert np.nanmax(chart.error) <= 1e-8
    assert error.max() < 1e-8
    assert np.all(error <= np.maximum(chart.error, 3e-11))
    # No number claims more than an ulp.
    assert np.nanmin(chart.error) > np.finfo(float).eps
    other = lobex.sweep(process, speeds, gains, lobex.Chebyshev(90))
    assert chart.chatter_frequency == pytest.approx(other.chatter_frequency, rel=1e-6, abs=1e-6)


def test_nodes_follow_every_mode_that_might_dominate():
    # Of five lightly damped modes the fourth or fifth can be the one that chatters, where nodes enough for the first
    # show nothing of it: at 150 Hz and 0.68 MN/m 42 nodes give 1.071, and the truth is 1.083.
    process = rub(5, 0.001)
    speeds, gains = np.linspace(50, 400, 8), np.linspace(4.5e4, 4.5e6, 8)
    chart = lobex.sweep(process, speeds, gains, lobex.Duhamel())
    exact = lobex.spectral_radius(process, speeds[:, None], gains, lobex.Chebyshev(100))
    assert chart.spectral_radius == pytest.approx(exact, rel=1e-8)
    with pytest.warns(lobex.SweepWarning, match="1 of 1 points have an estimated error"):
        blind = lobex.sweep(process, [150.0], [gains[1]], lobex.Duhamel(nodes=42))
    assert np.isinf(blind.error[0, 0])


@pytest.mark.filterwarnings("ignore::lobex.SweepWarning")
def test_the_estimate_tells_where_nodes_given_are_too_few():
    speeds, gains = np.linspace(50, 400, 9), np.linspace(4.5e4, 4.5e6, 7)
    chart = lobex.sweep(ROD, speeds, gains, lobex.Duhamel(nodes=16))
    exact = lobex.spectral_radius(ROD, speeds[:, None], gains, lobex.Chebyshev(90))
    error = np.abs(chart.spectral_radius / exact - 1)
    # Sixteen nodes cannot follow the seven waves of 50 Hz, and are plenty for the one of 400 Hz.
    assert error[0].max() > 1e-3
    assert chart.error[0].min() > 1e-4
    assert chart.error[-1].max() < 1e-8
    assert np.all(error <= np.maximum(10 * chart.error, 3e-11))


def test_multipliers_do_not_change_with_the_units_of_the_shapes():
    modes = ROD.modes
    scaled = lobex.Modes(modes.angular_frequency, modes.damping_ratio, 1e3 * np.asarray(modes.shape))
    speeds, gains = np.array([80.0, 200.0, 310.0]), np.array([1e5, 1e6, 4e6])
    one = lobex.sweep(ROD, speeds, gains, lobex.Duhamel())
    other = lobex.sweep(lobex.Rub(scaled), speeds, gains * 1e-6, lobex.Duhamel())
    assert other.spectral_radius == pytest.approx(one.spectral_radius, rel=1e-11)
    assert other.error == pytest.approx(one.error, rel=1e-2, abs=5e-14)


@settings(max_examples=20)
@given(st.integers(0, 2**31))
def test_elimination_inverts_batches(seed):
    matrices = np.eye(7) + 0.1 * np.random.default_rng(seed).standard_normal((3, 2, 7, 7))
    with jax.enable_x64(True):
        batched = jax.vmap(jax.vmap(inverse))(matrices)
        single = inverse(matrices[0, 0])
    assert np.asarray(batched) == pytest.approx(np.linalg.inv(matrices), rel=1e-11, abs=1e-12)
    assert np.asarray(single) == pytest.approx(np.asarray(batched[0, 0]), rel=1e-14, abs=1e-15)


@pytest.mark.parametrize("size", [1, 2, 5, 26, 27, 53, 110])
def test_elimination_inverts_any_size(size):
    noise = np.random.default_rng(size).standard_normal((5, size, size))
    matrices = np.eye(size) + 0.3 * noise / np.sqrt(size)
    with jax.enable_x64(True):
        found = np.asarray(jax.vmap(inverse)(matrices))
    assert found == pytest.approx(np.linalg.inv(matrices), rel=1e-11, abs=1e-11)


def test_a_mode_is_as_quick_in_any_coordinates():
    """Also while it does not vibrate."""
    rng = np.random.default_rng(5)
    with jax.enable_x64(True):
        for values in ([-0.2 + 3j, -0.2 - 3j], [-4.0, 1.0], [-2.0, -2.0]):
            block = np.array([[0.0, 1.0], [-np.prod(values).real, np.sum(values).real]])
            turned = [basis @ block @ np.linalg.inv(basis) for basis in rng.standard_normal((3, 2, 2))]
            expected = np.sqrt(np.mean(np.abs(values) ** 2))
            assert np.asarray(quickness(np.array([block, *turned]))) == pytest.approx(expected, rel=1e-9)
        assert np.asarray(quickness(np.array([[[-3.0]], [[2.0]]]))) == pytest.approx([3.0, 2.0])


@given(seed=st.integers(0, 1000), size=st.integers(3, 16), share=st.floats(0.0, 1.0))
def test_blocks_of_many_states_are_as_quick_as_their_largest_eigenvalue(seed, size, share):
    """From 1e-3 to 1 and one of 10, in coordinates that are more or less skew; a bound, and no wide one."""
    rng = np.random.default_rng(seed)
    values = np.append(10.0 ** rng.uniform(-3, 0, size - 1), 10.0) * rng.choice([-1, 1], size)
    basis = np.eye(size) + share * rng.standard_normal((size, size)) / np.sqrt(size)
    block = basis @ np.diag(values) @ np.linalg.inv(basis)
    (found,) = quickness(block[None])
    assert 10.0 * (1 - 1e-9) <= found <= 10.0 * np.linalg.cond(basis) ** (1 / 32) * size ** (1 / 32)
    assert quickness(np.zeros((1, size, size))) == pytest.approx([0.0], abs=0)


def test_a_present_force_without_the_gain_is_taken_in_once_and_for_all():
    process = lobex.DelayedMathieu(delta=2.5, epsilon=1.3, damping=0.05)
    system = process.system(1 / (2 * np.pi), 0.7)
    method = lobex.Duhamel(nodes=18)
    with jax.enable_x64(True):
        each, once = (
            method.assemble(method.respond(prepared, system, jnp.linalg.inv), system)
            for prepared in (method.prepare(system), method.prepare(system, Traits(True, False, True)))
        )
    assert np.asarray(once) == pytest.approx(np.asarray(each), rel=1e-12, abs=1e-13)


@pytest.mark.slow
def test_chips_without_the_gain_are_taken_in_once_and_for_all():
    modes = lobex.Modes.from_table(
        frequency=[510.0, 525.0], damping_ratio=[0.02, 0.022], mass=[0.5, 0.55], direction=["x", "y"]
    )
    cutter = lobex.Cutter.end_mill(0.019, pitch_degrees=[70.0, 110.0, 70.0, 110.0])
    process = lobex.Milling(modes, cutter, 6e8, 2e8, 0.5)
    system, method, traits = process.system(100.0, 1e-3), lobex.Duhamel(nodes=8), traits_of(process)
    assert system.chips
    assert traits == Traits(structure_by_gain=False, present_by_gain=True, chips_by_gain=False)
    with jax.enable_x64(True):
        each, once = method.prepare(system), method.prepare(system, traits)
        assert once.left is None
        each, once = (method.assemble(method.respond(one, system, jnp.linalg.inv), system) for one in (each, once))
    assert np.asarray(once) == pytest.approx(np.asarray(each), rel=1e-12, abs=1e-13)


def test_gradients_of_the_response_are_those_of_differences():
    def radius(young_modulus, speed):
        modes = lobex.Rod(3, young_modulus=young_modulus).modes(0.03)
        return lobex.spectral_radius(lobex.Rub(modes), speed, 1.2e6, lobex.Duhamel(nodes=30))

    with jax.enable_x64(True):
        slopes = jax.jit(jax.grad(radius, argnums=(0, 1)))(210e7, 120.0)
    for slope, step in zip(slopes, (np.array([210e7 * 1e-6, 0.0]), np.array([0.0, 1e-4])), strict=True):
        up, down = (float(radius(210e7 + s * step[0], 120.0 + s * step[1])) for s in (1, -1))
        assert float(slope) == pytest.approx((up - down) / (2 * step.sum()), rel=1e-6)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [({"nodes": 2}, "nodes"), ({"tolerance": 0.0}, "tolerance"), ({"tolerance": "a"}, "tolerance")],
)
def test_bad_arguments_are_named(wrong, message):
    with pytest.raises(ValueError, match=message):
        lobex.Duhamel(**wrong)


def test_rub_with_other_modes_than_five():
    # One mode and ten: the estimate must hold where stiff modes hardly matter, and where there are none.
    for process in (rub(1), rub(10, 0.01)):
        speeds, gains = np.array([60.0, 150.0, 380.0]), np.array([2e5, 2e6])
        chart = lobex.sweep(process, speeds, gains, lobex.Duhamel())
        exact = lobex.spectral_radius(process, speeds[:, None], gains, lobex.Duhamel(nodes=80))
        assert chart.spectral_radius == pytest.approx(exact, rel=1e-8)


@pytest.mark.slow
def test_nodes_that_are_too_few_are_warned_of():
    fine = lobex.spectral_radius(ROD, 120.0, 1.2e6, lobex.Duhamel(nodes=30))
    with pytest.warns(lobex.SweepWarning, match="1 of 1 points failed or have an estimated error above 1e-08"):
        coarse = lobex.spectral_radius(ROD, 120.0, 1.2e6, lobex.Duhamel(nodes=16))
    assert abs(coarse / fine - 1) > 1e-6
