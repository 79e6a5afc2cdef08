"""Modes of a damping that couples those without it: pairs of poles with complex shapes, as real numbers.

A pair of poles λ, μ (conjugate, or both real) with what each does to the contact, u vᵀ/(s − λ) + û v̂ᵀ/(s − μ), is that
of two real states (x, ẋ/ω) with forces on both and a contact that sees both.
"""

import contextlib
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Complex, Float

from lobex import _checks
from lobex._shapes import AnyArray, ComplexLike

# Of the largest pole: what rounding leaves of an imaginary part.
_REAL = 1e-12
# Of the largest singular value of a residue, what the next one of a single mode may be.
_RANK = 1e-6


class Quadrature(NamedTuple):
    """Numbers of ``Modes`` by name: of n modes in r directions."""

    angular_frequency: Float[AnyArray, " n"]
    damping_ratio: Float[AnyArray, " n"]
    shape: Float[AnyArray, "n r"]
    force_shape: Float[AnyArray, "n r"]
    quadrature: Float[AnyArray, "n r"]
    force_quadrature: Float[AnyArray, "n r"]


def of_damping(
    angular_frequency: Float[AnyArray, " k"],
    damping: Float[AnyArray, "k k"],
    shape: Float[AnyArray, "k r"],
    loading: Float[AnyArray, "k r"],
) -> Quadrature:
    """The modes of ü + C u̇ + ω² u = ψᵀ F, with a symmetric matrix C, (k, k), in modes without damping.

    In the states (ωu, u̇), all of a size, with the right vectors V of the poles forces act by V⁻¹, whose rows are the
    left ones of each pole, however the vectors of poles that are alike lie among themselves.

    Raises:
        ValueError: where a motion would not die out, or two poles fall together so that they have one shape.
    """
    own, none = np.diag(angular_frequency), np.zeros_like(shape)
    pole, vector = _solved(np.block([[np.zeros_like(own), own], [-own, -damping]]))
    with contextlib.suppress(np.linalg.LinAlgError):
        inverse = np.linalg.inv(vector)
        # Of one vector each both are of size 1, and of two that are nearly one the product is without bound.
        if np.all(_REAL * np.linalg.norm(inverse, axis=1) < 1):
            seen = np.concatenate([shape / angular_frequency[:, None], none]).T @ vector
            return of_poles(pole, seen, np.concatenate([none, loading]).T @ inverse.T)
    raise ValueError("damping makes two poles one, which no pair of modes stands for; change it by a little")


def _solved(matrix: Float[AnyArray, "n n"]) -> tuple[Complex[np.ndarray, " n"], Complex[np.ndarray, "n n"]]:
    """Eigenvalues, and vectors of size 1."""
    found: Any = np.linalg.eig(matrix)
    return found[0].astype(complex), found[1].astype(complex)


def of_poles(
    pole: Complex[AnyArray, " p"], seen: Complex[AnyArray, "r p"], acting: Complex[AnyArray, "r p"]
) -> Quadrature:
    """The modes of all poles (p,), of every pair both, that see and act with u and v, (r, p) each."""
    if np.any(pole.real > _REAL * np.abs(pole)) or np.any(pole == 0):
        raise ValueError("damping (in the modes) lets a vibration grow; give a matrix that takes energy out")
    real = np.abs(pole.imag) <= _REAL * np.abs(pole)
    upper = np.flatnonzero(~real & (pole.imag > 0))
    still = np.flatnonzero(real)
    still = still[np.argsort(pole[still].real)]
    u, v = _turned(pole[upper], seen[:, upper], acting[:, upper])
    # Quick ones with slow ones, so that of modes that are alike no pole meets its own like.
    first, second = np.split(still, 2)
    pairs = [
        (pole[upper], pole[upper].conj(), u, u.conj(), v, v.conj()),
        (pole[first], pole[second], seen[:, first], seen[:, second], acting[:, first], acting[:, second]),
    ]
    parts = [np.concatenate(part, axis=-1) for part in zip(*(_real_form(*pair) for pair in pairs), strict=True)]
    order = np.argsort(parts[0])
    return Quadrature(*(part[..., order].T for part in parts))


def of_residues(pole: ComplexLike, residue: ComplexLike) -> Quadrature:
    """The modes of one pole of each pair, (n,), rad/s, and its residue at the contact, (n,) or (n, r, r)."""
    poles: Any = np.atleast_1d(np.asarray(pole, dtype=complex))
    residues: Any = np.asarray(residue, dtype=complex)
    for name, part in (("pole", poles), ("residue", residues)):
        _checks.as_numbers(name, part.real)
        _checks.as_numbers(name, part.imag)
    residues = residues.reshape(-1, 1, 1) if residues.ndim < 2 else residues
    if poles.ndim != 1 or residues.ndim != 3 or len(residues) != len(poles) or len(set(residues.shape[1:])) != 1:
        raise ValueError(
            f"residue has shape {np.shape(residue)} and pole {np.shape(pole)}; give (n,) or (n, r, r), and (n,)"
        )
    if np.any(poles.imag <= 0) or np.any(poles.real > 0):
        raise ValueError("pole has parts of another sign; give −ξω + jω√(1 − ξ²) of every pair, in rad/s")
    left, size, right = np.linalg.svd(residues)
    if np.any(size[:, 1:] > _RANK * size[:, :1]):
        raise ValueError("residue has several shapes in one mode; give residues of rank one, u vᵀ")
    seen, acting = left[:, :, 0].T * size[:, 0], right[:, 0, :].T
    every = np.concatenate([poles, poles.conj()])
    return of_poles(every, np.concatenate([seen, seen.conj()], -1), np.concatenate([acting, acting.conj()], -1))


def _turned(
    pole: Complex[AnyArray, " p"], seen: Complex[AnyArray, "r p"], acting: Complex[AnyArray, "r p"]
) -> tuple[Complex[AnyArray, "r p"], Complex[AnyArray, "r p"]]:
    """The same pairs, what is seen as nearly real as it can be, and as large as where damping couples no modes."""
    angle = np.exp(-0.5j * np.angle(np.sum(seen**2, axis=0)))
    seen_size, acting_size = (np.sqrt(np.sum(np.abs(part) ** 2, axis=0)) for part in (seen, acting))
    size = np.sqrt(2 * np.abs(pole.imag) * np.where(seen_size > 0, acting_size, 1.0) / np.maximum(seen_size, 1e-300))
    factor = angle * np.where(size > 0, size, 1.0)
    return seen * factor, acting / factor


def _real_form(
    pole: Complex[AnyArray, " p"],
    other: Complex[AnyArray, " p"],
    seen: Complex[AnyArray, "r p"],
    seen_other: Complex[AnyArray, "r p"],
    acting: Complex[AnyArray, "r p"],
    acting_other: Complex[AnyArray, "r p"],
) -> Quadrature:
    """Of a state p_λ a + p_μ â with p_λ = (1, λ/ω), of which each a has its own pole; shapes (r, p)."""
    omega = np.sqrt(np.real(pole * other))
    rate = omega * (seen - seen_other) / (pole - other)
    parts = (
        omega,
        -(pole + other) / (2 * omega),
        seen - rate * pole / omega,
        pole * acting + other * acting_other,
        rate,
        omega * (acting + acting_other),
    )
    return Quadrature(*(np.real(part) for part in parts))
