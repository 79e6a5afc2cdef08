"""Boundaries as curves: against D-subdivision, Mathieu's characteristic values, re-entrant milling, and coarse maps."""

from dataclasses import replace
from importlib import import_module

import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.special import mathieu_a, mathieu_b

import lobex
from cases import LIMIT_TOOLS, milling
from lobex.limits.contour import GrowthMap, contours, on_curve, refined, with_hidden_lines
from lobex.limits.contour_vertices import along_edge, along_gradient
from lobex.limits.coverage import waves_per_cell
from refusals import refused

BLADE = lobex.Rub(lobex.Rod(2).modes(0.03))
METHOD = lobex.Chebyshev(32)
MILLING = milling(LIMIT_TOOLS["Insperger-Stepan"], 0.1, "up")
TURNS = 1 / (2 * np.pi)


@pytest.fixture(scope="module")
def chart():
    return lobex.sweep(BLADE, np.linspace(120, 300, 41), np.linspace(0, 1.6e6, 25), METHOD)


@pytest.fixture(scope="module")
def blade(chart):
    return lobex.boundary(chart)


@pytest.fixture(scope="module")
def islands():
    # The reference's re-entrant case lies at 12,000 rpm.
    speeds = np.linspace(11000, 13000, 17) / 60
    return lobex.boundary(MILLING, speeds, np.linspace(0, 5.5e-3, 23), lobex.Chebyshev(24))


def thinned(chart, speeds, gains):
    """Every so many speeds and gains of a chart."""
    maps = {n: getattr(chart, n)[::speeds, ::gains] for n in ("spectral_radius", "multiplier", "chatter_frequency")}
    return replace(chart, speed=chart.speed[::speeds], gain=chart.gain[::gains], **maps)


def exact_at(speed):
    """The exact limit and its chatter frequency, at so many speeds that one program serves all tests."""
    limit = lobex.exact_limit(BLADE, np.resize(speed, 512))
    return limit.gain[: len(speed)], limit.chatter_frequency[: len(speed)]


def inside(curve, speed, gain):
    """Whether a point is within a closed curve, by the crossings of a ray."""
    x, y = curve.speed, curve.gain
    crosses = (y[1:] > gain) != (y[:-1] > gain)
    with np.errstate(divide="ignore", invalid="ignore"):
        where = x[:-1] + (gain - y[:-1]) / (y[1:] - y[:-1]) * (x[1:] - x[:-1])
    return np.sum(crosses & (where > speed)) % 2 == 1


def crossings(curves, speed):
    """Gains at which polylines cross a speed, in order, by linear interpolation."""
    gains = []
    for curve in curves:
        x, y = curve.speed, curve.gain
        for i in np.flatnonzero((x[1:] > speed) != (x[:-1] > speed)):
            gains.append(y[i] + (speed - x[i]) / (x[i + 1] - x[i]) * (y[i + 1] - y[i]))
    return np.sort(gains)


def test_vertices_lie_on_the_exact_limit(blade):
    assert blade.dropped == 0
    assert blade.residual <= 1e-8
    assert blade.waves_per_cell < 0.25
    speed, gain, frequency, kind = (
        np.concatenate([getattr(c, n) for c in blade]) for n in ("speed", "gain", "chatter_frequency", "kind")
    )
    exact, waves = exact_at(speed)
    assert gain == pytest.approx(exact, rel=1e-7)
    assert frequency == pytest.approx(waves, rel=1e-5)
    assert set(kind) == {"hopf"}


def test_the_curves_are_the_limit_at_every_speed(blade):
    # Between the vertices, cusps included: no chord is off by more than a hundredth of a cell.
    speeds = np.linspace(121, 299, 64)
    exact = exact_at(speeds)[0]
    seen = np.array([crossings(blade, s)[0] if k < 1.55e6 else np.nan for s, k in zip(speeds, exact, strict=True)])
    gap = np.abs(seen - exact) / (1.6e6 / 24)
    assert np.nanmedian(gap) < 0.01
    assert np.nanmax(gap) < 0.2


def test_the_unstable_side_is_on_the_left(blade, islands):
    for result, process, method in ((blade, BLADE, METHOD), (islands, MILLING, lobex.Chebyshev(24))):
        slowest, fastest, low, high = result.bounds
        curve = result.curves[0]
        size = np.array([fastest - slowest, high - low])
        ahead = np.diff(np.column_stack([curve.speed, curve.gain]) / size, axis=0)
        middle = np.column_stack([curve.speed[1:] + curve.speed[:-1], curve.gain[1:] + curve.gain[:-1]]) / 2
        long = np.linalg.norm(ahead, axis=1) > 0.01
        left = np.column_stack([-ahead[:, 1], ahead[:, 0]])[long]
        aside = middle[long] + 2e-3 * size * left / np.linalg.norm(left, axis=1, keepdims=True)
        radius = lobex.spectral_radius(process, aside[:8, 0], np.maximum(aside[:8, 1], 0), method)
        assert np.mean(radius > 1) > 0.8


def test_the_re_entrant_case_has_its_three_depths(islands):
    assert islands.dropped == 0
    assert islands.residual <= 1e-8
    depths = [0.0031801762108573588, 0.004514895124331333, 0.004857372477035402]
    seen = crossings(islands, 12000 / 60)
    assert seen == pytest.approx(depths, abs=2e-5)
    assert {"hopf", "flip"} == {str(k) for curve in islands for k in curve.kind}


def test_vertices_agree_with_the_operator(islands):
    for curve in islands:
        few = np.linspace(0, len(curve.speed) - 1, 8).astype(int)
        radius = lobex.spectral_radius(MILLING, curve.speed[few], curve.gain[few], lobex.Chebyshev(24))
        assert np.log(radius) == pytest.approx(0, abs=1e-8)


@pytest.mark.parametrize(("delta", "kind"), [(3.0, "flip"), (1.6, "fold")])
def test_mathieu_lines_of_the_undamped_equation(delta, kind):
    # μ = +1 iff δ − b is a_{2n}(2ε)/4 or b_{2n}(2ε)/4, μ = −1 iff δ + b is a_{2n+1}(2ε)/4 or b_{2n+1}(2ε)/4.
    epsilon = 1.0
    # Vertices on the border of the map stay there: its first column is the field's period of 2π.
    speeds, gains = np.linspace(1, 1.14, 15) * TURNS, np.linspace(-1.45, 1.35, 15)
    result = lobex.boundary(lobex.DelayedMathieu(delta, epsilon), speeds, gains, lobex.Chebyshev(32))
    orders = (1, 3, 5) if kind == "flip" else (2, 4)
    values = np.array([function(n, 2 * epsilon) / 4 for n in orders for function in (mathieu_a, mathieu_b)])
    lines = values - delta if kind == "flip" else delta - values
    seen = [c.gain[(c.speed == TURNS) & (c.kind == kind)] for c in result]
    found = np.concatenate(seen)
    assert found.size >= 1
    for gain in found:
        assert np.min(np.abs(lines - gain)) < 1e-7


def test_a_coarse_map_gives_the_curves_of_a_fine_one(chart, blade):
    coarse = lobex.boundary(thinned(chart, 1, 3))
    for speed in (127.0, 143.0, 171.0, 222.0, 280.0):
        fine = crossings(blade, speed)
        assert crossings(coarse, speed)[: len(fine)] == pytest.approx(fine, abs=0.02 * 1.6e6 / 8)


def test_printing_saving_and_loading(islands, tmp_path):
    assert "curves" in repr(islands)
    assert "waves per cell" in repr(islands)
    islands.save(tmp_path / "boundary.nc")
    again = lobex.load(tmp_path / "boundary.nc")
    assert len(again) == len(islands)
    for one, other in zip(again, islands, strict=True):
        for name in ("speed", "gain", "chatter_frequency", "kind_code"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
        assert one.closed == other.closed
    names = ("residual", "dropped", "unresolved", "waves_per_cell", "bounds", "quantity", "process", "method")
    assert [getattr(again, n) for n in names] == [getattr(islands, n) for n in names]


def test_closed_curves_end_where_they_begin(islands):
    for curve in islands:
        same = curve.speed[0] == curve.speed[-1] and curve.gain[0] == curve.gain[-1]
        assert same == curve.closed
        if not curve.closed:
            edges = np.array(islands.bounds)
            for end in (0, -1):
                assert curve.speed[end] in edges[:2] or curve.gain[end] in edges[2:]


def test_pictures(islands, chart, blade):
    axes = islands.plot()
    assert axes.get_xlabel() == "spindle speed (rpm)"
    assert axes.get_ylabel() == "depth of cut $b$ (mm)"
    assert [t.get_text() for t in axes.get_legend().get_texts()] == ["Hopf (complex pair)", "flip (μ = −1)"]
    own = chart.plot(plt.figure().add_subplot())
    assert blade.plot(own) is own


def test_a_coarse_grid_of_speeds_and_vertices_of_too_large_an_error_are_warned_of(chart, monkeypatch):
    waves, frequency, where = waves_per_cell(BLADE, np.linspace(80, 305, 6), 1.6e6)
    assert frequency == pytest.approx(float(BLADE.modes.frequency[0]))
    assert where == 80
    assert waves == pytest.approx(frequency * (1 / 80 - 1 / 125))
    module = import_module("lobex.limits.boundary_tracing")
    evaluate = module.dominant_at_points

    def coarsely(*arguments):
        found = evaluate(*arguments)
        return found._replace(error=np.full_like(found.error, np.inf))

    monkeypatch.setattr(module, "dominant_at_points", coarsely)
    with pytest.warns(lobex.SweepWarning) as caught:
        lobex.boundary(thinned(chart, 20, 4))
    told = [str(w.message) for w in caught]
    assert any("of a lobe of the mode at" in words for words in told)
    assert any("vertices have an estimated error above the tolerance 1e-08" in words for words in told)


def test_modes_beyond_reach_of_the_gain_do_not_count():
    # The second mode chatters from K = −1/(2 Re G) on, at its least above that mode's frequency.
    modes, speeds = BLADE.modes, np.linspace(80.0, 300.0, 45)
    omega = modes.angular_frequency[1] * np.linspace(0.95, 1.2, 20001)[:, None]
    own, ratio = modes.angular_frequency, modes.damping_ratio
    response = np.sum(modes.shape[:, 0] ** 2 / (own**2 - omega**2 + 2j * ratio * own * omega), axis=1)
    least = -0.5 / response.real.min()
    assert least > 1.6e6
    assert waves_per_cell(BLADE, speeds, 0.99 * least)[1] == pytest.approx(float(modes.frequency[0]))
    assert waves_per_cell(BLADE, speeds, 1.01 * least)[1] == pytest.approx(float(modes.frequency[1]))
    tooth = waves_per_cell(MILLING, np.array([100.0, 110.0]), 1e-3)
    assert tooth[0] == pytest.approx(922 / 2 * (1 / 100 - 1 / 110))


def parabola(x, y):
    """Growth y − x² and its gradient."""
    return y - x**2, -2 * x, np.ones_like(x), np.ones(len(x), dtype=bool)


def roof(x, y):
    """The larger of two planes: a kink along x = 0."""
    return y + np.abs(x) - 1, np.sign(x) + (x == 0), np.ones_like(x), np.ones(len(x), dtype=bool)


def test_newton_along_the_gradient():
    start = np.array([[0.3, 0.3], [-0.9, 0.5], [0.0, 0.2]])
    found = along_gradient(parabola, start, np.ones((3, 2)))
    assert found.place[:, 1] == pytest.approx(found.place[:, 0] ** 2, abs=1e-10)
    fixed = along_gradient(parabola, start, np.ones((3, 2)), np.array([False, True]))
    assert fixed.place[:, 0].tolist() == start[:, 0].tolist()
    far = along_gradient(parabola, np.array([[0.0, 9.0]]), np.ones((1, 2)))
    assert far.growth[0] > 1e-8


@pytest.mark.parametrize("turn", [1, -1])
def test_a_bracket_on_an_edge_holds_over_a_kink(turn):
    first, last = np.array([[-0.5, 0.2], [0.0, 0.0], [0.2, 3.0]]), np.array([[0.4, 1.5], [0.0, 2.0], [0.1, -9.0]])
    first, last = (first, last)[::turn]
    place, left = along_edge(roof, first, last, (roof(*first.T)[0], roof(*last.T)[0]))
    assert left == pytest.approx(0, abs=1e-10)
    assert roof(*place.T)[0] == pytest.approx(0, abs=1e-10)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda chart: lobex.boundary(chart, [1.0, 2.0]), "speed = [1.0, 2.0] beside a chart"),
        (lambda chart: lobex.boundary(chart, method=METHOD), "beside a chart"),
        (lambda chart: lobex.boundary(BLADE), "give the speeds and gains"),
        (lambda chart: lobex.boundary(BLADE, [80.0, 90.0], [2e6, 1e6]), "not strictly increasing"),
        (lambda chart: lobex.boundary(BLADE.modes, [80.0, 90.0], [1e6, 2e6]), "is no process"),
        (
            lambda chart: lobex.boundary(replace(chart, process={**chart.process, "type": "Mine"})),
            "'Mine', which cannot be made again",
        ),
    ],
)
def test_bad_input_is_refused_in_one_line(chart, call, words):
    with refused(words):
        call(chart)


def test_an_island_is_closed_and_stable_inside():
    process, method = lobex.DelayedMathieu(3.0, 2.0, 0.1), lobex.Chebyshev(32)
    result = lobex.boundary(process, np.linspace(0.245, 0.525, 15), np.linspace(-1.4, 0.7, 15), method)
    (island,) = [c for c in result if c.closed and inside(c, 0.38, -0.2)]
    assert set(island.kind) == {"hopf", "flip", "fold"}
    # Stable inside, so that the curve runs clockwise.
    area = np.sum(island.speed[:-1] * island.gain[1:] - island.speed[1:] * island.gain[:-1]) / 2
    assert area < 0
    radius = lobex.spectral_radius(process, island.speed, island.gain, method)
    assert np.log(radius) == pytest.approx(0, abs=1e-8)
    center = np.array([0.38, -0.2])
    for share, stable in ((0.97, True), (1.03, False)):
        points = center + share * (np.column_stack([island.speed, island.gain])[:: len(island.speed) // 8] - center)
        radius = lobex.spectral_radius(process, np.resize(points[:, 0], 12), np.resize(points[:, 1], 12), method)
        assert np.mean((radius < 1) == stable) > 0.8


def ring(x, y):
    """Growth log(x² + 4y²) and its gradient: unstable outside of an ellipse."""
    square = x**2 + 4 * y**2
    return np.log(square), 2 * x / square, 8 * y / square, np.ones(len(x), dtype=bool)


@pytest.mark.parametrize("cells", [4, 10])
def test_a_known_island(cells):
    x, y = np.linspace(-1.5, 1.6, cells + 1), np.linspace(-0.9, 0.8, cells + 1)
    grid = GrowthMap(x, y, ring(*np.meshgrid(x, y, indexing="ij"))[0])
    (line,) = contours(grid)
    assert line.closed
    (place, growth, _), lost = refined(grid, on_curve(grid, [line], ring), ring)
    assert not lost.size
    assert growth == pytest.approx(0, abs=1e-10)
    assert place[0].tolist() == place[-1].tolist()
    area = -np.sum(place[:-1, 0] * place[1:, 1] - place[1:, 0] * place[:-1, 1]) / 2
    assert area == pytest.approx(np.pi / 2, rel=0.02)


def test_an_island_between_grid_lines_is_found_by_the_slopes():
    # Two ridges that sink below zero where they meet: stable only within |x| < 0.1, between the columns ±0.5.
    def ridge(x, y):
        return np.abs(x) + y**2 / 10 - 0.1

    x, y = np.linspace(-2.5, 2.5, 6), np.linspace(-2.3, 2.4, 8)
    grid = GrowthMap(x, y, ridge(*np.meshgrid(x, y, indexing="ij")))
    assert contours(grid) == []
    (line,) = contours(with_hidden_lines(grid, ridge))
    assert line.closed
