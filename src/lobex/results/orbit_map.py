"""The result of a sweep of periodic motions over a grid of speeds and gains."""

from typing import TYPE_CHECKING, Any

import numpy as np

from lobex._by_name import by_name
from lobex.results.codes import OrbitStatus
from lobex.results.description import doubts, in_words, wall_time
from lobex.results.fields import Array, Codes, Coordinate, field, in_gain, in_hertz
from lobex.results.march import displacement_unit, span
from lobex.results.result import OfProcess
from lobex.results.units import shown_gain, shown_range, shown_speed

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class OrbitMap(OfProcess, form="lobex orbit map 1"):
    """How far a forced process moves, over a (speed, gain) grid; NaN where no motion comes to its orbit.

    Attributes:
        speed: (n,), Hz.
        gain: (m,), in ``quantity.unit``.
        peak: the largest distance of each output from zero over the period, (n, m, r), m where the structure has modes.
        spectral_radius: max|μ| of the motion about the orbit, (n, m): below 1 it dies out.
        error: estimated error of the displacement, relative to the largest of all outputs, each in units of its own
            size, (n, m).
        status_code: members of ``OrbitStatus``, (n, m).
        quantity: what the gain is.
        speed_unit: "Hz", "rpm", or "1" of a process without units, for axes.
        process, method: the model and the method, as plain dictionaries.
        seconds: wall time, compiling included.
        compiling: the part of it in which JAX traced and compiled programs; 0 where they were there already.
    """

    speed: np.ndarray = field(Coordinate("speed", "rotational frequency", in_hertz, increasing=True))
    gain: np.ndarray = field(Coordinate("gain", lambda found: found.quantity.name, in_gain, increasing=True))
    peak: np.ndarray = field(Array("speed gain output", "largest displacement of the period", displacement_unit))
    spectral_radius: np.ndarray = field(Array("speed gain", "spectral radius max|μ| about the orbit", "1"))
    error: np.ndarray = field(Array("speed gain", "estimated error of the displacement, relative to the largest", "1"))
    status_code: np.ndarray = field(
        Codes("speed gain", "what became of the periodic motion", name="status", codes=OrbitStatus)
    )
    method: dict[str, Any]

    @property
    def status(self) -> np.ndarray:
        """What became of each point, in words, (n, m), as of ``Orbit``."""
        return OrbitStatus.words_of(self.status_code)

    def __repr__(self) -> str:
        lines = [
            f"{type(self).__name__} of {self.process['type']}: {len(self.speed)} speeds × {len(self.gain)} gains",
            f"  speed            {shown_range(*(shown_speed(s, self.speed_unit) for s in self.speed[[0, -1]]))}",
            f"  gain             {shown_range(*(shown_gain(g, self.quantity) for g in self.gain[[0, -1]]))}"
            f" ({self.quantity.name} {self.quantity.symbol})",
            f"  peak             {span(self.peak)} {displacement_unit(self)}",
            f"  spectral radius  {span(self.spectral_radius)}",
            f"  method           {in_words(self.method)}",
            f"  wall time        {wall_time(self, self.error.size, 'point')}",
            *doubts(self.error, OrbitStatus, self.status_code, "points"),
        ]
        return "\n".join(lines)

    def plot(self, ax: "Axes | None" = None, speed_unit: str | None = None, *, of: str = "peak") -> "Axes":
        """A map of one of the quantities over the stable region, with the stability limit drawn; returns the axes.

        Args:
            ax: axes to draw into; by default those of a new figure.
            speed_unit: "Hz" or "rpm", by default what the process is usually drawn in.
            of: the name of the quantity: "peak", the largest of all outputs; of a ``CuttingMap`` also
                "location_error", "mean_power", "highest_torque" and "pulled".

        Raises:
            ValueError: for a quantity that the map has not.
        """
        return by_name("plots.orbit_map_picture.plot_orbit_map")(self, ax, speed_unit, of)


class CuttingMap(OrbitMap, form="lobex cutting map 1"):
    """An ``OrbitMap`` of a process that knows its teeth: the wall that they leave, and what they ask of the spindle.

    Attributes:
        location_error: material left at the finished wall, m, (n, m): of all teeth and heights that which is furthest
            from zero, as ``CuttingOrbit.surface_location_error`` has it.
        mean_power: of the spindle over the period, W, (n, m). NaN, as torque, of a cutter without a diameter.
        highest_torque: of the period, N m, (n, m).
        pulled: of the chip that a tooth takes, the share with a thickness below zero, of the tooth of which it is
            most, (n, m).
    """

    location_error: np.ndarray = field(Array("speed gain", "material left at the finished wall", "m"))
    mean_power: np.ndarray = field(Array("speed gain", "mean power of the period", "W"))
    highest_torque: np.ndarray = field(Array("speed gain", "largest torque of the period", "N m"))
    pulled: np.ndarray = field(Array("speed gain", "share of the chip with a thickness below zero", "1"))

    def __repr__(self) -> str:
        lines = super().__repr__().split("\n")
        lines[4:4] = [
            f"  location error   {span(self.location_error)} m",
            f"  mean power       {span(self.mean_power)} W, torque up to {span(self.highest_torque)} N m",
        ]
        return "\n".join(lines)

    def plot(self, ax: "Axes | None" = None, speed_unit: str | None = None, *, of: str = "location_error") -> "Axes":
        """As ``OrbitMap.plot``, by default of the location error; returns the axes."""
        return super().plot(ax, speed_unit, of=of)
