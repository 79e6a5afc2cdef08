"""Maps of periodic motions: what orbits say point by point, under grad too, in files and pictures."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.tree_util import Partial

import lobex
import small_results
from problems import KN, KT, times
from refusals import refused

TOOL = lobex.Modes.single(frequency=600.0, damping_ratio=0.03, mass=0.5)
MILL = lobex.Milling(
    replace(TOOL, shape=np.array([[0.0, 1.0]]) * TOOL.shape),
    lobex.Cutter.end_mill(0.01, teeth=2),
    KT,
    KN,
    0.5,
    "up",
    feed_per_tooth=5e-5,
)
SPEED, DEPTH = np.linspace(4000, 9000, 5) / 60, np.linspace(0, 12e-3, 7)


@pytest.fixture(scope="module")
def found():
    return lobex.orbits(MILL, SPEED, DEPTH)


def series(speed, depth, phase):
    """y of even teeth under the nominal force, by its harmonics: −b f Σ (K_n cos φ − K_t sin φ) sin φ."""
    k = np.arange(-4000, 4001)
    angle, weight = np.polynomial.legendre.leggauss(400)
    angle, weight = (angle + 1) * np.pi / 4, weight * np.pi / 4
    force = -(KN * np.cos(angle) - KT * np.sin(angle)) * np.sin(angle) * MILL.feed_per_tooth * depth
    few = np.abs(k) <= 60
    harmonics = np.zeros(len(k), dtype=complex)
    harmonics[few] = np.exp(-2j * np.outer(k[few], angle)) @ (weight * force) / np.pi
    s, own = 4j * np.pi * k * speed, 2 * np.pi * 600.0
    response = harmonics / (0.5 * (s**2 + 2 * 0.03 * own * s + own**2))
    return np.real(np.exp(2j * np.pi * np.outer(phase, k)) @ response)


@pytest.mark.slow
def test_a_map_is_what_the_series_says_where_it_is_stable_and_nothing_elsewhere(found):
    chart = lobex.sweep(MILL, SPEED, DEPTH)
    stable = chart.spectral_radius < 1
    assert 0.3 < stable.mean() < 1
    assert np.array_equal(np.isfinite(found.location_error), stable)
    assert np.array_equal(found.status == "unstable", ~stable)
    assert found.spectral_radius == pytest.approx(chart.spectral_radius, rel=1e-8)
    row, column = np.argwhere(stable & (DEPTH > 0))[-1]
    # Up-milling passes the wall at the angle 0, where t = 0, and leaves −y.
    y = series(SPEED[row], DEPTH[column], np.arange(400) / 400)
    assert found.location_error[row, column] == pytest.approx(-y[0], abs=1e-4 * np.abs(y).max())
    assert found.peak[row, column] == pytest.approx([0, np.abs(y).max()], rel=1e-3, abs=1e-15)
    power = np.outer(SPEED, DEPTH) * 2 * 0.005 * KT * MILL.feed_per_tooth
    assert found.mean_power[stable] == pytest.approx(power[stable], rel=1e-7)
    assert found.highest_torque[stable] == pytest.approx((0.005 * KT * MILL.feed_per_tooth * DEPTH * stable)[stable])
    assert found.error[stable].max() < 1e-8
    # Nothing is cut at no depth.
    assert not found.location_error[:, 0].any()


@pytest.mark.search
def test_derivatives_of_a_map_are_those_of_what_is_proportional():
    def told(feed):
        process = replace(MILL, feed_per_tooth=feed)
        found = lobex.orbits(process, SPEED[:2], DEPTH[1:3], lobex.Duhamel(nodes=9))
        both = jax.numpy.stack([found.location_error, found.mean_power])
        return both, both

    with jax.enable_x64(True):
        slope, value = jax.jit(jax.jacfwd(told, has_aux=True))(MILL.feed_per_tooth)
    assert np.asarray(slope) == pytest.approx(np.asarray(value) / MILL.feed_per_tooth, rel=1e-8)


@pytest.mark.slow
def test_a_map_is_printed_and_drawn(found):
    assert "location error" in repr(found)
    assert "unstable" in repr(found)
    for of in ("location_error", "mean_power", "highest_torque", "pulled", "peak"):
        assert found.plot(of=of).get_xlabel() == "spindle speed (rpm)"
    with pytest.raises(ValueError, match="of = 'power' is unknown; choose one of 'peak', 'location_error'"):
        found.plot(of="power")
    with pytest.raises(ValueError, match="of = 'mean_power' is unknown; choose one of 'peak'"):
        small_results.orbit_map().plot(of="mean_power")


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"process": replace(MILL, feed_per_tooth=None)}, "process has no forcing"),
        ({"speed": [150.0, 100.0]}, r"speed = \[150, 100\] is not strictly increasing"),
        ({"gain": []}, "gain is empty"),
        ({"gain": [-1e-3, 0.0]}, "gain = .* must not be negative"),
        ({"method": lobex.Chebyshev()}, "makes no orbit"),
        ({"height": [2.0]}, "height = .* shares of the depth of cut"),
    ],
)
def test_bad_input_is_one_line(changed, message):
    given = {"process": MILL, "speed": SPEED, "gain": DEPTH} | changed
    with refused(match=message):
        lobex.orbits(**given)


def waves(t, speed, gain):
    return 1 + jnp.cos(2 * jnp.pi * t)


def test_a_map_of_an_equation_without_teeth_is_its_transfer_function():
    """x' = −x + b x(t − 0.5) + 1 + cos 2πt, whose mean and whose wave are largest together."""
    process = lobex.LinearDelay(-1.0, [(Partial(times, np.eye(1)), 0.5)], period=1.0, forcing=waves)
    gains, s = np.array([-0.4, 0.1, 0.2, 1.5]), 2j * np.pi
    found = lobex.orbits(process, [1.0], gains)
    peak = 1 / (1 - gains) + np.abs(1 / (s + 1 - gains * np.exp(-0.5 * s)))
    assert found.peak[0, :3, 0] == pytest.approx(peak[:3], rel=1e-8)
    assert np.all(found.error[0, :3] < 1e-8)
    assert found.status[0].tolist() == ["good", "good", "good", "unstable"]
    with jax.enable_x64(True):
        slope = jax.grad(lambda b: lobex.orbits(process, jnp.ones(1), b[None]).peak[0, 0, 0])(0.1)
    step = lobex.orbits(process, [1.0], [0.1 - 1e-4, 0.1 + 1e-4]).peak[0, :, 0]
    assert slope == pytest.approx(np.diff(step)[0] / 2e-4, rel=1e-6)
