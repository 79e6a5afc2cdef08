"""Orbits as pictures: the displacement of every lane over the period."""

from typing import TYPE_CHECKING

import numpy as np

from lobex.plots.frame import legend_above, one_of
from lobex.plots.march_picture import check_lanes, lane_names, prefix_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lobex.results.orbit import Orbit

COLOURS = ("#12436d", "#c8500a", "#5b8fb9", "#e8a33d", "#0b7a75", "#8c3b0a")
DASHES = ("-", "--", ":")


def plot_orbit(orbit: "Orbit", ax: "Axes | None") -> "Axes":
    """Draw every lane over the shares of its period; two outputs solid and dashed."""
    check_lanes(orbit.speed.size)
    ax = one_of(ax, 7.0, 3.6)
    lanes = orbit.displacement.reshape(orbit.speed.size, len(orbit.phase), -1)
    vibrates = "modes" in orbit.process
    scale, prefix = prefix_of(lanes) if vibrates else (1.0, "")
    names = lane_names(orbit.speed, orbit.gain / orbit.quantity.scale, orbit.quantity, orbit.speed_unit)
    order = np.argsort(orbit.phase)
    for lane, (name, status) in enumerate(zip(names, orbit.status.ravel(), strict=True)):
        label = name if np.isfinite(lanes[lane]).all() else f"{name}: {status}"
        for output in range(lanes.shape[2]):
            ax.plot(
                orbit.phase[order],
                lanes[lane, order, output] / scale,
                color=COLOURS[lane],
                linestyle=DASHES[output % len(DASHES)],
                linewidth=0.9,
                label=label if lanes.shape[2] == 1 else f"{label}, {'xyz'[output] if vibrates else output + 1}",
            )
    ax.set_xlabel("share of the period")
    ax.set_ylabel(f"displacement ({prefix}m)" if vibrates else "displacement")
    ax.axhline(0, color="0.6", linewidth=0.6, zorder=0)
    legend_above(ax, columns=2)
    return ax
