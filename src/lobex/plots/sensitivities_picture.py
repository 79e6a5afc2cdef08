"""Sensitivities of the stability limit as a picture: curves over speed, or bars for one speed."""

from typing import TYPE_CHECKING

import numpy as np

from lobex.plots.frame import one_of, speed_axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lobex.results.sensitivities import Sensitivities

# Distinct in grey by dash as well as by colour.
_LOOK = [
    ("#12436d", "-"),
    ("#c8500a", "--"),
    ("#5d8a3a", "-."),
    ("#7a4b94", ":"),
    ("#8a6d1b", (0, (6, 2, 1, 2, 1, 2))),
    ("0.45", (0, (1, 1))),
]
_MOST_BARS = 16


def plot_sensitivities(table: "Sensitivities", ax: "Axes | None", speed_unit: str | None) -> "Axes":
    """Draw d ln K / d ln p of the numbers that matter most."""
    scale, label = speed_axis(table.limit.speed_unit if speed_unit is None else speed_unit)
    symbol = table.limit.quantity.symbol
    head, _, tail = symbol.partition("_")
    ratio = f"d ln ${head}{f'_{{{tail}}}' if tail else ''}$ / d ln $p$"
    ax = one_of(ax, 7.0, 4.4)
    ax.set_axisbelow(True)
    if len(table.limit.speed) == 1:
        chosen = table.largest(_MOST_BARS)[::-1]
        size = table.logarithmic[0, chosen]
        names = [table.names[i] for i in chosen]
        ax.barh(names, size, color=[_LOOK[0][0] if s >= 0 else _LOOK[1][0] for s in size], height=0.7)
        ax.axvline(0, color="0.3", linewidth=0.8)
        ax.margins(x=0.14)
        for name, s in zip(names, size, strict=True):
            side = 1 if s >= 0 else -1
            ax.annotate(
                f"{s:+.2f}",
                (s, name),
                xytext=(3 * side, 0),
                textcoords="offset points",
                ha="left" if side > 0 else "right",
                va="center",
                fontsize="small",
            )
        ax.set_xlabel(f"{ratio} at {table.limit.speed[0] * scale:.6g} {speed_unit or table.limit.speed_unit}")
        return ax
    order = np.argsort(table.limit.speed)
    speed, lobe = table.limit.speed[order] * scale, table.limit.lobe[order]
    # The sensitivities jump from one lobe to the next: no line across.
    jumps = np.flatnonzero(np.diff(lobe) != 0) + 1
    for (colour, dash), i in zip(_LOOK, table.largest(len(_LOOK)), strict=False):
        values = np.insert(table.logarithmic[order, i], jumps, np.nan)
        ax.plot(np.insert(speed, jumps, np.nan), values, color=colour, linestyle=dash, label=table.names[i])
    # Steep ends of lobes run out of the picture, so that the rest can be read.
    drawn = np.abs(table.logarithmic[:, table.largest(len(_LOOK))])
    drawn = drawn[np.isfinite(drawn)]
    if drawn.size and (usual := 2 * float(np.quantile(drawn, 0.9))) < drawn.max():
        ax.set_ylim(-usual, usual)
    ax.axhline(0, color="0.3", linewidth=0.8)
    ax.grid(axis="y", color="0.9")
    ax.set_xlim(speed[0], speed[-1])
    ax.set_xlabel(label)
    ax.set_ylabel(ratio)
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False, fontsize="small")
    return ax
