"""Multipliers of any delay system by Gauss' collocation of its whole state in NumPy: an oracle for every kind.

The equation is asked of the process, and nothing else is of lobex: the state is a polynomial over each of many equal
parts of the pieces of a period, what acts later is met between its points, and the longest delay is whole periods.
"""

from functools import cache
from itertools import pairwise

import jax
import numpy as np
from scipy.sparse.linalg import ArpackNoConvergence, eigs

# Images of images of jumps: the state is smoother by one with each.
_GENERATIONS = 3
_ROUNDING = 1e-9


@jax.jit
def _asked(process, speed, gain, phase):
    system = process.system(speed, gain)
    forces = system.at(phase)
    matrices = system.drift(), system.input_matrix(), system.output_matrix()
    return matrices, system.remembered, forces.present, forces.delayed, system.lags(phase), system.period


def asked(process, speed, gain, phase):
    """A, and at each phase E P C, E Q_k D and τ_k/T, times the period."""
    with jax.enable_x64(True):
        parts = jax.tree.map(np.asarray, _asked(process, float(speed), float(gain), phase))
    (drift, inputs, outputs), remembered, present, delayed, lags, period = parts
    seen = outputs
    if remembered is not None:
        seen = np.swapaxes(remembered, 0, 1).reshape(np.shape(remembered)[1], -1)
    now = period * (drift + inputs @ present @ outputs)
    return now, [period * inputs @ part @ seen for part in delayed], lags


@cache
def _points(count):
    """Chebyshev points on [0, 1], their barycentric weights, and Gauss points, one fewer."""
    index = np.arange(count + 1)
    weights = (-1.0) ** index
    weights[[0, -1]] /= 2
    return (1 - np.cos(np.pi * index / count)) / 2, weights, (np.polynomial.legendre.leggauss(count)[0] + 1) / 2


def _values(x, count):
    """From values at the points to those at x, (…, count + 1): Berrut and Trefethen, SIAM Review 46 (2004)."""
    points, weights, _ = _points(count)
    distance = x[..., None] - points
    near = np.abs(distance) < 1e-14
    terms = weights / np.where(near, 1.0, distance)
    found = terms / terms.sum(axis=-1, keepdims=True)
    return np.where(near.any(axis=-1, keepdims=True), near, found)


@cache
def _rates(count):
    """From values at the points to derivatives at the Gauss points."""
    points, _, gauss = _points(count)
    powers = np.polynomial.legendre.legvander(2 * points - 1, count)
    slopes = np.stack([np.polynomial.legendre.legder(row) for row in np.eye(count + 1)], axis=1)
    return 2 * np.polynomial.legendre.legvander(2 * gauss - 1, count - 1) @ slopes @ np.linalg.inv(powers)


def edges_of(breaks, carry, parts):
    """Ends of the parts of a period: jumps, where delays carry them, and equal parts between."""
    every, last = [0.0, *np.mod(breaks, 1.0)], list(breaks)
    for _ in range(_GENERATIONS if len(breaks) else 0):
        last = [float(image % 1.0) for image in carry(np.array(last))] if last else []
        last = [image for image in last if np.min(np.abs((image - np.array(every) + 0.5) % 1 - 0.5)) > _ROUNDING]
        every += last
    ends = np.append(np.sort(every), 1.0)
    ends = ends[np.append(np.diff(ends) > _ROUNDING, True)]
    inner = [np.linspace(a, b, max(round(parts * (b - a)), 1) + 1)[:-1] for a, b in pairwise(ends)]
    return np.append(np.concatenate(inner), 1.0)


def largest(process, speed, gain, breaks=(), parts=8, points=10, count=3):
    """The largest multipliers, largest first.

    Args:
        process: any process.
        speed, gain: of the point.
        breaks: phases at which its coefficients jump.
        parts: of a period at the least.
        points: per part, one more than of the rates.
        count: how many.
    """

    def carry(phase):
        images = []
        for index in range(len(asked(process, speed, gain, phase)[2])):
            image = phase
            for _ in range(60):
                image = phase + asked(process, speed, gain, image)[2][index]
            images.append(image)
        return np.unique(np.round(np.concatenate(images), 12))

    edges = edges_of(np.asarray(breaks, dtype=float), carry, parts)
    _, _, gauss = _points(points)
    pieces = len(edges) - 1
    length = np.diff(edges)
    phase = (edges[:-1, None] + length[:, None] * gauss).ravel()
    now, delayed, lags = asked(process, speed, gain, phase)
    d, periods = now.shape[-1], int(np.ceil(max(map(np.max, lags)) - _ROUNDING))
    steps = pieces * points
    # Rows of equations, columns of points from −periods to 1.
    equations = np.zeros((steps, d, (periods + 1) * steps + 1, d))
    row = np.arange(steps)
    piece = row // points

    def add(place, weights, matrices):
        """The value at a place, of the piece and between its points, times matrices."""
        for point in range(points + 1):
            equations[row, :, place * points + point] += weights[:, point, None, None] * matrices

    here = periods * pieces + piece
    add(here, np.tile(_rates(points), (pieces, 1)) / length[piece, None], np.broadcast_to(np.eye(d), (steps, d, d)))
    add(here, np.tile(_values(gauss, points), (pieces, 1)), -now)
    for matrices, lag in zip(delayed, lags, strict=True):
        before = phase - lag
        turn = np.floor(before)
        inside = before - turn
        part = np.clip(np.searchsorted(edges, inside, side="right") - 1, 0, pieces - 1)
        weights = _values((inside - edges[part]) / length[part], points)
        add(((periods + turn) * pieces + part).astype(int), weights, -matrices)
    equations = equations.reshape(steps * d, -1)
    past = (periods * steps + 1) * d
    new = np.linalg.solve(equations[:, past:], -equations[:, :past])
    matrix = np.concatenate([np.eye(past, past, steps * d)[: past - steps * d], new])
    try:
        found = eigs(matrix, k=count + 1, tol=1e-13, v0=np.ones(past), return_eigenvectors=False)
    except ArpackNoConvergence:
        found = np.linalg.eigvals(matrix)
    return found[np.argsort(-np.abs(found))][:count]
