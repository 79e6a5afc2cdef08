"""The stability limit as a picture: critical gain above, chatter frequency below, on one speed axis."""

import itertools
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, cast

import matplotlib.pyplot as plt
import numpy as np

from lobex.plots.frame import frequency_label, gain_label, legend_above, one_of, several_of, speed_axis
from lobex.results.codes import Kind, Status

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lobex.results.limit import Limit

# Distinct in grey and by marker as well as by colour.
COLOUR = {Kind.HOPF: "#12436d", Kind.FLIP: "#c8500a", Kind.FOLD: "#5d8a3a"}
NAME = {Kind.HOPF: "Hopf (complex pair)", Kind.FLIP: "flip (μ = −1)", Kind.FOLD: "fold (μ = +1)"}
# Of modes, and of waves around the disc, one after the other: Okabe and Ito's, which colour-blind people tell apart.
LABELLED = ("#12436d", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#5d3a9b", "#7a7a7a")
_MARKER = {Kind.HOPF: "o", Kind.FLIP: "s", Kind.FOLD: "^"}
STABLE = "#d6e6f2"
BAND = "#e0a458"
# Of the lobes' numbers and what they keep off, points.
_TEXT, _GAP = 8.0, 4.0

Band = tuple[np.ndarray, np.ndarray, str]


def plot_limit(
    limit: "Limit", ax: "Axes | None", axes: Any, speed_unit: str | None, label: str | None, band: Band | None = None
) -> "Figure | Axes":
    """Draw into axes of its own, or over others.

    ``band`` is a lower and an upper gain per speed to shade between, and its name in the legend.
    """
    if ax is not None and axes is not None:
        raise ValueError("ax and axes are both given; give ax for the limit alone, or axes for limit and frequency")
    if ax is None and label is not None:
        raise ValueError(f"label = {label!r} names one of several limits; give ax, the axes that they share")
    return _panels_of(limit, axes, speed_unit, band) if ax is None else _over(limit, ax, speed_unit, label, band)


def _panels_of(limit: "Limit", axes: Any, speed_unit: str | None, band: Band | None) -> "Figure":
    """Draw the limit, its stable intervals, its kinds and lobes, above the chatter frequencies."""
    scale, label = speed_axis(limit.speed_unit if speed_unit is None else speed_unit)
    upper, lower = several_of(axes, ("gain", "chatter frequency"), _panels)
    speed, gain = _draw_gain(upper, limit, scale, band)
    order = np.argsort(limit.speed)
    kinds, frequency = np.asarray(limit.kind_code)[order], limit.chatter_frequency[order]
    for here, style, _ in groups(limit, order):
        lower.plot(speed[here], frequency[here], **style)
    for start, stop in _broken(limit.lobe[order], kinds):
        lower.plot(speed[start:stop], frequency[start:stop], color="0.25", linewidth=0.6)
    if not np.isfinite(frequency).any():
        lower.set_yticks([])
    top = limit.bounds[1] / limit.quantity.scale
    if np.isfinite(gain).any():
        # A band of first order shoots up beside a cusp; the limit is what must be seen.
        top = np.nanmax(gain) if band is None else min(np.nanmax(band[1]) / limit.quantity.scale, 1.5 * np.nanmax(gain))
    upper.set_ylim(limit.bounds[0] / limit.quantity.scale, min(limit.bounds[1] / limit.quantity.scale, 1.08 * top))
    if len(speed) > 1:
        for ax in (upper, lower):
            ax.set_xlim(speed[0], speed[-1])
    edges = (gain, gain) if band is None else [edge[order] / limit.quantity.scale for edge in band[:2]]
    upper.set_ylabel(gain_label(limit.quantity))
    lower.set_ylabel(frequency_label(limit.speed_unit))
    lower.set_xlabel(label)
    legend_above(upper, columns=4)
    figure = cast("Figure", upper.figure)
    # How much room numbers have is known once the axes lie where they will.
    figure.draw_without_rendering()
    _number_lobes(upper, speed, gain, limit.lobe[order], *edges)
    return figure


def _over(limit: "Limit", ax: "Axes", speed_unit: str | None, label: str | None, band: Band | None) -> "Axes":
    """Draw the limit alone, over what is in the axes already, whose ends are left as they are.

    With a ``label``, as one of several: a line in a colour of its own, its kinds told by markers alone.
    """
    scale, name = speed_axis(limit.speed_unit if speed_unit is None else speed_unit)
    ax = one_of(ax, 7.0, 4.4)
    if label is None:
        _draw_gain(ax, limit, scale, band, shaded=not ax.has_data())
    else:
        order = np.argsort(limit.speed)
        speed, gain = limit.speed[order] * scale, limit.gain[order] / limit.quantity.scale
        (line,) = ax.plot(speed, gain, linewidth=1.4, label=label)
        if band is not None:
            low, high = (edge[order] / limit.quantity.scale for edge in band[:2])
            ax.fill_between(speed, low, high, color=line.get_color(), alpha=0.2, linewidth=0)
        for kind in NAME:
            here = np.asarray(limit.kind_code)[order] == kind
            ax.plot(speed[here], gain[here], **{**_style(kind, here), "color": line.get_color()})
    ax.set_xlabel(ax.get_xlabel() or name)
    ax.set_ylabel(ax.get_ylabel() or gain_label(limit.quantity))
    legend_above(ax)
    return ax


def _panels() -> Any:
    return plt.subplots(2, 1, figsize=(7.0, 5.6), sharex=True, layout="constrained", height_ratios=(2.2, 1))[1]


def _draw_gain(
    ax: "Axes", limit: "Limit", scale: float, band: Band | None, shaded: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """The limit by kinds over its stable intervals; returns speed and gain as drawn."""
    order = np.argsort(limit.speed)
    speed, gain = limit.speed[order] * scale, limit.gain[order] / limit.quantity.scale
    if shaded:
        _shade(ax, speed, limit.intervals[order] / limit.quantity.scale)
        always = np.asarray(limit.status_code)[order] == Status.STABLE_AT_ANY_GAIN
        _hatch(ax, speed, always, f"stable at any {limit.quantity.name}")
    if band is not None:
        low, high = (edge[order] / limit.quantity.scale for edge in band[:2])
        ax.fill_between(speed, low, high, color=BAND, alpha=0.75, linewidth=0, label=band[2])
    ax.plot(speed, gain, color="0.25", linewidth=0.8)
    for here, style, name in groups(limit, order):
        ax.plot(speed[here], gain[here], label=name, **style)
    return speed, gain


def groups(limit: "Limit", order: np.ndarray) -> list[tuple[np.ndarray, dict[str, Any], str]]:
    """Limits that are drawn alike, with their style and name: by kind, or where there is one kind, by the modes or the
    waves around the disc that chatter, each in a colour of its own.
    """
    kinds = np.asarray(limit.kind_code)[order]
    found = [(kinds == kind, _style(kind, kinds == kind), name) for kind, name in NAME.items() if np.any(kinds == kind)]
    for name, codes, none in (("nodal diameter {}".format, limit.nodal_diameter, -1), (_mode_of(limit), limit.mode, 0)):
        labels = np.asarray(codes)[order]
        values = np.unique(labels[labels > none])
        if len(found) == 1 and 1 < len(values) <= len(LABELLED):
            style = found[0][1]
            return [
                (labels == value, {**style, "color": colour}, name(value))
                for value, colour in zip(values, LABELLED, strict=False)
            ]
    return found


def _mode_of(limit: "Limit") -> Callable[[int], str]:
    """The name of a mode by its number: those of a casing come after those of the blade, and are counted anew."""
    structure = limit.process.get("modes") or {}
    own = np.shape(structure.get("blade", structure).get("angular_frequency", ()))[-1:]
    if not limit.process.get("casing") or not own:
        return "mode {}".format
    return lambda number: f"mode {number}" if number <= own[0] else f"casing mode {number - own[0]}"


def _style(kind: Kind, here: np.ndarray) -> dict[str, Any]:
    size = 3.0 if here.sum() < 120 else 1.6
    return {"color": COLOUR[kind], "marker": _MARKER[kind], "markersize": size, "linestyle": "none"}


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
            axes.fill_between(x, low, high, color=STABLE, linewidth=0, label=label)
            label = None


def _hatch(axes: "Axes", speed: np.ndarray, always: np.ndarray, name: str) -> None:
    """Hatch where no gain is too large, whatever the bounds are."""
    if len(speed) < 2:
        return
    edges = np.r_[speed[0], (speed[1:] + speed[:-1]) / 2, speed[-1]]
    changes = np.flatnonzero(np.diff(np.pad(always.astype(int), 1)))
    for number, (start, stop) in enumerate(changes.reshape(-1, 2)):
        label = name if number == 0 else None
        style = {"facecolor": STABLE, "edgecolor": "white", "hatch": "//", "linewidth": 0}
        axes.axvspan(edges[start], edges[stop], label=label, **style)


def _broken(lobe: np.ndarray, kind: np.ndarray) -> list[tuple[int, int]]:
    """Runs of one lobe and kind."""
    jumps = np.flatnonzero((np.diff(lobe) != 0) | (np.diff(kind) != 0)) + 1
    ends = [0, *jumps.tolist(), len(lobe)]
    return [(a, b) for a, b in itertools.pairwise(ends) if lobe[a] >= 0]


def _number_lobes(
    axes: "Axes", speed: np.ndarray, gain: np.ndarray, lobe: np.ndarray, low: np.ndarray, high: np.ndarray
) -> None:
    """Write each lobe's number under its lowest point and what is shaded there, or where that leaves no room above the
    axis, over it; none where it would lie on another.
    """
    if len(speed) < 2:
        return
    points = 72 / axes.figure.dpi * np.array([axes.bbox.width, axes.bbox.height])
    span, last = speed[-1] - speed[0], -np.inf
    bottom, top = axes.get_ylim()
    # A line of text with the gap before it, in units of the gain.
    need = (_GAP + 1.2 * _TEXT) / points[1] * (top - bottom)
    for number in sorted(set(lobe[lobe >= 0].tolist()), reverse=True):
        here = np.flatnonzero((lobe == number) & np.isfinite(gain))
        lowest = here[np.argmin(gain[here])]
        width = 0.7 * _TEXT * len(str(number)) / points[0] * span
        interior = 0.01 * span < speed[lowest] - speed[0] < 0.99 * span
        beside = np.abs(speed - speed[lowest]) <= 0.7 * width
        lower, upper = np.fmin.reduce(low[beside]), np.fmax.reduce(high[beside])
        under = lower - bottom > need
        if not interior or speed[lowest] - last < 1.5 * width or not (under or top - upper > need):
            continue
        last = speed[lowest]
        axes.annotate(
            str(number),
            (speed[lowest], lower if under else upper),
            xytext=(0, -_GAP if under else _GAP),
            textcoords="offset points",
            ha="center",
            va="top" if under else "bottom",
            fontsize=_TEXT,
        )
