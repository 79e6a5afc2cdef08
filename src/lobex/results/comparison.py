"""A chart held against cuts that were made: what it said of each, and on which side it erred."""

from typing import TYPE_CHECKING, Any

import numpy as np

from lobex import _checks
from lobex._by_name import by_name
from lobex.processes.quantity import Quantity
from lobex.results.codes import Outcome
from lobex.results.fields import Array, Attribute, Codes, Coordinate, field, in_gain, in_hertz
from lobex.results.result import Result
from lobex.results.stored import Stored

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lobex.results.chart import Chart

_HITS = (Outcome.QUIET_AS_SAID, Outcome.CHATTER_AS_SAID)


class Comparison(Result, form="lobex comparison 1"):
    """Cuts that were made, and what a chart says of them.

    Attributes:
        speed: (k,), Hz.
        gain: (k,), in ``quantity.unit``.
        chattered: whether each did, (k,).
        spectral_radius: what the chart has there, (k,); NaN outside it and beside points that failed.
        outcome_code: members of ``Outcome``, (k,).
        quantity: what the gain is.
        speed_unit: "Hz", "rpm", or "1" of a process without units, for axes.
        process, method: those of the chart, as plain dictionaries.
    """

    speed: np.ndarray = field(Coordinate("cut", "rotational frequency", in_hertz))
    gain: np.ndarray = field(Coordinate("cut", lambda found: found.quantity.name, in_gain))
    chattered: np.ndarray = field(Array("cut", "whether the cut chattered", dtype=np.int8))
    spectral_radius: np.ndarray = field(Array("cut", "spectral radius max|μ|", "1"))
    outcome_code: np.ndarray = field(Codes("cut", "what the chart said of the cut", name="outcome", codes=Outcome))
    quantity: Quantity
    speed_unit: str = field(Attribute(Stored.unit))
    process: dict[str, Any]
    method: dict[str, Any]

    @property
    def outcome(self) -> np.ndarray:
        """What became of each, in words, (k,): "quiet as said", "chatter as said", "chatter below the limit" (the chart
        has it stable: the dangerous side), "quiet above the limit", or "outside the chart"."""
        return Outcome.words_of(self.outcome_code)

    @property
    def hits(self) -> int:
        """Cuts that the chart was right about."""
        return int(np.sum(np.isin(self.outcome_code, _HITS)))

    @property
    def misses(self) -> int:
        """Cuts that it was wrong about, on either side."""
        return int(np.sum(self.outcome_code != Outcome.OUTSIDE_THE_CHART)) - self.hits

    @property
    def score(self) -> float:
        """The share of hits; NaN where all cuts lie outside."""
        return self.hits / (self.hits + self.misses) if self.hits + self.misses else np.nan

    def __repr__(self) -> str:
        lines = [f"Comparison with {len(self.speed)} cuts: {self.hits} hits, {self.misses} misses"]
        lines += [f"  {code.words:<24} {np.sum(self.outcome_code == code)}" for code in Outcome]
        return "\n".join(lines)

    def plot(self, ax: "Axes | None" = None, speed_unit: str | None = None) -> "Axes":
        """The cuts, crosses where they chattered, in the colour of hits and of misses on either side; returns the axes.

        Args:
            ax: axes to draw over, such as those of ``chart.plot()``.
            speed_unit: "Hz" or "rpm", by default what the process is usually drawn in.
        """
        return by_name("plots.advice_pictures.plot_comparison")(self, ax, speed_unit)


def compared(chart: "Chart", cuts: Any) -> Comparison:
    """What ``Chart.compare`` does."""
    numbers = _checks.as_numbers("cuts", cuts)
    if numbers is None or numbers.ndim != 2 or numbers.shape[1] != 3 or not len(numbers):
        raise ValueError(
            f"cuts = {_checks.brief(cuts)} must be rows of speed in Hz, gain in {chart.quantity.unit}, and 1 where the "
            "cut chattered or 0"
        )
    speed, gain, told = numbers.T
    if not np.isin(told, (0, 1)).all():
        raise ValueError(
            f"cuts say {told[~np.isin(told, (0, 1))][0]:.6g} of chatter; give 1 where a cut chattered or 0"
        )
    radius = _between(chart, speed, gain)
    if np.isnan(radius).all():
        raise ValueError(
            f"cuts lie outside the chart, from speed = {speed.min():.6g} and gain = {gain.min():.6g} on; speeds are "
            f"revolutions per second, rpm/60, and gains in {chart.quantity.unit}"
        )
    chattered = told == 1
    outcome = np.where(
        radius < 1,
        np.where(chattered, Outcome.CHATTER_BELOW_THE_LIMIT, Outcome.QUIET_AS_SAID),
        np.where(chattered, Outcome.CHATTER_AS_SAID, Outcome.QUIET_ABOVE_THE_LIMIT),
    )
    outcome = np.where(np.isnan(radius), Outcome.OUTSIDE_THE_CHART, outcome).astype(np.int8)
    return Comparison(
        speed,
        gain,
        chattered.astype(np.int8),
        radius,
        outcome,
        chart.quantity,
        chart.speed_unit,
        chart.process,
        chart.method,
    )


def _between(chart: "Chart", speed: np.ndarray, gain: np.ndarray) -> np.ndarray:
    """max|μ| at points, linear in its logarithm between those of the chart, NaN outside."""
    from scipy.interpolate import RegularGridInterpolator

    tiny = np.log(np.finfo(float).tiny)
    with np.errstate(divide="ignore"):
        growth = np.maximum(np.log(chart.spectral_radius), tiny)
    if min(growth.shape) < 2:
        raise ValueError(
            f"the chart has {growth.shape} points; cuts are compared with two speeds and two gains or more"
        )
    between = RegularGridInterpolator((chart.speed, chart.gain), growth, bounds_error=False, fill_value=np.nan)
    return np.exp(between(np.stack([speed, gain], axis=1)))
