"""The thesis' Appendix B as a plain loop over points: the whole-state operator and a dense eigensolver.

Own code of (3.10)-(3.15), in NumPy and SciPy, as the yardstick of what a user of the published scripts waits for.
"""

import numpy as np
import scipy.linalg

import lobex


def spectral_radius(modes: lobex.Modes, speed: float, gain: float, nodes: int = 40) -> float:
    """max|μ| of the rubbing rod at one point, by the 2n·nodes square operator (3.15)."""
    n, tau = modes.count, 1 / speed
    omega, ratio, phi = (np.asarray(a) for a in (modes.angular_frequency, modes.damping_ratio, modes.shape[:, 0]))
    kappa = gain * np.outer(phi, phi)
    zero, unit = np.zeros((n, n)), np.eye(n)
    drift = np.block([[zero, unit], [-np.diag(omega**2) - kappa, -np.diag(2 * ratio * omega)]])
    delayed = np.block([[zero, zero], [kappa, zero]])
    x = np.cos(np.pi * np.arange(nodes) / (nodes - 1))
    c = np.r_[2.0, np.ones(nodes - 2), 2.0] * (-1.0) ** np.arange(nodes)
    derivative = np.outer(c, 1 / c) / (x[:, None] - x + np.eye(nodes))
    derivative -= np.diag(derivative.sum(axis=1))
    matched = np.vstack([derivative[:-1] * 2 / tau, np.eye(nodes)[-1]])
    inner = np.eye(nodes)
    inner[-1, -1] = 0
    left = np.kron(matched, np.eye(2 * n)) - np.kron(inner, drift)
    first = np.zeros((nodes, nodes))
    first[-1, 0] = 1
    right = np.kron(inner, delayed) + np.kron(first, np.eye(2 * n))
    return float(np.abs(scipy.linalg.eigvals(scipy.linalg.solve(left, right))).max())
