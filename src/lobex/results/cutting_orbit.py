"""The periodic motion of a cutter, and what its teeth do along it."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lobex._by_name import by_name
from lobex.results.fields import Array, Coordinate, field
from lobex.results.march import span
from lobex.results.orbit import Orbit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class CuttingOrbit(Orbit, form="lobex cutting orbit 1"):
    """An ``Orbit`` of a process that knows its teeth: force, torque and power, chips, and the surface left.

    They are those of the linear motion, in which no tooth leaves the cut: ``status`` "tooth leaves the cut" says where
    one would.

    Attributes:
        height: of the finished wall, from the tip, as shares of the depth of cut, (h,).
        force: of the cut on the structure at the samples, N, (*lanes, samples, e): along the feed and across it.
        torque: that the spindle has to give at the samples, N m, (*lanes, samples). NaN, as what follows from it, of a
            cutter without a diameter.
        highest_torque: the largest of the period, between the samples too, N m, (*lanes,).
        mean_torque: that over the period, N m, (*lanes,).
        chip_thickness: of each tooth at the samples, m, (*lanes, samples, teeth): the mean along the part of its edge
            that is in the cut, and 0 out of it.
        pulled: of the chip that each tooth takes in a turn, the share with a thickness below zero, (*lanes, teeth):
            there the tooth would have left the cut, and is pushed as if it pulled at the material.
        surface_location_error: material that each tooth leaves at the finished wall by the motion, m,
            (*lanes, teeth, h): above zero where the cut is too shallow. A tooth that stands out by its runout leaves as
            much less. NaN of modes that have the direction of the feed alone.
    """

    height: np.ndarray = field(Coordinate("height", "height as a share of the depth of cut", "1", "share_of_depth"))
    force: np.ndarray = field(Array("*lane phase direction", "cutting force on the structure", "N"))
    torque: np.ndarray = field(Array("*lane phase", "torque of the cut", "N m"))
    highest_torque: np.ndarray = field(Array("*lane", "largest torque of the period", "N m"))
    mean_torque: np.ndarray = field(Array("*lane", "mean torque of the period", "N m"))
    chip_thickness: np.ndarray = field(Array("*lane phase tooth", "chip thickness", "m"))
    pulled: np.ndarray = field(Array("*lane tooth", "share of the chip with a thickness below zero", "1"))
    surface_location_error: np.ndarray = field(Array("*lane tooth height", "material left at the finished wall", "m"))

    @property
    def power(self) -> np.ndarray:
        """Torque times the angular speed of the spindle, at the samples, W, (*lanes, samples)."""
        return 2 * np.pi * self.speed[..., None] * self.torque

    @property
    def mean_power(self) -> np.ndarray:
        """The same over the period, W, (*lanes,)."""
        return 2 * np.pi * self.speed * self.mean_torque

    def __repr__(self) -> str:
        lines = super().__repr__().split("\n")
        lines[0] = lines[0].replace("Orbit of", "CuttingOrbit of", 1)
        lines[4:4] = [
            f"  location error   {span(self.surface_location_error)} m",
            f"  force            {span(self.force)} N",
            f"  mean power       {span(self.mean_power)} W, torque up to {span(self.highest_torque)} N m",
        ]
        return "\n".join(lines)

    def plot_cut(self, lane: int = 0, axes: "Sequence[Axes] | None" = None) -> "Figure":
        """Force, torque and the chips of the teeth over the period, of one lane; returns the figure.

        Args:
            lane: its number, in the order of the flattened lanes.
            axes: three axes to draw into, for force, torque and chips.

        Raises:
            ValueError: for a lane that there is not.
        """
        return by_name("plots.cutting_picture.plot_cutting")(self, lane, axes)

    def plot_wall(self, ax: "Axes | None" = None) -> "Axes":
        """The material that each tooth leaves over the height of the finished wall, lane by lane; returns the axes."""
        return by_name("plots.cutting_picture.plot_wall")(self, ax)
