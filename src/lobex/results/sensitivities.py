"""The result of a sensitivity analysis: a labelled table."""

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from lobex._by_name import by_name
from lobex.results.fields import Array, Parts, Whole, derived, field
from lobex.results.limit import Limit
from lobex.results.result import Result
from lobex.results.stored import Stored
from lobex.results.units import shown_gain, shown_speed

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lobex.results.band import Band

_MOST_COLUMNS = 5
_MOST_ROWS = 24


class _Labels:
    """Text that tells the places of a dimension apart."""

    def write(self, name: str, value: tuple[str, ...], result: Any, into: Parts) -> None:
        into.coordinates["parameter"] = ("parameter",), np.asarray(value, dtype=str), {}
        into.attributes["parameters"] = json.dumps(value)

    def read(self, name: str, stored: Stored) -> tuple[str, ...]:
        names = stored.names("parameters")
        if tuple(stored.array("parameter", "parameter", kind="U")) != names:
            stored.refuse("has variable 'parameter' with other names than attribute 'parameters'")
        return names


class Sensitivities(Result, form="lobex sensitivities 2"):
    """How the stability limit K moves with every number p of the model, at each speed.

    Attributes:
        names: of the p numbers, such as "modes.damping_ratio[0]"; "speed" is the last.
        value: their values, (n, p), in SI units.
        derivative: dK/dp, (n, p); NaN where there is no limit.
        limit: the limit, over the n speeds.
    """

    names: tuple[str, ...] = field(_Labels())
    value: np.ndarray = field(Array("speed parameter", "value of p, in SI units"))
    derivative: np.ndarray = field(
        Array("speed parameter", lambda table: f"dK/dp, in {table.limit.quantity.unit} per unit of p")
    )
    limit: Limit = field(Whole(Limit))

    @property
    @derived(Array("speed parameter", "d ln K / d ln p", "1"), after="names")
    def logarithmic(self) -> np.ndarray:
        """d ln K / d ln p, (n, p): percent of limit per percent of p. Zero for a p of 0, NaN for a limit of 0."""
        gain = np.asarray(self.limit.gain)[:, None]
        return self.derivative * self.value / np.where(gain == 0, np.nan, gain)

    def __getitem__(self, name: str) -> np.ndarray:
        """d ln K / d ln p of one number, by its name, (n,)."""
        if name not in self.names:
            raise KeyError(f"{name!r} is none of the numbers {', '.join(self.names)}")
        return self.logarithmic[:, self.names.index(name)]

    def band(self, relative_standard_deviation: Mapping[str, float], correlation: Any = None) -> "Band":
        """The first-order uncertainty of the limit for uncertain numbers; see ``Limit.band``."""
        from lobex.results.propagation import band

        return band(self, relative_standard_deviation, correlation)

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
        return by_name("plots.sensitivities_picture.plot_sensitivities")(self, ax, speed_unit)


def _row(name: str, wide: int, cells: Any) -> str:
    return f"  {name:<{max(wide, 16)}}" + "".join(f"{cell:>13}" for cell in cells)


def _in(what: str, unit: str) -> str:
    return what if unit == "1" else f"{what} ({unit})"


def _number(shown: str) -> str:
    return shown.partition(" ")[0]
