"""Wear maps as pictures: depth over speed and casing position, and histories of ramps."""

from typing import TYPE_CHECKING, Any, cast

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.ticker import MaxNLocator

from lobex import _checks
from lobex.plots.frame import one_of, several_of
from lobex.plots.pooling import pooled, speed_order
from lobex.results.spectrum_map import critical_speeds_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lobex.results.wear_map import WearMap

# White to dark, so that it reads in grey as well.
COLOURS = LinearSegmentedColormap.from_list("wear", ["#ffffff", "#f6d9a8", "#c8500a", "#3d1500"])
_POSITIONS = 720
_HARMONICS = 3


def plot_wear(march: "WearMap", ax: "Axes | None", speed_along: str) -> "Axes":
    """Draw the depth removed over speed and position, with the critical speeds of the first mode."""
    _checks.choice("speed_along", speed_along, ("x", "y"))
    order = speed_order("march", march.speed, ", or see plot_history() and plot_casing()")
    speed = march.speed[order]
    ax = one_of(ax, 7.0, 4.4)
    depth, angle = pooled(march.depth[order] * 1e6, np.degrees(march.angle), _POSITIONS)
    upright = speed_along == "x"
    grid = (speed, angle, depth.T) if upright else (angle, speed, depth)
    mesh = ax.pcolormesh(*grid, cmap=COLOURS, vmin=0, shading="nearest", rasterized=True)
    along, across = (ax.set_xlabel, ax.set_ylabel) if upright else (ax.set_ylabel, ax.set_xlabel)
    along("rotational frequency (Hz)")
    across("casing position (°)")
    (ax.set_yticks if upright else ax.set_xticks)(np.arange(0, 361, 60))
    (ax.set_ylim if upright else ax.set_xlim)(0, 360)
    mark_critical_speeds(ax, march.natural_frequency, march.nodal_diameters, (speed[0], speed[-1]), upright)
    bar = ax.figure.colorbar(mesh, ax=ax, pad=0.02 if upright else 0.06)
    bar.set_label(f"depth removed after {march.revolutions} revolutions (µm)")
    return ax


def mark_critical_speeds(
    ax: "Axes", frequency: np.ndarray, nodal_diameters: int, span: tuple[float, float], upright: bool = True
) -> None:
    """Lines at the critical speeds f₁/k, (1.18), and at f₁ itself, named at the axes' edge."""
    critical = critical_speeds_of(frequency[:1], nodal_diameters, _HARMONICS)[0]
    orders = nodal_diameters * np.arange(1, _HARMONICS + 1)
    marks = {1: float(frequency[0]), **dict(zip(orders.tolist(), critical.tolist(), strict=True))}
    taken: list[float] = []
    drawn = False
    for order, speed in marks.items():
        if not span[0] <= speed <= span[1]:
            continue
        label = None if drawn else "critical speed without contact"
        drawn = True
        (ax.axvline if upright else ax.axhline)(speed, color="0.3", linewidth=0.8, linestyle=(0, (4, 3)), label=label)
        # Names that would overlap are left out, the lines are not.
        if any(abs(speed - other) < 0.045 * (span[1] - span[0]) for other in taken):
            continue
        taken.append(speed)
        name = "$f_1$" if order == 1 else f"$f_1/{order}$"
        place = (speed, 1.0) if upright else (1.0, speed)
        horizontal, vertical = ("center", "bottom") if upright else ("left", "center")
        shift = (0, 2) if upright else (3, 0)
        transform = ax.get_xaxis_transform() if upright else ax.get_yaxis_transform()
        ax.annotate(
            name,
            place,
            xycoords=transform,
            xytext=shift,
            textcoords="offset points",
            ha=horizontal,
            va=vertical,
            fontsize="small",
        )


def plot_history(march: "WearMap", axes: Any) -> "Figure":
    """Draw amplitude and wear of every revolution: over the speed where it changes, else over the revolutions."""
    upper, lower = several_of(axes, ("amplitude", "wear"), _panels)
    lanes = min(len(march.speed), _MOST_LANES)
    shown = np.unique(np.linspace(0, len(march.speed) - 1, lanes).astype(int))
    for number, lane in enumerate(shown):
        history = march.speed_history[lane]
        x = history if not march.steady else np.arange(1, march.revolutions + 1)
        colour, line, marker = _LOOKS[number]
        ends = dict.fromkeys(f"{f:.6g}" for f in (history[0], history[-1]))
        style = {
            "color": colour,
            "linestyle": line,
            "linewidth": 1.2,
            "marker": marker,
            "markersize": 3.5,
            "markevery": max(march.revolutions // 16, 1),
        }
        upper.plot(x, march.amplitude[lane] * 1e6, label=f"{' to '.join(ends)} Hz", **style)
        lower.plot(x, march.wear[lane] * 1e6, **style)
    upper.set_ylabel("largest tip motion (µm)")
    lower.set_ylabel("wear (mm² per revolution)")
    if march.steady:
        lower.xaxis.set_major_locator(MaxNLocator(integer=True))
    lower.set_xlabel("rotational frequency (Hz)" if not march.steady else "revolution")
    if not march.steady:
        span = (float(march.speed_history.min()), float(march.speed_history.max()))
        for ax in (upper, lower):
            mark_critical_speeds(ax, march.natural_frequency, march.nodal_diameters, span)
    upper.set_ylim(bottom=0)
    lower.set_ylim(bottom=0)
    figure = cast("Figure", upper.figure)
    if axes is None:
        # Names of critical speeds stand above the axes.
        place = {"loc": "outside upper center", "ncols": min(len(shown), 3), "frameon": False}
        figure.legend(*upper.get_legend_handles_labels(), fontsize="small", **place)
    else:
        upper.legend(fontsize="small")
    return figure


def _panels() -> Any:
    return plt.subplots(2, 1, figsize=(7.0, 5.2), sharex=True, layout="constrained")[1]


# Told apart in grey by line and marker.
_LOOKS = (
    ("#12436d", "-", "o"),
    ("#c8500a", "--", "s"),
    ("#5d8a3a", "-.", "^"),
    ("#7a4f9c", ":", "d"),
    ("#444444", "-", "x"),
    ("#b8860b", "--", "v"),
)
_MOST_LANES = len(_LOOKS)
