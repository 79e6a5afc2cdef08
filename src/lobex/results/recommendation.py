"""The cuts of highest removal rate that keep all limits."""

from typing import TYPE_CHECKING, Any

import numpy as np

from lobex._by_name import by_name
from lobex.results.codes import Binding, OrbitStatus
from lobex.results.description import wall_time
from lobex.results.fields import Array, Codes, Coordinate, field
from lobex.results.result import OfProcess
from lobex.results.units import shown_gain, shown_speed

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Recommendation(OfProcess, form="lobex recommendation 1"):
    """Cuts in the order of their removal rate, each the best of its neighbourhood; margins are shares of the limits.

    Attributes:
        speed: (k,), Hz.
        depth: axial depth of cut, m, (k,).
        removal_rate: m³/s, (k,).
        stability_margin: by which share of the limit the depth is below it, (k,); NaN where there is no limit in the
            range of depths.
        mean_power: W, (k,). NaN, as torque, of a cutter without a diameter.
        highest_torque: N m, (k,).
        location_error: material left at the finished wall, furthest from zero, m, (k,).
        binding_code: members of ``Binding``, (k,): what keeps the depth from being larger.
        status_code: members of ``OrbitStatus``, (k,).
        scanned_speed: the speeds looked at, Hz, (s,).
        scanned_depth: at each the depth that keeps all limits, m, (s,); NaN where none does.
        scanned_binding_code: what binds there, (s,).
        power, torque, location_error_limit: the limits given, W, N m and m; infinite where there is none.
        margin: the share of every limit that was to be left.
        quantity: what the gain is.
        speed_unit: "Hz" or "rpm", for axes.
        process: the model, as a plain dictionary.
        seconds: wall time, compiling included.
        compiling: the part of it in which JAX traced and compiled programs; 0 where they were there already.
    """

    speed: np.ndarray = field(Array("choice", "spindle speed", "Hz"))
    depth: np.ndarray = field(Array("choice", "depth of cut", "m"))
    removal_rate: np.ndarray = field(Array("choice", "removal rate", "m3 s-1"))
    stability_margin: np.ndarray = field(Array("choice", "share of the stability limit that is left", "1"))
    mean_power: np.ndarray = field(Array("choice", "mean power of the period", "W"))
    highest_torque: np.ndarray = field(Array("choice", "largest torque of the period", "N m"))
    location_error: np.ndarray = field(Array("choice", "material left at the finished wall", "m"))
    binding_code: np.ndarray = field(Codes("choice", "what binds", name="binding", codes=Binding))
    status_code: np.ndarray = field(
        Codes("choice", "what became of the periodic motion", name="status", codes=OrbitStatus)
    )
    scanned_speed: np.ndarray = field(Coordinate("scanned", "spindle speeds looked at", "Hz", increasing=True))
    scanned_depth: np.ndarray = field(Array("scanned", "depth of cut that keeps all limits", "m"))
    scanned_binding_code: np.ndarray = field(
        Codes("scanned", "what binds there", name="scanned_binding", codes=Binding)
    )
    power: float
    torque: float
    location_error_limit: float
    margin: float

    @property
    def binding(self) -> np.ndarray:
        """What keeps each depth from being larger, in words: "stability", "power", "torque", "location error", or
        "range" of depths."""
        return Binding.words_of(self.binding_code)

    @property
    def power_margin(self) -> np.ndarray:
        """The share of the limit of the power that is left, (k,); NaN where there is none."""
        return _left(self.mean_power, self.power)

    @property
    def torque_margin(self) -> np.ndarray:
        """The share of the limit of the torque that is left, (k,); NaN where there is none."""
        return _left(self.highest_torque, self.torque)

    @property
    def location_error_margin(self) -> np.ndarray:
        """The share of the limit of the location error that is left, (k,); NaN where there is none."""
        return _left(np.abs(self.location_error), self.location_error_limit)

    def __repr__(self) -> str:
        told: list[tuple[str, Any]] = [
            ("stability", self.stability_margin),
            ("power", self.power_margin),
            ("torque", self.torque_margin),
            ("location error", self.location_error_margin),
        ]
        lines = [
            f"Recommendation for {self.process['type']}: {len(self.speed)} cuts, a margin of {self.margin:g} asked"
        ]
        for i, (speed, depth) in enumerate(zip(self.speed, self.depth, strict=True)):
            left = ", ".join(f"{name} {part[i]:.1%}" for name, part in told if np.isfinite(part[i]))
            lines.append(
                f"  {shown_speed(speed, self.speed_unit)}, {shown_gain(depth, self.quantity)}: "
                f"{self.removal_rate[i] * 6e7:.4g} cm³/min, bound by {self.binding[i]}; left: {left or 'no limit'}"
            )
        return "\n".join([*lines, f"  wall time        {wall_time(self, len(self.scanned_speed), 'speed')}"])

    def plot(self, ax: "Axes | None" = None, speed_unit: str | None = None) -> "Axes":
        """The depths that keep all limits over the speeds, by what binds, and the cuts; returns the axes.

        Args:
            ax: axes to draw into; by default those of a new figure.
            speed_unit: "Hz" or "rpm", by default what the process is usually drawn in.
        """
        return by_name("plots.advice_pictures.plot_recommendation")(self, ax, speed_unit)


def _left(taken: np.ndarray, limit: float) -> np.ndarray:
    return 1 - taken / (limit if np.isfinite(limit) else np.nan)
