"""The receptance of modes by the equations that ``Modes`` states, complex ones included."""

import numpy as np


def of_modes(modes, s):
    """G(s) of all contacts, from the states of complex modes as ``Modes`` defines them."""
    sides = (modes.shape, modes.loading, modes.quadrature, modes.force_quadrature)
    total = 0
    for omega, ratio, *shapes in zip(modes.angular_frequency, modes.damping_ratio, *sides, strict=True):
        seen, acting, seen_aside, acting_aside = shapes
        state = np.array([[0, omega], [-omega, -2 * ratio * omega]])
        pushed = np.stack([acting_aside, acting]) / omega
        total = total + np.stack([seen, seen_aside], axis=1) @ np.linalg.solve(s * np.eye(2) - state, pushed)
    return total
