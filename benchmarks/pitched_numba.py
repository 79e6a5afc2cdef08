"""Zeroth-order semi-discretization of milling with two pitch angles in turn, in numba: a fast code of the usual kind.

Own code of Insperger and Stépán's method (Semi-Discretization for Time-Delay Systems, 2011, chs. 3 and 5): in each step
the force is that of the mean coefficients and of the displacements remembered, held at their mean; points run in
parallel, and LAPACK has the eigenvalues. Delays that are no whole number of steps lie between two of them.
"""

import numba
import numpy as np

SAMPLES = 10


@numba.njit(parallel=True, fastmath=False, cache=False)
def spectral_radii(
    omega: np.ndarray,
    ratio: np.ndarray,
    shape: np.ndarray,
    pitch: np.ndarray,
    tangential: float,
    normal: float,
    enter: float,
    leave: float,
    speeds: np.ndarray,
    depths: np.ndarray,
    steps: int,
) -> np.ndarray:
    """max|μ| at the points (speeds[i], depths[i]) of a cutter with two pitch angles, in ``steps`` per half turn."""
    modes = len(omega)
    radii = np.empty(len(speeds))
    period_angle = pitch[0] + pitch[1]
    for point in numba.prange(len(speeds)):
        step = period_angle / (2 * np.pi * speeds[point]) / steps
        back = pitch / period_angle * steps
        longest = int(np.ceil(back.max())) + 1
        # The state is (u, u′) of the modes, and (x, y) now and so many steps ago.
        size = 2 * modes + 2 * (longest + 1)
        product = np.eye(size)
        for number in range(steps):
            force = np.zeros((2, 2, 2))
            for tooth in range(2):
                first = 0.0 if tooth == 0 else pitch[0]
                for sample in range(SAMPLES):
                    angle = (first + period_angle * (number + (sample + 0.5) / SAMPLES) / steps) % np.pi
                    if enter <= angle <= leave:
                        s, c = np.sin(angle), np.cos(angle)
                        along, across = tangential * c + normal * s, normal * c - tangential * s
                        force[tooth, 0, 0] += along * s / SAMPLES
                        force[tooth, 0, 1] += along * c / SAMPLES
                        force[tooth, 1, 0] += across * s / SAMPLES
                        force[tooth, 1, 1] += across * c / SAMPLES
            force *= depths[point]
            # Each meets what the one ahead left a pitch ago.
            stiffness = force[0] + force[1]
            pushed = np.zeros((2, size))
            for tooth in range(2):
                # At the middle of the step.
                ago = back[tooth] - 0.5
                whole = int(np.floor(ago))
                share = ago - whole
                for direction in range(2):
                    for other in range(2):
                        near = product[2 * modes + 2 * whole + other]
                        far = product[2 * modes + 2 * (whole + 1) + other]
                        pushed[direction] += force[tooth, direction, other] * ((1 - share) * near + share * far)
            # Exact for the modes under the force held: x of now by an exponential of the whole.
            drift = np.zeros((2 * modes + 2, 2 * modes + 2))
            for mode in range(modes):
                drift[mode, modes + mode] = 1.0
                drift[modes + mode, mode] = -(omega[mode] ** 2)
                drift[modes + mode, modes + mode] = -2 * ratio[mode] * omega[mode]
                for other in range(modes):
                    for a in range(2):
                        for b in range(2):
                            drift[modes + mode, other] -= shape[mode, a] * stiffness[a, b] * shape[other, b]
                for a in range(2):
                    drift[modes + mode, 2 * modes + a] = shape[mode, a]
            moved = exponential(drift * step)
            free, forced = moved[: 2 * modes, : 2 * modes].copy(), moved[: 2 * modes, 2 * modes :].copy()
            state = free @ product[: 2 * modes] + forced @ pushed
            for row in range(size - 1, 2 * modes + 1, -1):
                product[row] = product[row - 2]
            product[: 2 * modes] = state
            for a in range(2):
                product[2 * modes + a] = 0.0
                for mode in range(modes):
                    product[2 * modes + a] += shape[mode, a] * state[mode]
        radii[point] = np.abs(np.linalg.eigvals(product.astype(np.complex128))).max()
    return radii


@numba.njit
def exponential(matrix: np.ndarray) -> np.ndarray:
    """exp of a matrix, by its series after halving, and squaring."""
    size = matrix.shape[0]
    halvings = max(0, int(np.ceil(np.log2(np.abs(matrix).sum() + 1e-300))) + 2)
    small = matrix / 2.0**halvings
    found, term = np.eye(size), np.eye(size)
    for order in range(1, 14):
        term = term @ small / order
        found = found + term
    for _ in range(halvings):
        found = found @ found
    return found
