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
    may = np.ones((len(speed) - 1, len(gain) - 1), dtype=bool)
    spent = 0
    for _ in range(_HALVINGS):
        size = pixels[0] / (len(speed) - 1), pixels[1] / (len(gain) - 1)
        cells = doubtful(speed, gain, growth, max(size)) & may
        wanted = _new_points(cells)
        spent += len(wanted[0])
        if max(size) <= 1 or not cells.any() or spent > _MOST_POINTS:
            break
        speed, gain = halved(speed), halved(gain)
        growth = halved(halved(growth).T).T
        growth[wanted] = sample(speed[wanted[0]], gain[wanted[1]])
        may = cells.repeat(2, axis=0).repeat(2, axis=1)
    return speed, gain, growth


def doubtful(speed: np.ndarray, gain: np.ndarray, growth: np.ndarray, size: float) -> np.ndarray:
    """Cells, (n - 1, m - 1), in which the line of growth zero is elsewhere than interpolation puts it, by more than one
    of the ``size`` pixels of a cell, or may be without showing at the corners.

    Between its corners growth may differ from what interpolation says by half of what it bends there.
    """
    corners = np.stack([growth[:-1, :-1], growth[1:, :-1], growth[:-1, 1:], growth[1:, 1:]])
    across, along = _bend(speed, growth), _bend(gain, growth.T).T
    off = np.maximum(across[:, :-1], across[:, 1:]) + np.maximum(along[:-1], along[1:])
    least, most = corners.min(axis=0), corners.max(axis=0)
    crossed = (least < 0) & (most > 0)
    hidden = ~crossed & (np.minimum(np.abs(least), np.abs(most)) < off)
    return (off > _FLAT) & (hidden | (crossed & (off * size > most - least)))


def _bend(axis: np.ndarray, growth: np.ndarray) -> np.ndarray:
    """Half of the change of slope at either end of a cell along the first axis, times the cell's width, (n - 1, m)."""
    if len(axis) < 3:
        return np.zeros((len(axis) - 1, growth.shape[1]))
    width = np.diff(axis)[:, None]
    change = np.abs(np.diff(np.diff(growth, axis=0) / width, axis=0))
    ends = np.concatenate([change[:1], change, change[-1:]])
    return np.maximum(ends[:-1], ends[1:]) * width / 2


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
