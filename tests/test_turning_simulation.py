"""Turning in time with loss of contact: against the linear march, closed forms, and a method of steps."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import lobex
from lobex.contact.laws import Cubic, Linear, Plastic, Power, Threshold
from lobex.marches.delay import march_delay
from lobex.marches.turning import simulate_turning
from refusals import refused

OMEGA, XI, MASS = 2 * np.pi * 150.0, 0.03, 2.5
STIFFNESS = MASS * OMEGA**2
TOOL = lobex.Modes.single(frequency=150.0, damping_ratio=XI, mass=MASS)
RADIAL, SPEED, FEED = 2e8, 70.0, 1e-4
LIMIT = float(lobex.exact_limit(lobex.Turning(TOOL, RADIAL), [SPEED]).gain[0])
DEPTHS = LIMIT * np.array([0.5, 0.9, 1.15, 3.0])
LAWS = {
    "linear": Linear(RADIAL),
    "cubic": Cubic(1.0, 3e8, -1e12, 2e15),
    "threshold": Threshold(1.0, 1e4, 1.5e8),
    "power": Power(1.0, 1.8e7, 0.7),
}


@pytest.fixture(scope="module")
def cut():
    return simulate_turning(TOOL, Linear(RADIAL), SPEED, DEPTHS, FEED, 60, 600)


def test_in_permanent_contact_it_is_the_linear_march(cut):
    rest = RADIAL * DEPTHS[:2] * FEED / STIFFNESS
    # (2.12) around its steady deflection.
    history = lambda t: np.broadcast_to(-rest[:, None], t.shape)  # noqa: E731
    march = march_delay(lobex.Turning(TOOL, RADIAL), SPEED, DEPTHS[:2], history, 60, 600)
    assert cut.chip_thickness[:2].min() > 0
    assert cut.displacement[:2] == pytest.approx(march.displacement[:, :, 0] + rest[:, None], abs=1e-12 * FEED)


@pytest.mark.parametrize("name", LAWS)
def test_a_stable_cut_settles_at_the_static_deflection(name):
    per_depth = {
        "linear": RADIAL * FEED,
        "cubic": 3e8 * FEED - 1e12 * FEED**2 + 2e15 * FEED**3,
        "threshold": 1e4 + 1.5e8 * FEED,
        "power": 1.8e7 * FEED**0.7,
    }[name]
    depth = 0.4 * LIMIT
    settled = simulate_turning(TOOL, LAWS[name], SPEED, depth, FEED, 60, 200)
    assert settled.force[-200:] == pytest.approx(depth * per_depth, rel=1e-6)
    assert settled.displacement[-200:] == pytest.approx(depth * per_depth / STIFFNESS, rel=1e-6)
    assert settled.chip_thickness[-200:] == pytest.approx(FEED, rel=1e-6)
    assert settled.separation == 0


def test_cuts_below_the_limit_calm_down_and_above_it_chatter(cut):
    assert np.all(cut.amplitude[:2] < 1e-2 * FEED)
    assert np.array_equal(cut.separation[:2], [0, 0])
    # Linear theory would let it grow for ever: leaving the cut bounds it at the size of the feed.
    assert np.all(cut.separation[2:] > 0.1)
    assert np.all((cut.amplitude[2:] > 0.3 * FEED) & (cut.amplitude[2:] < 10 * FEED))
    growth = lobex.spectral_radius(lobex.Turning(TOOL, RADIAL), SPEED, DEPTHS)
    assert np.array_equal(growth > 1, [False, False, True, True])


@pytest.mark.parametrize("name", LAWS)
def test_chip_and_force_come_from_the_lowest_surface_of_all_earlier_passes(name):
    depth, steps = 3 * LIMIT, 200
    chatter = simulate_turning(TOOL, LAWS[name], SPEED, depth, FEED, 30, steps)
    q = chatter.displacement
    before = np.concatenate([np.zeros(steps), q[:-1]])
    passes = before.reshape(31, steps)
    # The surface that pass j left lies j feeds above the tool's path in the pass p.
    lowest = np.array([np.min(passes[: p + 1] + FEED * np.arange(p + 1, 0, -1)[:, None], axis=0) for p in range(30)])
    gap = lowest.ravel() - q[:-1]
    assert np.maximum(gap, 0) == pytest.approx(chatter.chip_thickness[:-1], abs=1e-12)
    last_pass_only = before[:-1][: len(gap)] + FEED - q[:-1]
    left = chatter.force == 0
    assert left.any()
    assert np.all(chatter.force >= 0)
    assert np.all(chatter.chip_thickness >= 0)
    assert np.array_equal(left, chatter.chip_thickness == 0)
    # Regeneration from the last pass alone would give another force.
    assert np.max(last_pass_only - gap) > 0.1 * FEED
    law = {
        "linear": lambda h: RADIAL * h,
        "cubic": lambda h: 3e8 * h - 1e12 * h**2 + 2e15 * h**3,
        "threshold": lambda h: np.where(h > 0, 1e4 + 1.5e8 * h, 0),
        "power": lambda h: 1.8e7 * h**0.7,
    }[name]
    assert chatter.force == pytest.approx(depth * law(chatter.chip_thickness), rel=1e-12, abs=1e-12)


def reference(depth, law, revolutions):
    """The tool at the ends of the revolutions, by a Runge-Kutta method of order 8 over all earlier passes."""
    tau, tracks, z, ends = 1 / SPEED, [lambda t: 0.0], np.zeros(2), []
    for p in range(revolutions):

        def slope(t, z, p=p):
            surface = min((p + 1 - j) * FEED + track(t - (p + 1 - j) * tau) for j, track in enumerate(tracks))
            force = depth * law(max(surface - z[0], 0.0))
            return [z[1], (force - 2 * XI * OMEGA * MASS * z[1] - STIFFNESS * z[0]) / MASS]

        span = (p * tau, (p + 1) * tau)
        done = solve_ivp(slope, span, z, "DOP853", rtol=1e-10, atol=1e-14, dense_output=True, max_step=tau / 100)
        tracks.append(lambda t, sol=done.sol: sol(t)[0])
        z = done.y[:, -1]
        ends.append(z[0])
    return np.array(ends)


@pytest.mark.parametrize(
    ("name", "law"), [("linear", lambda h: RADIAL * h), ("cubic", lambda h: 3e8 * h - 1e12 * h**2 + 2e15 * h**3)]
)
def test_loss_of_contact_against_the_method_of_steps(name, law):
    depth = 3 * LIMIT
    exact = reference(depth, law, 6)
    errors, steps = [], np.array([200, 400, 800, 1600])
    for k in steps:
        chatter = simulate_turning(TOOL, LAWS[name], SPEED, depth, FEED, 6, int(k))
        errors.append(np.max(np.abs(chatter.displacement[k::k] - exact)) / FEED)
    assert chatter.separation > 0.1
    assert errors[-1] < 1e-3
    order = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert order == pytest.approx(2, abs=0.25)


# A thousand times as much is more than any tool has.
@pytest.mark.filterwarnings("ignore:feed = :lobex.LobexWarning")
@settings(max_examples=10)
@given(scale=st.floats(1e-3, 1e3))
def test_with_a_linear_law_all_lengths_scale_with_the_feed(scale):
    unit = simulate_turning(TOOL, Linear(RADIAL), SPEED, 3 * LIMIT, FEED, 8, 200)
    scaled = simulate_turning(TOOL, Linear(RADIAL), SPEED, 3 * LIMIT, scale * FEED, 8, 200)
    assert scaled.displacement == pytest.approx(scale * unit.displacement, abs=1e-8 * scale * FEED)
    assert scaled.force == pytest.approx(scale * unit.force, abs=1e-8 * scale * unit.force.max())


def test_a_batch_is_its_single_lanes_and_thins_out_exactly(cut):
    speeds = np.array([[60.0], [SPEED]])
    batch = simulate_turning(TOOL, Linear(RADIAL), speeds, DEPTHS[2:], FEED, 10, 600, every=20)
    assert batch.displacement.shape == (2, 2, 301)
    assert batch.time[0, 0, -1] == pytest.approx(10 / 60)
    for lane in range(2):
        # The solution is chaotic: rounding grows tenfold in some revolutions.
        assert batch.displacement[1, lane, :101] == pytest.approx(cut.displacement[2 + lane, :2001:20], abs=1e-9 * FEED)
    single = simulate_turning(TOOL, Linear(RADIAL), 60.0, DEPTHS[2], FEED, 10, 600, every=20)
    assert single.displacement == pytest.approx(batch.displacement[0, 0], abs=1e-9 * FEED)


def test_several_modes_bend_by_the_sum_of_their_compliances():
    modes = lobex.Modes(np.array([900.0, 3000.0]), np.full(2, 0.05), np.array([[0.6], [0.4]]))
    settled = simulate_turning(modes, Linear(RADIAL), 50.0, 2e-4, FEED, 60, 300)
    compliance = 0.36 / 900**2 + 0.16 / 3000**2
    assert settled.displacement[-300:] == pytest.approx(RADIAL * 2e-4 * FEED * compliance, rel=1e-6)


def test_a_tool_above_the_surface_feels_nothing_until_the_feed_brings_it_back():
    # The revolution before left the surface ten feeds below the tool's path.
    far = simulate_turning(
        TOOL, Linear(RADIAL), SPEED, LIMIT / 2, FEED, 14, 200, history=lambda t: -10.5 * FEED + 0 * t, state=np.zeros(2)
    )
    assert np.all(far.force[: 9 * 200] == 0)
    assert np.all(far.displacement[: 9 * 200] == 0)
    assert far.chip_thickness[10 * 200 + 1] == pytest.approx(FEED / 2, rel=0.05)


def test_a_cut_survives_its_file(cut, tmp_path):
    cut.save(tmp_path / "cut.nc")
    with xarray.open_dataset(tmp_path / "cut.nc", engine="h5netcdf") as stored:
        assert stored["force"].attrs["units"] == "N"
    back = lobex.load(tmp_path / "cut.nc")
    for name in ("speed", "depth", "phase", "displacement", "chip_thickness", "force", "state"):
        assert np.array_equal(getattr(back, name), getattr(cut, name)), name
    assert repr(back) == repr(cut)
    assert "4 lanes, 60 revolutions of 600 steps" in repr(cut)
    assert f"{60 * SPEED:.6g} rpm\n" in repr(cut)


def test_a_cut_plots_its_histories(cut):
    for what, unit in (("displacement", "µm"), ("chip_thickness", "µm"), ("force", "N")):
        axes = cut.plot(plt.subplots()[1], what)
        assert len([line for line in axes.get_lines() if len(line.get_xdata()) > 2]) == 4
        assert unit in axes.get_ylabel()
    with pytest.raises(ValueError, match="what = 'speed'"):
        cut.plot(what="speed")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"steps_per_revolution": 10}, "steps_per_revolution = 10 is too few at speed = 70 Hz; give 19"),
        ({"steps_per_revolution": 100.0}, "steps_per_revolution = 100.0"),
        ({"revolutions": 0}, "revolutions = 0"),
        ({"feed": 0.0}, "feed = 0"),
        ({"feed": np.nan}, "feed = nan"),
        ({"feed": [1e-4, 2e-4]}, "feed has shape (2,)"),
        ({"depth": -1e-3}, "depth = -0.001"),
        ({"depth": np.inf}, "depth = inf"),
        ({"speed": 70.0 * 6000}, "rpm/60"),
        ({"every": 9}, "every = 9 does not divide"),
        ({"history": lambda t: np.full_like(t, np.nan)}, "history(t) = [nan"),
        ({"state": np.zeros(5)}, "state has shape (5,)"),
        ({"law": 2e8}, "is no contact law"),
        ({"law": Plastic(1e6, 1.0)}, "law = Plastic"),
        ({"law": Power(1e-3, 1e6, 0.7)}, "law.width = 0.001"),
        ({"modes": lobex.Modes.plane(x=TOOL, y=TOOL)}, "2 contact directions"),
        ({"modes": 7}, "modes = 7"),
    ],
)
def test_bad_input_is_refused_in_one_line(changes, words):
    arguments = {"modes": TOOL, "law": Linear(RADIAL), "speed": SPEED, "depth": 1e-3, "feed": FEED}
    with refused(words):
        simulate_turning(**{**arguments, "revolutions": 2, "steps_per_revolution": 100, **changes})
