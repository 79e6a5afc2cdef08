"""The result of a sensitivity analysis: a labelled table."""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lobex._by_name import by_name
from lobex.results.limit import Limit
from lobex.results.stored import Stored
from lobex.results.units import shown_gain, shown_speed

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

    from lobex.results.band import Band

Array = Any

FORM = "lobex sensitivities 2"
_MOST_COLUMNS = 5
_MOST_ROWS = 24


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivities:
    """How the stability limit K moves with every number p of the model, at each speed.

    Attributes:
        names: of the p numbers, such as "modes.damping_ratio[0]"; "speed" is the last.
        value: their values, (n, p), in SI units.
        derivative: dK/dp, (n, p); NaN where there is no limit.
        limit: the limit, over the n speeds.
    """

    names: tuple[str, ...]
    value: np.ndarray
    derivative: np.ndarray
    limit: Limit

    @property
    def logarithmic(self) -> np.ndarray:
        """d ln K / d ln p, (n, p): percent of limit per percent of p. Zero for a p of 0, NaN for a limit of 0."""
        gain = np.asarray(self.limit.gain)[:, None]
        return self.derivative * self.value / np.where(gain == 0, np.nan, gain)

    def __getitem__(self, name: str) -> np.ndarray:
        """d ln K / d ln p of one number, by its name, (n,)."""
        if name not in self.names:
            raise KeyError(f"{name!r} is none of the numbers {', '.join(self.names)}")
        return self.logarithmic[:, self.names.index(name)]

    def band(self, relative_standard_deviation: Mapping[str, float]) -> "Band":
        """The first-order uncertainty of the limit for uncertain numbers; see ``Limit.band``."""
        from lobex.results.propagation import band

        return band(self, relative_standard_deviation)

    def largest(self, count: int) -> list[int]:
        """Indices of the numbers that matter most, by their largest |d ln K / d ln p|, in falling order."""
        size = np.max(np.abs(np.nan_to_num(self.logarithmic)), axis=0)
        return np.argsort(-size, kind="stable")[:count].tolist()

    def __repr__(self) -> str:
        limit, table = self.limit, self.logarithmic
        shown = np.unique(np.linspace(0, len(limit.speed) - 1, _MOST_COLUMNS).round().astype(int))
        speeds, gains = limit.speed[shown], np.asarray(limit.gain)[shown]
        rows = sorted(self.largest(_MOST_ROWS))
        wide = max(len(self.names[i]) for i in rows)
        head = f"Sensitivities of the limit of {limit.process['type']}: {len(limit.speed)} speeds × {len(self.names)}"
        lines = [
            f"{head} numbers, d ln {limit.quantity.symbol} / d ln p",
            _row(_in("speed", limit.speed_unit), wide, (_number(shown_speed(s, limit.speed_unit)) for s in speeds)),
            _row(
                _in("limit", limit.quantity.display_unit), wide, (_number(shown_gain(g, limit.quantity)) for g in gains)
            ),
            *(
                _row(
                    self.names[i],
                    wide,
                    (f"{table[j, i]:+.4f}".lstrip("+" if np.isnan(table[j, i]) else "") for j in shown),
                )
                for i in rows
            ),
        ]
        rest = len(self.names) - len(rows)
        return "\n".join([*lines, f"  … and {rest} smaller ones"] if rest else lines)

    def plot(self, ax: "Axes | None" = None, speed_unit: str | None = None) -> "Axes":
        """The largest sensitivities over speed, or as bars for a single speed; returns the axes."""
        return by_name("plots.sensitivities.plot_sensitivities")(self, ax, speed_unit)

    def to_xarray(self) -> "xarray.Dataset":
        """The table over the coordinates speed and parameter, with the limit's own variables beside it."""
        axes = ("speed", "parameter")
        dataset = self.limit.to_xarray()
        unit = self.limit.quantity.unit
        names = {
            "logarithmic": (self.logarithmic, {"long_name": "d ln K / d ln p", "units": "1"}),
            "derivative": (self.derivative, {"long_name": f"dK/dp, in {unit} per unit of p"}),
            "value": (self.value, {"long_name": "value of p, in SI units"}),
        }
        dataset = dataset.assign({name: (axes, values, notes) for name, (values, notes) in names.items()})
        dataset.attrs.update(format=FORM, parameters=json.dumps(self.names))
        return dataset.assign_coords(parameter=("parameter", list(self.names)))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the table and its limit to a file, all at once or not at all; its ending says which: .nc (NetCDF-4),
        which ``lobex.load`` reads back, .mat (MATLAB) or .csv (one row per speed and number).

        Raises:
            ValueError: for any other ending, and a place that cannot be written.
        """
        from lobex.results.saving import save_dataset

        save_dataset(self.to_xarray(), path)


def read_sensitivities(stored: Stored, limit: Limit) -> Sensitivities:
    """The table that ``to_xarray`` made, and whose limit has been read."""
    axes = ("speed", "parameter")
    names = stored.names("parameters")
    if tuple(stored.array("parameter", "parameter", kind="U")) != names:
        stored.refuse("has variable 'parameter' with other names than attribute 'parameters'")
    # A product of the others, for who reads the file with another program.
    stored.array("logarithmic", *axes)
    return Sensitivities(names, stored.array("value", *axes), stored.array("derivative", *axes), limit)


def _row(name: str, wide: int, cells: Any) -> str:
    return f"  {name:<{max(wide, 16)}}" + "".join(f"{cell:>13}" for cell in cells)


def _in(what: str, unit: str) -> str:
    return what if unit == "1" else f"{what} ({unit})"


def _number(shown: str) -> str:
    return shown.partition(" ")[0]
