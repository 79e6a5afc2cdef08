"""The design example, run as it stands, against a scan of all moduli by the scaling law."""

import runpy
from pathlib import Path

import numpy as np
import pytest

import lobex

NOTEBOOK = Path(__file__).parents[1] / "notebooks" / "design_by_gradient.py"


@pytest.fixture(scope="module")
def example():
    return runpy.run_path(str(NOTEBOOK))


def test_the_ascent_finds_what_a_brute_force_scan_finds(example):
    # K(αE; f) = α K(E; f/√α): the limit of the nominal blade at scaled speeds stands for every modulus.
    share = np.linspace(0.9, 1.3, 401)[:, None]
    scaled = example["SPEEDS"] / np.sqrt(share)
    limit = lobex.exact_limit(example["blade"](example["NOMINAL"]), scaled.ravel()).gain.reshape(scaled.shape)
    smallest = np.min(share * limit, axis=1)
    assert example["after"] >= 0.995 * smallest.max()
    assert example["best"] / example["NOMINAL"] == pytest.approx(share[np.argmax(smallest), 0], abs=2e-3)
    assert example["before"] == pytest.approx(smallest[100], rel=1e-9)
    assert example["after"] > 1.5 * example["before"]


def test_the_soft_minimum_is_as_close_as_the_text_says(example):
    gap = np.log(example["after"]) - example["heights"].max()
    assert 0 <= gap <= example["TEMPERATURE"] * np.log(len(example["SPEEDS"]))


def test_the_best_modulus_is_inside_the_bounds(example):
    low, high = example["BOUNDS"]
    assert np.all((example["paths"] >= np.log(low) - 1e-12) & (example["paths"] <= np.log(high) + 1e-12))
    assert low < example["best"] < high
