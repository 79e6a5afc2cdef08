"""Random milling against a collocation of the tests' own: the number is right, or it says that it may not be."""

import warnings

import numpy as np
import pytest

import lobex
from milling_collocation import multipliers

# Teeth, modes, directions, up or down: each is a program of its own.
SHAPES = [(1, 1, 1, "down"), (2, 2, 1, "up"), (3, 3, 1, "down"), (2, 1, 2, "down"), (3, 2, 2, "up"), (4, 3, 2, "down")]
# What the collocation itself is good for.
REFERENCE = 1e-13


def random_cutter(rng, teeth, modes, directions, direction, immersion, apart=2.5):
    frequency = rng.uniform(100, 400) * np.cumprod(np.r_[1.0, rng.uniform(1.02, apart, modes - 1)])
    return {
        "omega": 2 * np.pi * frequency,
        "ratio": 10 ** rng.uniform(-3, np.log10(0.05), modes),
        "shape": rng.normal(size=(modes, directions)) * 10 ** rng.uniform(-0.5, 0.5),
        "teeth": teeth,
        "direction": direction,
        "radial_immersion": immersion,
        "tangential": 10 ** rng.uniform(8.3, 9.2),
        "normal": 10 ** rng.uniform(7.8, 8.8),
    }


def grid_of(rng, cutter, waves):
    """Speeds, of so many waves of the first mode in a tooth period, and gains around the limit."""
    waves = np.asarray(waves)
    speeds = np.sort(cutter["omega"][0] / (2 * np.pi) / waves / cutter["teeth"])
    # The least limit of one mode under the mean force of all teeth, within a factor of a few.
    softness = np.max(np.sum(cutter["shape"] ** 2, axis=1) / (4 * cutter["omega"] ** 2 * cutter["ratio"]))
    force = cutter["tangential"] * cutter["teeth"] * np.arccos(1 - 2 * cutter["radial_immersion"]) / (2 * np.pi)
    return speeds, np.sort(10 ** rng.uniform(-1, 1, 4)) / (softness * force)


def assert_right_or_said(cutter, speeds, gains):
    """Every |μ| is within ten times its stated error, or that is above the tolerance and was warned of."""
    modes = lobex.Modes(cutter["omega"], cutter["ratio"], cutter["shape"])
    numbers = (cutter[name] for name in ("teeth", "tangential", "normal", "radial_immersion", "direction"))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        chart = lobex.sweep(lobex.Milling(modes, *numbers), speeds, gains)
    assert np.any(chart.error > 1e-8) == bool([w for w in caught if "estimated error" in str(w.message)]), cutter
    expected = np.array([[np.abs(multipliers(cutter, speed, gain)[0]) for gain in gains] for speed in speeds])
    error = np.abs(chart.spectral_radius / expected - 1)
    within = error <= 10 * np.maximum(chart.error, REFERENCE / 10)
    said = chart.error > 1e-8
    assert np.all(within | said), f"{cutter}, {speeds}, {gains}: {error} of {chart.error}"
    return error, chart.error


@pytest.mark.parametrize(
    "seed", [seed if seed == 2 else pytest.param(seed, marks=pytest.mark.slow) for seed in range(10)]
)
def test_a_random_cutter_is_right_or_says_so(seed):
    rng = np.random.default_rng(seed)
    cutter = random_cutter(rng, 2, 2, 2, "down", rng.uniform(0.05, 0.45), apart=1.3)
    # As many waves in the cut at the lowest speed of all, so that all begin with the same nodes.
    in_cut = np.arccos(1 - 2 * cutter["radial_immersion"]) / np.pi
    waves = np.array([1.2, 10 ** rng.uniform(-1, 0)]) / in_cut
    _, stated = assert_right_or_said(cutter, *grid_of(rng, cutter, waves))
    assert np.all(stated <= 1e-8)


@pytest.mark.search
@pytest.mark.parametrize("seed", range(100))
def test_any_cutter_is_right_or_says_so(seed):
    rng = np.random.default_rng(1000 + seed)
    cutter = random_cutter(rng, *SHAPES[seed % len(SHAPES)], rng.uniform(0.05, 1.0))
    assert_right_or_said(cutter, *grid_of(rng, cutter, 10 ** rng.uniform(np.log10(0.3), np.log10(15.0), 2)))
