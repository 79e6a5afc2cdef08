"""The estimated error of delays apart from the period, shorter and longer, that vary, and of forces that jump."""

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


def waiting(share, t, speed, gain):
    """At work in a part of the period."""
    return jnp.where(t * speed < share, 2 * gain, 0.0)


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


def stepped(rng, delays):
    """One that feeds back in a part of the period alone, by delays whose jumps meet in no image."""
    numbers, share = np.array([rng.uniform(0.3, 30), rng.uniform(0.1, 2)]), rng.uniform(0.2, 0.8)
    process = lobex.LinearDelay.second_order(
        1.0,
        rng.uniform(0.02, 0.3),
        PARTIAL(pulling, numbers),
        [(PARTIAL(waiting, share), PARTIAL(constant, delay)) for delay in delays],
        delay_range=(min(delays), max(delays)),
        breaks=[0.0, share],
    )
    return process, np.sort(rng.uniform(-2, 2, 4)) * numbers[0]


@pytest.mark.parametrize("kind", KINDS)
def test_a_general_system_is_right_or_says_so(kind):
    rng = np.random.default_rng(5)
    worse, points = 0, 0
    for _ in range(8):
        process, gains = mathieu(rng, *KINDS[kind])
        chart = lobex.sweep(process, [1 / (2 * np.pi)], gains)
        fine = lobex.sweep(process, [1 / (2 * np.pi)], gains, FINE)
        error = np.abs(chart.spectral_radius / fine.spectral_radius - 1)
        assert np.all((chart.error <= 1e-8) & (fine.error < 1e-9))
        assert np.all(error < 1e-8)
        worse += np.sum(error > 10 * np.maximum(chart.error, fine.error))
        points += error.size
    assert worse <= 0.01 * points


@pytest.mark.filterwarnings("ignore::lobex.SweepWarning")
@pytest.mark.parametrize("delays", [(0.618034,), (0.618034, 0.81)])
def test_jumps_whose_images_end_no_piece_are_in_the_error(delays):
    rng = np.random.default_rng(6)
    ratio = []
    for _ in range(6):
        process, gains = stepped(rng, delays)
        fine = lobex.sweep(process, [1 / (2 * np.pi)], gains, lobex.Duhamel(nodes=30))
        for nodes in (10, 18):
            chart = lobex.sweep(process, [1 / (2 * np.pi)], gains, lobex.Duhamel(nodes=nodes))
            error = np.abs(chart.spectral_radius / fine.spectral_radius - 1)
            ratio.append(error / np.maximum(chart.error, fine.error))
    assert np.mean(np.array(ratio) > 10) <= 0.01
    # The bound is not so wide that it tells nothing.
    assert np.max(ratio) > 0.1
