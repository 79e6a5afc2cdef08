"""Advice: recommended cuts keep their limits, next speeds are parts of the chatter, and cuts made are scored."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import lobex
import small_results
from lobex.advice.best_cuts import _best, _scanned, _where_binding
from lobex.results.codes import Status
from problems import KN, KT
from refusals import refused

# --- cuts that were made, against a made-up chart

CHART = replace(
    small_results.chart(),
    speed=np.array([50.0, 60.0, 70.0]),
    gain=np.array([1e5, 2e5]),
    spectral_radius=np.exp(np.array([[-1.0, 1.0], [-1.0, 1.0], [-1.0, np.nan]])),
)
# Linear in the logarithm, the limit is at 1.5e5 throughout.
CUTS = [(52.0, 1.4e5, 0), (58.0, 1.6e5, 1), (55.0, 1.4e5, 1), (59.0, 1.7e5, 0), (45.0, 1.5e5, 1), (65.0, 1.5e5, 1)]


def test_cuts_are_scored_and_told_apart_by_side():
    found = CHART.compare(CUTS)
    assert found.spectral_radius[:4] == pytest.approx(np.exp([-0.2, 0.2, -0.2, 0.4]))
    assert np.isnan(found.spectral_radius[4:]).all()
    sides = ["quiet as said", "chatter as said", "chatter below the limit", "quiet above the limit"]
    assert list(found.outcome) == [*sides, "outside the chart", "outside the chart"]
    assert (found.hits, found.misses, found.score) == (2, 2, 0.5)
    assert "2 hits, 2 misses" in repr(found)


def test_cuts_are_drawn_over_a_chart():
    ax = small_results.limit().plot().axes[0]
    ends = ax.get_xlim()
    assert CHART.compare(CUTS).plot(ax) is ax
    assert "chatter below the limit: 1" in [text.get_text() for text in ax.get_legend().get_texts()]
    assert ax.get_xlim() == ends


# --- the next speed

TURNING = lobex.Turning(lobex.Modes.single(frequency=146.5, damping_ratio=0.03, mass=2.573), 1.5e9, speed_unit="rpm")


def test_next_speeds_are_whole_parts_of_the_chatter():
    found = lobex.next_speed(620.0, 4)
    assert found.speed == pytest.approx(620 / 4 / np.arange(1, 9))
    assert list(lobex.next_speed(620.0, 4, speed=(2000 / 60, 6000 / 60)).lobe) == [2, 3, 4]
    assert np.isnan(found.limit).all()
    assert "k = 1, 9300 rpm" in repr(found)


@pytest.mark.parametrize("always", [Status.NONE_IN_RANGE, Status.STABLE_AT_ANY_GAIN])
def test_speeds_are_ranked_by_their_limits(monkeypatch, always):
    limit, status = np.array([1e-3, np.nan, 3e-3, np.nan]), np.array([0, 2, 0, always], dtype=np.int8)
    monkeypatch.setattr(
        "lobex.advice.next_try.critical_gain", lambda *_: SimpleNamespace(gain=limit, status_code=status)
    )
    found = lobex.next_speed(155.0, 1, speed=(38.0, 160.0), process=TURNING, bounds=(1e-6, 5e-3))
    # Stable throughout, the limits in turn, and what is unstable at once.
    assert list(found.lobe) == [4, 3, 1, 2]
    assert f"k = 4, 2325 rpm: {always.words}" in repr(found)


@pytest.mark.search
def test_with_a_process_they_are_ranked_by_its_limits():
    found = lobex.next_speed(155.0, 1, speed=(20.0, 160.0), process=TURNING, bounds=(1e-6, 5e-3))
    exact = lobex.exact_limit(TURNING, np.sort(found.speed)).gain[np.argsort(np.argsort(found.speed))]
    known = np.isfinite(found.limit)
    assert found.limit[known] == pytest.approx(exact[known], rel=1e-8)
    assert (exact[~known] > 5e-3).all()
    assert (np.diff(found.limit[known]) < 0).all()
    assert (~known[: np.sum(~known)]).all()


# --- recommended cuts

TOOL = lobex.Modes.single(frequency=300.0, damping_ratio=0.05, mass=0.5)
RADIUS, FEED = 0.005, 5e-5
MILL = lobex.Milling(
    replace(TOOL, shape=np.array([[0.0, 1.0]]) * TOOL.shape),
    lobex.Cutter.end_mill(2 * RADIUS, teeth=2),
    KT,
    KN,
    0.5,
    "up",
    feed_per_tooth=FEED,
)
SPEED, DEPTH = (100.0, 200.0), (1e-5, 4e-3)


@pytest.fixture(scope="module")
def free():
    return lobex.recommend(MILL, SPEED, DEPTH)


@pytest.mark.search
def test_without_limits_stability_or_the_range_binds(free):
    assert set(free.binding) <= {"stability", "range"}
    assert "stability" in free.binding
    for speed, depth, binding, left in zip(free.speed, free.depth, free.binding, free.stability_margin, strict=True):
        if binding == "range":
            assert depth == DEPTH[1]
            continue
        assert left == pytest.approx(0.1, abs=1e-5)
        radius = lobex.sweep(MILL, [speed], [0.999 * depth / 0.9, 1.001 * depth / 0.9]).spectral_radius[0]
        assert radius[0] < 1 < radius[1]
    assert free.removal_rate == pytest.approx(0.5 * 2 * RADIUS * free.depth * 2 * FEED * free.speed)
    assert (np.diff(free.removal_rate) <= 0).all()
    # No speed looked at does better.
    assert (free.scanned_depth * free.scanned_speed <= 1.01 * free.depth[0] * free.speed[0]).all()


@pytest.mark.search
def test_every_limit_is_kept_and_the_one_that_binds_leaves_its_margin(free):
    power = 0.8 * free.mean_power[0]
    error = 0.4 * np.abs(free.location_error).max()
    found = lobex.recommend(MILL, SPEED, DEPTH, power=power, location_error=error, margin=0.2)
    margins = {"power": found.power_margin, "location error": found.location_error_margin}
    motion = lobex.orbit(MILL, found.speed, found.depth, phase=[0.0])
    assert motion.mean_power == pytest.approx(found.mean_power, rel=1e-9)
    assert motion.surface_location_error[:, 0, 0] == pytest.approx(found.location_error, rel=1e-6)
    # The even teeth's nominal force.
    assert found.mean_power == pytest.approx(found.speed * 2 * RADIUS * KT * FEED * found.depth, rel=1e-7)
    assert set(found.binding) & {"power", "location error"}
    for i, binding in enumerate(found.binding):
        assert all(part[i] > 0.2 - 1e-6 for part in margins.values())
        if binding in margins:
            assert margins[binding][i] == pytest.approx(0.2, abs=1e-5)
    assert np.isnan(found.torque_margin).all()
    assert "bound by" in repr(found)
    assert found.plot().get_ylabel().startswith("depth of cut")


@pytest.mark.search
def test_limits_that_no_cut_keeps_are_told():
    with pytest.raises(ValueError, match=r"depth = 0\.0005 m or more keeps the limits at no speed from 100 to 200 Hz"):
        lobex.recommend(MILL, SPEED, (5e-4, 4e-3), power=1e-3)


def test_the_depth_at_which_the_first_of_several_limits_binds_is_found():
    """Of lines, of a square and of what is not known above a third."""
    slope = np.array([[1.0, 2.0, 0.1, 3.0, 50.0], [0.5, 0.0, 6.0, 0.1, 0.0]])

    def shares(depth, lanes):
        values = np.stack([slope[0, lanes] * depth, slope[1, lanes] * depth**2])
        return np.where((lanes == 3) & (depth > 0.3), np.inf, values)

    lanes, low, high = np.arange(5), np.full(5, 0.1), np.full(5, 2.0)
    found, which = _where_binding(shares, lanes, low, high, shares(high, lanes), 1e-6)
    assert found == pytest.approx([1.0, 0.5, 6**-0.5, 0.3, np.nan], rel=1e-5, nan_ok=True)
    assert list(which[:3]) == [0, 0, 1]
    assert (np.max(shares(found[:4], lanes[:4]), axis=0) <= 1).all()


def test_speeds_are_scanned_as_lobes_lie_and_tops_are_found():
    speeds = _scanned(MILL, np.array(SPEED))
    assert speeds[[0, -1]] == pytest.approx(SPEED, rel=0)
    assert np.diff(1 / speeds) == pytest.approx((1 / 200 - 1 / 100) / (len(speeds) - 1))
    assert list(_best(np.array([1.0, 3.0, 2.0, 5.0, 5.0, -1.0, 4.0]), 2)) == [3, 6]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: CHART.compare([]), r"cuts = \[\] must be rows of speed in Hz, gain in N/m, and 1"),
        (lambda: CHART.compare([(55.0, 1e5, 2)]), "cuts say 2 of chatter; give 1 where a cut chattered or 0"),
        (lambda: CHART.compare([(3300.0, 1e5, 1)]), "cuts lie outside the chart, from speed = 3300"),
        (lambda: lobex.next_speed(-5.0, 2), "chatter_frequency = -5 must be positive"),
        (lambda: lobex.next_speed(600.0, 0), "teeth = 0 must be a whole number"),
        (
            lambda: lobex.next_speed(600.0, 2, speed=(6000, 6100)),
            "holds none of f/.* give a wider range",
        ),
        (lambda: lobex.next_speed(600.0, 2, speed=(6, 3)), "speed = .* must be a range in Hz"),
        (lambda: lobex.next_speed(600.0, 2, process=MILL), "process and bounds rank the speeds together"),
        (lambda: lobex.next_speed(36000.0, 2, process=MILL, bounds=DEPTH), "120 times that of the fastest mode"),
        (lambda: lobex.recommend(MILL, (100.0, 100.0), DEPTH), r"speed = \(100.0, 100.0\) must be a range in Hz"),
        (lambda: lobex.recommend(MILL, SPEED, (2e-3, 1e-3)), "depth = .* must be a range in m"),
        (lambda: lobex.recommend(MILL, (6000.0, 12000.0), DEPTH), "give revolutions per second, which is rpm/60"),
        (lambda: lobex.recommend(MILL, SPEED, DEPTH, power=-1.0), "power = -1 must be positive; give a number above 0"),
        (lambda: lobex.recommend(MILL, SPEED, DEPTH, torque=np.inf), "torque = inf has NaN or infinite"),
        (lambda: lobex.recommend(MILL, SPEED, DEPTH, margin=1.0), "margin = 1.0 must be a share of the limits"),
        (lambda: lobex.recommend(TURNING, SPEED, DEPTH), "removes nothing; give one with teeth"),
        (
            lambda: lobex.recommend(replace(MILL, feed_per_tooth=None), SPEED, DEPTH),
            "feed_per_tooth = None where a removal rate is asked for; give it in m",
        ),
        (
            lambda: lobex.recommend(replace(MILL, cutter=lobex.Cutter(2)), SPEED, DEPTH),
            "diameter = None where a removal",
        ),
        (
            lambda: lobex.recommend(replace(MILL, modes=TOOL), SPEED, DEPTH, location_error=1e-5),
            "location_error = 1e-05 limits a wall of which modes along the feed alone know nothing",
        ),
    ],
)
def test_bad_input_is_one_line(call, message):
    with refused(match=message):
        call()
