"""The result of a march of a delayed process."""

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lobex._by_name import by_name
from lobex.processes.quantity import Quantity, hertz
from lobex.results.description import wall_time

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class March:
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
            where there are too few periods (below 2) or no motion.
        growth_error: estimated error of |multiplier| that the fit leaves, (*lanes,); it falls with more periods.
        steps_per_period: steps per period.
        quantity: what the gain is.
        speed_unit: "Hz", "rpm", or "1" of a process without units, for legends.
        process: the model, as a plain dictionary.
        seconds: wall time, compiling included.
        compiling: the part of it in which JAX traced and compiled programs; 0 where they were there already.
    """

    speed: np.ndarray
    gain: np.ndarray
    delay: np.ndarray
    phase: np.ndarray
    displacement: np.ndarray
    state: np.ndarray
    multiplier: np.ndarray
    growth_error: np.ndarray
    steps_per_period: int
    quantity: Quantity
    speed_unit: str
    process: dict[str, Any]
    seconds: float
    compiling: float

    @property
    def growth(self) -> np.ndarray:
        """The factor per period by which the motion grows (above 1) or dies out, (*lanes,)."""
        return np.abs(self.multiplier)

    @property
    def time(self) -> np.ndarray:
        """The times of the samples, s, (*lanes, samples)."""
        return self.delay[..., None] * self.phase

    def __repr__(self) -> str:
        unit, steps = self.quantity.unit, self.delay / self.steps_per_period
        lines = [
            f"March of {self.process['type']}: {self.speed.size} lanes, {self.phase[-1]:.0f} periods of "
            f"{self.steps_per_period} steps",
            f"  speed            {span(self.speed)}{hertz(self.speed_unit)}",
            f"  gain             {span(self.gain)} {unit} ({self.quantity.name} {self.quantity.symbol})",
            f"  time step        {span(steps)} s",
            f"  growth           {span(self.growth)} per period, fitted to {_worst(self.growth_error)}",
            f"  displacement     {self.displacement.shape}, {self.displacement.nbytes / 1e6:.3g} MB",
            f"  wall time        {wall_time(self, self.speed.size, 'lane')}",
            f"  failed           {int(np.isnan(self.state).any(axis=-1).sum())} lanes",
        ]
        return "\n".join(lines)

    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """The displacement over revolutions or tooth passes, lane by lane as in Fig. 4.13; returns the axes."""
        return by_name("plots.march.plot_march")(self, ax)

    def to_xarray(self) -> "xarray.Dataset":
        """The march as a labelled dataset, the lanes as one dimension, with units and the model in its attributes."""
        from lobex.results.march_file import march_to_dataset

        return march_to_dataset(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the march to a file, all at once or not at all; its ending says which: .nc (NetCDF-4), which
        ``lobex.load`` reads back, .mat (MATLAB) or .csv (one row per lane and sample).

        Raises:
            ValueError: for any other ending, and a place that cannot be written.
        """
        from lobex.results.saving import save_dataset

        save_dataset(self.to_xarray(), path)


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
