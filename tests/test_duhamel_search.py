"""Random rubs by the operator, against a count of roots: the number is right, or it says that it may not be."""

import warnings

import numpy as np
import pytest

import lobex
from root_count import Feedback, polished, roots_beyond

# What 1 and 3 modes and 16 nodes resolve goes up to few waves per delay.
FEW_WAVES, MANY_WAVES = (-1.0, 1.5), (-1.0, 2.5)


def swept(omega, ratio, shape, speed, gains, method):
    """A chart of one speed, and whether its errors were warned of."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        chart = lobex.sweep(lobex.Rub(lobex.Modes(omega, ratio, shape)), [speed], gains, method)
    return chart, any("estimated error" in str(warning.message) for warning in caught)


def sure_points(omega, ratio, shape, speed, gains, method):
    """How many points claim to be good; of each, that it is a root as stated, and that no other lies beyond."""
    omega, ratio, shape = (np.asarray(part, dtype=float) for part in (omega, ratio, shape))
    chart, warned = swept(omega, ratio, shape, speed, gains, method)
    said = chart.error[0] > method.tolerance
    assert warned == np.any(said)
    growth = np.log(chart.spectral_radius[0])
    for gain, start, turn, stated, open_ in zip(
        gains, growth, 2 * np.pi * chart.chatter_frequency[0] / speed, chart.error[0], said, strict=True
    ):
        if open_:
            continue
        function = Feedback(omega, ratio, shape[:, 0] ** 2, 1 / speed, gain)
        root, step = polished(function, start + 1j * turn)
        case = f"{omega}, {ratio}, {shape}, {speed}, {gain}: {np.exp(start)} with {stated}"
        assert step < 1e-9, case
        assert abs(root.real - start) <= 10 * max(stated, 1e-14), case
        assert roots_beyond(function, root.real + 1e-6) == 0, case
    return int(np.sum(~said))


def random_model(rng, modes, waves):
    """Modes, a speed and gains from a hundredth of the least limit to 1e4 times it."""
    omega = np.sort(10 ** rng.uniform(0, 2, modes))
    ratio = 10 ** rng.uniform(-4, -0.7, modes)
    shape = rng.normal(size=(modes, 1)) * omega[:, None] ** rng.uniform(0.3, 1)
    speed = min(omega[-1] / 10 ** rng.uniform(*waves), 30 * omega[0]) / (2 * np.pi)
    turn = np.concatenate([own * (1 + xi * np.linspace(0, 10, 200)) for own, xi in zip(omega, ratio, strict=True)])
    response = np.sum(
        shape[:, 0] ** 2 / (omega**2 - turn[:, None] ** 2 + 2j * ratio * omega * turn[:, None]), axis=1
    ).real
    return omega, ratio, shape, speed, np.sort(10 ** rng.uniform(-2, 4, 8)) / (-2 * response.min())


@pytest.mark.slow
@pytest.mark.parametrize("modes", [1, 3])
def test_sixteen_nodes_are_right_or_say_so(modes):
    rng = np.random.default_rng(modes)
    sure = sum(sure_points(*random_model(rng, modes, FEW_WAVES), lobex.Duhamel(nodes=16)) for _ in range(40))
    assert 60 < sure < 300


SLOW = [
    (1.0, 0.03, 1.0, 0.0086, [50.0, 60.0]),
    (1.0, 0.03, 1.0, 0.0086, [10.0, 20.0]),
    (1.0, 0.001, 1.0, 0.0086, [50.0, 100.0]),
    (1480.0, 0.03, 135.0, 2.94, [0.146, 182.0, 361.0]),
]


@pytest.mark.slow
@pytest.mark.parametrize(("omega", "ratio", "shape", "speed", "gains"), SLOW)
def test_a_contact_too_stiff_for_the_nodes_is_said(omega, ratio, shape, speed, gains):
    # The loop turns 7 to 10 times as quickly as the mode alone, 130 times per delay and more.
    chart, warned = swept([omega], [ratio], [[shape]], speed, gains, lobex.Duhamel(nodes=110))
    assert warned
    assert np.all(np.isinf(chart.error))


@pytest.mark.search
def test_hundreds_of_nodes_follow_a_stiff_contact():
    assert sure_points([1.0], [0.03], [[1.0]], 0.0086, [10.0, 20.0], lobex.Duhamel()) == 2


@pytest.mark.search
@pytest.mark.parametrize("modes", [1, 2, 5, 8])
def test_any_rub_is_right_or_says_so(modes):
    rng = np.random.default_rng(100 + modes)
    assert sum(sure_points(*random_model(rng, modes, MANY_WAVES), lobex.Duhamel()) for _ in range(50)) > 100
