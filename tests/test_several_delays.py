"""Characteristic roots where one force remembers several constant delays."""

from itertools import pairwise

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.tree_util import Partial
from scipy.optimize import brentq

import lobex
from lobex.grids.choice import AUTO, chosen_method
from own_feedback import modal, seen
from root_count import Feedback, polished, roots_beyond

ROOTS = lobex.CharacteristicRoots()


class Several(Feedback):
    """1 − K Σ [p + v z + Σ (q + u z) e^{−zθ}]/(…), of displacement and velocity now and some delays ago."""

    def __init__(self, omega, ratio, mass, delay, gain, now, then, lags):
        super().__init__(omega, ratio, 1 / mass, delay, gain)
        self.now, self.then, self.lags = now / [1, delay], then / [1, delay], lags

    def loop(self, z):
        z = np.asarray(z)
        response = sum(c / (z * z + 2 * b * z + a * a) for a, b, c in zip(self.a, self.b, self.c, strict=True))
        delayed = sum((q + u * z) * np.exp(-z * lag) for (q, u), lag in zip(self.then, self.lags, strict=True))
        return -response * (self.now[0] + self.now[1] * z + delayed)

    def slope(self, z):
        step = 1e-6
        return (self.loop(z + step) - self.loop(z - step)) / (2 * step)

    def height(self, level):
        seen = np.abs(self.now) + np.exp(-level * self.lags) @ np.abs(self.then)
        size = 8 * np.sum(np.abs(self.c))
        return 2 * np.max(np.abs(self.poles)) + np.sqrt(size * seen[0]) + size * seen[1] + 10


def model(seed):
    """Two modes under any feedback, now and two delays ago, commensurate or not; and what the oracle takes."""
    rng = np.random.default_rng(seed)
    omega = np.sort(np.exp(rng.uniform(0, 2, 2)))
    ratio, mass = np.exp(rng.uniform(np.log(1e-3), np.log(0.2), 2)), np.exp(rng.uniform(-1, 1, 2))
    now, then = rng.normal(size=2) * [1, 0.3], rng.normal(size=(2, 2)) * [1, 0.3]
    delay = np.exp(rng.uniform(np.log(0.3), np.log(12)))
    lags = np.array([1.0, rng.uniform(0.05, 1) if seed % 2 else rng.integers(1, 6) / 6])
    process = modal(
        omega,
        ratio,
        mass,
        present=Partial(seen, now[None]),
        delayed=[(Partial(seen, row[None]), delay * lag) for row, lag in zip(then, lags, strict=True)],
        period=2.0,
        delay_range=(1e-3, 20.0),
    )
    gains = np.sort(rng.choice([-1, 1], 4) * np.exp(rng.uniform(-3, 2, 4)))
    return process, gains, delay, lambda gain: Several(omega, ratio, mass, delay, gain, now, then, lags)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_no_root_is_missed(seed):
    process, gains, delay, function = model(seed)
    chart = lobex.sweep(process, [1.0], gains)
    assert chart.method == {"type": "CharacteristicRoots"}
    assert np.max(chart.error) < 1e-9
    for mu, frequency, gain in zip(chart.multiplier[0], chart.chatter_frequency[0], gains, strict=True):
        z = np.log(np.abs(mu)) * delay / 2.0 + 2j * np.pi * frequency * delay
        root, _ = polished(function(gain), z)
        assert abs(root - z) < 1e-9 * (1 + abs(z))
        assert roots_beyond(function(gain), z.real + 1e-6 * (1 + abs(z))) == 0


@pytest.mark.parametrize("seed", range(4))
def test_every_change_of_stability_is_found(seed):
    process, gains, _, function = model(seed)
    limit = lobex.critical_gain(process, [1.0], (float(gains[0]), float(gains[-1])))
    assert limit.method == {"type": "CharacteristicRoots"}
    edges = limit.intervals[0][np.isfinite(limit.intervals[0]).all(axis=1)].ravel()
    inner = edges[(edges > gains[0]) & (edges < gains[-1])]
    parts = np.concatenate([gains[:1], inner, gains[-1:]])
    for low, high in pairwise(parts):
        stable = any(start <= low and high <= stop for start, stop in edges.reshape(-1, 2))
        for gain in (low + 1e-6 * (high - low), (low + high) / 2, high - 1e-6 * (high - low)):
            assert (roots_beyond(function(gain), 0.0) == 0) == stable


def test_two_delays_of_one_state_have_their_limit_in_closed_form():
    # ẋ = −a x − K [x(t − r) + x(t − s)]: ω (r + s)/2 + atan(ω/a) = π and 2 K cos(ω (r − s)/2) = √(a² + ω²).
    unit, a = np.ones((1, 1)), 0.4
    for first, second in ((1.0, 0.35), (0.7, 0.7)):
        delayed = [(Partial(seen, -unit), delay) for delay in (first, second)]
        process = lobex.LinearDelay([[-a]], delayed, period=1.0)
        total, apart = first + second, first - second
        omega = brentq(
            lambda w, total=total: w * total / 2 + np.arctan2(w, a) - np.pi, 0.1, 2 * np.pi / total, xtol=1e-15
        )
        limit = lobex.critical_gain(process, [1.0], (1e-3, 10.0))
        assert limit.method == {"type": "CharacteristicRoots"}
        assert limit.gain[0] == pytest.approx(np.hypot(a, omega) / (2 * np.cos(omega * apart / 2)), rel=1e-12)
        assert limit.chatter_frequency[0] == pytest.approx(omega / (2 * np.pi), rel=1e-12)


def share_of_a_turn(share, t, speed, gain):
    return share / speed


@pytest.mark.slow
def test_delays_that_follow_the_speed_agree_with_an_operator():
    row = np.array([[1.0, 0.0]])
    process = modal(
        np.array([1.0, 2.3]),
        np.array([0.02, 0.05]),
        np.ones(2),
        present=Partial(seen, -2 * row),
        delayed=[(Partial(seen, row), None), (Partial(seen, row), Partial(share_of_a_turn, 0.4))],
        delay_range=(0.4, 1.0),
    )
    speeds, gains = np.array([0.11, 0.4]), np.array([0.05, 0.6])
    chart = lobex.sweep(process, speeds, gains)
    assert chart.method == {"type": "CharacteristicRoots"}
    radius = lobex.spectral_radius(process, speeds[:, None], gains, lobex.Chebyshev(48))
    assert np.abs(chart.multiplier) == pytest.approx(np.asarray(radius), rel=1e-8)


def spread(matrix, s, t, speed, gain):
    return gain * matrix * jnp.exp(-s)


@pytest.mark.parametrize(
    ("others", "words"),
    [
        ({"delayed": [(Partial(seen, np.eye(1)), 0.1 * k) for k in range(1, 10)]}, "which has 9 delays"),
        ({"distributed": [(Partial(spread, np.eye(1)), (0.1, 1.0))], "distributed_nodes": 2}, "distributed delay"),
    ],
)
def test_what_is_left_to_an_operator_is_said(others, words):
    process = lobex.LinearDelay([[-1.0]], period=1.0, **others)
    with jax.enable_x64(True), pytest.raises(ValueError, match=words):
        ROOTS.over_grid(process, np.ones(1), np.ones(1))
    assert isinstance(chosen_method(AUTO, process, 1.0), lobex.Duhamel)
