"""The structure with the present feedback closed, whose roots the delayed feedback moves.

With z = sτ, P = K p and Q = K q the characteristic equation 1 − K(p + q e^{−z})H(z) = 0 reads e^{−z} M(z) = 1, where
M = K q H/(1 − K p H) is the response with the present feedback closed: a rational function, whose modulus and phase
know nothing of the delay.
"""

from typing import Any, NamedTuple

import numpy as np

from lobex.characteristic.lanes import with_modes

Array = Any

_NEARBY = 1e-10
# Where poles that are none lie, out of the way.
_FAR = 1e9


class Loops(NamedTuple):
    """M(z) = Σ (α z + β)/((z − π₁)(z − π₂)) with pairs of poles, each of shape (modes, lanes).

    Attributes:
        first: α, real.
        constant: β, real.
        upper: π₁.
        lower: π₂, its conjugate, or another real pole.
    """

    first: Array
    constant: Array
    upper: Array
    lower: Array

    def at_delay(self, delay: Array) -> "Loops":
        """In z = sτ, where these are in s, for delays of the same lanes."""
        return Loops(self.first * delay, self.constant * delay**2, self.upper * delay, self.lower * delay)

    def filled(self) -> "Loops":
        """With modes that add nothing, up to one of a few numbers of them, for which programs are compiled."""
        nothing, far = np.zeros(1), np.full(1, -_FAR + 0j)
        return Loops(*map(with_modes, self, (nothing, nothing, far, far)))

    @property
    def rightmost(self) -> Array:
        """The largest real part of a pole, (lanes,)."""
        return np.max(np.maximum(self.upper.real, self.lower.real), axis=0)


def close(drift: Array, inputs: Array, outputs: Array, present: Array, delayed: Array) -> Loops:
    """The loops of ż = A z + E (P y + Q w), y = C z, from y's delayed value w to y, times Q.

    Args:
        drift: A, (l, d, d).
        inputs: E, (l, d).
        outputs: C, (l, d).
        present: P, (l,).
        delayed: Q, (l,).
    """
    size = np.shape(drift)[1]
    closed = drift + present[:, None, None] * inputs[:, :, None] * outputs[:, None, :]
    poles, vectors = np.linalg.eig(closed)
    coordinates = _coordinates(vectors, inputs)
    defective = ~np.all(np.isfinite(coordinates), axis=1)
    if np.any(defective):
        # A critically damped mode is taken for one that is nearly so; the roots are polished without these poles.
        nearby = closed[defective] * (1 + _NEARBY * np.arange(size) / size)
        poles, vectors = poles + 0j, vectors + 0j
        poles[defective], vectors[defective] = np.linalg.eig(nearby)
        coordinates[defective] = _coordinates(vectors[defective], inputs[defective])
    residue = delayed[:, None] * (outputs[:, None, :] @ vectors)[:, 0] * coordinates
    poles = poles + 0j
    # Those of the upper half-plane first, then the real ones, each with its partner.
    kind = 1 - np.sign(poles.imag)
    order = np.lexsort((poles.real, kind), axis=-1)
    poles, residue, kind = (np.take_along_axis(a, order, axis=1) for a in (poles, residue, kind))
    above = np.sum(kind == 0, axis=1)[:, None]
    slot = np.arange(-(-size // 2))
    oscillating = slot < above
    place = np.where(oscillating, slot, np.minimum(2 * slot - above, size - 1))
    partner = np.minimum(place + 1, size - 1)
    alone = ~oscillating & (place + 1 >= size - above)
    upper, at_upper = np.take_along_axis(poles, place, axis=1), np.take_along_axis(residue, place, axis=1)
    lower = np.where(oscillating, upper.conj(), np.take_along_axis(poles, partner, axis=1))
    at_lower = np.where(oscillating, at_upper.conj(), np.take_along_axis(residue, partner, axis=1))
    # A real pole left over gets a partner that the numerator takes away again.
    lower = np.where(alone, -_FAR, lower)
    at_lower = np.where(alone, 0.0, at_lower)
    first, constant = (at_upper + at_lower).real, -(at_upper * lower + at_lower * upper).real
    return Loops(*(np.ascontiguousarray(a.T) for a in (first, constant, upper, lower)))


def _coordinates(vectors: Array, inputs: Array) -> Array:
    """V⁻¹ E, (l, d); NaN where the poles have no full set of vectors."""
    try:
        return np.linalg.solve(vectors, inputs[..., None])[..., 0] + 0j
    except np.linalg.LinAlgError:
        if len(vectors) == 1:
            return np.full(np.shape(inputs), np.nan, dtype=complex)
        return np.concatenate([_coordinates(vectors[i : i + 1], inputs[i : i + 1]) for i in range(len(vectors))])
