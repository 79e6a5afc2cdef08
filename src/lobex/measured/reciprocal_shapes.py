"""Shapes from residues: of a structure that answers alike whichever of two points is pushed."""

import numpy as np
from jaxtyping import Complex, Float, Inexact

_ROUNDS = 20
_STILL = 1e-13


def shapes_of(
    residue: Inexact[np.ndarray, "k m"], weight: Float[np.ndarray, "k m"], pairs: list[tuple[int, int]], count: int
) -> Inexact[np.ndarray, "k r"]:
    """φ of which φᵢφⱼ is nearest to the residues of all pairs (i, j), (k, r), each mode by itself.

    Real residues must be positive at the driving points; shapes begin with a positive part at the one that moves most.

    Args:
        residue: (k, m).
        weight: 1 over the standard deviation of each.
        pairs: of directions, (m,), with one driving point or more, and all others linked to one.
        count: of directions r.
    """
    return np.stack([_shape(one, own, pairs, count) for one, own in zip(residue, weight, strict=True)])


def _shape(
    residue: Inexact[np.ndarray, " m"], weight: Float[np.ndarray, " m"], pairs: list[tuple[int, int]], count: int
) -> Inexact[np.ndarray, " r"]:
    shape = _start(residue, pairs, count)
    first, second = np.array(pairs).T
    rows = np.arange(len(pairs))
    for _ in range(_ROUNDS):
        slope = np.zeros((len(pairs), count), shape.dtype)
        np.add.at(slope, (rows, first), shape[second])
        np.add.at(slope, (rows, second), shape[first])
        off = residue - shape[first] * shape[second]
        # Of complex numbers the product is analytic: its least squares have the same form.
        step = np.linalg.lstsq(weight[:, None] * slope, weight * off, rcond=None)[0]
        shape = shape + step
        if np.max(np.abs(step)) < _STILL * np.max(np.abs(shape)):
            break
    return shape


def _start(residue: Inexact[np.ndarray, " m"], pairs: list[tuple[int, int]], count: int) -> Inexact[np.ndarray, " r"]:
    """From the driving point of the largest residue along the links."""
    driving = {i: residue[place] for place, (i, j) in enumerate(pairs) if i == j}
    largest = max(driving, key=lambda i: driving[i].real if np.isrealobj(residue) else abs(driving[i]))
    shape = np.zeros(count, residue.dtype)
    shape[largest] = np.sqrt(driving[largest])
    known = {largest}
    while len(known) < count:
        place, (i, j) = next((p, pair) for p, pair in enumerate(pairs) if (pair[0] in known) != (pair[1] in known))
        old, new = (i, j) if i in known else (j, i)
        shape[new] = residue[place] / shape[old] if shape[old] else 0.0
        known.add(new)
    return shape


def linked(pairs: list[tuple[str, str]]) -> list[list[str]]:
    """Directions in groups within which pairs link them, in order of their names."""
    groups: list[list[str]] = []
    for pair in pairs:
        joined = [group for group in groups if set(pair) & set(group)]
        rest = [group for group in groups if group not in joined]
        groups = [*rest, sorted({*(name for group in joined for name in group), *pair})]
    return sorted(groups)


def residues_of(
    coefficient: Float[np.ndarray, "k each m"], omega: Float[np.ndarray, " k"], damping_ratio: Float[np.ndarray, " k"]
) -> tuple[Complex[np.ndarray, " k"], Complex[np.ndarray, "k m"]]:
    """Poles λ and residues R of (β + αs)/(s² + 2ξωs + ω²)."""
    pole = omega * (-damping_ratio + 1j * np.sqrt(1 - damping_ratio**2))
    return pole, (coefficient[:, 0] + coefficient[:, 1] * pole[:, None]) / (2j * pole.imag[:, None])
