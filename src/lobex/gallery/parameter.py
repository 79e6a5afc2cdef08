"""Maps and pairs of limits as one number of the rod varies: Figs. 4.6 to 4.11."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lobex.gallery import models, style
from lobex.gallery.reproduction import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LOBES = 4
Build = Callable[[float], Any]


def limits_of(build: Build, along: str, values: Sequence[float] | np.ndarray, speed: np.ndarray) -> Results:
    """The exact limits at every value, and where each lobe is lowest."""
    gain, frequency = zip(*(models.limits(build(float(v)), speed) for v in values), strict=True)
    data = models.family(along, values, speed, gain, frequency)
    found = [models.least(build(float(v)), _LOBES) for v in values]
    data["least_stiffness"] = (along, np.array([least for least, _, _ in found]), {"units": "N/m"})
    data["lobe_speed"] = ((along, "lobe"), np.array([lobes for _, lobes, _ in found]), {"units": "Hz"})
    data["lobe_frequency"] = (along, np.array([frequency for _, _, frequency in found]), {"units": "Hz"})
    return {along: data.assign_coords(lobe=("lobe", np.arange(1, _LOBES + 1)))}


def draw_map(results: Results, label: str, lowest: float, highest: float) -> "Figure":
    """The limit over speed and parameter, with the speeds at which lobes are lowest."""
    ((along, data),) = results.items()
    figure, ax = style.panels(1, 4.4)
    style.draw_map(ax, data, along, label, lowest, highest)
    value, speed = data[along].to_numpy(), data["speed"].to_numpy()
    for lobe in range(_LOBES):
        place = data["lobe_speed"].to_numpy()[:, lobe]
        name = "lowest points of the numbered lobes" if lobe == 0 else None
        ax.plot(place, value, color="white", linewidth=2.4, scalex=False, scaley=False)
        ax.plot(place, value, color="#c8500a", linewidth=1.1, linestyle=(0, (5, 2)), label=name, scalex=False)
        shown = np.flatnonzero((place > speed[0]) & (place < 0.97 * speed[-1]))
        if len(shown):
            last = shown[-1]
            ax.annotate(
                str(lobe + 1),
                (place[last], value[last]),
                xytext=(4, -10),
                textcoords="offset points",
                fontsize="small",
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0, "alpha": 0.85},
            )
    style.legend_above(ax, 1)
    return figure


def draw_pair(results: Results, symbol: str, top: float) -> "Figure":
    """The limits at two values."""
    ((along, data),) = results.items()
    speed = data["speed"].to_numpy()
    figure, ax = style.panels(1, 4.0)
    for value, row, look in zip(
        data[along].to_numpy(), data["critical_stiffness"].to_numpy(), style.LOOKS, strict=False
    ):
        ax.plot(speed, row / 1e6, label=f"{symbol} = {value:g}", **look)
    style.over_speed(ax, speed, style.CRITICAL)
    ax.set_ylim(0, top)
    style.legend_above(ax, 2)
    return figure
