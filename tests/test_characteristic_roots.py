"""Dominant characteristic roots against dense operators, closed forms, and the count of roots by eigenvalues."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import lambertw

import lobex
import root_count
from cases import MILL, ROD, rub
from lobex._pytree import pytree
from lobex.characteristic.closed_loop import close
from lobex.characteristic.function import loop
from lobex.characteristic.lanes import placed
from lobex.characteristic.line import roots_beyond
from lobex.characteristic.method import CharacteristicRoots, contacts
from lobex.operators.duhamel import Duhamel
from lobex.systems.coefficients import Constant
from lobex.systems.delays import Share
from lobex.systems.terms import Delayed, Present
from refusals import refused

ROOTS = CharacteristicRoots()
GAINS = np.linspace(4.5e4, 4.5e6, 41)
TOOL = lobex.Modes.single(frequency=146.5, damping_ratio=0.0032, mass=2.573)


def over_grid(process, speeds, gains):
    with jax.enable_x64(True):
        return ROOTS.over_grid(process, np.asarray(speeds, dtype=float), np.asarray(gains, dtype=float))


def upper(value):
    return value.real + 1j * np.abs(value.imag)


def worst(process, speeds, gains, method, points=24):
    """The largest relative distance from dense eigenvalues over random points, and the unsettled points of the grid."""
    found, _, _, settled = over_grid(process, speeds, gains)
    rng = np.random.default_rng(3)
    i, j = rng.integers(0, len(speeds), points), rng.integers(0, len(gains), points)
    dense = upper(lobex.multipliers(process, speeds[i], gains[j], method)[:, 0])
    kept = settled[i, j]
    return np.max(np.abs(found[i, j] - dense)[kept] / np.abs(dense)[kept]), np.sum(~settled)


@pytest.mark.parametrize("method", [Duhamel(60), lobex.Chebyshev(90)], ids=["Duhamel", "Chebyshev"])
@pytest.mark.parametrize("damping_ratio", [0.03, 0.0177])
def test_appendix_b_against_both_operators(damping_ratio, method):
    error, unsettled = worst(rub(5, damping_ratio), np.linspace(100, 400, 33), GAINS, method)
    assert error < 1e-11
    assert unsettled == 0


@pytest.mark.parametrize(
    ("process", "lowest", "nodes"),
    [(rub(5, 0.001), 130.0, 120), (rub(1), 50.0, 60), (rub(10), 160.0, 120)],
    ids=["light damping", "one mode", "ten modes"],
)
def test_rods_against_duhamel(process, lowest, nodes):
    error, unsettled = worst(process, np.linspace(lowest, 400, 33), GAINS, Duhamel(nodes))
    assert error < 1e-11
    assert unsettled <= 1e-3 * 33 * GAINS.size


def test_turning_from_zero_depth():
    process = lobex.Turning(TOOL, radial=2e8)
    error, unsettled = worst(process, np.linspace(2000, 25000, 33) / 60, np.linspace(0, 5e-3, 42), Duhamel(60))
    assert error < 1e-11
    assert unsettled == 0


@pytest.mark.parametrize("a", [-3.0, -1.0, 0.0, 2.0])
def test_hayes_by_lambert_w(a):
    speeds, gains = np.linspace(0.4, 3, 27), np.linspace(-6, 6, 83)
    found, frequency, _, settled = over_grid(lobex.Scalar(a), speeds, gains)
    tau = 1 / speeds[:, None]
    branches = [a + lambertw(np.where(gains == 0, np.nan, gains) * tau * np.exp(-a * tau), k) / tau for k in (-1, 0)]
    exact = np.where(branches[0].real > branches[1].real, *branches)
    exact = np.where(gains == 0, a, exact)
    away = np.abs(gains * tau * np.exp(1 - a * tau) + 1) > 0.2
    assert np.all(settled[away])
    assert np.mean(settled) > 0.98
    error = np.abs(found / upper(np.exp(exact * tau)) - 1)
    # Two real roots meet where b τ e^{1 − aτ} = −1; so close to it the error grows as the root of the distance.
    assert np.max(error[away]) < 1e-12
    assert np.nanmax(error) < 1e-9
    assert frequency[away] == pytest.approx(np.abs(exact.imag)[away] / (2 * np.pi), abs=1e-10)


def test_what_is_settled_solves_the_equation_and_the_frequency_has_its_carrier():
    speeds, gains = np.linspace(50, 400, 33), GAINS
    found, frequency, _, settled = over_grid(ROD, speeds, gains)
    assert np.all(settled)
    modes = ROD.modes
    tau = 1 / speeds[:, None]
    s = np.log(np.abs(found)) / tau + 2j * np.pi * frequency
    terms = modes.shape[:, 0] ** 2 / (
        s[..., None] ** 2
        + 2 * modes.damping_ratio * modes.angular_frequency * s[..., None]
        + modes.angular_frequency**2
    )
    residual = 1 + gains * np.sum(terms, axis=-1) * (1 - np.exp(-s * tau))
    slope = gains * np.sum(terms, axis=-1) * tau * np.exp(-s * tau)
    assert np.max(np.abs(residual) / np.maximum(np.abs(slope), 1)) < 1e-10


def test_the_count_is_that_of_the_eigenvalues():
    speeds, gains = np.linspace(150, 400, 24), np.resize(GAINS[::5], 24)
    with jax.enable_x64(True):
        _, structure, _ = contacts(ROD, speeds, 1.0)
        loops = structure.closed(np.arange(24), gains).at_delay(structure.delay)
        level = loops.rightmost - 0.37
        count = roots_beyond(loops, placed(loops.filled()), np.arange(24), level)
    assert np.all(count.decided)
    moduli = np.abs(lobex.multipliers(ROD, speeds, gains, Duhamel(120)))
    assert np.array_equal(count.roots, np.sum(moduli > np.exp(level)[:, None], axis=1))
    assert count.roots.max() >= 10


def test_the_count_on_lines_that_begin_between_roots():
    # Left of a real root M > 0 where the line begins, and an ulp of M beside the real axis would count as a turn.
    rng = np.random.default_rng(5)
    size = 200
    omega, damping = 10 ** rng.uniform(0, 3, size), 10 ** rng.uniform(-4, -0.7, size)
    delay, gain = rng.uniform(0.5, 4, size) / omega, omega**2 * 10 ** rng.uniform(-1, 1, size)
    level = rng.uniform(-4, -0.05, size)
    drift = omega[:, None, None] * np.array([[0.0, 1.0], [-1.0, 0.0]])
    drift[:, 1, 1] = -2 * damping * omega
    with jax.enable_x64(True):
        inputs, outputs = np.stack([0 * omega, 1 / omega], axis=1), np.tile([1.0, 0.0], (size, 1))
        feedback = gain[:, None] * outputs
        loops = close(drift, inputs, -feedback, feedback).at_delay(delay)
        count = roots_beyond(loops, placed(loops.filled()), np.arange(size), level)
    right = [
        root_count.roots_beyond(root_count.Feedback([own], [ratio], [1.0], time, stiffness), line)
        for own, ratio, time, stiffness, line in zip(omega, damping, delay, gain, level, strict=True)
    ]
    assert np.all(count.decided)
    assert count.roots.tolist() == right


def test_the_slope_is_the_functions_derivative():
    with jax.enable_x64(True):
        _, _, made = contacts(ROD, np.full(3, 200.0), 1.0)
        z = np.array([-0.3 + 5.0j, 0.2 + 11.0j, -1.0 + 0.0j])
        at, step = loop(made, z), 1e-5
        beside = [np.asarray(loop(made, z + sign * step).value) for sign in (1, -1)]
        assert np.asarray(at.slope) == pytest.approx((beside[0] - beside[1]) / (2 * step), rel=1e-7)
        system = ROD.system(200.0, 1.0)
        drift, inputs, outputs = (np.asarray(m()) for m in (system.drift, system.input_matrix, system.output_matrix))
        for k, s in enumerate(200.0 * z):
            response = (outputs @ np.linalg.solve(s * np.eye(len(drift)) - drift, inputs))[0, 0]
            assert np.asarray(at.value)[k] == pytest.approx((1 - np.exp(-z[k])) * response, rel=1e-12)


def test_a_mode_that_the_contact_does_not_see_stays():
    modes = rub(1).modes
    parts = (modes.angular_frequency, [300.0]), (modes.damping_ratio, [1e-4]), (modes.shape, [[0.0]])
    slow = lobex.Modes(*map(np.concatenate, parts))
    speeds, gains = np.linspace(150, 400, 33), GAINS
    alone, _, _, _ = over_grid(lobex.Rub(modes), speeds, gains)
    found, frequency, _, settled = over_grid(lobex.Rub(slow), speeds, gains)
    root = 300.0 * (-1e-4 + 1j * np.sqrt(1 - 1e-8))
    still = np.broadcast_to(upper(np.exp(root / speeds))[:, None], found.shape)
    ahead = np.abs(still) > np.abs(alone)
    assert np.all(settled)
    assert 0.1 < np.mean(ahead) < 0.9
    assert found == pytest.approx(np.where(ahead, still, alone), rel=1e-11)
    assert frequency[ahead] == pytest.approx(root.imag / (2 * np.pi), rel=1e-12)


def test_two_equal_modes_are_one_of_twice_the_strength_and_one_unmoved():
    one = lobex.Modes.single(frequency=100.0, damping_ratio=0.02, mass=1.0)
    two = lobex.Modes(*(np.concatenate([a, a]) for a in (one.angular_frequency, one.damping_ratio, one.shape)))
    heavy = lobex.Modes(one.angular_frequency, one.damping_ratio, np.sqrt(2) * one.shape)
    speeds, gains = np.linspace(40, 90, 33), np.linspace(1e3, 1e5, 41)
    found, _, _, settled = over_grid(lobex.Rub(two), speeds, gains)
    alone, _, _, _ = over_grid(lobex.Rub(heavy), speeds, gains)
    free = np.exp(-0.02 * one.angular_frequency / speeds)[:, None]
    assert np.all(settled)
    assert np.abs(found) == pytest.approx(np.maximum(np.abs(alone), free), rel=1e-11)


@settings(max_examples=5)
@given(stiffer=st.floats(0.5, 2.0), heavier=st.floats(0.5, 2.0))
def test_scaling(stiffer, heavier):
    # α times stiffer and β times heavier: frequencies √(α/β), gains α, the multipliers the same.
    base = lobex.Modes.single(frequency=100.0, damping_ratio=0.03, mass=1.0)
    ratio = np.sqrt(stiffer / heavier)
    scaled = lobex.Modes.single(frequency=100.0 * ratio, damping_ratio=0.03, mass=heavier)
    speeds, gains = np.linspace(30, 150, 33), np.linspace(0, 4e5, 42)
    mu, frequency, _, settled = over_grid(lobex.Rub(base), speeds, gains)
    again, higher, _, also = over_grid(lobex.Rub(scaled), speeds * ratio, gains * stiffer)
    both = settled & also
    assert np.mean(both) > 0.999
    assert again[both] == pytest.approx(mu[both], rel=1e-10)
    assert higher[both] == pytest.approx(ratio * frequency[both], rel=1e-10)


def test_the_grid_does_not_change_a_point():
    speeds, gains = np.linspace(60, 400, 33), GAINS
    whole, _, _, settled = over_grid(ROD, speeds, gains)
    others = np.sort(np.append(gains[::4], np.linspace(1e4, 6e6, 30)))
    part, _, _, also = over_grid(ROD, speeds[5:9], others)
    assert np.all(settled)
    assert np.all(also)
    assert part[:, np.searchsorted(others, gains[::4])] == pytest.approx(whole[5:9, ::4], rel=1e-12)


@pytree()
class Offset:
    """A process with a delayed force that does not grow with the gain."""

    gain = lobex.Rub.gain
    speed_unit = "Hz"

    def system(self, speed, gain):
        terms = Present(Constant(-gain * np.eye(1))), Delayed(Constant(1e5 * np.eye(1)))
        return replace(ROD.system(speed, gain), terms=terms)


@pytree()
class Pitched:
    """A process with the given delays, as shares of its period."""

    shares: tuple

    gain = lobex.Rub.gain
    speed_unit = "Hz"

    def system(self, speed, gain):
        terms = tuple(Delayed(Constant(gain * np.eye(1)), Share(share)) for share in self.shares)
        return replace(ROD.system(speed, gain), terms=terms, shortest=0.1)


def swaying(t, speed, gain):
    return 0.3 + 0.1 * jnp.sin(t)


def alone(t, speed, gain):
    return gain * jnp.eye(1)


SWAYING = lobex.LinearDelay([[-1.0]], [(alone, swaying)], period=2 * np.pi, delay_range=(0.01, 0.1))


@pytest.mark.parametrize(
    ("process", "words"),
    [
        (MILL, "periodic coefficients"),
        (lobex.DelayedMathieu(delta=1.0, epsilon=1.0), "periodic coefficients"),
        (lobex.Rub(lobex.Modes.plane(x=TOOL, y=TOOL)), "2 contact directions"),
        (Offset(), "not proportional to the gain"),
        (Pitched((1 / 9,) * 9), "9 delays"),
        (SWAYING, "delay varies"),
        (3.0, "is no process"),
    ],
)
def test_other_processes_are_refused(process, words):
    with refused(words):
        over_grid(process, [100.0], [1e5])
