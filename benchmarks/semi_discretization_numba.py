"""Zeroth-order semi-discretization of milling with one flexible mode, in numba: a fast code of the usual kind.

Own code of Insperger and Stépán's method (Semi-Discretization for Time-Delay Systems, 2011, ch. 3): the products of
the step maps are taken on the two rows that change, points run in parallel, and LAPACK has the eigenvalues.
"""

import numba
import numpy as np


@numba.njit(parallel=True, fastmath=False, cache=False)
def spectral_radii(
    omega: float,
    ratio: float,
    mass: float,
    tangential: float,
    normal: float,
    enter: float,
    leave: float,
    speeds: np.ndarray,
    depths: np.ndarray,
    steps: int,
) -> np.ndarray:
    """max|μ| at the points (speeds[i], depths[i]) of a cutter with one tooth, in ``steps`` per period."""
    radii = np.empty(len(speeds))
    for point in numba.prange(len(speeds)):
        step = 1.0 / speeds[point] / steps
        size = steps + 2
        # The state is (x, x′, x one step ago, …, x a period ago).
        product = np.eye(size)
        for number in range(steps):
            force = 0.0
            for sample in range(10):
                angle = 2 * np.pi * (number + (sample + 0.5) / 10) / steps
                if enter <= angle <= leave:
                    force += np.sin(angle) * (tangential * np.cos(angle) + normal * np.sin(angle)) / 10
            delayed = depths[point] * force / mass
            stiffness = omega**2 + delayed
            decay = ratio * omega
            square = stiffness - decay**2
            root = np.sqrt(abs(square))
            damped = np.exp(-decay * step)
            if square > 0:
                c, s = np.cos(root * step), np.sin(root * step) / root
            else:
                c, s = np.cosh(root * step), np.sinh(root * step) / root
            p11, p12 = damped * (c + decay * s), damped * s
            p21, p22 = -damped * stiffness * s, damped * (c - decay * s)
            # The delayed displacement is held at its mean over the step: a constant force.
            r1, r2 = (1 - p11) * delayed / stiffness, -p21 * delayed / stiffness
            first, second = np.empty(size), np.empty(size)
            for column in range(size):
                x, v = product[0, column], product[1, column]
                mean = (product[size - 1, column] + product[size - 2, column]) / 2
                first[column] = p11 * x + p12 * v + r1 * mean
                second[column] = p21 * x + p22 * v + r2 * mean
            for row in range(size - 1, 2, -1):
                product[row] = product[row - 1]
            product[2] = product[0]
            product[0], product[1] = first, second
        radii[point] = np.abs(np.linalg.eigvals(product.astype(np.complex128))).max()
    return radii
