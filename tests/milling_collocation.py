"""Milling with straight teeth by Gauss' collocation of the whole state in NumPy: an oracle without any of lobex.

Over each part of a tooth period the derivative of the state is a polynomial through Gauss points (a Runge-Kutta
method of order twice their number), and what a tooth finds is the output at the same points one period ago.
"""

from itertools import pairwise

import numpy as np

_POINTS = 16
# Of the quickest mode with the largest force as its spring, per polynomial.
_WAVES = 1.0


def gauss(points):
    """Nodes and weights on [0, 1], and the integrals from 0 to each node of the polynomials through the nodes."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    basis = np.polynomial.legendre.legvander(nodes, points - 1)
    integrals = [
        np.polynomial.legendre.legval(nodes, np.polynomial.legendre.legint(row, lbnd=-1)) for row in np.eye(points)
    ]
    return (nodes + 1) / 2, weights / 2, np.stack(integrals, axis=1) @ np.linalg.inv(basis) / 2


def specific_force(angle, tangential, normal, directions):
    sine, cosine = np.sin(angle), np.cos(angle)
    force = np.array([tangential * cosine + normal * sine, normal * cosine - tangential * sine])
    return (force[:, None] * np.array([sine, cosine]))[:directions, :directions]


def _flight(omega, ratio, time):
    """The free motion of vibrating modes, of the state (u, u̇/ω), (2n, 2n)."""
    damped = np.sqrt(1 - ratio**2)
    decay, angle = np.exp(-ratio * omega * time), damped * omega * time
    cosine, sine = decay * np.cos(angle), decay * np.sin(angle) / damped
    corners = cosine + ratio * sine, sine, -sine, cosine - ratio * sine
    return np.block([[np.diag(corners[0]), np.diag(corners[1])], [np.diag(corners[2]), np.diag(corners[3])]])


def multipliers(cutter, speed, depth):
    """All multipliers, largest first, of a dictionary with the fields of ``Modes`` and ``Milling``, rad/s and N/m²."""
    omega, ratio, shape = (np.asarray(cutter[name]) for name in ("omega", "ratio", "shape"))
    n, r = shape.shape
    teeth, immersion = cutter["teeth"], cutter["radial_immersion"]
    entry, leave = (
        (np.arccos(2 * immersion - 1), np.pi) if cutter["direction"] == "down" else (0.0, np.arccos(1 - 2 * immersion))
    )
    period = 1 / (teeth * speed)
    drift = np.block([[np.zeros((n, n)), np.diag(omega)], [-np.diag(omega), -np.diag(2 * ratio * omega)]])
    inputs = np.vstack([np.zeros((n, r)), shape / omega[:, None]])
    outputs = np.hstack([shape.T, np.zeros((r, n))])
    pitch = 2 * np.pi / teeth
    whole, part = divmod((leave - entry) / pitch, 1.0)
    stretches = [(0.0, part, int(whole) + 1), (part, 1.0, int(whole))]
    nodes, weights, within = gauss(_POINTS)
    force = depth * teeth * np.hypot(cutter["tangential"], cutter["normal"])
    quickest = np.sqrt(omega.max() ** 2 + force * np.sum(shape**2))
    parts = []
    for start, stop, cutting in stretches:
        waves = (stop - start) * period * quickest / (2 * np.pi)
        edges = np.linspace(start, stop, int(np.ceil(waves / _WAVES)) + 1 if cutting else 2)
        parts += [(a, b - a, cutting) for a, b in pairwise(edges) if b > a]
    block = _POINTS * r
    size = 2 * n + block * sum(cutting > 0 for *_, cutting in parts)
    state, history, rows = np.eye(2 * n, size), 2 * n, []
    specific = cutter["tangential"], cutter["normal"]
    for start, length, cutting in parts:
        step = length * period
        if not cutting:
            state = _flight(omega, ratio, step) @ state
            continue
        forces = -depth * np.array(
            [
                sum(
                    specific_force(entry + pitch * (start + length * x + tooth), *specific, r)
                    for tooth in range(cutting)
                )
                for x in nodes
            ]
        )
        pushes = inputs @ forces
        slopes = drift + pushes @ outputs
        before = np.zeros((block, size))
        before[:, history : history + block] = np.eye(block)
        history += block
        left = np.eye(_POINTS * 2 * n) - step * np.einsum("ij,iab->iajb", within, slopes).reshape(_POINTS * 2 * n, -1)
        right = slopes @ state - pushes @ before.reshape(_POINTS, r, size)
        rates = np.linalg.solve(left, right.reshape(-1, size)).reshape(_POINTS, 2 * n, size)
        rows.append((outputs @ (state + step * np.einsum("ij,jan->ian", within, rates))).reshape(block, size))
        state = state + step * np.tensordot(weights, rates, axes=1)
    found = np.linalg.eigvals(np.vstack([state, *rows]))
    return found[np.argsort(-np.abs(found))]
