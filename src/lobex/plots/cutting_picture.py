"""What a cutter does along its periodic motion as pictures: force, torque, chips, and the wall that it leaves."""

from typing import TYPE_CHECKING, Any, cast

import matplotlib.pyplot as plt
import numpy as np

from lobex import _checks
from lobex.plots.frame import legend_above, one_of, several_of
from lobex.plots.march_picture import check_lanes, lane_names, prefix_of
from lobex.plots.orbit_picture import COLOURS, DASHES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lobex.results.cutting_orbit import CuttingOrbit

_PANELS = ("force", "torque", "chip thickness")


def plot_cutting(orbit: "CuttingOrbit", lane: int, axes: Any) -> "Figure":
    """Draw one lane into three panels over the period."""
    count = orbit.speed.size
    number = _checks.integer("lane", lane, 0)
    if number >= count:
        raise ValueError(f"lane = {number} is none of the {count} lanes; give 0 to {count - 1}")
    panels = several_of(axes, _PANELS, _make)
    order = np.argsort(orbit.phase)
    phase = orbit.phase[order]
    force, torque, chip = (
        part.reshape(count, len(phase), -1)[number, order] for part in (orbit.force, orbit.torque, orbit.chip_thickness)
    )
    scale, prefix = prefix_of(chip)
    for part, dash, name in zip(force.T, DASHES, "xyz", strict=False):
        panels[0].plot(phase, part, color=COLOURS[0], linestyle=dash, linewidth=0.9, label=f"force, {name}")
    panels[1].plot(phase, torque[:, 0], color=COLOURS[1], linewidth=0.9, label="torque")
    for tooth, part in enumerate(chip.T):
        colour, dash = COLOURS[tooth % len(COLOURS)], DASHES[tooth // len(COLOURS) % len(DASHES)]
        panels[2].plot(phase, part / scale, color=colour, linestyle=dash, linewidth=0.9, label=f"tooth {tooth}")
    for panel, label in zip(panels, ("force (N)", "torque (N m)", f"chip ({prefix}m)"), strict=True):
        panel.set_ylabel(label)
        panel.axhline(0, color="0.6", linewidth=0.6, zorder=0)
    panels[2].set_xlabel("share of the period")
    legend_above(panels[0])
    panels[2].legend(fontsize="small", frameon=False, ncols=4)
    return cast("Figure", panels[0].figure)


def plot_wall(orbit: "CuttingOrbit", ax: "Axes | None") -> "Axes":
    """Draw what every tooth of every lane leaves over the height; teeth that leave the same as one line."""
    check_lanes(orbit.speed.size)
    ax = one_of(ax, 5.0, 4.2)
    teeth, heights = orbit.surface_location_error.shape[-2:]
    lanes = orbit.surface_location_error.reshape(-1, teeth, heights)
    scale, prefix = prefix_of(lanes)
    names = lane_names(orbit.speed, orbit.gain / orbit.quantity.scale, orbit.quantity, orbit.speed_unit)
    for lane, (name, depth) in enumerate(zip(names, orbit.gain.ravel() / orbit.quantity.scale, strict=True)):
        for tooth, left in enumerate(lanes[lane]):
            # Of one height all of the wall is alike.
            place, left = (np.r_[0, depth], np.repeat(left, 2)) if heights == 1 else (orbit.height * depth, left)
            style = {"color": COLOURS[lane], "linestyle": DASHES[tooth % len(DASHES)], "linewidth": 0.9}
            ax.plot(left / scale, place, label=f"{name}, tooth {tooth}", **style)
    ax.axvline(0, color="0.6", linewidth=0.6, zorder=0)
    ax.set_xlabel(f"material left at the finished wall ({prefix}m)")
    ax.set_ylabel(f"height ({orbit.quantity.display_unit})")
    legend_above(ax, columns=2)
    return ax


def _make() -> Any:
    return plt.subplots(3, 1, figsize=(7.0, 6.0), sharex=True, layout="constrained")[1]
