"""The stability boundary as a picture: curves by kind, ticked on their unstable side."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.patheffects import TickedStroke

from lobex.plots.frame import gain_label, legend_above, one_of, speed_axis
from lobex.plots.limit_picture import COLOUR, NAME
from lobex.results.codes import Kind

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lobex.results.boundary import Boundary

_DASH = {Kind.HOPF: "-", Kind.FLIP: (0, (5, 2)), Kind.FOLD: (0, (4, 1.5, 1, 1.5))}


def plot_boundary(boundary: "Boundary", ax: "Axes | None", speed_unit: str | None) -> "Axes":
    """Draw the curves in pieces of one kind, into a new picture or over a chart."""
    scale, label = speed_axis(boundary.speed_unit if speed_unit is None else speed_unit)
    fresh = ax is None
    ax = one_of(ax, 7.0, 4.4)
    kinds = set()
    for curve in boundary:
        speed, gain = curve.speed * scale, curve.gain / boundary.quantity.scale
        ticks = [TickedStroke(spacing=7, angle=90, length=0.5, linewidth=0.6, foreground="0.35")]
        ax.plot(speed, gain, color="none", linewidth=0, path_effects=ticks)
        # A piece goes on to the first vertex of the next, so that no gap is left between two kinds.
        jumps = np.flatnonzero(np.diff(curve.kind_code)) + 1
        for start, stop in zip((0, *jumps), (*jumps, len(speed)), strict=True):
            kind = Kind(curve.kind_code[start])
            kinds.add(kind)
            part = np.s_[start : stop + 1]
            ax.plot(speed[part], gain[part], color=COLOUR[kind], linestyle=_DASH[kind], linewidth=1.4)
    for kind in sorted(kinds):
        ax.plot([], [], color=COLOUR[kind], linestyle=_DASH[kind], linewidth=1.4, label=NAME[kind])
    if fresh:
        low, high, least, most = boundary.bounds
        ax.set_xlim(low * scale, high * scale)
        ax.set_ylim(least / boundary.quantity.scale, most / boundary.quantity.scale)
    ax.set_xlabel(ax.get_xlabel() or label)
    ax.set_ylabel(ax.get_ylabel() or gain_label(boundary.quantity))
    legend_above(ax, title="stability boundary max|μ| = 1, ticks on the unstable side", title_fontsize="small")
    return ax
