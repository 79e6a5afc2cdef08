"""Vibrations of a turning, twisted and tapered beam by Chebyshev collocation of its equations, in NumPy alone."""

import numpy as np
import scipy.linalg


def chebyshev(points, length):
    """Places from root to tip and the matrix that differentiates values at them (Trefethen, 2000, ch. 6)."""
    k = np.arange(points)
    x = np.cos(np.pi * k / (points - 1))[::-1]
    c = np.where((k == 0) | (k == points - 1), 2.0, 1.0) * (-1.0) ** k
    away = x[:, None] - x + np.eye(points)
    first = np.outer(c, 1 / c) / away
    first -= np.diag(first.sum(axis=1))
    return length * (1 + x) / 2, 2 / length * first


def frequencies(points, length, modulus, density, area, flap, edge, angle, spin=0.0, hub=0.0, count=6):
    """Lowest angular frequencies, (count,), rad/s, of stretch u and deflections v, w along motion and axis.

    ρA(ü − 2Ωv̇ − Ω²u) = (EA u′)′, ρA(v̈ + 2Ωu̇ − Ω²v) + M_v″ = (T v′)′, ρA ẅ + M_w″ = (T w′)′, with T′ = −ρAΩ²(r + x)
    and moments M of the curvatures; sections are functions of x, in m.
    """
    x, d = chebyshev(points, length)
    n, one, nil = points, np.eye(points), np.zeros((points, points))
    mass = density * area(x)
    sine, cosine = np.sin(angle(x)), np.cos(angle(x))
    large, small, both = edge(x), flap(x), (edge(x) - flap(x)) * sine * cosine
    # T by solving T′ = −ρAΩ²(r + x) with T = 0 at the tip.
    slope = d.copy()
    slope[-1] = one[-1]
    tension = np.linalg.solve(slope, np.r_[-(mass * spin**2 * (hub + x))[:-1], 0.0])
    pull = d @ np.diag(tension) @ d
    m = np.diag(mass)
    bend = [[np.diag(modulus * part) @ d @ d for part in row] for row in
            ((large * sine**2 + small * cosine**2, both), (both, large * cosine**2 + small * sine**2))]  # fmt: skip
    still = np.block(
        [
            [-d @ np.diag(modulus * area(x)) @ d - spin**2 * m, nil, nil, nil, nil],
            [nil, -pull - spin**2 * m, nil, d @ d, nil],
            [nil, nil, -pull, nil, d @ d],
            [nil, bend[0][0], bend[0][1], -one, nil],
            [nil, bend[1][0], bend[1][1], nil, -one],
        ]
    )
    rate, inertia = np.zeros_like(still), np.zeros_like(still)
    rate[:n, n : 2 * n], rate[n : 2 * n, :n] = -2 * spin * m, 2 * spin * m
    for field in range(3):
        inertia[field * n : (field + 1) * n, field * n : (field + 1) * n] = m
    # Clamped at the root, free at the tip: rows of the ends of each equation make way.
    ends = [(0, one[0], 0), (n - 1, d[-1], 0)]
    for field in (1, 2):
        ends += [(field * n, one[0], field), (field * n + n - 1, one[-1], field + 2)]
        ends += [((field + 2) * n, d[0], field), ((field + 2) * n + n - 1, d[-1], field + 2)]
    for row, values, field in ends:
        still[row], rate[row], inertia[row] = 0.0, 0.0, 0.0
        still[row, field * n : (field + 1) * n] = values
    # Without what has no inertia: 1/s of the rest.
    size = len(still)
    left = np.block([[-rate, -inertia], [np.eye(size), np.zeros((size, size))]])
    right = np.block([[still, np.zeros((size, size))], [np.zeros((size, size)), np.eye(size)]])
    slow = scipy.linalg.eigvals(np.linalg.solve(right, left))
    found = np.sort(np.imag(1 / slow[np.abs(slow) > 1e-12 * np.abs(slow).max()]))
    return found[found > 0][:count]
