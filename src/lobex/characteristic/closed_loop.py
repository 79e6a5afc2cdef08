"""The structure with the present feedback closed, whose roots the delayed feedback moves.

With z = sτ and feedback K(p y + q w) of outputs y now and w a delay ago the characteristic equation
1 − K p H − K q H e^{−z} = 0 reads e^{−z} M(z) = 1, where M = K q H/(1 − K p H) is the response from the delayed
feedback to itself with the present feedback closed: a rational function, whose modulus and phase know nothing of the
delay.
"""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Complex, Float, Inexact

from lobex.characteristic.lanes import with_modes

_NEARBY = 1e-10
# Where poles that are none lie, out of the way.
FAR = 1e9


class Loops(NamedTuple):
    """M(z) = Σ (α z + β)/((z − π₁)(z − π₂)) with pairs of poles, each of shape (modes, lanes).

    Of several responses with the same poles, α and β are (modes, outputs, lanes).

    Attributes:
        first: α, real.
        constant: β, real.
        upper: π₁.
        lower: π₂, its conjugate, or another real pole.
    """

    first: Float[Any, "*modes l"]
    constant: Float[Any, "*modes l"]
    upper: Complex[Any, "*modes l"]
    lower: Complex[Any, "*modes l"]

    def at_delay(self, delay: Float[Any, " l"]) -> "Loops":
        """In z = sτ, where these are in s, for delays of the same lanes."""
        return Loops(self.first * delay, self.constant * delay**2, self.upper * delay, self.lower * delay)

    def filled(self) -> "Loops":
        """With modes that add nothing, up to one of a few numbers of them, for which programs are compiled."""
        nothing, far = np.zeros(1), np.full(1, -FAR + 0j)
        return Loops(*map(with_modes, self, (nothing, nothing, far, far)))

    def each(self) -> list["Loops"]:
        """Of one mode of several responses, each response."""
        return [self._replace(first=a, constant=b) for a, b in zip(self.first, self.constant, strict=True)]

    @property
    def lanes(self) -> int:
        """Their number."""
        return np.shape(self.upper)[1]

    @property
    def finite(self) -> Bool[Any, " l"]:
        """Of which lanes all is a number, (lanes,)."""
        return np.all(np.isfinite(self.first), axis=0)

    @property
    def rightmost(self) -> Float[Any, " l"]:
        """The largest real part of a pole, (lanes,)."""
        return np.max(np.maximum(self.upper.real, self.lower.real), axis=0)


def close(
    drift: Float[Any, "l d d"],
    inputs: Float[Any, "l d"],
    present: Float[Any, "l d"],
    delayed: Float[Any, "l *k d"],
) -> Loops:
    """The loops of ż = A z + E (P z + Q w), from z's delayed value w to itself.

    Args:
        drift: A, (l, d, d).
        inputs: E, (l, d).
        present: P, (l, d).
        delayed: Q, (l, d), or (l, k, d) of k delays, with as many responses.
    """
    drift = drift + inputs[:, :, None] * present[:, None, :]
    if np.ndim(delayed) == 3:
        return responses(drift, inputs, delayed)
    closed = responses(drift, inputs, delayed[:, None])
    return closed._replace(first=closed.first[:, 0], constant=closed.constant[:, 0])


def responses(drift: Float[Any, "l d d"], inputs: Float[Any, "l d"], outputs: Float[Any, "l o d"]) -> Loops:
    """C (sI − A)⁻¹ E with A (l, d, d), E (l, d) and C (l, o, d), as responses with the same poles."""
    size = np.shape(drift)[1]
    poles, vectors = np.linalg.eig(drift)
    coordinates = _coordinates(vectors, inputs)
    defective = ~np.all(np.isfinite(coordinates), axis=1)
    if np.any(defective):
        # A critically damped mode is taken for one that is nearly so; the roots are polished without these poles.
        nearby = drift[defective] * (1 + _NEARBY * np.arange(size) / size)
        poles, vectors = poles + 0j, vectors + 0j
        poles[defective], vectors[defective] = np.linalg.eig(nearby)
        coordinates[defective] = _coordinates(vectors[defective], inputs[defective])
    residue = (outputs @ vectors) * coordinates[:, None, :]
    poles = poles + 0j
    # Those of the upper half-plane first, then the real ones, each with its partner.
    kind = 1 - np.sign(poles.imag)
    order = np.lexsort((poles.real, kind), axis=-1)
    poles, kind = (np.take_along_axis(a, order, axis=1) for a in (poles, kind))
    residue = np.take_along_axis(residue, order[:, None], axis=2)
    above = np.sum(kind == 0, axis=1)[:, None]
    slot = np.arange(-(-size // 2))
    oscillating = slot < above
    place = np.where(oscillating, slot, np.minimum(2 * slot - above, size - 1))
    partner = np.minimum(place + 1, size - 1)
    alone = ~oscillating & (place + 1 >= size - above)
    upper, at_upper = np.take_along_axis(poles, place, axis=1), np.take_along_axis(residue, place[:, None], axis=2)
    lower = np.where(oscillating, upper.conj(), np.take_along_axis(poles, partner, axis=1))
    at_partner = np.take_along_axis(residue, partner[:, None], axis=2)
    at_lower: Any = np.where(oscillating[:, None], at_upper.conj(), at_partner)
    # A real pole left over gets a partner that the numerator takes away again.
    lower = np.where(alone, -FAR, lower)
    at_lower = np.where(alone[:, None], 0.0, at_lower)
    first, constant = (at_upper + at_lower).real, -(at_upper * lower[:, None] + at_lower * upper[:, None]).real
    by_mode = (np.moveaxis(a, (2, 1, 0), (0, 1, 2)) for a in (first, constant))
    return Loops(*map(np.ascontiguousarray, (*by_mode, upper.T, lower.T)))


def doubt(drift: Float[Any, "l d d"]) -> Float[Any, " l"]:
    """How far off the poles of matrices (l, d, d) may be that are known to rounding, in ulps of 1, (l,).

    To first order, of which the units of the states make no difference.
    """
    poles, vectors = np.linalg.eig(drift)
    inverse = _solved(vectors, np.broadcast_to(np.eye(np.shape(drift)[1]), np.shape(drift)))
    with np.errstate(all="ignore"):
        moved = np.max(np.sum((np.abs(inverse) @ np.abs(drift)).swapaxes(1, 2) * np.abs(vectors), axis=1), axis=1)
    most = _NEARBY / np.finfo(float).eps * np.max(np.abs(poles), axis=1)
    return np.where(moved < most, moved, most)


def _coordinates(vectors: Inexact[Any, "l d d"], inputs: Float[Any, "l d"]) -> Complex[Any, "l d"]:
    """V⁻¹ E, (l, d); NaN where the poles have no full set of vectors."""
    return _solved(vectors, inputs[..., None])[..., 0]


def _solved(vectors: Inexact[Any, "l d d"], right: Float[Any, "l d k"]) -> Complex[Any, "l d k"]:
    """V⁻¹ times matrices, (l, d, k); NaN where the poles have no full set of vectors."""
    try:
        return np.linalg.solve(vectors, right) + 0j
    except np.linalg.LinAlgError:
        if len(vectors) == 1:
            return np.full(np.shape(right), np.nan, dtype=complex)
        return np.concatenate([_solved(vectors[i : i + 1], right[i : i + 1]) for i in range(len(vectors))])
