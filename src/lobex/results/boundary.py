"""The stability boundary as curves in the plane of speed and gain."""

import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lobex._by_name import by_name
from lobex.processes.quantity import Quantity, hertz
from lobex.results.codes import Kind, flags
from lobex.results.description import in_words, wall_time
from lobex.results.stored import Stored

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

FORM = "lobex boundary 2"


@dataclass(frozen=True, eq=False)
class BoundaryCurve:
    """One connected piece of the boundary, with the unstable side on the left of its direction of travel.

    Attributes:
        speed: (k,), Hz.
        gain: (k,).
        chatter_frequency: (k,), Hz.
        kind_code: members of ``Kind``, (k,).
        closed: whether it comes back to its first vertex, which is then also its last; else it ends at the
            border of the map.
    """

    speed: np.ndarray
    gain: np.ndarray
    chatter_frequency: np.ndarray
    kind_code: np.ndarray
    closed: bool

    @property
    def kind(self) -> np.ndarray:
        """ "hopf", "flip" or "fold", (k,)."""
        return np.array([Kind(code).words for code in self.kind_code], dtype=str)


@dataclass(frozen=True, eq=False, repr=False)
class Boundary:
    """The curves max|μ| = 1 within a rectangle of speeds and gains.

    What is not missed: every curve that separates two points of the map that it was traced from, and every pair of
    crossings between two grid points that the slopes beside them give away. A map whose ``waves_per_cell`` is
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

    curves: tuple[BoundaryCurve, ...]
    residual: float
    dropped: int
    unresolved: int
    waves_per_cell: float
    fastest_frequency: float
    bounds: tuple[float, float, float, float]
    quantity: Quantity
    speed_unit: str
    process: dict[str, Any]
    method: dict[str, Any]
    seconds: float
    compiling: float

    def __iter__(self) -> Iterator[BoundaryCurve]:
        return iter(self.curves)

    def __len__(self) -> int:
        return len(self.curves)

    def __repr__(self) -> str:
        closed = sum(c.closed for c in self.curves)
        lines = [
            f"Boundary of {self.process['type']}: {len(self)} curves, {closed} of them closed, "
            f"{sum(len(c.speed) for c in self)} vertices",
            f"  speed            {self.bounds[0]:.6g} to {self.bounds[1]:.6g}{hertz(self.speed_unit)}",
            f"  gain             {self.bounds[2]:.6g} to {self.bounds[3]:.6g} {self.quantity.unit}"
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
        return by_name("plots.boundary.plot_boundary")(self, ax, speed_unit)

    def to_xarray(self) -> "xarray.Dataset":
        """All vertices, one curve after the other, with the number of each one's curve: a labelled dataset."""
        import xarray

        unit = self.quantity.unit
        number = [np.full(len(c.speed), i, dtype=np.int32) for i, c in enumerate(self)]
        vertex: dict[str, tuple[list[np.ndarray], type, dict[str, Any]]] = {
            "speed": ([c.speed for c in self], float, {"long_name": "rotational frequency", "units": "Hz"}),
            "gain": ([c.gain for c in self], float, {"long_name": self.quantity.name, "units": unit}),
            "chatter_frequency": (
                [c.chatter_frequency for c in self],
                float,
                {"long_name": "chatter frequency", "units": "Hz"},
            ),
            "kind": (
                [c.kind_code for c in self],
                np.int8,
                flags("how the dominant multiplier leaves the unit circle", Kind),
            ),
            "curve": (number, np.int32, {"long_name": "number of the curve"}),
        }
        return xarray.Dataset(
            data_vars={
                **{
                    n: ("vertex", np.concatenate([*parts, np.empty(0)]).astype(d), a)
                    for n, (parts, d, a) in vertex.items()
                },
                "closed": ("curve_number", np.array([c.closed for c in self], dtype=np.int8)),
            },
            attrs={
                "format": FORM,
                "residual": self.residual,
                "dropped": self.dropped,
                "unresolved": self.unresolved,
                "waves_per_cell": self.waves_per_cell,
                "fastest_frequency": self.fastest_frequency,
                "bounds": np.asarray(self.bounds, dtype=float),
                "quantity": json.dumps(self.quantity._asdict(), ensure_ascii=False),
                "speed_unit": self.speed_unit,
                "process": json.dumps(self.process, ensure_ascii=False),
                "method": json.dumps(self.method, ensure_ascii=False),
                "seconds": self.seconds,
                "compiling": self.compiling,
            },
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the curves to a file, all at once or not at all; its ending says which: .nc (NetCDF-4), which
        ``lobex.load`` reads back, .mat (MATLAB) or .csv (one row per vertex).

        Raises:
            ValueError: for any other ending, and a place that cannot be written.
        """
        from lobex.results.saving import save_dataset

        save_dataset(self.to_xarray(), path)


def read_boundary(stored: Stored) -> Boundary:
    """The boundary that ``to_xarray`` made."""
    speed, gain, frequency = (stored.array(name, "vertex") for name in ("speed", "gain", "chatter_frequency"))
    kind = stored.flags("kind", Kind, "vertex")
    number, closed = stored.array("curve", "vertex", kind="i"), stored.array("closed", "curve_number", kind="i")
    if not np.array_equal(np.unique(number), np.arange(len(closed))):
        stored.refuse(f"has variable 'curve' that does not number the {len(closed)} curves of 'closed'")
    curves = []
    for i, ends in enumerate(closed):
        mine = number == i
        curves.append(BoundaryCurve(speed[mine], gain[mine], frequency[mine], kind[mine], bool(ends)))
    slowest, fastest, low, high = stored.numbers("bounds", 4)
    return Boundary(
        curves=tuple(curves),
        residual=stored.number("residual"),
        dropped=stored.count("dropped"),
        unresolved=stored.count("unresolved"),
        waves_per_cell=stored.number("waves_per_cell"),
        fastest_frequency=stored.number("fastest_frequency"),
        bounds=(slowest, fastest, low, high),
        quantity=stored.quantity("quantity"),
        speed_unit=stored.unit("speed_unit"),
        process=stored.description("process"),
        method=stored.description("method"),
        seconds=stored.number("seconds"),
        compiling=stored.number("compiling"),
    )
