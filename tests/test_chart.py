"""The chart as text, file and picture."""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray
from matplotlib.collections import LineCollection

import lobex
import small_results
from cases import MILL, ROD, assert_same_fields
from lobex.results.boundary import BoundaryCurve


@pytest.fixture(scope="module")
def chart():
    return lobex.sweep(MILL, np.linspace(3e3, 25e3, 12) / 60, np.linspace(0, 5e-3, 10), lobex.Chebyshev(24))


def test_printing_tells_what_was_done(chart):
    text = repr(chart)
    for part in ("12 speeds × 10 gains", "Chebyshev(nodes=24", "µs a point", "failed           0", "depth of cut b"):
        assert part in text


def test_printing_is_in_the_units_of_the_picture(chart):
    text = repr(chart)
    assert "speed            3000 to 25000 rpm" in text
    assert "gain             0 to 5 mm (depth of cut b)" in text


@pytest.mark.parametrize(
    ("speeds", "gains", "label", "fixed"),
    [
        (slice(3, 4), slice(None), "depth of cut $b$ (mm)", "at 9000 rpm"),
        (slice(None), slice(9, 10), "spindle speed (rpm)", "at $b$ = 5 mm"),
        (slice(3, 4), slice(9, 10), "depth of cut $b$ (mm)", "at 9000 rpm"),
    ],
)
def test_one_speed_or_one_gain_is_drawn_as_a_curve(chart, speeds, gains, label, fixed):
    names = ("spectral_radius", "multiplier", "chatter_frequency", "error")
    parts = {name: getattr(chart, name)[speeds, gains] for name in names}
    part = replace(chart, speed=chart.speed[speeds], gain=chart.gain[gains], **parts)
    axes = part.plot()
    (line,) = axes.lines
    np.testing.assert_array_equal(line.get_ydata(), part.spectral_radius.ravel())
    scaled = part.speed * 60 if "rpm" in label else part.gain * 1e3
    np.testing.assert_allclose(line.get_xdata(), scaled)
    assert axes.get_xlabel() == label
    assert axes.get_ylabel() == f"spectral radius max|μ| {fixed}"
    assert axes.get_ylim()[0] <= part.spectral_radius.min() <= part.spectral_radius.max() <= axes.get_ylim()[1]
    assert axes.get_ylim()[0] < 1 < axes.get_ylim()[1]


def test_saving_and_loading_returns_the_same_chart(chart, tmp_path):
    path = tmp_path / "mill.nc"
    chart.save(path)
    again = lobex.load(path)
    assert_same_fields(again, chart)
    chart.save(path)
    assert [p.name for p in tmp_path.iterdir()] == ["mill.nc"]


def test_the_file_is_plain_netcdf_with_units(chart, tmp_path):
    chart.save(tmp_path / "mill.nc")
    with xarray.open_dataset(tmp_path / "mill.nc", engine="h5netcdf") as data:
        assert data["spectral_radius"].dims == ("speed", "gain")
        assert data["gain"].attrs["units"] == "m"
        assert data["chatter_frequency"].attrs["units"] == "Hz"
        assert "radial_immersion" in data.attrs["process"]
        modulus = np.hypot(data["multiplier_real"], data["multiplier_imag"])
        np.testing.assert_allclose(modulus, data["spectral_radius"], rtol=1e-14)


def test_dataset_is_labelled(chart):
    data = chart.to_xarray()
    nearest = data["spectral_radius"].sel(speed=chart.speed[3], gain=chart.gain[4])
    assert float(nearest) == chart.spectral_radius[3, 4]
    assert np.iscomplexobj(data["multiplier"])


def test_chatter_frequency_is_one_of_the_multipliers_frequencies(chart):
    tau = 1 / chart.speed[:, None]
    turns = chart.chatter_frequency * tau
    offset = np.abs(np.angle(chart.multiplier)) / (2 * np.pi)
    distance = np.minimum(np.abs((turns - offset + 0.5) % 1 - 0.5), np.abs((turns + offset + 0.5) % 1 - 0.5))
    assert np.max(distance) < 1e-9
    assert np.all(np.abs(chart.chatter_frequency - 146.5) < 0.75 * chart.speed[:, None] + 30)


def test_a_picture_has_units_a_legend_and_the_limit(chart):
    axes = chart.plot()
    assert axes.get_xlabel() == "spindle speed (rpm)"
    assert axes.get_ylabel() == "depth of cut $b$ (mm)"
    assert axes.get_xlim() == pytest.approx((3e3, 25e3))
    assert axes.get_ylim() == pytest.approx((0, 5))
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert [label.split(",")[0] for label in labels] == ["stable", "unstable", "stability limit"]
    assert axes.figure.axes[1].get_ylabel() == "spectral radius max|μ|"
    _, other = plt.subplots()
    assert chart.plot(ax=other, speed_unit="Hz") is other
    assert other.get_xlabel() == "rotational frequency (Hz)"


def test_the_limit_is_drawn_where_the_map_crosses_one():
    chart = lobex.sweep(ROD, np.linspace(150, 250, 21), np.linspace(1e5, 1e6, 31))
    axes = chart.plot()
    solid, dotted = line_of(axes)
    assert not len(dotted)
    exact = lobex.exact_limit(ROD, chart.speed).gain / 1e6
    shown = exact < 0.99
    assert shown.sum() > 10
    # To about a pixel, of which the picture has 840 by 540 within its axes.
    for speed, gain in zip(chart.speed[shown], exact[shown], strict=True):
        assert np.min(np.hypot((solid[:, 0] - speed) / 100 * 840, (solid[:, 1] - gain) / 0.9 * 540)) < 3


def line_of(axes):
    """Vertices of the limit as drawn, solid and dotted."""
    solid, dotted = (c for c in axes.collections if isinstance(c, LineCollection))
    return [np.concatenate([np.empty((0, 2)), *c.get_segments()]) for c in (solid, dotted)]


def test_a_tongue_thinner_than_a_cell_is_drawn_whole():
    # The peak between two lobes, on a grid whose columns stand a lobe's width apart, against the closed form.
    chart = lobex.sweep(ROD, np.linspace(108, 124, 5), np.linspace(2e5, 1.4e6, 5))
    solid, _ = line_of(chart.plot())
    speed = np.linspace(109, 123, 57)
    exact = lobex.exact_limit(ROD, speed).gain / 1e6
    for s, gain in zip(speed, exact, strict=True):
        if 0.25 < gain < 1.35:
            # A cell is halved four times: 13 by 8 pixels are left of 210 by 135.
            assert np.min(np.hypot((solid[:, 0] - s) / 16 * 840, (solid[:, 1] - gain) / 1.2 * 540)) < 16
    assert solid[:, 1].max() > 0.97 * min(exact.max(), 1.4)


def test_what_cannot_be_computed_again_is_dotted_where_the_grid_is_too_coarse():
    chart = lobex.sweep(ROD, np.linspace(108, 124, 5), np.linspace(2e5, 1.4e6, 5))
    own = replace(chart, process={**chart.process, "type": "Mine"})
    axes = own.plot()
    assert len(line_of(axes)[1])
    assert axes.get_legend().get_texts()[-1].get_text() == "the grid is too coarse to tell"
    curve = BoundaryCurve(np.array([110.0, 120.0]), np.array([3e5, 4e5]), np.zeros(2), np.ones(2, np.int8), False)
    traced = replace(small_results.boundary(), curves=(curve,))
    solid, dotted = line_of(own.plot(boundary=traced))
    assert not len(dotted)
    np.testing.assert_allclose(solid, [[110.0, 0.3], [120.0, 0.4]])


def test_a_picture_without_a_crossing_draws_no_limit():
    chart = lobex.sweep(ROD, [80.0, 90.0], [1e4, 2e4])
    assert len(chart.plot().get_legend().get_texts()) == 2


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda chart, tmp: chart.save(tmp / "no" / "x.nc"), "there is no folder"),
        (lambda chart, tmp: chart.save(tmp), "not a file name"),
        (lambda chart, tmp: chart.save("/proc/x.nc"), "cannot be written"),
        (lambda chart, tmp: chart.plot(speed_unit="rad/s"), "speed_unit = 'rad/s'"),
        (lambda chart, tmp: chart.plot(boundary=3), "boundary = 3 is no boundary"),
        (lambda chart, tmp: lobex.load(tmp / "none.nc"), "is not a file"),
        (lambda chart, tmp: lobex.load(_write(tmp / "text.nc", b"plain text")), "no readable NetCDF-4"),
        (lambda chart, tmp: lobex.load(_foreign(tmp / "other.nc")), "not a lobex result"),
    ],
)
def test_bad_files_and_pictures_are_refused_in_one_line(chart, tmp_path, call, words):
    with pytest.raises(ValueError) as error:
        call(chart, tmp_path)
    assert words in str(error.value)


def _write(path, content):
    path.write_bytes(content)
    return path


def _foreign(path):
    xarray.Dataset({"x": 1.0}).to_netcdf(path, engine="h5netcdf")
    return path
