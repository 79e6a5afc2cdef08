"""The stability lobe diagram as a picture."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import ListedColormap, TwoSlopeNorm
from matplotlib.patches import Rectangle

from lobex import _checks
from lobex.grids.finer import halved
from lobex.plots.frame import gain_label, legend_above, one_of, speed_axis
from lobex.plots.section import plot_section
from lobex.plots.stability_line import LINE, PIXELS, Map, draw_line, map_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable

    from lobex.results.boundary import Boundary
    from lobex.results.chart import Chart

# Light and dark meet at max|μ| = 1, so that the stable side is told in grey as well: pale blue to white is
# stable, sand to brown unstable.
_STABLE = ["#b3d3e8", "#edf5fa"]
_UNSTABLE = ["#f6d9a8", "#8c3b0a"]
_LEVELS = 256
# Points of a map from which on triangles between them take longer to draw than all else.
_MANY = 40_000


def plot_chart(chart: "Chart", ax: "Axes | None", speed_unit: str | None, boundary: "Boundary | None") -> "Axes":
    """Draw max|μ| over the grid and the limit, with legend and colour bar; of one speed or one gain as a curve."""
    if min(chart.spectral_radius.shape) < 2:
        return plot_section(chart, ax, speed_unit)
    speed_scale, label = speed_axis(chart.speed_unit if speed_unit is None else speed_unit)
    if boundary is not None and not hasattr(boundary, "curves"):
        raise ValueError(f"boundary = {_checks.brief(boundary)} is no boundary; give lobex.boundary(chart)")
    ax = one_of(ax, 7.0, 4.4)
    scale = (speed_scale, 1 / chart.quantity.scale)
    drawn = map_of(chart, refine=boundary is None)
    radius = np.ma.masked_invalid(chart.spectral_radius)
    top = max(float(radius.max()) if radius.count() else 1.0, 1.0 + 1e-6)
    bottom = min(float(radius.min()) if radius.count() else 0.0, 1.0 - 1e-6)
    mesh = _fill(ax, scale, drawn, TwoSlopeNorm(1.0, bottom, top))
    # Entries that stay when somebody draws more and asks for the legend again.
    for name, colour in (("stable, max|μ| < 1", _STABLE[0]), ("unstable, max|μ| > 1", _UNSTABLE[0])):
        ax.add_patch(Rectangle((np.nan, np.nan), 0, 0, facecolor=colour, edgecolor="0.3", label=name))
    if boundary is not None or (bottom < 1 - 1e-6 and top > 1 + 1e-6):
        ax.plot([], [], label="stability limit, max|μ| = 1", **LINE)
        if draw_line(ax, scale, drawn, boundary):
            ax.plot([], [], linestyle=":", label="the grid is too coarse to tell", **LINE)
    ax.set_xlabel(label)
    ax.set_ylabel(gain_label(chart.quantity))
    ax.set_xlim(chart.speed[0] * scale[0], chart.speed[-1] * scale[0])
    ax.set_ylim(chart.gain[0] * scale[1], chart.gain[-1] * scale[1])
    bar = ax.figure.colorbar(mesh, ax=ax, pad=0.02)
    bar.set_label("spectral radius max|μ|")
    legend_above(ax, columns=2 if len(ax.get_legend_handles_labels()[1]) == 4 else 3)
    return ax


def _fill(ax: "Axes", scale: tuple[float, float], drawn: Map, norm: TwoSlopeNorm) -> "ScalarMappable":
    """The map in colours: shaded between its points where they are few, else in cells of about a pixel."""
    speed, gain, growth = drawn.speed, drawn.gain, drawn.growth
    if growth.size < _MANY:
        radius = np.ma.masked_invalid(np.exp(growth)).T
        shading = "gouraud" if radius.count() == radius.size else "nearest"
        x, y = speed * scale[0], gain * scale[1]
        return ax.pcolormesh(x, y, radius, cmap=_colours(), norm=norm, shading=shading, rasterized=True)
    speed, growth = _about(PIXELS[0], speed, growth)
    gain, growth = _about(PIXELS[1], gain, growth.T)
    growth = growth.T
    # Cells and no image: an image is wrong on logarithmic axes.
    edges = (np.r_[axis[0], (axis[1:] + axis[:-1]) / 2, axis[-1]] for axis in (speed * scale[0], gain * scale[1]))
    radius = np.ma.masked_invalid(np.exp(growth)).T
    return ax.pcolormesh(*edges, radius, cmap=_colours(), norm=norm, shading="flat", rasterized=True)


def _about(pixels: float, axis: np.ndarray, growth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A map along its first axis in cells of one to two pixels: more points between, or every second left out."""
    while 2 * len(axis) < pixels:
        axis, growth = halved(axis), halved(growth)
    while len(axis) > pixels and len(axis) % 2:
        axis, growth = axis[::2], growth[::2]
    return axis, growth


def _colours() -> ListedColormap:
    from matplotlib.colors import LinearSegmentedColormap

    half = np.linspace(0, 1, _LEVELS // 2)
    stable = LinearSegmentedColormap.from_list("stable", _STABLE)(half)
    unstable = LinearSegmentedColormap.from_list("unstable", _UNSTABLE)(half)
    return ListedColormap(np.vstack([stable, unstable]), name="stability")
