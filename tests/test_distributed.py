"""Distributed delays: against roots of characteristic equations that are known in closed form."""

import jax.numpy as jnp
import numpy as np
import pytest
from jax.tree_util import Partial
from scipy.optimize import root

import lobex
from lobex.systems.mesh import pieces_of
from refusals import refused

A, SHARE = -0.5, 0.8
GAINS = np.array([-3.0, -1.0, 1.2])
TWELVE = lobex.Duhamel(nodes=12)


def weighted(powers, s, t, speed, gain):
    """gain (p + q s)."""
    return gain * (powers[0] + powers[1] * s)


def process(powers=(1.0, 0.0), nodes=10, **others):
    """ẋ = a x + gain ∫ (p + q s) x(t − s) ds over the last second, seen over a period of 0.8 s."""
    kernel = Partial(weighted, np.array(powers))
    return lobex.LinearDelay(A, distributed=[(kernel, (0.0, 1.0))], distributed_nodes=nodes, period=SHARE, **others)


def multiplier(gain, powers):
    """exp(λ T) of the rightmost root of λ − a − gain [p (1 − e^−λ)/λ + q (1 − (1 + λ) e^−λ)/λ²]."""

    def characteristic(parts):
        s = complex(*parts)
        even, rising = (1 - np.exp(-s)) / s, (1 - (1 + s) * np.exp(-s)) / s**2
        value = s - A - gain * (powers[0] * even + powers[1] * rising)
        return value.real, value.imag

    starts = [(real, turn) for real in (-4.0, -1.0, 0.7) for turn in (0.1, 2.0, 5.0, 9.0)]
    found = [root(characteristic, start, tol=1e-14) for start in starts]
    roots = [complex(*one.x) for one in found if np.max(np.abs(one.fun)) < 1e-11]
    return np.exp(max(roots, key=lambda one: one.real) * SHARE)


@pytest.mark.slow
@pytest.mark.parametrize("powers", [(1.0, 0.0), (0.2, 1.5)])
def test_multipliers_are_those_of_the_characteristic_equation(powers):
    chart = lobex.sweep(process(powers), [1.0], GAINS, TWELVE)
    wanted = np.array([multiplier(gain, powers) for gain in GAINS])
    # Gains share what is the same for all: not what delays shorter than a piece bring within it.
    assert chart.multiplier[0] == pytest.approx(wanted.real + 1j * np.abs(wanted.imag), rel=1e-9)
    assert np.all(chart.error < 1e-8)


@pytest.mark.slow
def test_few_point_delays_come_to_it_with_twice_their_number():
    wanted = abs(multiplier(-3.0, (1.0, 0.0)))
    error = [abs(lobex.spectral_radius(process(nodes=n), 1.0, -3.0, TWELVE) / wanted - 1) for n in (1, 3)]
    assert error[0] > 0.1
    assert error[1] < error[0] / 500


@pytest.mark.slow
def test_ends_that_follow_the_speed_and_a_kernel_that_is_a_number():
    window = lobex.LinearDelay(
        A,
        distributed=[(-3.0, (0.0, lambda speed, gain: 1 / speed))],
        period=lambda speed, gain: SHARE / speed,
        delay_range=(0.01, 1.25),
    )
    radius = lobex.spectral_radius(window, 1.0, 0.0, TWELVE)
    assert radius == pytest.approx(abs(multiplier(-3.0, (1.0, 0.0))), rel=1e-9)


@pytest.mark.slow
def test_a_forced_one_moves_as_its_transfer_function_says():
    def wave(t, speed, gain):
        return jnp.cos(2 * jnp.pi * t / SHARE)

    motion = lobex.orbit(process(nodes=8, forcing=wave), 1.0, -1.0, TWELVE)
    s = 2j * np.pi / SHARE
    transfer = 1 / (s - A + (1 - np.exp(-s)) / s)
    assert motion.displacement[:, 0] == pytest.approx(np.real(transfer * np.exp(s * motion.time)), abs=1e-10)


@pytest.mark.filterwarnings("ignore::lobex.SweepWarning")
@pytest.mark.slow
def test_jumps_end_pieces_and_their_images_by_so_many_delays_do_not():
    def stepping(s, t, speed, gain):
        return jnp.where(t < 0.3, gain, 0.5 * gain)

    jumping = lobex.LinearDelay(A, distributed=[(stepping, (0.0, 1.0))], period=SHARE, breaks=[0.0, 0.375])
    found = lobex.sweep(jumping, [1.0], [-2.0], TWELVE)
    system = jumping.system(1.0, -2.0)
    assert len(system.feedback) == 10
    assert len(pieces_of(system)) == 2
    # What jumps is seen through each of the delays, weakly, within pieces: the error tells.
    finer = lobex.sweep(jumping, [1.0], [-2.0], lobex.Duhamel(nodes=20))
    assert abs(found.spectral_radius / finer.spectral_radius - 1) < 10 * found.error
    assert 1e-7 < found.error < 1e-4


@pytest.mark.parametrize(
    ("distributed", "message"),
    [
        ([1.0], r"distributed\[0\] = 1.0 must be a pair: a kernel, and the shortest and the longest delay in s"),
        ([(1.0, 0.5)], r"distributed\[0\] = .* must be a pair"),
        ([(1.0, (0.5, 0.5))], r"distributed\[0\] reaches from 0.5 to 0.5 s; give the shorter delay first"),
        ([(1.0, (-0.1, 0.5))], r"an end of distributed\[0\] = -0.1 must not be negative"),
        ([(np.eye(2), (0.0, 0.5))], r"distributed\[0\] has shape \(2, 2\); give \(1, 1\)"),
        ([(1.0, (0.0, lambda speed, gain: 1.0))], "delay_range is needed"),
    ],
)
def test_bad_input_is_one_line(distributed, message):
    with refused(match=message):
        lobex.LinearDelay(A, distributed=distributed, period=SHARE)
