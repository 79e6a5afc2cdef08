"""The result of a search for the periodic motion of a forced process."""

from typing import TYPE_CHECKING, Any

import numpy as np

from lobex._by_name import by_name
from lobex._namespace import namespace
from lobex.results.codes import OrbitStatus
from lobex.results.description import doubts, in_words, wall_time
from lobex.results.fields import Array, Codes, Coordinate, field, in_gain, in_hertz
from lobex.results.march import displacement_unit, span
from lobex.results.result import OfProcess
from lobex.results.units import shown_gain, shown_span, shown_speed

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Orbit(OfProcess, form="lobex orbit 1"):
    """The motion, periodic as the forcing is, that a stable process comes to; lanes have the broadcast shape of speed
    and gain.

    Attributes:
        speed: (*lanes,), Hz.
        gain: (*lanes,), in ``quantity.unit``.
        period: T, (*lanes,), s.
        phase: t/T of the samples, (samples,).
        displacement: y at the samples, (*lanes, samples, r), m where the structure has modes; NaN where the process is
            unstable or the point failed.
        lowest, highest: the extremes of y over the period, between the samples too, (*lanes, r).
        spectral_radius: max|μ| of the motion about the orbit, (*lanes,): below 1 it dies out.
        error: estimated error of the displacement, relative to the largest of all outputs, each in units of its own
            size, (*lanes,).
        status_code: members of ``OrbitStatus``, (*lanes,).
        quantity: what the gain is.
        speed_unit: "Hz", "rpm", or "1" of a process without units, for legends.
        process, method: the model and the method, as plain dictionaries.
        seconds: wall time, compiling included.
        compiling: the part of it in which JAX traced and compiled programs; 0 where they were there already.
    """

    speed: np.ndarray = field(Coordinate("*lane", "rotational frequency", in_hertz))
    gain: np.ndarray = field(Coordinate("*lane", lambda orbit: orbit.quantity.name, in_gain))
    period: np.ndarray = field(Coordinate("*lane", "period", "s"))
    phase: np.ndarray = field(Coordinate("phase", "time in periods", "1"))
    displacement: np.ndarray = field(
        Array("*lane phase output", "displacement of the periodic motion", displacement_unit)
    )
    lowest: np.ndarray = field(Array("*lane output", "lowest displacement of the period", displacement_unit))
    highest: np.ndarray = field(Array("*lane output", "highest displacement of the period", displacement_unit))
    spectral_radius: np.ndarray = field(Array("*lane", "spectral radius max|μ| about the orbit", "1"))
    error: np.ndarray = field(Array("*lane", "estimated error of the displacement, relative to the largest", "1"))
    status_code: np.ndarray = field(
        Codes("*lane", "what became of the periodic motion", name="status", codes=OrbitStatus)
    )
    method: dict[str, Any]

    @property
    def time(self) -> np.ndarray:
        """The times of the samples, s, (*lanes, samples)."""
        return self.period[..., None] * self.phase

    @property
    def peak(self) -> np.ndarray:
        """The largest distance of y from zero over the period, (*lanes, r)."""
        return namespace(self.lowest, self.highest).maximum(-self.lowest, self.highest)

    @property
    def status(self) -> np.ndarray:
        """What became of each point, in words, (*lanes,): "good", "above tolerance" (its error may be more than asked
        for), "unstable" (no motion comes to the orbit, which is not told), or "failed" (it is NaN)."""
        return OrbitStatus.words_of(self.status_code)

    def __repr__(self) -> str:
        unit = displacement_unit(self)
        size = "" if unit == "1" else f" {unit}"
        lines = [
            f"Orbit of {self.process['type']}: {self.speed.size} lanes, {len(self.phase)} samples of the period",
            f"  speed            {shown_span(self.speed, lambda speed: shown_speed(speed, self.speed_unit))}",
            f"  gain             {shown_span(self.gain, lambda gain: shown_gain(gain, self.quantity))}"
            f" ({self.quantity.name} {self.quantity.symbol})",
            f"  displacement     {span(self.displacement)}{size}, {self.displacement.shape}",
            f"  spectral radius  {span(self.spectral_radius)}",
            f"  method           {in_words(self.method)}",
            f"  wall time        {wall_time(self, self.speed.size, 'lane')}",
            *doubts(self.error, OrbitStatus, self.status_code, "lanes"),
        ]
        return "\n".join(lines)

    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """The displacement over the period, lane by lane; returns the axes."""
        return by_name("plots.orbit_picture.plot_orbit")(self, ax)
