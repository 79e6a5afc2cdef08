"""Maps of periodic motions as pictures: one quantity over the stable region, and the stability limit."""

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.patches import Rectangle

from lobex import _checks
from lobex.plots.frame import gain_label, legend_above, one_of, speed_axis
from lobex.plots.march_picture import prefix_of
from lobex.plots.stability_line import LINE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lobex.results.orbit_map import OrbitMap

_UNSTABLE = "#d9cbb8"
# What is signed is shown about zero.
_QUANTITIES = {
    "peak": ("largest displacement", "m", "viridis"),
    "location_error": ("material left at the wall", "m", "RdBu_r"),
    "mean_power": ("mean power", "W", "viridis"),
    "highest_torque": ("largest torque", "N m", "viridis"),
    "pulled": ("share of the chip below zero", "", "viridis"),
}


def plot_orbit_map(found: "OrbitMap", ax: "Axes | None", speed_unit: str | None, of: str) -> "Axes":
    """Draw the quantity over the grid, in the unit's prefix in which it has one to three digits."""
    _checks.choice("of", of, [name for name in _QUANTITIES if hasattr(found, name)])
    if min(found.spectral_radius.shape) < 2:
        raise ValueError(f"the map has {found.spectral_radius.shape} points; a picture takes two speeds and two gains")
    factor, label = speed_axis(found.speed_unit if speed_unit is None else speed_unit)
    ax = one_of(ax, 7.0, 4.4)
    values = getattr(found, of)
    values = np.max(values, axis=-1) if values.ndim == 3 else values
    name, unit, colours = _QUANTITIES[of]
    scale, prefix = prefix_of(values) if unit else (1.0, "")
    shown = np.ma.masked_invalid(values.T / scale)
    most = float(np.max(np.abs(shown))) if shown.count() else 1.0
    limits: dict[str, Any] = {"vmin": -most, "vmax": most} if colours == "RdBu_r" else {}
    x, y = found.speed * factor, found.gain / found.quantity.scale
    ax.set_facecolor(_UNSTABLE)
    mesh = ax.pcolormesh(x, y, shown, cmap=colours, shading="nearest", rasterized=True, **limits)
    with np.errstate(divide="ignore"):
        growth = np.ma.masked_invalid(np.log(found.spectral_radius).T)
    if growth.count() and growth.min() < 0 < growth.max():
        ax.contour(x, y, growth, levels=[0.0], colors=LINE["color"], linewidths=LINE["linewidth"])
        ax.plot([], [], label="stability limit, max|μ| = 1", **LINE)
    ax.add_patch(Rectangle((np.nan, np.nan), 0, 0, facecolor=_UNSTABLE, edgecolor="0.3", label="no stable motion"))
    ax.set_xlabel(label)
    ax.set_ylabel(gain_label(found.quantity))
    ax.set_xlim(x[0], x[-1])
    ax.set_ylim(y[0], y[-1])
    told = f" ({prefix}{unit})" if unit else ""
    ax.figure.colorbar(mesh, ax=ax, pad=0.02).set_label(name + told)
    legend_above(ax)
    return ax
