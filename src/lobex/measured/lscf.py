"""Poles of frequency responses by least squares in the complex frequency domain, for growing orders."""

import numpy as np
from jaxtyping import Complex, Float

# Of the circle that the band is laid along, so that its two ends do not meet.
_ARC = 0.95


def poles_by_order(
    frequency: Float[np.ndarray, " n"],
    response: Complex[np.ndarray, "n m"],
    trust: Float[np.ndarray, "n m"],
    most: int,
) -> list[Complex[np.ndarray, "..."]]:
    """The poles of one denominator for all responses, of orders 1 to ``most``; those in the band that die out.

    Every response is a fraction of polynomials in z = e^{jω′Δt}, with ω′ counted from the band's lower end and Δt so
    that the band is laid along the circle |z| = 1; numerators are eliminated, and the coefficient of the highest power
    of the denominator is one, which puts most poles that stand for nothing where vibrations grow (Guillaume et al.,
    IMAC XXI, 2003; Peeters, Van der Auweraer, Guillaume and Leuridan, Shock and Vibration 11, 2004).

    Args:
        frequency: (n,), Hz, increasing.
        response: (n, m), whose noise is alike but for
        trust: 1 over what it is larger by, (n, m), which weighs the lines of each response.
        most: highest order, which is the number of poles.

    Returns:
        For each order its poles λ, rad/s, with Re λ < 0 and Im λ in the band.
    """
    first, width = frequency[0], frequency[-1] - frequency[0]
    step = _ARC / width
    basis = np.exp(2j * np.pi * step * np.outer(frequency - first, np.arange(most + 1)))
    weighed = [
        (basis.conj().T * weight**2, one[:, None] * basis) for weight, one in zip(trust.T, response.T, strict=True)
    ]
    own = [left @ basis for left, _ in weighed]
    between = [left @ right for left, right in weighed]
    squared = basis.conj().T @ (np.sum(np.abs(trust * response) ** 2, axis=1)[:, None] * basis)
    found = []
    for order in range(1, most + 1):
        part = np.s_[: order + 1, : order + 1]
        matrix = squared[part] - sum(
            one[part].conj().T @ np.linalg.pinv(alone[part], hermitian=True) @ one[part]
            for alone, one in zip(own, between, strict=True)
        )
        low = np.linalg.lstsq(matrix[:-1, :-1], -matrix[:-1, -1], rcond=None)[0]
        root = np.roots(np.r_[1.0, low[::-1]])
        root = root[np.abs(root) > 0]
        turned = np.angle(root) / (2 * np.pi)
        # Angles just below zero are those of frequencies below the band, and not above it.
        turned = np.where(turned < (_ARC - 1) / 2, turned + 1, turned)
        pole = np.log(np.abs(root)) / step + 2j * np.pi * (first + turned / step)
        inside = (pole.imag > 2 * np.pi * first) & (pole.imag < 2 * np.pi * frequency[-1])
        found.append(pole[(pole.real < 0) & inside])
    return found
