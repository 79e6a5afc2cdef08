"""Advice as pictures: recommended cuts over the depths that keep all limits, and cuts that were made over a chart."""

from typing import TYPE_CHECKING

import numpy as np

from lobex.plots.frame import gain_label, legend_above, one_of, speed_axis
from lobex.results.codes import Binding, Outcome

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lobex.results.comparison import Comparison
    from lobex.results.recommendation import Recommendation

_BINDING = {
    Binding.STABILITY: ("#12436d", "o"),
    Binding.POWER: ("#c8500a", "s"),
    Binding.TORQUE: ("#e8a33d", "D"),
    Binding.LOCATION_ERROR: ("#0b7a75", "^"),
    Binding.RANGE: ("0.5", "v"),
}
OUTCOMES = {
    Outcome.QUIET_AS_SAID: ("#0b7a75", "o"),
    Outcome.CHATTER_AS_SAID: ("#0b7a75", "X"),
    Outcome.CHATTER_BELOW_THE_LIMIT: ("#c8102e", "X"),
    Outcome.QUIET_ABOVE_THE_LIMIT: ("#e8a33d", "o"),
    Outcome.OUTSIDE_THE_CHART: ("0.6", "d"),
}


def plot_recommendation(advice: "Recommendation", ax: "Axes | None", speed_unit: str | None) -> "Axes":
    """Draw the deepest cut at every speed looked at, by what binds, and the cuts as numbered stars."""
    factor, label = speed_axis(advice.speed_unit if speed_unit is None else speed_unit)
    ax = one_of(ax, 7.0, 4.4)
    speed, depth = advice.scanned_speed * factor, advice.scanned_depth / advice.quantity.scale
    ax.plot(speed, depth, color="0.4", linewidth=0.8)
    for binding, (colour, marker) in _BINDING.items():
        here = (advice.scanned_binding_code == binding) & np.isfinite(depth)
        if here.any():
            words = f"bound by {binding.words}"
            ax.plot(speed[here], depth[here], marker=marker, markersize=4, linestyle="none", color=colour, label=words)
    own = advice.speed * factor, advice.depth / advice.quantity.scale
    ax.plot(*own, marker="*", markersize=13, linestyle="none", color="black", label="highest removal rate")
    for number, place in enumerate(zip(*own, strict=True), start=1):
        ax.annotate(str(number), place, xytext=(7, 5), textcoords="offset points")
    ax.set_xlabel(label)
    ax.set_ylabel(gain_label(advice.quantity))
    ax.set_ylim(bottom=0)
    legend_above(ax)
    return ax


def plot_comparison(found: "Comparison", ax: "Axes | None", speed_unit: str | None) -> "Axes":
    """Draw the cuts over what is there, crosses where they chattered."""
    factor, label = speed_axis(found.speed_unit if speed_unit is None else speed_unit)
    ax = one_of(ax, 7.0, 4.4)
    speed, gain = found.speed * factor, found.gain / found.quantity.scale
    for outcome, (colour, marker) in OUTCOMES.items():
        here = found.outcome_code == outcome
        if here.any():
            words = f"{outcome.words}: {here.sum()}"
            place = speed[here], gain[here]
            ax.scatter(
                *place, marker=marker, s=42, color=colour, edgecolor="white", linewidth=0.6, label=words, zorder=3
            )
    ax.set_xlabel(ax.get_xlabel() or label)
    ax.set_ylabel(ax.get_ylabel() or gain_label(found.quantity))
    legend_above(ax)
    return ax
