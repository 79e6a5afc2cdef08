"""A map of growth made finer where its grid cannot tell the line at which growth is zero.

Between grid points a picture interpolates. That is true where growth is smooth over a few cells, and wrong where two
multipliers change places: a tongue thinner than a cell comes out as beads, and a sharp corner is cut off.
"""

from collections.abc import Callable

import numpy as np

Sample = Callable[[np.ndarray, np.ndarray], np.ndarray]

# Growth that bends by less over a cell is flat to what any method can tell, such as along |μ| = 1 without damping.
_FLAT = 1e-7
LEAST = -20.0
"""Growth of a multiplier that vanishes."""

# A cell is halved so often at most, and so many points are computed at most.
_HALVINGS = 4
_MOST_POINTS = 40_000


def finer(
    speed: np.ndarray, gain: np.ndarray, growth: np.ndarray, sample: Sample, pixels: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The map with doubtful cells halved, and halved again, until they are resolved or about a pixel wide.

    Args:
        speed, gain: increasing, (n,) and (m,).
        growth: log max|μ|, (n, m), NaN where a point failed.
        sample: growth at scattered points, from their speeds and gains, (p,) each.
        pixels: that the whole map is wide and high.

    Returns:
        Speeds, gains and growth of a grid that has the given one in it; bilinear in cells that were not in doubt.
    """
    may = None
    spent = 0
    for _ in range(_HALVINGS):
        size = pixels[0] / (len(speed) - 1), pixels[1] / (len(gain) - 1)
        cells = doubtful(speed, gain, growth, max(size), may)
        wanted = _new_points(cells)
        spent += len(wanted[0])
        if max(size) <= 1 or not cells.any() or spent > _MOST_POINTS:
            break
        speed, gain = halved(speed), halved(gain)
        growth = halved(halved(growth).T).T
        growth[wanted] = sample(speed[wanted[0]], gain[wanted[1]])
        may = cells.repeat(2, axis=0).repeat(2, axis=1)
    return speed, gain, growth


def doubtful(
    speed: np.ndarray, gain: np.ndarray, growth: np.ndarray, size: float, among: np.ndarray | None = None
) -> np.ndarray:
    """Cells, (n - 1, m - 1), in which the line of growth zero is elsewhere than interpolation puts it, by more than one
    of the ``size`` pixels of a cell, or may be without showing at the corners; of those ``among`` alone, if given.

    Between its corners growth may differ from what interpolation says by half of what it bends there.
    """
    cells = np.zeros((len(speed) - 1, len(gain) - 1), dtype=bool)
    row, column = (part.ravel() for part in np.indices(cells.shape)) if among is None else np.nonzero(among)
    corners = [growth[row + i, column + j] for i in (0, 1) for j in (0, 1)]
    least, most = np.minimum.reduce(corners), np.maximum.reduce(corners)
    across, along = _bends(speed, growth, row, column), _bends(gain, growth.T, column, row)
    off = np.maximum(*across) + np.maximum(*along)
    crossed = (least < 0) & (most > 0)
    hidden = ~crossed & (np.minimum(np.abs(least), np.abs(most)) < off)
    cells[row, column] = (off > _FLAT) & (hidden | (crossed & (off * size > most - least)))
    return cells


def _bends(axis: np.ndarray, growth: np.ndarray, cell: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Half of the change of slope at either end of cells (k,) along the first axis, times their width, on both of their
    sides, (k,) each.
    """
    if len(axis) < 3:
        return np.zeros(len(cell)), np.zeros(len(cell))
    width = np.diff(axis)
    # Where the change of slope at either end is centred; at the ends of the axis the next one stands for it.
    ends = [np.clip(end, 1, len(axis) - 2) for end in (cell, cell + 1)]

    def side(column: np.ndarray) -> np.ndarray:
        changes = []
        for end in ends:
            before, here, after = (growth[end + step, column] for step in (-1, 0, 1))
            changes.append(np.abs((after - here) / width[end] - (here - before) / width[end - 1]))
        return np.maximum(*changes) * width[cell] / 2

    return side(other), side(other + 1)


def halved(values: np.ndarray) -> np.ndarray:
    """With the means of neighbours between them, along the first axis."""
    between = np.empty((2 * len(values) - 1, *values.shape[1:]))
    between[::2], between[1::2] = values, (values[1:] + values[:-1]) / 2
    return between


def _new_points(cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Indices on the halved grid of the middles of cells and of their edges."""
    points = np.zeros((2 * cells.shape[0] + 1, 2 * cells.shape[1] + 1), dtype=bool)
    for i in range(3):
        for j in range(3):
            if i == 1 or j == 1:
                points[i : i + 2 * cells.shape[0] : 2, j : j + 2 * cells.shape[1] : 2] |= cells
    row, column = np.nonzero(points)
    return row, column
