"""Points of a contour line moved onto the curve max|μ| = 1: Newton's method in the plane of speed and gain."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

# Target of the steps, well under what a vertex is accepted at; steps along the gradient, and along an edge.
_TARGET = 1e-10
_STEPS = 6
_EDGE_STEPS = 40
# A vertex stays within this many cells of where the contour put it.
_REACH = 1.0
_LONGEST = 0.5

# Growth, its derivative by speed and by gain, and whether they are to be trusted, at points (p,).
Evaluation = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]


class Vertices(NamedTuple):
    """Points (p, 2) in speed and gain, |log max|μ|| left there, (p,), and the gradient per cell, (p, 2)."""

    place: np.ndarray
    growth: np.ndarray
    uphill: np.ndarray


def along_gradient(evaluate: Evaluation, place: np.ndarray, cell: np.ndarray, free: Any = True) -> Vertices:
    """Newton steps along the gradient, measured in cells, of all points at once.

    Args:
        evaluate: the growth and its gradient.
        place: where to start, (p, 2).
        cell: size of a cell of the map there, (p, 2).
        free: whether a point may move in speed and in gain, (p, 2): not off the border of the map.

    Returns:
        The best place met within one cell of the start, and the growth left there.
    """
    start, here = place, place.copy()
    best, left, uphill = place.copy(), np.full(len(place), np.inf), np.zeros_like(place)
    busy = np.arange(len(place))
    for _ in range(_STEPS):
        if not busy.size:
            break
        growth, by_speed, by_gain, trusted = evaluate(here[busy, 0], here[busy, 1])
        better = trusted & (np.abs(growth) < left[busy])
        full = np.column_stack([by_speed, by_gain]) * cell[busy]
        best[busy[better]], left[busy[better]] = here[busy[better]], np.abs(growth[better])
        uphill[busy[better]] = full[better]
        slope = full * np.broadcast_to(free, place.shape)[busy]
        with np.errstate(divide="ignore", invalid="ignore"):
            step = -growth[:, None] * slope / np.sum(slope**2, axis=1, keepdims=True)
            step *= np.minimum(1.0, _LONGEST / np.linalg.norm(step, axis=1, keepdims=True))
        new = here[busy] + np.where(np.isfinite(step), step, 0.0) * cell[busy]
        moves = np.isfinite(step).all(axis=1) & trusted
        near = np.linalg.norm((new - start[busy]) / cell[busy], axis=1) <= _REACH
        going = moves & near & (left[busy] > _TARGET)
        here[busy[going]] = new[going]
        busy = busy[going]
    return Vertices(best, left, uphill)


def along_edge(
    evaluate: Evaluation, first: np.ndarray, last: np.ndarray, ends: tuple[Any, Any]
) -> tuple[np.ndarray, np.ndarray]:
    """The zero between two points with growth of opposite sign: Newton steps along the line, else bisection.

    The growth is continuous, so that there is a zero, at a kink between two multipliers as anywhere else.

    Args:
        evaluate: the growth and its gradient.
        first, last: the ends of the edges, (p, 2).
        ends: the growth at both ends, each (p,).

    Returns:
        Places, (p, 2), and |log max|μ|| left there, (p,).
    """
    sign = np.sign(ends[0])
    low, high = np.zeros(len(first)), np.ones(len(first))
    share = np.clip(ends[0] / (ends[0] - ends[1]), 0.02, 0.98)
    best, left = share.copy(), np.full(len(first), np.inf)
    busy = np.arange(len(first))
    for _ in range(_EDGE_STEPS):
        if not busy.size:
            break
        span = (last - first)[busy]
        here = first[busy] + share[busy, None] * span
        growth, by_speed, by_gain, trusted = evaluate(here[:, 0], here[:, 1])
        better = trusted & (np.abs(growth) < left[busy])
        best[busy[better]], left[busy[better]] = share[busy[better]], np.abs(growth[better])
        same = np.sign(growth) == sign[busy]
        low[busy] = np.where(same & trusted, share[busy], low[busy])
        high[busy] = np.where(~same & trusted, share[busy], high[busy])
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = share[busy] - growth / (by_speed * span[:, 0] + by_gain * span[:, 1])
        inside = trusted & (newton > low[busy]) & (newton < high[busy])
        middle = (low[busy] + high[busy]) / 2
        share[busy] = np.where(inside, newton, middle)
        busy = busy[trusted & (left[busy] > _TARGET)]
    return first + best[:, None] * (last - first), left
