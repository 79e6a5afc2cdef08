"""The stability boundary as curves in the plane of speed and gain."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from lobex._by_name import by_name
from lobex.processes.quantity import hertz
from lobex.results.codes import Kind
from lobex.results.description import in_words, wall_time
from lobex.results.fields import Array, Attribute, Codes, Fields, Parts, declared_of, field, in_gain, in_hertz
from lobex.results.result import OfProcess
from lobex.results.stored import Stored
from lobex.results.units import shown_gain, shown_range, shown_speed

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class BoundaryCurve(Fields):
    """One connected piece of the boundary, with the unstable side on the left of its direction of travel.

    Attributes:
        speed: (k,), Hz.
        gain: (k,).
        chatter_frequency: (k,), Hz.
        kind_code: members of ``Kind``, (k,).
        closed: whether it comes back to its first vertex, which is then also its last; else it ends at the
            border of the map.
    """

    speed: np.ndarray = field(Array("vertex", "rotational frequency", in_hertz))
    gain: np.ndarray = field(Array("vertex", lambda boundary: boundary.quantity.name, in_gain))
    chatter_frequency: np.ndarray = field(Array("vertex", "chatter frequency", in_hertz))
    kind_code: np.ndarray = field(
        Codes("vertex", "how the dominant multiplier leaves the unit circle", name="kind", codes=Kind)
    )
    closed: bool = field(Array("curve_number", dtype=np.int8))

    @property
    def kind(self) -> np.ndarray:
        """ "hopf", "flip" or "fold", (k,)."""
        return Kind.words_of(self.kind_code)


class _Curves:
    """Curves as all their vertices, one curve after the other, with the number of each one's curve."""

    number = Array("vertex", "number of the curve", dtype=np.int32)

    def write(self, name: str, value: "tuple[BoundaryCurve, ...]", result: Any, into: Parts) -> None:
        for part, declared in declared_of(BoundaryCurve).items():
            values = [np.atleast_1d(getattr(curve, part)) for curve in value]
            declared.write(part, np.concatenate([np.empty(0), *values]), result, into)
        sizes = np.array([len(curve.speed) for curve in value], dtype=int)
        self.number.write("curve", np.repeat(np.arange(len(sizes)), sizes), result, into)

    def read(self, name: str, stored: Stored) -> "tuple[BoundaryCurve, ...]":
        parts = {part: declared.read(part, stored) for part, declared in declared_of(BoundaryCurve).items()}
        number, closed = self.number.read("curve", stored), parts.pop("closed")
        if not np.array_equal(np.unique(number), np.arange(len(closed))):
            stored.refuse(f"has variable 'curve' that does not number the {len(closed)} curves of 'closed'")
        return tuple(
            BoundaryCurve(**{part: values[number == i] for part, values in parts.items()}, closed=bool(ends))
            for i, ends in enumerate(closed)
        )


class Boundary(OfProcess, form="lobex boundary 2"):
    """The curves max|μ| = 1 within a rectangle of speeds and gains.

    What is not missed: every curve that separates two points of the map that it was traced from, and every pair of
    changes between two grid points that the slopes beside them give away. A map whose ``waves_per_cell`` is
    1/4 or less has four columns or more in every lobe of the fastest mode that can chatter. An island that
    lies within one cell, without a sign in the slopes around it, is missed: trace from a finer map.

    Attributes:
        curves: ``BoundaryCurve``s, longest first.
        residual: largest |log max|μ|| at a vertex, each looked at once more after polishing.
        dropped: vertices that could not be polished to 1e-8, and were left out.
        unresolved: chords in whose middle no curve to lead along was found: they cut a sharp corner between two
            multipliers, or join two curves that meet within one cell of the map.
        waves_per_cell: the largest part of a lobe, of the fastest mode that can chatter, between two speeds.
        fastest_frequency: natural frequency of that mode, Hz.
        bounds: lowest and highest speed (Hz), lowest and highest gain.
        quantity: what the gain is.
        speed_unit: "Hz", "rpm", or "1" of a process without units, for axes.
        process, method: the model and the method, as plain dictionaries.
        seconds: wall time, compiling and the map included.
        compiling: the part of it in which JAX traced and compiled programs; 0 where they were there already.
    """

    curves: tuple[BoundaryCurve, ...] = field(_Curves())
    residual: float
    dropped: int
    unresolved: int
    waves_per_cell: float
    fastest_frequency: float
    bounds: tuple[float, float, float, float] = field(Attribute(lambda stored, name: stored.numbers(name, 4)))
    method: dict[str, Any]

    def __iter__(self) -> Iterator[BoundaryCurve]:
        return iter(self.curves)

    def __len__(self) -> int:
        return len(self.curves)

    def __repr__(self) -> str:
        closed = sum(c.closed for c in self.curves)
        lines = [
            f"Boundary of {self.process['type']}: {len(self)} curves, {closed} of them closed, "
            f"{sum(len(c.speed) for c in self)} vertices",
            f"  speed            {shown_range(*(shown_speed(end, self.speed_unit) for end in self.bounds[:2]))}",
            f"  gain             {shown_range(*(shown_gain(end, self.quantity) for end in self.bounds[2:]))}"
            f" ({self.quantity.name} {self.quantity.symbol})",
            f"  residual         |log max|μ|| ≤ {self.residual:.1e}, {self.dropped} vertices dropped, "
            f"{self.unresolved} chords unresolved",
            f"  resolution       {self.waves_per_cell:.3g} waves per cell of the mode at "
            f"{self.fastest_frequency:.6g}{hertz(self.speed_unit)}",
            f"  method           {in_words(self.method)}",
            f"  wall time        {wall_time(self, sum(len(c.speed) for c in self), 'vertex')}",
        ]
        return "\n".join(lines)

    def plot(self, ax: "Axes | None" = None, speed_unit: str | None = None) -> "Axes":
        """The curves, their kinds by colour and dash, with ticks on the unstable side; returns the axes."""
        return by_name("plots.boundary_picture.plot_boundary")(self, ax, speed_unit)
