"""The vibration eigenproblem K v = ω² M v with mass-normalised vectors, (1.6)-(1.8) and (3.6) of the thesis."""

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import scipy.linalg
from jaxtyping import Float, Real

from lobex import _checks
from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._shapes import AnyArray, Number
from lobex.structures.matrices import check_same_size, check_symmetric, dense, diagonal, is_sparse, size_of

# Of ω₁² M/K, in rounding units: 1e-6 and less clamped, 1 and more free, in rods and beams of up to 200 elements.
_FREE = 0.01


def vibration_modes(
    mass: Any, stiffness: Any, keep: Sequence[int] | None = None, condense: bool = False
) -> tuple[Float[AnyArray, " n"], Float[AnyArray, "dof n"]]:
    """Angular natural frequencies (n,), rad/s, and mass-normalised vectors (dof, n), in order of frequency.

    Dense matrices may be traced: gradients flow through frequencies and vectors wherever the frequencies
    are distinct. Modes so fast that rounding leaves nothing of them, beyond about 1e7 times the first, are none:
    those of a penalty on fixed degrees of freedom and, with ``condense``, of degrees of freedom without mass, which
    follow the others statically.

    Raises:
        ValueError: for matrices that are not square, symmetric and definite; with ``condense`` the mass may be
            semidefinite.
    """
    for name, matrix in (("mass", mass), ("stiffness", stiffness)):
        check_symmetric(name, matrix)
    check_same_size("stiffness", stiffness, mass)
    if keep is not None and (is_sparse(mass) or is_sparse(stiffness)):
        _check_masses(diagonal(mass), condense)
        if max(keep_modes(keep, size_of(mass)[0])) < np.sum(diagonal(mass) > 0) - 2:
            return _lowest_modes(mass, stiffness, keep)
    mass, stiffness = dense(mass), dense(stiffness)
    _check_definite(mass, condense)
    inverse, vectors = _symmetric_pencil(mass, stiffness)
    inverse, vectors = _resolved(mass, stiffness, inverse, vectors)
    # What is not kept may be rounding, which would spoil derivatives.
    index = slice(None) if keep is None else keep_modes(keep, np.shape(inverse)[0])
    slowness = inverse[index] ** 0.5
    return 1 / slowness, vectors[:, index] / slowness


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
def _symmetric_pencil(mass: Any, stiffness: Any) -> tuple[Float[AnyArray, " n"], Float[AnyArray, "dof n"]]:
    """1/ω², largest first, and vectors with vᵀKv = 1.

    The problem is M v = ω⁻² K v, with K = L Lᵀ symmetric in Lᵀ v: its error is small beside the largest ω⁻², so
    that no stiff part of the model costs the first modes their digits. (With M factored, a penalty of 1e8 times the
    stiffness moves the first frequency of a beam by 8 %.)
    """
    lib = namespace(mass, stiffness)
    solve = jax.scipy.linalg.solve_triangular if lib is jnp else scipy.linalg.solve_triangular
    try:
        factor = lib.linalg.cholesky(lib.asarray(stiffness, dtype=lib.result_type(float)))
    except np.linalg.LinAlgError:
        raise ValueError("stiffness is singular or indefinite; clamp rigid-body motion") from None
    half = solve(factor, lib.asarray(mass, dtype=factor.dtype), lower=True)
    reduced = solve(factor, half.T, lower=True)
    inverse, rotated = lib.linalg.eigh((reduced + reduced.T) / 2)
    return inverse[::-1], solve(factor.T, rotated[:, ::-1], lower=False)


def _resolved(
    mass: Any, stiffness: Any, inverse: Float[AnyArray, " n"], vectors: Float[AnyArray, "dof n"]
) -> tuple[Float[AnyArray, " kept"], Float[AnyArray, "dof kept"]]:
    """The modes of which rounding leaves something; all of them where they are traced."""
    if _checks.is_traced((mass, stiffness)):
        return inverse, vectors
    _check_clamped(np.diagonal(mass), np.diagonal(stiffness), inverse[0])
    kept = inverse > len(inverse) * np.finfo(float).eps * inverse[0]
    return inverse[kept], vectors[:, kept]


def _lowest_modes(
    mass: Any, stiffness: Any, keep: Sequence[int]
) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, "dof n"]]:
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import LinearOperator, eigsh, splu

    dof = mass.shape[0]
    index = keep_modes(keep, dof)
    wanted = int(index.max()) + 1
    mass, stiffness = (csc_array(m, dtype=float) for m in (mass, stiffness))
    # No more vectors than there are modes.
    ncv = min(max(2 * wanted + 1, 20), int(np.sum(mass.diagonal() > 0)) - 1)
    try:
        factors = splu(stiffness)
    except RuntimeError:
        raise ValueError("stiffness is singular; clamp rigid-body motion") from None
    solve = LinearOperator((dof, dof), factors.solve)
    start = factors.solve(mass @ np.random.default_rng(0).standard_normal(dof))
    squared, vectors = eigsh(stiffness, wanted, mass, sigma=0.0, v0=start, ncv=ncv, OPinv=solve)
    order = np.argsort(squared)
    _check_clamped(mass.diagonal(), stiffness.diagonal(), float(1 / squared[order[0]]))
    squared, vectors = squared[order][index], vectors[:, order][:, index]
    # A step of the inverse iteration, after which what has no mass follows the rest exactly.
    vectors = factors.solve(mass @ vectors) * squared
    modal_mass = np.einsum("in,in->n", vectors, mass @ vectors)
    _checks.positive("mass (modal masses)", modal_mass, "kg: the matrix must be positive definite")
    return np.sqrt(squared), vectors / np.sqrt(modal_mass)


def _check_clamped(mass: np.ndarray, stiffness: np.ndarray, inverse: Number) -> None:
    """Require that the first 1/ω² is not that of a stiffness of mere rounding, beside the softest degree of freedom."""
    softest = np.min(np.asarray(stiffness, dtype=float)[mass > 0] / mass[mass > 0])
    if not 0 < inverse * softest < _FREE / np.finfo(float).eps:
        raise ValueError("stiffness is singular or indefinite; clamp rigid-body motion")


def _check_masses(mass: Real[AnyArray, " dof"], condense: bool) -> None:
    massless = int(np.sum(mass == 0))
    if massless and not condense:
        raise ValueError(
            f"mass is singular: {massless} of {len(mass)} degrees of freedom have none; give condense=True for "
            "static condensation, in which they follow the others"
        )


def _check_definite(mass: Any, condense: bool) -> None:
    numbers = _checks.as_numbers("mass", mass)
    if numbers is None:
        return
    own = np.diagonal(numbers)
    _check_masses(own, condense)
    scale = np.where(own > 0, own, 1.0) ** -0.5
    smallest = np.linalg.eigvalsh(scale[:, None] * numbers * scale)[0]
    rounding = len(numbers) * np.finfo(float).eps
    if smallest < -rounding or (smallest <= rounding and not condense):
        raise ValueError(
            f"mass is singular or indefinite, smallest eigenvalue {smallest:.3g} of it scaled to a diagonal of ones; "
            "give a definite matrix, or condense=True if massless motion is to follow the rest statically"
        )
