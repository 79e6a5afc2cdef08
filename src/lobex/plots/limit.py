"""The stability limit as a picture: critical gain above, chatter frequency below, on one speed axis."""

import itertools
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np

from lobex.plots.axes import frequency_label, gain_label, speed_axis
from lobex.results.limit import Kind

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lobex.results.limit import Limit

# Distinct in grey and by marker as well as by colour.
COLOUR = {Kind.HOPF: "#12436d", Kind.FLIP: "#c8500a", Kind.FOLD: "#5d8a3a"}
NAME = {Kind.HOPF: "Hopf (complex pair)", Kind.FLIP: "flip (μ = −1)", Kind.FOLD: "fold (μ = +1)"}
_MARKER = {Kind.HOPF: "o", Kind.FLIP: "s", Kind.FOLD: "^"}
_STABLE = "#d6e6f2"
_BAND = "#e0a458"


def plot_limit(
    limit: "Limit", speed_unit: str | None, band: tuple[np.ndarray, np.ndarray, str] | None = None
) -> "Figure":
    """Draw the limit, its stable intervals, its kinds and lobes, and the chatter frequencies.

    ``band`` is a lower and an upper gain per speed to shade between, and its name in the legend.
    """
    scale, label = speed_axis(limit.speed_unit if speed_unit is None else speed_unit)
    order = np.argsort(limit.speed)
    speed, gain = limit.speed[order] * scale, limit.gain[order] / limit.quantity.scale
    figure, (upper, lower) = plt.subplots(
        2, 1, figsize=(7.0, 5.6), sharex=True, layout="constrained", height_ratios=(2.2, 1)
    )
    _shade(upper, speed, limit.intervals[order] / limit.quantity.scale)
    if band is not None:
        low, high = (edge[order] / limit.quantity.scale for edge in band[:2])
        upper.fill_between(speed, low, high, color=_BAND, alpha=0.75, linewidth=0, label=band[2])
    kinds = np.asarray(limit.kind_code)[order]
    joined = _broken(limit.lobe[order], kinds)
    upper.plot(speed, gain, color="0.25", linewidth=0.8)
    for kind, name in NAME.items():
        here = kinds == kind
        if here.any():
            size = 3.0 if here.sum() < 120 else 1.6
            style = {"color": COLOUR[kind], "marker": _MARKER[kind], "markersize": size, "linestyle": "none"}
            upper.plot(speed[here], gain[here], label=name, **style)
            lower.plot(speed[here], limit.chatter_frequency[order][here], **style)
    for start, stop in joined:
        part = np.s_[start:stop]
        lower.plot(speed[part], limit.chatter_frequency[order][part], color="0.25", linewidth=0.6)
    _number_lobes(upper, speed, gain, limit.lobe[order])
    top = limit.bounds[1] / limit.quantity.scale
    if np.isfinite(gain).any():
        # A band of first order shoots up beside a cusp; the limit is what must be seen.
        top = np.nanmax(gain) if band is None else min(np.nanmax(band[1]) / limit.quantity.scale, 1.5 * np.nanmax(gain))
    upper.set_ylim(limit.bounds[0] / limit.quantity.scale, min(limit.bounds[1] / limit.quantity.scale, 1.08 * top))
    if len(speed) > 1:
        upper.set_xlim(speed[0], speed[-1])
    upper.set_ylabel(gain_label(limit.quantity))
    lower.set_ylabel(frequency_label(limit.speed_unit))
    lower.set_xlabel(label)
    if upper.get_legend_handles_labels()[0]:
        upper.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, frameon=False, fontsize="small")
    return figure


def _shade(axes: "Axes", speed: np.ndarray, intervals: np.ndarray) -> None:
    """Fill the stable intervals; between speeds with different numbers of them, up to the middle."""
    if len(speed) < 2:
        return
    edges = np.r_[speed[0], (speed[1:] + speed[:-1]) / 2, speed[-1]]
    count = np.sum(np.isfinite(intervals[:, :, 0]), axis=1)
    ends = np.r_[0, np.flatnonzero(np.diff(count)) + 1, len(speed)]
    label: str | None = "stable"
    for start, stop in itertools.pairwise(ends.tolist()):
        x = np.r_[edges[start], speed[start:stop], edges[stop]]
        for k in range(count[start]):
            low, high = (np.pad(intervals[start:stop, k, end], 1, mode="edge") for end in (0, 1))
            axes.fill_between(x, low, high, color=_STABLE, linewidth=0, label=label)
            label = None


def _broken(lobe: np.ndarray, kind: np.ndarray) -> list[tuple[int, int]]:
    """Runs of one lobe and kind."""
    jumps = np.flatnonzero((np.diff(lobe) != 0) | (np.diff(kind) != 0)) + 1
    ends = [0, *jumps.tolist(), len(lobe)]
    return [(a, b) for a, b in itertools.pairwise(ends) if lobe[a] >= 0]


def _number_lobes(axes: "Axes", speed: np.ndarray, gain: np.ndarray, lobe: np.ndarray) -> None:
    """Write each lobe's number under its lowest point, where there is room."""
    if len(speed) < 2:
        return
    span, last = speed[-1] - speed[0], -np.inf
    for number in sorted(set(lobe[lobe >= 0].tolist()), reverse=True):
        here = np.flatnonzero((lobe == number) & np.isfinite(gain))
        lowest = here[np.argmin(gain[here])]
        interior = 0.01 * span < speed[lowest] - speed[0] < 0.99 * span
        if interior and speed[lowest] - last > 0.025 * span:
            last = speed[lowest]
            axes.annotate(
                str(number),
                (speed[lowest], gain[lowest]),
                xytext=(0, -4),
                textcoords="offset points",
                ha="center",
                va="top",
                fontsize="small",
            )
