"""The stability lobe diagram as a picture."""

from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.artist import Artist
from matplotlib.colors import ListedColormap, TwoSlopeNorm
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from lobex.plots.axes import gain_label, speed_axis
from lobex.plots.section import plot_section

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lobex.results.chart import Chart

# Light and dark meet at max|μ| = 1, so that the stable side is told in grey as well: pale blue to white is
# stable, sand to brown unstable.
_STABLE = ["#b3d3e8", "#edf5fa"]
_UNSTABLE = ["#f6d9a8", "#8c3b0a"]
_LEVELS = 256


def plot_chart(chart: "Chart", ax: "Axes | None", speed_unit: str | None) -> "Axes":
    """Draw max|μ| over the grid, with its legend and colour bar; of one speed or one gain as a curve."""
    if min(chart.spectral_radius.shape) < 2:
        return plot_section(chart, ax, speed_unit)
    scale, label = speed_axis(chart.speed_unit if speed_unit is None else speed_unit)
    if ax is None:
        _, ax = plt.subplots(figsize=(7.0, 4.4), layout="constrained")
    speed = chart.speed * scale
    gain = chart.gain / chart.quantity.scale
    radius = np.ma.masked_invalid(chart.spectral_radius)
    top = max(float(radius.max()) if radius.count() else 1.0, 1.0 + 1e-6)
    bottom = min(float(radius.min()) if radius.count() else 0.0, 1.0 - 1e-6)
    mesh = ax.pcolormesh(
        speed,
        gain,
        radius.T,
        cmap=_colours(),
        norm=TwoSlopeNorm(1.0, bottom, top),
        shading="gouraud" if radius.count() == radius.size else "nearest",
        rasterized=True,
    )
    handles: list[Artist] = [
        Patch(facecolor=_STABLE[0], edgecolor="0.3", label="stable, max|μ| < 1"),
        Patch(facecolor=_UNSTABLE[0], edgecolor="0.3", label="unstable, max|μ| > 1"),
    ]
    if bottom < 1 - 1e-6 and top > 1 + 1e-6:
        ax.contour(speed, gain, radius.T, levels=[1.0], colors="black", linewidths=1.3)
        handles.append(Line2D([], [], color="black", linewidth=1.3, label="stability limit, max|μ| = 1"))
    ax.set_xlabel(label)
    ax.set_ylabel(gain_label(chart.quantity))
    ax.set_xlim(speed[0], speed[-1])
    ax.set_ylim(gain[0], gain[-1])
    bar = ax.figure.colorbar(mesh, ax=ax, pad=0.02)
    bar.set_label("spectral radius max|μ|")
    ax.legend(
        handles=handles,
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        ncols=3,
        frameon=False,
        fontsize="small",
    )
    return ax


def _colours() -> ListedColormap:
    from matplotlib.colors import LinearSegmentedColormap

    half = np.linspace(0, 1, _LEVELS // 2)
    stable = LinearSegmentedColormap.from_list("stable", _STABLE)(half)
    unstable = LinearSegmentedColormap.from_list("unstable", _UNSTABLE)(half)
    return ListedColormap(np.vstack([stable, unstable]), name="stability")
