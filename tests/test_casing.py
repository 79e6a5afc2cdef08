"""The casing's shape against its formulas, and its picture."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import lobex
from refusals import refused

CELLS = 720
ANGLE = 2 * np.pi * np.arange(CELLS) / CELLS


def test_the_default_is_two_cosine_bumps_with_the_tip_between():
    profile = lobex.Casing().profile(CELLS)
    assert profile.dtype == np.float64
    assert profile[0] == 0
    assert profile[CELLS // 4] == pytest.approx(-1e-4, rel=1e-15)
    assert profile[3 * CELLS // 4] == pytest.approx(-1e-4, rel=1e-15)
    # Each bump spans half of its pitch of 180°: 45° to 135°.
    degrees = np.degrees(ANGLE)
    inside = np.abs(degrees % 180 - 90) < 45
    expected = np.where(inside, -1e-4 * np.cos(np.radians(2 * (degrees % 180 - 90))) ** 2, 0)
    assert profile == pytest.approx(expected, abs=1e-18)


def test_the_public_benchmark_profile():
    gap = 5e-4
    expected = gap * (1 - 2 * np.exp(-((((ANGLE % np.pi) / np.pi - 0.5) / 0.15) ** 2)))
    casing = lobex.Casing(2, amplitude=2 * gap, clearance=gap, bump="gaussian", bump_width=0.15)
    assert casing.profile(CELLS) == pytest.approx(expected, abs=1e-16)


def test_the_ovoid_is_an_ellipse():
    casing = lobex.Casing(amplitude=0.02, clearance=0.003, bump="ovoid", radius=0.5)
    r = casing.profile(CELLS) - 0.003 + 0.5
    x, y = r * np.cos(ANGLE), r * np.sin(ANGLE)
    assert (x / 0.5) ** 2 + (y / 0.48) ** 2 == pytest.approx(np.ones(CELLS), rel=1e-14)


@pytest.mark.parametrize("bump", ["cosine", "gaussian"])
@pytest.mark.parametrize("diameters", [1, 3, 5])
def test_bumps_repeat_once_per_nodal_diameter(diameters, bump):
    profile = lobex.Casing(diameters, bump=bump, bump_width=0.3, clearance=2e-5).profile(30 * diameters)
    assert profile == pytest.approx(np.roll(profile, 30), abs=1e-17)
    assert profile.min() == pytest.approx(-8e-5, rel=1e-12)
    assert np.sum(profile == profile.min()) == diameters or np.ptp(np.sort(profile)[:diameters]) < 1e-17


def test_a_surface_of_ones_own_replaces_the_bumps():
    surface = 1e-5 * np.sin(ANGLE)
    assert np.array_equal(lobex.Casing(surface=surface).profile(CELLS), surface)


def test_the_picture_says_that_it_is_exaggerated_and_by_how_much():
    axes = lobex.Casing(clearance=2e-5).plot(magnification=400)
    assert "exaggerated" in axes.get_title()
    assert "× 400" in axes.get_title()
    surface = next(line for line in axes.get_lines() if line.get_label() == "casing before wear")
    assert surface.get_ydata().min() == pytest.approx(1 - 400 * 8e-5 / 0.5, rel=1e-5)
    assert surface.get_ydata().max() == pytest.approx(1 + 400 * 2e-5 / 0.5, rel=1e-5)
    automatic = lobex.Casing(amplitude=3e-6).plot()
    assert "× 20000" in automatic.get_title()
    _, given = plt.subplots(subplot_kw={"projection": "polar"})
    assert lobex.Casing().plot(ax=given) is given


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: lobex.Casing(0), "nodal_diameters = 0"),
        (lambda: lobex.Casing(2.5), "nodal_diameters = 2.5"),
        (lambda: lobex.Casing(clearance=-1e-5), "clearance = -1e-05"),
        (lambda: lobex.Casing(amplitude=np.nan), "amplitude = nan"),
        (lambda: lobex.Casing(amplitude=-1e-4), "amplitude = -0.0001"),
        (lambda: lobex.Casing(amplitude=0.6), "amplitude = 0.6 m is not below radius"),
        (lambda: lobex.Casing(amplitude=[1e-4, 2e-4]), "amplitude has shape (2,)"),
        (lambda: lobex.Casing(bump="square"), "bump = 'square'"),
        (lambda: lobex.Casing(bump_width=1.5), "bumps overlap"),
        (lambda: lobex.Casing(bump_width=0), "bump_width = 0"),
        (lambda: lobex.Casing(3, bump="ovoid"), "an ovoid has 2"),
        (lambda: lobex.Casing(radius=0), "radius = 0"),
        (lambda: lobex.Casing(surface=[0.0, np.nan]), "surface = [0, nan]"),
        (lambda: lobex.Casing(surface=[[0.0, 1.0]]), "surface has shape (1, 2)"),
        (lambda: lobex.Casing(surface=[]), "surface has shape (0,)"),
        (lambda: lobex.Casing(surface=[0.0, 1.0]).profile(3), "surface has 2 cells and 3"),
        (lambda: lobex.Casing().profile(0), "cells = 0"),
        (lambda: lobex.Casing().plot(magnification=0), "magnification = 0"),
        (lambda: lobex.Casing().plot(ax=plt.subplots()[1]), "not polar"),
    ],
)
def test_bad_casings_are_refused_in_one_line(call, words):
    with refused(words):
        call()
