"""An oracle of its own for several contacts, each in its own track: the least limit by a dense scan of the axis.

The eigenvalues of (1 − e^{−jωτ}) G(ω) are sampled, dense at the resonances and along every wave, and named from sample
to sample by what is nearest; where one passes the negative real axis is found by bisection. It shares no code with the
package.
"""

from itertools import permutations

import numpy as np


def loop(omega, ratio, weight, speed, at):
    """(1 − e^{−jωτ}) G at (k,), of G = Σ W_i/(ω_i² − ω² + 2jξ_iω_iω) with weights (n, m, m)."""
    denominator = (omega - at[:, None]) * (omega + at[:, None]) + 2j * ratio * omega * at[:, None]
    return (1 - np.exp(-1j * at / speed))[:, None, None] * np.tensordot(1 / denominator, weight, 1)


def least_limit(omega, ratio, weight, speed, per_wave=40):
    """K and ω of the lowest limit at a speed, Hz."""
    top = 3 * omega.max() + 2 * np.pi * speed
    edges = [np.linspace(1e-3 * omega.min(), top, int(per_wave * top / (2 * np.pi * speed)) + 8000)]
    for own, width in zip(omega, ratio * omega, strict=True):
        edges.append(own + width * np.sinh(np.linspace(-7, 7, 800)))
    at = np.unique(np.clip(np.concatenate(edges), 1e-3 * omega.min(), top))
    value = np.linalg.eigvals(loop(omega, ratio, weight, speed, at))
    orders = np.array(list(permutations(range(value.shape[1]))))
    apart = np.sum(np.abs(value[1:][:, orders] - value[:-1, None]), axis=2)
    following = np.take_along_axis(value[1:], orders[np.argmin(apart, axis=1)], axis=1)
    step, branch = np.nonzero((value[:-1].imag * following.imag < 0) & (value[:-1].real < 0) & (following.real < 0))
    low, high, first, last = at[step], at[step + 1], value[step, branch], following[step, branch]
    rising = last.imag > 0
    for _ in range(50):
        middle = (low + high) / 2
        every = np.linalg.eigvals(loop(omega, ratio, weight, speed, middle))
        nearest = np.argmin(np.abs(every - ((first + last) / 2)[:, None]), axis=1)
        found = every[np.arange(len(every)), nearest]
        beyond = (found.imag > 0) == rising
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
        first, last = np.where(beyond, first, found), np.where(beyond, found, last)
    # A branch that jumped was none.
    real = (np.abs(found.imag) < 1e-7 * np.abs(found.real)) & (found.real < -1e-12 * np.max(np.abs(value)))
    gain = np.where(real, -1 / found.real, np.inf)
    return np.min(gain), middle[np.argmin(gain)]
