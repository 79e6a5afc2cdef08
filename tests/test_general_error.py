"""The estimated error of delays apart from the period, shorter and longer, and of delays that vary."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lobex

PARTIAL = jax.tree_util.Partial
FINE = lobex.Duhamel(nodes=44)


def pulling(numbers, t, speed, gain):
    delta, epsilon = numbers
    return delta + epsilon * jnp.cos(2 * jnp.pi * speed * t)


def fed_back(t, speed, gain):
    return gain


def varying(share, t, speed, gain):
    return share * (1 + 0.1 * jnp.sin(2 * jnp.pi * speed * t)) / speed


def constant(share, t, speed, gain):
    return share / speed


KINDS = {
    "period of two delays": (constant, 0.5, (0.5, 0.5)),
    "delay of two periods": (constant, 2.0, (2.0, 2.0)),
    "golden ratio": (constant, 0.618034, (0.618034, 0.618034)),
    "delay that varies": (varying, 0.3, (0.27, 0.33)),
}


def mathieu(rng, delay, share, delay_range):
    """A damped delayed Mathieu equation, and gains."""
    numbers = np.array([rng.uniform(0.3, 4), rng.uniform(0.1, 2)])
    process = lobex.LinearDelay.second_order(
        1.0,
        rng.uniform(0.02, 0.3),
        PARTIAL(pulling, numbers),
        [(fed_back, PARTIAL(delay, share))],
        delay_range=delay_range,
    )
    return process, np.sort(rng.uniform(-0.8, 0.8, 4))


@pytest.mark.parametrize("kind", KINDS)
def test_a_general_system_is_right_or_says_so(kind):
    rng = np.random.default_rng(5)
    worse, points = 0, 0
    for _ in range(12):
        process, gains = mathieu(rng, *KINDS[kind])
        chart = lobex.sweep(process, [1 / (2 * np.pi)], gains)
        fine = lobex.sweep(process, [1 / (2 * np.pi)], gains, FINE)
        error = np.abs(chart.spectral_radius / fine.spectral_radius - 1)
        assert np.all((chart.error <= 1e-8) & (fine.error < 1e-9))
        assert np.all(error < 1e-8)
        worse += np.sum(error > 10 * np.maximum(chart.error, fine.error))
        points += error.size
    assert worse <= 0.01 * points
