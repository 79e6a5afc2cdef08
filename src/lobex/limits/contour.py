"""Contour lines of a map of growth: found, and turned into lines of points on the curve itself."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from contourpy import LineType, contour_generator

from lobex._hidden import hidden_sign_changes
from lobex.limits.contour_vertices import Evaluation, along_edge, along_gradient

# A chord that is off its curve by more than this, in cells, gets a vertex in its middle, in so many rounds.
_CHORD = 0.01
# A chord whose curve is farther away than this part of its length does not lead along that curve.
_SAG = 0.25
_ROUNDS = 4
_HIDDEN_ROUNDS = 3
_POLISHED = 1e-8


class GrowthMap(NamedTuple):
    """log max|μ| over a grid: speeds (n,), gains (m,), growth (n, m) with NaN where a point failed."""

    speed: np.ndarray
    gain: np.ndarray
    growth: np.ndarray


class Line(NamedTuple):
    """An ordered polyline, (k, 2) as speed and gain, higher growth on its left; a closed one ends where it began."""

    place: np.ndarray
    closed: bool


def contours(grid: GrowthMap) -> list[Line]:
    """The lines of growth 0 of a map, by linear interpolation on its grid lines."""
    growth = np.ma.masked_invalid(grid.growth.T)
    made = contour_generator(grid.speed, grid.gain, growth, name="serial", line_type=LineType.Separate)
    lines = [np.asarray(line, dtype=float) for line in made.lines(0.0)]
    return [Line(line, bool(np.all(line[0] == line[-1]))) for line in lines if len(line) > 1]


def with_hidden_lines(grid: GrowthMap, sample: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> GrowthMap:
    """The map with grid lines added through pairs of sign changes that hide between two grid points."""
    for _ in range(_HIDDEN_ROUNDS):
        speeds = np.union1d(grid.speed, _hidden(grid.speed, grid.gain, grid.growth.T, sample))
        gains = np.union1d(grid.gain, _hidden(grid.gain, grid.speed, grid.growth, lambda g, s: sample(s, g)))
        if len(speeds) == len(grid.speed) and len(gains) == len(grid.gain):
            break
        grid = _with_lines(grid, speeds, gains, sample)
    return grid


def _hidden(
    axis: np.ndarray, other: np.ndarray, growth: np.ndarray, sample: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> np.ndarray:
    """Places on ``axis``, at most one per cell, of hidden sign changes along it that a sample confirms.

    ``growth`` has the shape of (other, axis), and ``sample`` takes places on the axis first.
    """
    lane = np.repeat(np.arange(len(other)), len(axis))
    cell, place = hidden_sign_changes(lane, np.tile(axis, len(other)), growth.ravel())
    if not cell.size:
        return place
    found, beside = sample(place, other[lane[cell]]), growth.ravel()[cell]
    there = found * np.sign(beside) < 0
    place, depth = place[there], np.abs(found[there])
    order = np.argsort(-depth)
    _, first = np.unique(np.searchsorted(axis, place[order]), return_index=True)
    return place[order][first]


def doubled(grid: GrowthMap, places: np.ndarray, sample: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> GrowthMap:
    """The map with grid lines added through the middles of the cells in which ``places``, (p, 2), lie."""
    speed, gain = (_middles(axis, places[:, k]) for k, axis in enumerate((grid.speed, grid.gain)))
    return _with_lines(grid, speed, gain, sample)


def _middles(axis: np.ndarray, place: np.ndarray) -> np.ndarray:
    lower = np.unique(_lower(axis, place))
    return (axis[lower] + axis[lower + 1]) / 2


def _with_lines(
    grid: GrowthMap, speed: np.ndarray, gain: np.ndarray, sample: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> GrowthMap:
    speeds, gains = np.union1d(grid.speed, speed), np.union1d(grid.gain, gain)
    growth = np.full((len(speeds), len(gains)), np.inf)
    growth[np.ix_(np.searchsorted(speeds, grid.speed), np.searchsorted(gains, grid.gain))] = grid.growth
    wanted = np.nonzero(np.isposinf(growth))
    growth[wanted] = sample(speeds[wanted[0]], gains[wanted[1]])
    return GrowthMap(speeds, gains, growth)


class Traced(NamedTuple):
    """The vertices of all lines, one line after the other: places (p, 2), growth left and number of the line, (p,)."""

    place: np.ndarray
    growth: np.ndarray
    number: np.ndarray


def on_curve(grid: GrowthMap, lines: list[Line], evaluate: Evaluation) -> Traced:
    """The lines with all vertices moved onto the curve."""
    number = np.repeat(np.arange(len(lines)), [len(line.place) for line in lines])
    if not lines:
        return Traced(np.empty((0, 2)), np.empty(0), number)
    place, growth = _polished(grid, np.concatenate([line.place for line in lines]), evaluate)
    for i in (i for i, line in enumerate(lines) if line.closed):
        first, last = np.flatnonzero(number == i)[[0, -1]]
        place[last], growth[last] = place[first], growth[first]
    return Traced(place, growth, number)


def refined(grid: GrowthMap, traced: Traced, evaluate: Evaluation, rounds: int = _ROUNDS) -> tuple[Traced, np.ndarray]:
    """More vertices where chords leave the curve; and the middles of chords that do not lead along it, (q, 2)."""
    place, growth, number = traced
    fresh, lost = np.ones(len(place), dtype=bool), np.empty((0, 2))
    for _ in range(rounds):
        first = np.flatnonzero((number[1:] == number[:-1]) & (fresh[1:] | fresh[:-1]))
        first = first[(growth[first] <= _POLISHED) & (growth[first + 1] <= _POLISHED)]
        if not first.size:
            break
        chord = (place[first] + place[first + 1]) / 2
        cell = _cell(grid, chord)
        ahead = (place[first + 1] - place[first]) / cell
        found = along_gradient(evaluate, chord, cell)
        gap = np.linalg.norm((found.place - chord) / cell, axis=1)
        # On the curve's other side, across a thin tongue, the growth rises to the right of the chord.
        left = ahead[:, 0] * found.uphill[:, 1] - ahead[:, 1] * found.uphill[:, 0] > 0
        leads = (found.growth <= _POLISHED) & left & (gap < _SAG * np.linalg.norm(ahead, axis=1))
        lost = np.concatenate([lost, chord[~leads]])
        add = leads & (gap > _CHORD) & _within(grid, found.place)
        at = first[add] + 1
        place, growth = np.insert(place, at, found.place[add], axis=0), np.insert(growth, at, found.growth[add])
        number, fresh = np.insert(number, at, number[first[add]]), np.insert(np.zeros(len(fresh), dtype=bool), at, True)
    return Traced(place, growth, number), lost


def _polished(grid: GrowthMap, place: np.ndarray, evaluate: Evaluation) -> tuple[np.ndarray, np.ndarray]:
    """The vertices of contour lines moved onto the curve, and the growth left."""
    # A vertex on the border of the map stays there.
    border = np.column_stack([np.isin(place[:, 0], grid.speed[[0, -1]]), np.isin(place[:, 1], grid.gain[[0, -1]])])
    cell = _cell(grid, place)
    found = along_gradient(evaluate, place, cell, ~border)
    first, last, ends = _edges(grid, place)
    # The growth must rise the way it does on the edge: else this is another curve, across a thin tongue.
    rises = np.sum(found.uphill * (last - first) / cell, axis=1) * (ends[1] - ends[0]) > 0
    moved, growth = found.place.copy(), found.growth.copy()
    hard = np.flatnonzero(~(growth <= _POLISHED) | ~rises | ~_within(grid, moved))
    if hard.size:
        moved[hard], growth[hard] = along_edge(evaluate, first[hard], last[hard], (ends[0][hard], ends[1][hard]))
    return moved, growth


def _edges(grid: GrowthMap, place: np.ndarray) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """The grid edge that each vertex of a contour lies on: its ends, and the growth there."""
    axes = (grid.speed, grid.gain)
    nearest = [np.argmin(np.abs(axis[:, None] - place[:, k]), axis=0) for k, axis in enumerate(axes)]
    lower = [_lower(axis, place[:, k]) for k, axis in enumerate(axes)]
    off = [np.abs(axes[k][nearest[k]] - place[:, k]) / np.diff(axes[k])[lower[k]] for k in range(2)]
    by_gain = off[0] <= off[1]
    i = (np.where(by_gain, nearest[0], lower[0]), np.where(by_gain, lower[1], nearest[1]))
    j = (np.where(by_gain, nearest[0], lower[0] + 1), np.where(by_gain, lower[1] + 1, nearest[1]))
    first, last = (np.column_stack([grid.speed[e[0]], grid.gain[e[1]]]) for e in (i, j))
    return first, last, (grid.growth[i], grid.growth[j])


def _cell(grid: GrowthMap, place: np.ndarray) -> np.ndarray:
    """Width and height of the cell around each place, (p, 2)."""
    sizes = []
    for k, axis in enumerate((grid.speed, grid.gain)):
        sizes.append(np.diff(axis)[_lower(axis, place[:, k])])
    return np.column_stack(sizes)


def _lower(axis: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Index of the cell of an axis that each place lies in."""
    return np.clip(np.searchsorted(axis, place) - 1, 0, len(axis) - 2)


def _within(grid: GrowthMap, place: np.ndarray) -> np.ndarray:
    low, high = np.array([grid.speed[0], grid.gain[0]]), np.array([grid.speed[-1], grid.gain[-1]])
    return np.all((place >= low) & (place <= high), axis=1)
