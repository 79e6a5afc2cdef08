"""The result of a sweep."""

from typing import TYPE_CHECKING, Any

import numpy as np

from lobex._by_name import by_name
from lobex._warnings import warn
from lobex.results.codes import PointStatus
from lobex.results.description import doubts, in_words, wall_time
from lobex.results.fields import Array, Codes, Coordinate, field, in_gain, in_hertz
from lobex.results.result import OfProcess
from lobex.results.units import shown_gain, shown_range, shown_speed

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lobex.results.boundary import Boundary
    from lobex.results.comparison import Comparison

# Gains, at least, of the finer grid that is asked for.
_FINER = 65


class Chart(OfProcess, form="lobex chart 4"):
    """A stability lobe diagram: the dominant Floquet multiplier over a (speed, gain) grid.

    Attributes:
        speed: (n,), Hz.
        gain: (m,), in ``quantity.unit``.
        spectral_radius: max|μ|, (n, m): stable below 1, unstable above, NaN where a point failed.
        multiplier: the dominant μ, complex, Im ≥ 0, (n, m).
        chatter_frequency: frequency that carries most of the motion, Hz, (n, m).
        error: estimated relative error of max|μ| by discretisation and rounding, (n, m): infinite where a larger
            one may have been missed, and NaN where the method gives no estimate.
        status_code: members of ``PointStatus``, (n, m).
        quantity: what the gain is.
        speed_unit: "Hz", "rpm", or "1" of a process without units, for axes.
        process, method: the model and the method, as plain dictionaries.
        seconds: wall time of the sweep, compiling included.
        compiling: the part of it in which JAX traced and compiled programs; 0 where they were there already.
    """

    speed: np.ndarray = field(Coordinate("speed", "rotational frequency", in_hertz, increasing=True))
    gain: np.ndarray = field(Coordinate("gain", lambda chart: chart.quantity.name, in_gain, increasing=True))
    spectral_radius: np.ndarray = field(Array("speed gain", "spectral radius max|μ|", "1"))
    multiplier: np.ndarray = field(Array("speed gain", "dominant Floquet multiplier μ", "1", dtype=np.complex128))
    chatter_frequency: np.ndarray = field(Array("speed gain", "chatter frequency", in_hertz))
    error: np.ndarray = field(Array("speed gain", "estimated relative error of max|μ|", "1"))
    status_code: np.ndarray = field(Codes("speed gain", "what became of the point", name="status", codes=PointStatus))
    method: dict[str, Any]

    @property
    def status(self) -> np.ndarray:
        """What became of each point, in words, (n, m): "good", "settled again" (left to the dense eigensolver, or by
        characteristic roots to an operator), "above tolerance" (its error may be more than asked for), or "failed" (it
        is NaN)."""
        return PointStatus.words_of(self.status_code)

    @property
    def failed(self) -> int:
        """Number of points that are NaN."""
        return int(np.sum(self.status_code == PointStatus.FAILED))

    def __repr__(self) -> str:
        radius = self.spectral_radius[np.isfinite(self.spectral_radius)]
        span = f"{radius.min():.6g} to {radius.max():.6g}" if radius.size else "none finite"
        lines = [
            f"Chart of {self.process['type']}: {len(self.speed)} speeds × {len(self.gain)} gains",
            f"  speed            {shown_range(*(shown_speed(s, self.speed_unit) for s in self.speed[[0, -1]]))}",
            f"  gain             {shown_range(*(shown_gain(g, self.quantity) for g in self.gain[[0, -1]]))}"
            f" ({self.quantity.name} {self.quantity.symbol})",
            f"  spectral radius  {span}",
            f"  method           {in_words(self.method)}",
            f"  wall time        {wall_time(self, self.spectral_radius.size, 'point')}",
            *doubts(self.error, PointStatus, self.status_code, "points"),
        ]
        return "\n".join(lines)

    def critical_gain(self) -> np.ndarray:
        """Smallest gain, per speed, at which the map crosses from stable to unstable, (n,).

        Linear in log max|μ| between the two grid gains around the change, so good to the grid and no
        better. NaN where the grid holds no such change, also where its lowest gain is already unstable,
        where a point that failed comes before it, or where the change lies within the first cell: nothing but the
        growth at the lowest gain is known below it, which may be anywhere beside that of the limit.

        Warns:
            LobexWarning: where limits lie within the first cell, with the finer grid to ask for.
        """
        with np.errstate(divide="ignore"):
            growth = np.log(self.spectral_radius)
        unstable = ~(growth < 0)
        first = np.argmax(unstable, axis=1)
        found = unstable.any(axis=1) & (first > 1)
        if hidden := int(np.sum(first == 1)):
            low, high = (f"{gain:.6g}" for gain in self.gain[:2])
            unit = "" if self.quantity.unit == "1" else f" {self.quantity.unit}"
            warn(
                f"at {hidden} of {len(first)} speeds the limit lies within the first cell of the grid, between {low} "
                f"and {high}{unit}, and cannot be read; sweep a finer one there, such as "
                f"np.linspace({low}, {high}, {max(len(self.gain), _FINER)})"
            )
        lane = np.arange(len(self.speed))
        above, below = growth[lane, first], growth[lane, np.maximum(first - 1, 0)]
        with np.errstate(invalid="ignore", divide="ignore"):
            # From a vanishing multiplier the change is put at the unstable point.
            share = np.where(np.isneginf(below), 1.0, -below / (above - below))
            low, high = self.gain[np.maximum(first - 1, 0)], self.gain[first]
            return np.where(found, low + share * (high - low), np.nan)

    def compare(self, cuts: Any) -> "Comparison":
        """What the chart says of cuts that were made: hits, misses, and on which side it erred.

        max|μ| at a cut is linear in its logarithm between the points of the chart, so good to the grid.

        Args:
            cuts: rows of speed in Hz, gain in ``quantity.unit``, and 1 where the cut chattered or 0, (k, 3).

        Raises:
            ValueError: for anything but such rows, and where all of them lie outside the chart.
        """
        from lobex.results.comparison import compared

        return compared(self, cuts)

    def plot(
        self, ax: "Axes | None" = None, speed_unit: str | None = None, *, boundary: "Boundary | None" = None
    ) -> "Axes":
        """A filled map of max|μ| with the stability limit drawn; returns the axes.

        The limit is drawn where it is, to about a pixel: in cells whose neighbours show that interpolation would put
        it elsewhere, or would miss a piece, points between those of the chart are computed for the picture. With a
        process of your own, which a chart cannot make again, the line is dotted there; hand in its traced boundary.

        Args:
            ax: axes to draw into; by default those of a new figure.
            speed_unit: "Hz" or "rpm", by default what the process is usually drawn in.
            boundary: ``lobex.boundary(chart)``, to draw its curves in place of the map's own line.
        """
        return by_name("plots.chart_picture.plot_chart")(self, ax, speed_unit, boundary)
