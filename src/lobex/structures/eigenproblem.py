"""The vibration eigenproblem K v = ω² M v with mass-normalised vectors, (1.6)-(1.8) and (3.6) of the thesis."""

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from lobex import _checks
from lobex._float64 import in_float64

Array = Any


def vibration_modes(mass: Any, stiffness: Any, keep: Sequence[int] | None = None) -> tuple[Array, Array]:
    """Angular natural frequencies (n,), rad/s, and mass-normalised vectors (dof, n), in order of frequency.

    Dense matrices may be traced: gradients flow through frequencies and vectors wherever the frequencies
    are distinct. Raises ValueError for matrices that are not square, symmetric and definite.
    """
    mass, stiffness = (m.tocsr() if _is_sparse(m) else m for m in (mass, stiffness))
    _check_pair(mass, stiffness)
    if _is_sparse(mass) or _is_sparse(stiffness):
        if keep is None:
            mass, stiffness = _dense(mass), _dense(stiffness)
        else:
            return _lowest_modes(mass, stiffness, keep)
    _check_definite("mass", mass)
    squared, vectors = _symmetric_pencil(mass, stiffness)
    _checks.positive("stiffness (squared natural frequencies)", squared, "(rad/s)²: clamp rigid-body motion")
    index = slice(None) if keep is None else keep_modes(keep, np.shape(squared)[0])
    return squared[index] ** 0.5, vectors[:, index]


def keep_modes(keep: Sequence[int], available: int) -> np.ndarray:
    """Indices, from 0, of the mode numbers ``keep``, from 1."""
    if np.ndim(keep) != 1 or len(keep) == 0:
        raise ValueError(f"keep = {keep!r} must be a list of mode numbers, such as [1] or [1, 2]")
    numbers = [_checks.integer("keep", number, 1) for number in keep]
    if max(numbers) > available:
        raise ValueError(f"keep = {list(numbers)} asks for mode {max(numbers)} of {available}; modes count from 1")
    if len(set(numbers)) != len(numbers):
        raise ValueError(f"keep = {list(numbers)} names a mode twice; name each once")
    return np.asarray(numbers) - 1


@in_float64
def _symmetric_pencil(mass: Any, stiffness: Any) -> tuple[Array, Array]:
    # With M = L Lᵀ the problem is symmetric in Lᵀ v, and v = L⁻ᵀ w is mass-normalised by construction.
    dtype = jnp.result_type(float)
    factor = jnp.linalg.cholesky(jnp.asarray(mass, dtype=dtype))
    half = jax.scipy.linalg.solve_triangular(factor, jnp.asarray(stiffness, dtype=dtype), lower=True)
    reduced = jax.scipy.linalg.solve_triangular(factor, half.T, lower=True)
    squared, rotated = jnp.linalg.eigh((reduced + reduced.T) / 2)
    return squared, jax.scipy.linalg.solve_triangular(factor.T, rotated, lower=False)


def _lowest_modes(mass: Any, stiffness: Any, keep: Sequence[int]) -> tuple[Array, Array]:
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import eigsh, splu

    dof = mass.shape[0]
    index = keep_modes(keep, dof)
    wanted = int(index.max()) + 1
    if wanted >= dof - 1:
        return vibration_modes(_dense(mass), _dense(stiffness), keep)
    matrices = {"mass": csc_array(mass, dtype=float), "stiffness": csc_array(stiffness, dtype=float)}
    for name, matrix in matrices.items():
        try:
            splu(matrix)
        except RuntimeError:
            raise ValueError(f"{name} is singular; remove massless or unclamped degrees of freedom") from None
    start = np.random.default_rng(0).standard_normal(dof)
    squared, vectors = eigsh(matrices["stiffness"], wanted, matrices["mass"], sigma=0.0, v0=start, tol=0)
    order = np.argsort(squared)
    squared, vectors = squared[order], vectors[:, order]
    modal_mass = np.einsum("in,in->n", vectors, matrices["mass"] @ vectors)
    _checks.positive("mass (modal masses)", modal_mass, "kg: the matrix must be positive definite")
    _checks.positive("stiffness (squared natural frequencies)", squared, "(rad/s)²: clamp rigid-body motion")
    vectors = vectors / np.sqrt(modal_mass)
    return np.sqrt(squared)[index], vectors[:, index]


def _check_pair(mass: Any, stiffness: Any) -> None:
    for name, matrix in (("mass", mass), ("stiffness", stiffness)):
        shape = np.shape(matrix) if not _is_sparse(matrix) else matrix.shape
        if len(shape) != 2 or shape[0] != shape[1] or shape[0] == 0:
            raise ValueError(f"{name} has shape {shape}; give a square matrix")
        numbers = matrix if _is_sparse(matrix) else _checks.as_numbers(name, matrix)
        if numbers is None:
            continue
        if _is_sparse(matrix):
            _checks.as_numbers(name, matrix.data)
        gap = abs(numbers - numbers.T).max()
        if gap > 1e-8 * abs(numbers).max():
            raise ValueError(f"{name} is not symmetric, by up to {gap:.3g}; give a symmetric matrix")
    shapes = [m.shape if _is_sparse(m) else np.shape(m) for m in (mass, stiffness)]
    if shapes[0] != shapes[1]:
        raise ValueError(f"stiffness has shape {shapes[1]} and mass {shapes[0]}; give the same size")


def _check_definite(name: str, matrix: Any) -> None:
    numbers = _checks.as_numbers(name, matrix)
    if numbers is None:
        return
    smallest = np.linalg.eigvalsh(numbers)[0]
    if smallest <= len(numbers) * np.finfo(float).eps * abs(numbers).max():
        raise ValueError(
            f"{name} is singular or indefinite, smallest eigenvalue {smallest:.3g}; remove massless degrees of freedom"
        )


def _is_sparse(matrix: Any) -> bool:
    return hasattr(matrix, "tocsc")


def _dense(matrix: Any) -> Array:
    return matrix.toarray() if _is_sparse(matrix) else matrix
