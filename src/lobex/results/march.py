"""The result of a march of a delayed process."""

from typing import TYPE_CHECKING, Any

import numpy as np

from lobex._by_name import by_name
from lobex.results.description import wall_time
from lobex.results.fields import Array, Coordinate, field, in_gain, in_hertz
from lobex.results.result import OfProcess
from lobex.results.units import shown_gain, shown_span, shown_speed

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def displacement_unit(result: Any) -> str:
    """Metres where the structure has modes."""
    return "m" if "modes" in result.process else "1"


class March(OfProcess, form="lobex march 2"):
    """A motion in time, lane by lane; lanes have the broadcast shape of speed and gain.

    Attributes:
        speed: (*lanes,), Hz.
        gain: (*lanes,), in ``quantity.unit``.
        delay: the period T, which is τ where there is one delay, (*lanes,), s.
        phase: t/T of the samples, (samples,), from 0 to the number of periods.
        displacement: y at the samples, (*lanes, samples, r), m where the structure has modes; NaN once a lane has
            grown beyond floating point.
        state: z at the end, (*lanes, d).
        multiplier: the dominant Floquet multiplier, Im ≥ 0, fitted to the last periods, complex, (*lanes,). NaN
            where there are too few periods (below 2) or no motion, or a forced one has come to its orbit.
        growth_error: estimated error of |multiplier| that the fit leaves, (*lanes,); it falls with more periods.
        steps_per_period: steps per period.
        quantity: what the gain is.
        speed_unit: "Hz", "rpm", or "1" of a process without units, for legends.
        process: the model, as a plain dictionary.
        seconds: wall time, compiling included.
        compiling: the part of it in which JAX traced and compiled programs; 0 where they were there already.
    """

    speed: np.ndarray = field(Coordinate("*lane", "rotational frequency", in_hertz))
    gain: np.ndarray = field(Coordinate("*lane", lambda march: march.quantity.name, in_gain))
    delay: np.ndarray = field(Coordinate("*lane", "delay, which is the period", "s"))
    phase: np.ndarray = field(Coordinate("phase", "time in delays", "1", increasing=True))
    displacement: np.ndarray = field(Array("*lane phase output", "displacement at the contact", displacement_unit))
    state: np.ndarray = field(Array("*lane component", "state at the end"))
    multiplier: np.ndarray = field(Array("*lane", "fitted multiplier μ", "1", dtype=np.complex128))
    growth_error: np.ndarray = field(Array("*lane", "estimated error of the fitted |μ|", "1"))
    steps_per_period: int

    @property
    def growth(self) -> np.ndarray:
        """The factor per period by which the motion grows (above 1) or dies out, (*lanes,)."""
        return np.abs(self.multiplier)

    @property
    def time(self) -> np.ndarray:
        """The times of the samples, s, (*lanes, samples)."""
        return self.delay[..., None] * self.phase

    def __repr__(self) -> str:
        steps = self.delay / self.steps_per_period
        lines = [
            f"March of {self.process['type']}: {self.speed.size} lanes, {self.phase[-1]:.0f} periods of "
            f"{self.steps_per_period} steps",
            f"  speed            {shown_span(self.speed, lambda speed: shown_speed(speed, self.speed_unit))}",
            f"  gain             {shown_span(self.gain, lambda gain: shown_gain(gain, self.quantity))}"
            f" ({self.quantity.name} {self.quantity.symbol})",
            f"  time step        {span(steps)} s",
            f"  growth           {span(self.growth)} per period, fitted to {_worst(self.growth_error)}",
            f"  displacement     {self.displacement.shape}, {self.displacement.nbytes / 1e6:.3g} MB",
            f"  wall time        {wall_time(self, self.speed.size, 'lane')}",
            f"  failed           {int(np.isnan(self.state).any(axis=-1).sum())} lanes",
        ]
        return "\n".join(lines)

    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """The displacement over revolutions or tooth passes, lane by lane as in Fig. 4.13; returns the axes."""
        return by_name("plots.march_picture.plot_march")(self, ax)


def span(numbers: np.ndarray) -> str:
    """The range of the finite numbers, as text."""
    finite = numbers[np.isfinite(numbers)]
    if finite.size == 0:
        return "none finite"
    low, high = f"{finite.min():.6g}", f"{finite.max():.6g}"
    return low if low == high else f"{low} to {high}"


def _worst(errors: np.ndarray) -> str:
    finite = errors[np.isfinite(errors)]
    return f"{finite.max():.1e}" if finite.size else "nothing"
