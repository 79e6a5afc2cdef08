"""A chart of one speed or one gain: max|μ| as a curve over the other, with the limit between stable and unstable."""

from typing import TYPE_CHECKING

import numpy as np

from lobex.plots.frame import gain_label, one_of, speed_axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lobex.results.chart import Chart

_STABLE, _UNSTABLE = "#d6e6f2", "#f6d9a8"


def plot_section(chart: "Chart", ax: "Axes | None", speed_unit: str | None) -> "Axes":
    """Draw max|μ| of the one row or column, or of the one point, over the stable and the unstable side."""
    scale, label = speed_axis(chart.speed_unit if speed_unit is None else speed_unit)
    over_gain = len(chart.gain) > 1 or len(chart.speed) == 1
    x = chart.gain / chart.quantity.scale if over_gain else chart.speed * scale
    y = chart.spectral_radius.ravel()
    ax = one_of(ax, 7.0, 4.0)
    known = np.append(y[np.isfinite(y)], 1.0)
    margin = 0.1 * max(np.ptp(known), 1e-3)
    bottom, top = max(known.min() - margin, 0.0), known.max() + margin
    ax.axhspan(bottom, 1, color=_STABLE, linewidth=0, label="stable, max|μ| < 1")
    ax.axhspan(1, top, color=_UNSTABLE, linewidth=0, label="unstable, max|μ| > 1")
    ax.plot(x, y, color="black", linewidth=1.3, marker="o", markersize=3 if len(x) < 60 else 0)
    if len(x) > 1:
        ax.set_xlim(x[0], x[-1])
    ax.set_ylim(bottom, top)
    unit = "rpm" if scale == 60 else "Hz"
    fixed = f"at {chart.speed[0] * scale:.6g} {unit}" if over_gain else f"at {_gain_of(chart)}"
    ax.set_xlabel(gain_label(chart.quantity) if over_gain else label)
    ax.set_ylabel(f"spectral radius max|μ| {fixed}")
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False, fontsize="small")
    return ax


def _gain_of(chart: "Chart") -> str:
    symbol = gain_label(chart.quantity).split("$")[1]
    return f"${symbol}$ = {chart.gain[0] / chart.quantity.scale:.6g} {chart.quantity.display_unit}"
