"""Matrices of a finite-element model as they are handed over: dense or scipy sparse, whole or one triangle of them."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Real

from lobex import _checks
from lobex._shapes import AnyArray

# Of |Aᵢⱼ − Aⱼᵢ|, relative to √|Aᵢᵢ Aⱼⱼ|: a penalty on one degree of freedom hides nothing of the others.
_ASYMMETRY = 1e-8
TRIANGLES = ("lower", "upper")


def is_sparse(matrix: Any) -> bool:
    """Whether ``matrix`` is one of scipy's sparse ones."""
    return hasattr(matrix, "tocsc")


def dense(matrix: Any) -> Real[AnyArray, "dof dof"]:
    """The matrix as an array."""
    return matrix.toarray() if is_sparse(matrix) else matrix


def diagonal(matrix: Any) -> Real[AnyArray, " dof"]:
    """The diagonal, (dof,)."""
    return matrix.diagonal() if is_sparse(matrix) else np.diagonal(matrix)


def size_of(matrix: Any) -> tuple[int, ...]:
    """Its shape."""
    return matrix.shape if is_sparse(matrix) else np.shape(matrix)


def check_same_size(name: str, matrix: Any, mass: Any) -> None:
    """Require a matrix of as many degrees of freedom as a mass matrix has."""
    if size_of(matrix) != size_of(mass):
        raise ValueError(f"{name} has shape {size_of(matrix)} and mass {size_of(mass)}; give the same size")


def whole(name: str, matrix: Any, triangle: str | None) -> Any:
    """The symmetric matrix of which ``matrix`` holds one triangle, diagonal included; as it is for None.

    Raises:
        ValueError: for a matrix that is not square, and for entries on the other side of the diagonal that differ.
    """
    _check_numbers(name, matrix)
    if triangle is None:
        return matrix
    _checks.choice("triangle", triangle, TRIANGLES)
    kept, other = (_part(matrix, side) for side in (triangle, *(t for t in TRIANGLES if t != triangle)))
    if not _checks.is_traced(matrix) and abs(other).max() > 0:
        check_symmetric(name, matrix)
        return matrix
    return kept + kept.T + _diagonal_matrix(matrix)


def check_symmetric(name: str, matrix: Any) -> None:
    """Require a square symmetric matrix of finite real numbers, where they are not traced."""
    _check_numbers(name, matrix)
    if _checks.is_traced(matrix):
        return
    numbers = matrix.tocsr() if is_sparse(matrix) else np.asarray(matrix, dtype=float)
    scale = np.sqrt(np.abs(numbers.diagonal()))
    difference: Any = numbers - numbers.T
    if is_sparse(matrix):
        difference = difference.tocoo()
        row, column, size = difference.row, difference.col, np.abs(difference.data)
    else:
        row, column = np.nonzero(difference)
        size = np.abs(difference[row, column])
    wrong = size > _ASYMMETRY * scale[row] * scale[column]
    if np.any(wrong):
        raise ValueError(f"{name} is not symmetric, by up to {size[wrong].max():.3g}; {_remedy(numbers)}")


def _remedy(matrix: Any) -> str:
    for stored, empty in (TRIANGLES, TRIANGLES[::-1]):
        if abs(_part(matrix, empty)).max() == 0:
            return f"only its {stored} triangle is stored: give triangle={stored!r}, which takes the rest by symmetry"
    return "give a symmetric matrix"


def _part(matrix: Any, side: str) -> Any:
    """The entries on one side of the diagonal, without it."""
    if is_sparse(matrix):
        from scipy import sparse

        return sparse.tril(matrix, -1, "csr") if side == "lower" else sparse.triu(matrix, 1, "csr")
    lib = jnp if _checks.is_traced(matrix) else np
    return lib.tril(matrix, -1) if side == "lower" else lib.triu(matrix, 1)


def _diagonal_matrix(matrix: Any) -> Any:
    if is_sparse(matrix):
        from scipy.sparse import diags_array

        return diags_array(matrix.diagonal(), format="csr")
    lib = jnp if _checks.is_traced(matrix) else np
    return lib.diag(lib.diagonal(matrix))


def _check_numbers(name: str, matrix: Any) -> None:
    shape = size_of(matrix)
    if len(shape) != 2 or shape[0] != shape[1] or shape[0] == 0:
        raise ValueError(f"{name} has shape {shape}; give a square matrix")
    _checks.as_numbers(name, matrix.tocoo().data if is_sparse(matrix) else matrix)
