"""Whose axes pictures draw into: one rule for every result."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import lobex
import small_results as small

ONE = {
    "chart": lambda ax: small.chart().plot(ax),
    "boundary": lambda ax: small.boundary().plot(ax),
    "sensitivities": lambda ax: small.sensitivities().plot(ax),
    "march": lambda ax: small.march().plot(ax),
    "cut": lambda ax: small.cut().plot(ax),
    "wear map": lambda ax: small.wear_map().plot(ax),
    "spectrum": lambda ax: small.spectrum().plot(ax),
    "orbit map": lambda ax: small.orbit_map().plot(ax),
    "wall": lambda ax: small.cutting_orbit().plot_wall(ax),
    "recommendation": lambda ax: small.recommendation().plot(ax),
    "comparison": lambda ax: small.comparison().plot(ax),
    "campbell": lambda ax: lobex.campbell(small.MODES, ax=ax),
}
POLAR = {
    "worn casing": lambda ax: small.wear_map().plot_casing(50.0, ax),
    "casing": lambda ax: lobex.Casing().plot(ax),
}
BAND = lobex.Band(small.limit(), ("speed",), np.array([0.01]), np.full((3, 1), 0.02))
SEVERAL = {
    "limit": small.limit().plot,
    "band": BAND.plot,
    "history": lambda axes=None: small.wear_map().plot_history(axes),
}


@pytest.fixture(autouse=True)
def _own_process(monkeypatch):
    """The made-up charts are drawn as they are, and nothing is computed."""
    monkeypatch.setattr("lobex.plots.stability_line.doubtful", lambda *_: np.zeros((2, 1), dtype=bool))


@pytest.mark.parametrize("name", [*ONE, *POLAR])
def test_a_picture_of_one_axes_takes_and_returns_them(name):
    plot = {**ONE, **POLAR}[name]
    settings = {"projection": "polar"} if name in POLAR else {}
    _, (own, other) = plt.subplots(1, 2, subplot_kw=settings)
    figures = plt.get_fignums()
    assert plot(own) is own
    assert own.has_data()
    assert not other.has_data()
    assert plt.get_fignums() == figures
    fresh = plot(None)
    assert isinstance(fresh, Axes)
    assert plt.get_fignums() == [*figures, figures[-1] + 1]
    for wrong in (3, plt.figure()):
        with pytest.raises(ValueError, match=r"ax = .* is no matplotlib axes"):
            plot(wrong)


@pytest.mark.parametrize("name", SEVERAL)
def test_a_picture_of_several_axes_takes_them_and_returns_its_figure(name):
    plot = SEVERAL[name]
    figure, panels = plt.subplots(3, 1)
    figures = plt.get_fignums()
    assert plot(axes=panels[:2]) is figure
    assert [ax.has_data() for ax in panels] == [True, True, False]
    assert plt.get_fignums() == figures
    fresh = plot()
    assert isinstance(fresh, Figure)
    assert len(fresh.axes) == 2
    for wrong, words in ((panels, "axes has 3"), (panels[0], "axes has 1"), ([1, 2], "is no matplotlib axes")):
        with pytest.raises(ValueError, match=words):
            plot(axes=wrong)


@pytest.mark.parametrize("plot", [small.limit().plot, BAND.plot])
def test_a_limit_alone_is_drawn_over_what_is_there(plot):
    ax = small.chart().plot()
    ends = ax.get_xlim(), ax.get_ylim()
    named = {text.get_text() for text in ax.get_legend().get_texts()}
    assert plot(ax=ax) is ax
    assert (ax.get_xlim(), ax.get_ylim()) == ends
    shown = np.concatenate([line.get_xydata() for line in ax.get_lines() if len(line.get_xdata()) == 3])
    np.testing.assert_allclose(shown, [[50, 0.15], [60, np.nan], [70, 0.12]])
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert named | {"Hopf (complex pair)", "flip (μ = −1)"} <= set(texts)
    # The map is not covered by the stable region.
    assert "stable" not in texts


def test_several_limits_share_axes_and_are_told_apart():
    _, ax = plt.subplots()
    for label in ("sharp", "worn"):
        small.limit().plot(ax=ax, label=label)
    BAND.plot(ax=ax, label="with a band")
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["sharp", "worn", "with a band"]
    lines = {line.get_label(): line.get_color() for line in ax.get_lines() if line.get_linestyle() == "-"}
    assert len(set(lines.values())) == 3
    assert ax.get_xlabel() == "rotational frequency (Hz)"
    assert ax.get_ylabel() == "contact stiffness $K_{e}$ (MN/m)"


def test_what_is_added_to_a_chart_joins_its_legend():
    ax = small.chart().plot()
    ax.scatter([55.0], [0.15], label="chatter")
    small.boundary().plot(ax)
    ax.legend()
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert texts[:3] == ["stable, max|μ| < 1", "unstable, max|μ| > 1", "stability limit, max|μ| = 1"]
    assert {"chatter", "Hopf (complex pair)"} <= set(texts)


def test_ax_and_axes_at_once_and_a_label_alone_are_refused():
    _, panels = plt.subplots(2, 1)
    for plot in (small.limit().plot, BAND.plot):
        with pytest.raises(ValueError, match="ax and axes are both given"):
            plot(panels[0], axes=panels)
        with pytest.raises(ValueError, match="label = 'a' names one of several"):
            plot(label="a")


def test_lobes_that_leave_room_under_them_are_numbered_there():
    limit = lobex.exact_limit(lobex.Rub(lobex.Rod(5).modes(0.03)), np.linspace(85, 328, 300))
    figure = limit.plot()
    figure.canvas.draw()
    inverted = figure.axes[0].transData.inverted()
    numbers = {text.get_text(): inverted.transform(text.get_window_extent()) for text in figure.axes[0].texts}
    assert set(numbers) >= {"1", "2"}
    for (start, _), (stop, top) in numbers.values():
        there = (limit.speed >= start) & (limit.speed <= stop)
        assert np.all(limit.gain[there] / limit.quantity.scale > top)


@pytest.mark.parametrize("speeds", [(30.0, 400.0), (60.0, 130.0)])
@pytest.mark.parametrize("uncertain", [0.0, 0.02])
def test_lobe_numbers_keep_off_the_axis_the_band_and_each_other(speeds, uncertain):
    limit = lobex.exact_limit(lobex.Rub(lobex.Rod(5).modes(0.03)), np.linspace(*speeds, 300))
    band = limit.band({"modes.angular_frequency": uncertain, "modes.damping_ratio": 5 * uncertain})
    figure = band.plot() if uncertain else limit.plot()
    figure.canvas.draw()
    axes = figure.axes[0]
    boxes = [text.get_window_extent() for text in axes.texts]
    assert len(boxes) > 2
    assert not any(one.overlaps(other) for i, one in enumerate(boxes) for other in boxes[:i])
    low, high = (edge / limit.quantity.scale for edge in band.interval(2.0))
    for box in boxes:
        assert axes.bbox.y0 < box.y0 < box.y1 < axes.bbox.y1
        inside = axes.transData.inverted().transform(box)
        there = (limit.speed >= inside[0, 0]) & (limit.speed <= inside[1, 0])
        assert np.all(low[there] > inside[1, 1]) or np.all(high[there] < inside[0, 1])


def test_modes_of_a_casing_are_told_from_those_of_the_blade():
    blade = lobex.Modes.from_table([300.0, 700.0, 1500.0], 0.01, mass=[0.2, 0.3, 0.3])
    ring = lobex.Ring([2, 3], [150.0, 250.0], 0.01, [3.0, 3.0])
    speed = np.linspace(60, 300, 100)
    for casing, names in ((None, {"mode 1", "mode 2"}), (ring, {"mode 1", "mode 2", "casing mode 1", "casing mode 3"})):
        axes = lobex.exact_limit(lobex.Rub(blade, casing=casing), speed).plot().axes[0]
        told = {text.get_text() for text in axes.get_legend().get_texts()}
        assert {name for name in told if "mode" in name} == names
