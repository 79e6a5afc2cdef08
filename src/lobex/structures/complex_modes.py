"""Modes of a damping that couples those without it: pairs of poles with complex shapes, as real numbers.

A pair of poles λ, μ (conjugate, or both real) with what each does to the contact, u vᵀ/(s − λ) + û v̂ᵀ/(s − μ), is that
of two real states (x, ẋ/ω) with forces on both and a contact that sees both.
"""

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

    (λ² + λC + ω²) w = 0 has 2k solutions, of which each answers a force with w wᵀ/[wᵀ(2λ + C)w (s − λ)] (Tisseur and
    Meerbergen, The quadratic eigenvalue problem, SIAM Rev. 43, 2001).

    Raises:
        ValueError: where a motion would not die out, or two poles fall together so that they have one shape.
    """
    k = len(angular_frequency)
    first = np.block([[np.zeros((k, k)), np.eye(k)], [-np.diag(angular_frequency**2), -damping]])
    solved: Any = np.linalg.eig(first)
    pole, vector = solved[0].astype(complex), solved[1][:k]
    scale = np.einsum("kp,kp->p", vector, (2 * pole * vector) + damping @ vector)
    if np.any(np.abs(scale) <= _REAL * np.abs(pole) * np.sum(np.abs(vector) ** 2, axis=0)):
        raise ValueError("damping makes two poles one, which no pair of modes stands for; change it by a little")
    return of_poles(pole, shape.T @ vector, loading.T @ vector / scale)


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
    first, second = still[::2], still[1::2]
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
