"""Uncertainty bands of the limit against Monte Carlo, and models made again from what a result says of them."""

from dataclasses import replace

import jax
import numpy as np
import pytest

import lobex
from cases import LIMIT_TOOLS, MILL, ROD, milling
from lobex.results.description import describe
from lobex.results.rebuild import rebuild
from refusals import refused

SPEEDS = np.array([85.0, 112.0, 200.0])
SAMPLES = 4096


@pytest.fixture(scope="module")
def limit():
    return lobex.exact_limit(ROD, SPEEDS)


def test_against_monte_carlo_mode_by_mode(limit):
    # 0.2 % of each frequency and 2 % of each damping ratio, all ten independent.
    band = limit.band({"modes.angular_frequency": 0.002, "modes.damping_ratio": 0.02})
    assert len(band.names) == 10
    shares = np.exp(np.random.default_rng(1).standard_normal((SAMPLES, 2, 5)) * np.array([0.002, 0.02])[:, None])

    def sample(share):
        modes = ROD.modes
        moved = lobex.Modes(modes.angular_frequency * share[0], modes.damping_ratio * share[1], modes.shape)
        return lobex.exact_limit(lobex.Rub(moved), SPEEDS).gain

    with jax.enable_x64(True):
        gains = np.asarray(jax.jit(lambda s: jax.lax.map(sample, s, batch_size=256))(shares))
    spread = np.std(np.log(gains), axis=0, ddof=1)
    # The standard deviation of 4096 normal samples scatters by 1.1 %.
    assert spread == pytest.approx(band.relative, rel=4 / np.sqrt(2 * SAMPLES))
    low, high = band.interval(2.0)
    inside = np.mean((gains > low) & (gains < high), axis=0)
    assert inside == pytest.approx(0.9545, abs=0.015)


def test_numbers_add_in_squares_and_modes_are_independent(limit):
    table = lobex.sensitivities(ROD, SPEEDS)
    both = limit.band({"speed": 0.01, "modes.damping_ratio": 0.1})
    parts = [0.1 * table[f"modes.damping_ratio[{i}]"] for i in range(5)] + [0.01 * table["speed"]]
    assert both.relative == pytest.approx(np.linalg.norm(parts, axis=0), rel=1e-12)
    assert both.standard_deviation == pytest.approx(both.relative * limit.gain, rel=1e-12)
    assert limit.band({"modes.damping_ratio[0]": 0.1}).relative == pytest.approx(np.abs(parts[0]), rel=1e-12)
    # One number that all modes share moves them together: its parts add, and not their squares.
    shared = lobex.sensitivities(
        lambda p: lobex.Rub(lobex.Modes(ROD.modes.angular_frequency, p["ξ"] * np.ones(5), ROD.modes.shape)),
        SPEEDS,
        at={"ξ": 0.03},
    ).band({"ξ": 0.1})
    assert shared.relative == pytest.approx(np.abs(np.sum(parts[:5], axis=0)), rel=1e-10)
    # So do those that are told to hang together, and those apart do not.
    each = {f"modes.damping_ratio[{i}]": 0.1 for i in range(5)}
    assert limit.band(each, correlation=np.ones((5, 5))).relative == pytest.approx(shared.relative, rel=1e-8)
    assert limit.band(each, correlation=np.eye(5)).relative == pytest.approx(limit.band(each).relative, rel=1e-8)


def test_correlations_that_cannot_be_are_refused(limit):
    each = {f"modes.damping_ratio[{i}]": 0.1 for i in range(3)}
    for wrong, words in (
        (np.eye(2), "correlation has shape (2, 2); give (3, 3) of 3 numbers"),
        (2 * np.eye(3), "correlation is no correlation matrix"),
        (np.array([[1, 1, 1], [1, 1, -1], [1, -1, 1.0]]), "correlation is no correlation matrix"),
    ):
        with refused(words):
            limit.band(each, correlation=wrong)
    with refused("with correlation, name each number by itself"):
        limit.band({"modes.damping_ratio": 0.1}, correlation=np.eye(1))


def test_edges_are_symmetric_in_the_logarithm(limit):
    band = limit.band({"speed": 0.02})
    low, high = band.interval(1.0)
    assert np.log(high / limit.gain) == pytest.approx(band.relative)
    assert low * high == pytest.approx(limit.gain**2)
    assert "speed" in repr(band)
    assert "100 % of the variance" in repr(band)


def test_a_loaded_limit_of_milling_has_the_same_band(tmp_path):
    process = milling(LIMIT_TOOLS["Insperger-Stepan"], 0.1, "down")
    limit = lobex.critical_gain(process, [8000 / 60, 9000 / 60], (0, 2e-3), lobex.Chebyshev(24), scan=9)
    limit.save(tmp_path / "limit.nc")
    deviation = {"tangential": 0.05, "radial_immersion": 0.02}
    band, again = limit.band(deviation), lobex.load(tmp_path / "limit.nc").band(deviation)
    np.testing.assert_array_equal(again.relative, band.relative)
    assert np.array_equal(np.isnan(band.relative), np.isnan(limit.gain))
    assert np.isfinite(band.relative).any()


@pytest.mark.parametrize(
    "model",
    [
        ROD,
        MILL,
        milling(LIMIT_TOOLS["Insperger-Stepan"], 0.7, "up", 2),
        lobex.Turning(ROD.modes, radial=2e8),
        lobex.DelayedMathieu(3.0, 2.0, 0.1),
        lobex.Scalar(-1.0),
        lobex.Rub(lobex.Blading(ROD.modes, 3)),
        lobex.Rub(lobex.Receptance(np.arange(1.0, 9), -np.arange(1.0, 9) - 9j)),
        lobex.Chebyshev(31, aligned=False),
        lobex.SemiDiscretization(24, order=1),
    ],
    ids=lambda model: type(model).__name__,
)
def test_models_come_back_from_their_description(model):
    again = rebuild(describe(model))
    assert type(again) is type(model)
    assert jax.tree.structure(again) == jax.tree.structure(model)
    for leaf, original in zip(jax.tree.leaves(again), jax.tree.leaves(model), strict=True):
        np.testing.assert_array_equal(leaf, original)


def test_the_picture_shades_the_band(limit):
    figure = limit.band({"modes.damping_ratio": 0.1, "speed": 0.003}).plot()
    names = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert names == ["stable", "± 2 standard deviations", "Hopf (complex pair)"]


@pytest.mark.parametrize(
    ("deviation", "words"),
    [
        ({"stiffness": 0.1}, "names 'stiffness'; give some of modes.angular_frequency"),
        ({"modes.damping_ratio": -0.1}, "must not be negative"),
        ({"speed": np.nan}, "NaN"),
        ({"speed": [0.1, 0.2]}, "give one number"),
        ({"modes.shape": 0.1, "modes.shape[0,0]": 0.2}, "overlap"),
        ({}, "must be a dictionary"),
        (0.1, "must be a dictionary"),
    ],
)
def test_bad_deviations_are_refused_in_one_line(limit, deviation, words):
    with refused(words):
        limit.band(deviation)


def test_a_process_of_the_users_own_is_asked_for(limit):
    own = replace(limit, process={**limit.process, "type": "Mine"})
    with pytest.raises(ValueError, match="'Mine', which cannot be made again"):
        own.band({"speed": 0.1})
