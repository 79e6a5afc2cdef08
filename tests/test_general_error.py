"""The estimated error of every kind of delay system, random ones, against an oracle of the tests' own."""

import warnings

import jax.numpy as jnp
import numpy as np
import pytest
from jax.tree_util import Partial

import lobex
import whole_state
from problems import Damper, ago, around, pitched, times, turned
from reference_cases import varying as variation_of

# What the oracle is good for.
REFERENCE = 1e-11
TWO_PI = 2 * np.pi


def varying(share, t, speed, gain):
    return share * (1 + 0.1 * jnp.sin(TWO_PI * speed * t)) / speed


def waiting(share, t, speed, gain):
    """At work in a part of the period."""
    return jnp.where(t * speed < share, 2 * gain, 0.0)


def mathieu(delay, delay_range):
    """A damped delayed Mathieu equation."""

    def made(rng):
        stiffness = Partial(around, np.array([rng.uniform(0.3, 4), rng.uniform(0.1, 2)]))
        feedback = [(Partial(times, np.eye(1)), delay)]
        damping = rng.uniform(0.02, 0.3)
        process = lobex.LinearDelay.second_order(1.0, damping, stiffness, feedback, delay_range=delay_range)
        return process, 1 / TWO_PI, rng.uniform(-0.8, 0.8, 4), ()

    return made


def shortened(rng):
    """A delay that changes by a third of the time that goes by: waves, ten or so in a period, are shorter by that."""
    numbers = np.array([rng.uniform(60, 300), rng.uniform(0.1, 2)])
    stiffness, feedback = Partial(around, numbers), [(Partial(times, np.eye(1)), Partial(varying, 0.5))]
    process = lobex.LinearDelay.second_order(1.0, rng.uniform(0.1, 0.6), stiffness, feedback, delay_range=(0.45, 0.55))
    return process, 1 / TWO_PI, rng.uniform(-0.3, 0.3, 4) * numbers[0], ()


def stepped(delays):
    """One that feeds back in a part of the period alone, by delays whose jumps meet in no image."""

    def made(rng):
        numbers, share = np.array([rng.uniform(0.3, 30), rng.uniform(0.1, 2)]), rng.uniform(0.2, 0.8)
        process = lobex.LinearDelay.second_order(
            1.0,
            rng.uniform(0.02, 0.3),
            Partial(around, numbers),
            [(Partial(waiting, share), Partial(ago, delay)) for delay in delays],
            delay_range=(min(delays), max(delays)),
            breaks=[0.0, share],
        )
        return process, 1 / TWO_PI, rng.uniform(-2, 2, 4) * numbers[0], (0.0, share)

    return made


def first_order(rng):
    """Two states and two delays, one of them longer than the period."""
    drift = rng.normal(size=(2, 2)) - 1.5 * np.eye(2)
    feedback = [(Partial(times, rng.normal(size=(2, 2))), Partial(ago, periods)) for periods in (0.7, 1.4)]
    return lobex.LinearDelay(drift, feedback, delay_range=(0.7, 1.4)), rng.uniform(0.3, 1), rng.uniform(-1, 1, 4), ()


def damper(rng):
    """What acts now holds a velocity, and is not what is remembered."""
    numbers = rng.uniform((0.5, 0.02, -0.4, -0.1), (30.0, 0.5, 0.4, 0.6))
    return Damper(*numbers), 1.0, rng.uniform(-0.8, 0.8, 4) * numbers[0], ()


def turning(rng):
    """Process damping, of up to 15 waves in a turn."""
    frequency, ratio, mass = rng.uniform(100, 800), 10 ** rng.uniform(-2.5, -1), rng.uniform(0.2, 3)
    mode = {"frequency_Hz": frequency, "damping_ratio": ratio, "modal_mass_kg": mass}
    machine = {"modes": [mode], "K_N_per_m2": 1.5e9, "C_N_per_m": 10 ** rng.uniform(4, 5.8), "radius_m": 0.0175}
    rpm = 60 * frequency / 10 ** rng.uniform(-0.3, 1.2)
    limit = 2 * mass * (TWO_PI * frequency) ** 2 * ratio / 1.5e9
    return turned(machine, rpm), rpm / 60, limit * 10 ** rng.uniform(-1, 1, 4), ()


def cutter(rng):
    """Two teeth of unequal pitch; where pieces end is static, so that the angles stay."""
    modes = lobex.Modes.single(frequency=rng.uniform(100, 900), damping_ratio=rng.uniform(0.005, 0.05), mass=1.0)
    process = pitched([160, 200], modes=modes)
    speed = modes.frequency[0] / rng.uniform(0.6, 8)
    limit = 2 * modes.angular_frequency[0] ** 2 * modes.damping_ratio[0] / 2e8
    breaks = [float(piece.start) for term in process.system(1.0, 1.0).terms for piece in term.coefficient.pieces()]
    return process, speed, limit * 10 ** rng.uniform(-1, 1, 4), breaks


KINDS = {
    "period of two delays": mathieu(Partial(ago, 0.5), (0.5, 0.5)),
    "delay of two periods": mathieu(Partial(ago, 2.0), (2.0, 2.0)),
    "golden ratio": mathieu(Partial(ago, 0.618034), (0.618034, 0.618034)),
    "delay that varies": mathieu(Partial(varying, 0.3), (0.27, 0.33)),
    "waves that a delay shortens": shortened,
    "jumps": stepped((0.618034,)),
    "jumps of two delays": stepped((0.618034, 0.81)),
    "first order": first_order,
    "remembered": damper,
    "process damping": turning,
    "two teeth": cutter,
}
SMOOTH = (
    *("period of two delays", "delay of two periods", "golden ratio", "waves that a delay shortens"),
    "delay that varies",
)
JUMPS = ("jumps", "jumps of two delays")
OTHERS = ("first order", "remembered", "process damping", "two teeth")
# Of the oracle, so that none turns by more than a few radians.
PARTS = {
    "waves that a delay shortens": 60,
    "jumps": 16,
    "jumps of two delays": 16,
    "process damping": 40,
    "two teeth": 24,
}


def slow(kinds):
    return [pytest.param(kind, marks=pytest.mark.slow) for kind in kinds]


def compared(kind, rng, method):
    """Of a random system: the error of |μ|, and what was said of it."""
    process, speed, gains, breaks = KINDS[kind](rng)
    gains = np.sort(gains)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        chart = lobex.sweep(process, [speed], gains, method)
    said = chart.error[0] > 1e-8
    assert np.any(said) == any("estimated error" in str(warning.message) for warning in caught)
    parts = PARTS.get(kind, 8)
    exact = [abs(whole_state.largest(process, speed, gain, breaks, parts)[0]) for gain in gains]
    return np.abs(chart.spectral_radius[0] / exact - 1), chart.error[0]


def assert_honest(kind, cases, method, seed):
    rng = np.random.default_rng(seed)
    error, stated = np.array([compared(kind, rng, method) for _ in range(cases)]).swapaxes(0, 1)
    assert np.mean(error > 10 * np.maximum(stated, REFERENCE)) <= 0.01
    # What is above the tolerance is said.
    assert np.all((error <= 1e-8) | (stated > 1e-8))
    return error, stated


@pytest.mark.parametrize("kind", slow(SMOOTH))
def test_chosen_nodes_are_right_or_say_so(kind):
    _, stated = assert_honest(kind, 5, lobex.Duhamel(), 5)
    assert np.all(stated <= 1e-8)


# Of x″ + 2ξω x′ + ω²x = g ω² [x(t − τ(t)) − x], 100 Hz and 2 %, by collocation of the pencil and Hill's determinant.
@pytest.mark.slow
@pytest.mark.parametrize(
    ("form", "multiplier"),
    [
        ("instantaneous", 0.45041969197 + 0.39257016704j),
        ("first-order", 0.08513407092 + 0.47850501483j),
    ],
)
def test_many_waves_in_a_piece_that_a_delay_shortens_are_right(form, multiplier):
    omega = TWO_PI * 100.0
    process = variation_of(form, 0.1, 0.5, (0.04 * omega, omega**2, omega**2, 1.0))
    found = lobex.sweep(process, [10.0], [0.1])
    assert found.multiplier[0, 0] == pytest.approx(multiplier, rel=1e-8)
    # With as few nodes as one might take the error is said.
    few = lobex.sweep(process, [10.0], [0.1], lobex.Duhamel(nodes=44, tolerance=1e-3))
    assert abs(few.spectral_radius[0, 0] / abs(multiplier) - 1) < 10 * few.error[0, 0]


@pytest.mark.parametrize("kind", slow(JUMPS))
def test_jumps_whose_images_end_no_piece_are_in_the_error(kind):
    error, stated = assert_honest(kind, 4, lobex.Duhamel(nodes=18), 6)
    # The bound is not so wide that it tells nothing.
    assert np.max(error / np.maximum(stated, REFERENCE)) > 0.01


@pytest.mark.parametrize("kind", [*slow(OTHERS[:-1]), pytest.param(OTHERS[-1], marks=pytest.mark.search)])
def test_few_nodes_are_right_or_say_so(kind):
    error, stated = assert_honest(kind, 5, lobex.Duhamel(nodes=14), 5)
    assert np.any(error > 1e-4 * stated)


@pytest.mark.search
@pytest.mark.parametrize("nodes", [8, 14, 20, None])
@pytest.mark.parametrize("kind", KINDS)
def test_any_system_is_right_or_says_so(kind, nodes):
    _, stated = assert_honest(kind, 60, lobex.Duhamel(nodes=nodes), 100 + (nodes or 0))
    assert nodes is not None or np.all(stated <= 1e-8)
