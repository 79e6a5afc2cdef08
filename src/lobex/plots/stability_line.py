"""The line max|μ| = 1 of a chart, as far as it is known."""

import itertools
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from contourpy import LineType, contour_generator
from matplotlib.collections import LineCollection

from lobex.grids.finer import LEAST, doubtful, finer

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lobex.results.boundary import Boundary
    from lobex.results.chart import Chart

LINE: dict[str, Any] = {"color": "black", "linewidth": 1.3}
PIXELS = (840.0, 540.0)
"""Within the axes of a picture of the usual size, at 150 dots per inch."""

# A line of fewer pixels each way, on a map that is fine already, is what is left of a tongue's end.
_SPECK = 3
# Where a grid cannot be made finer, its line is dotted if it may be off by one part of so many of a cell.
_ROUGH = 3.0
# Where there is no damping max|μ| is 1 but for rounding, and no line.
_ROUNDING = 1e-9


class Map(NamedTuple):
    """log max|μ| over a grid; which cells, one fewer each way, cannot tell where it is zero; and whether the grid is
    finer than the chart's."""

    speed: np.ndarray
    gain: np.ndarray
    growth: np.ndarray
    doubtful: np.ndarray
    refined: bool


def map_of(chart: "Chart", refine: bool) -> Map:
    """The chart's growth, made finer where its grid cannot tell the line, if that is asked for and can be done."""
    with np.errstate(divide="ignore"):
        growth = np.maximum(np.log(chart.spectral_radius), LEAST)
    size = max(pixels / (count - 1) for pixels, count in zip(PIXELS, growth.shape, strict=True))
    cells = doubtful(chart.speed, chart.gain, growth, size)
    own = Map(chart.speed, chart.gain, growth, cells, False)
    if not refine or size <= 1 or not cells.any():
        return own._replace(doubtful=np.zeros_like(cells))
    # What computes is imported where something is to be computed.
    from lobex.grids.again import sampler

    try:
        sample = sampler(chart)
    except ValueError:
        return own._replace(doubtful=doubtful(chart.speed, chart.gain, growth, _ROUGH))
    speed, gain, growth = finer(chart.speed, chart.gain, growth, sample, PIXELS)
    return Map(speed, gain, growth, np.zeros((len(speed) - 1, len(gain) - 1), dtype=bool), True)


def draw_line(ax: "Axes", scale: tuple[float, float], drawn: Map, boundary: "Boundary | None") -> bool:
    """A traced boundary, or the map's own line, dotted in cells that are in doubt; whether any of it is dotted.

    ``scale`` takes speed and gain to the units of the axes.
    """
    pieces: dict[str, list[np.ndarray]] = {"-": [], ":": []}
    if boundary is not None:
        pieces["-"] = [np.column_stack([curve.speed, curve.gain]) for curve in boundary]
    else:
        for line in _lines(drawn):
            unsure = _in_doubt(drawn, (line[1:] + line[:-1]) / 2)
            turns = (np.flatnonzero(np.diff(unsure)) + 1).tolist()
            for begin, end in itertools.pairwise([0, *turns, len(unsure)]):
                pieces[":" if unsure[begin] else "-"].append(line[begin : end + 1])
    for style, lines in pieces.items():
        scaled = [line * scale for line in lines]
        ax.add_collection(LineCollection(scaled, colors="black", linewidths=LINE["linewidth"], linestyles=style))
    return bool(pieces[":"])


def _lines(drawn: Map) -> list[np.ndarray]:
    growth = np.ma.masked_invalid(drawn.growth.T)
    made = contour_generator(drawn.speed, drawn.gain, growth, name="serial", line_type=LineType.Separate)
    lines = [np.asarray(line, dtype=float) for line in made.lines(_ROUNDING)]
    extent = np.array([np.ptp(drawn.speed), np.ptp(drawn.gain)])
    least = _SPECK * extent / PIXELS if drawn.refined else np.zeros(2)
    return [line for line in lines if np.any(np.ptp(line, axis=0) >= least)]


def _in_doubt(drawn: Map, place: np.ndarray) -> np.ndarray:
    axes = (drawn.speed, drawn.gain)
    index = [np.clip(np.searchsorted(axis, place[:, k]) - 1, 0, len(axis) - 2) for k, axis in enumerate(axes)]
    return drawn.doubtful[index[0], index[1]]
