"""Pictures of bladings, and of how bad marches get over speed and penetration."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import lobex
import small_results
from refusals import refused

MODES = lobex.Modes.single(frequency=300.0, damping_ratio=0.03, mass=2.0)
STIFFNESS = 1e6
HEIGHTS = np.array([2e-5, 6e-5, 1e-4])
SPEED = np.array([100.0, 140.0, 180.0, 220.0])


def study(**others):
    return lobex.march_wear(
        MODES,
        lobex.Casing(clearance=1e-5),
        lobex.Linear(STIFFNESS),
        SPEED,
        3,
        64,
        samples_per_revolution=16,
        over={"casing.amplitude": HEIGHTS, **others},
    )


def test_a_severity_map_shows_the_last_motion_and_where_lobes_foretell_chatter():
    found, limit = study(), lobex.exact_limit(lobex.Rub(MODES), np.linspace(100, 220, 121))
    ax = lobex.severity(found, limit, STIFFNESS)
    mesh, hatched = ax.collections
    assert np.asarray(mesh.get_array()).ravel() == pytest.approx(1e6 * found["amplitude"].to_numpy()[:, :, -1].ravel())
    # Heights beyond the clearance, of which none is below 0.
    assert ax.get_ylim() == pytest.approx((0, 110))
    paths = hatched.get_paths()
    inside = np.array([any(bool(path.contains_point((s, 50.0))) for path in paths) for s in limit.speed[1:-1]])
    unstable = (limit.gain < STIFFNESS)[1:-1]
    assert np.any(unstable)
    assert not np.all(unstable)
    # Edges lie between two speeds.
    assert np.sum(inside != unstable) <= 2 * np.sum(np.diff(unstable.astype(int)) != 0)
    wear = np.asarray(lobex.severity(found, of="wear").collections[0].get_array()).ravel()
    assert wear == pytest.approx(1e6 * found["wear"].to_numpy().sum(axis=2).ravel())
    plt.close("all")


def test_the_shell_draws_the_map_that_python_draws(shell, tmp_path):
    flags = ("--elements", "1", "--stiffness", "1e6", "--clearance", "1e-5", "--revolutions", "3", "--steps", "64")
    grid = ("--speed", "100:220:4", "--penetration", "1e-5:9e-5:3", "--lobes", "121")
    assert shell("severity", "rub", *grid, *flags, "--out", "map").code == 0, shell.err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["map-limit.nc", "map.nc", "map.png"]
    modes = lobex.Rod(1).modes(0.03)
    study = lobex.march_wear(
        modes,
        lobex.Casing(clearance=1e-5),
        lobex.Linear(1e6),
        SPEED,
        3,
        64,
        over={"casing.amplitude": HEIGHTS},
    )
    found, limit = lobex.load("map.nc"), lobex.load("map-limit.nc")
    np.testing.assert_allclose(found["amplitude"].values, study["amplitude"].values, rtol=1e-12)
    exact = lobex.exact_limit(lobex.Rub(modes), np.linspace(100, 220, 121)).gain
    np.testing.assert_allclose(limit.gain, exact, rtol=1e-12)
    assert f"chatter at {np.sum(exact < 1e6)} of 121 speeds with K = 1e+06 N/m" in shell.out
    assert min(plt.imread("map.png").shape[:2]) > 500


def test_a_law_without_a_stiffness_foretells_nothing(shell, tmp_path):
    law = ("--law", "power", "--coefficient", "1e8", "--exponent", "1.5", "--revolutions", "3", "--steps", "64")
    grid = ("--speed", "100:220:4", "--penetration", "1e-5:9e-5:3", "--elements", "1", "--out", "map")
    assert shell("severity", *grid, *law).code == 0, shell.err
    assert "no stiffness that a limit is held against" in shell.out
    assert sorted(path.name for path in tmp_path.iterdir()) == ["map.nc", "map.png"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("--speed 100", "speed = '100' is one value"),
        ("--penetration 0:1e-4:3", "penetration = [0, "),
        ("--of noise", "of = 'noise'"),
        ("--lobes -1", "lobes = -1"),
        ("--law plastic", "yield_force is missing"),
        ("--blade none.toml", "cannot be read"),
    ],
)
def test_the_shell_refuses_a_map_of_bad_flags_in_one_line(shell, words, told):
    assert told in shell.refuses("severity", "rub", *words.split())


def test_a_blading_is_drawn_blade_by_blade():
    march = small_results.blading_wear()
    ax = march.plot()
    assert [line.get_label() for line in ax.lines] == [
        *("blade 1, track 1", "blade 1, track 2", "blade 2, track 1", "blade 2, track 2"),
        "mean of all",
    ]
    order = np.argsort(march.speed)
    assert np.asarray(ax.lines[3].get_ydata()) == pytest.approx(1e6 * march.peak[order, 3])
    assert march.blade_to_blade == pytest.approx(np.ones((2, 2)))
    one = march.of(3)
    assert one.depth.tolist() == march.depth[:, 1].tolist()
    assert one.amplitude.tolist() == march.amplitude[:, 3].tolist()
    plt.close("all")


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: lobex.severity(small_results.study()), "is no study of march_wear over casing.amplitude alone"),
        (lambda: lobex.severity(study(), stiffness=1e6), "limit and stiffness = 1000000.0 go together"),
        (lambda: lobex.severity(study(), of="noise"), "of = 'noise'"),
        (lambda: small_results.blading_wear().of(4), "contact = 4"),
    ],
)
def test_what_cannot_be_drawn_is_refused(call, words):
    with refused(words):
        call()
