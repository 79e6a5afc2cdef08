"""Turning as a picture: displacement, chip thickness or force of every lane over revolutions."""

from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np

from lobex import _checks
from lobex.plots.frame import one_of
from lobex.plots.march_picture import check_lanes, finish, lane_names, prefix_of, reach
from lobex.processes.quantity import DEPTH_OF_CUT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lobex.results.cut import Cut

_COLOURS = ("#12436d", "#c8500a", "#5b8fb9", "#e8a33d", "#0b7a75", "#8c3b0a")
_UNITS = {"displacement": "m", "chip_thickness": "m", "force": "N"}


def plot_cut(cut: "Cut", ax: "Axes | None", what: str) -> "Axes":
    """Draw one history of every lane."""
    _checks.choice("what", what, tuple(_UNITS))
    check_lanes(cut.speed.size)
    ax = one_of(ax, 7.0, 3.6)
    lanes = getattr(cut, what).reshape(cut.speed.size, -1)
    scale, prefix = prefix_of(lanes)
    names = lane_names(cut.speed, cut.depth / DEPTH_OF_CUT.scale, DEPTH_OF_CUT, "rpm")
    # Large motion first, so that small motion is drawn over it and stays visible.
    for order, lane in enumerate(np.argsort([-reach(samples) for samples in lanes])):
        style = {"color": _COLOURS[lane % len(_COLOURS)], "linewidth": 0.9, "zorder": 2 + order / 10}
        ax.plot(cut.phase, lanes[lane] / scale, label=names[lane], **style)
    ax.set_xlabel("revolutions")
    ax.set_ylabel(f"{what.replace('_', ' ')} ({prefix}{_UNITS[what]})")
    finish(ax, cut.phase[-1])
    return ax


def plot_histories(cut: "Cut") -> "Figure":
    """Displacement, chip thickness and force above each other, with one legend."""
    figure, axes = plt.subplots(3, 1, figsize=(7.0, 6.6), sharex=True, layout="constrained")
    for ax, what in zip(axes, _UNITS, strict=True):
        plot_cut(cut, ax, what)
    for ax in axes[1:]:
        ax.get_legend().remove()
    for ax in axes[:-1]:
        ax.set_xlabel("")
    return figure
