"""Multipliers by the dense eigensolver, and the derivative of the dominant one."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Complex, Float

_BESIDE = 1e-8


class Triple(NamedTuple):
    """A multiplier (Im ≥ 0 of a pair), its unit right vector v, Uv = μv, and its left vector w, wᵀU = μwᵀ."""

    value: Complex[Array, ""]
    right: Complex[Array, " N"]
    left: Complex[Array, " N"]


def all_multipliers(matrix: Float[Array, "... N N"]) -> Complex[Array, "... N"]:
    """Every eigenvalue of (…, N, N), complex (…, N), largest modulus first, +Im before −Im of a pair."""
    values = jnp.linalg.eigvals(matrix)
    order = jnp.lexsort((-values.imag, -jnp.abs(values)))
    return jnp.take_along_axis(values, order, axis=-1)


def pair_by_eigensolver(matrix: Float[Array, "N N"]) -> tuple[Complex[Array, ""], Complex[Array, " N"]]:
    """The eigenvalue of largest modulus of (N, N), with Im ≥ 0 of a pair, and its unit right eigenvector."""
    values, vectors = jnp.linalg.eig(matrix)
    index = jnp.argmax(jnp.abs(values))
    return upper_half(values[index], vectors[:, index])


def left_vector(
    matrix: Float[Array, "N N"], value: Complex[Array, ""], right: Complex[Array, " N"]
) -> Complex[Array, " N"]:
    """The left vector w, wᵀv = 1, of an eigenvalue of (N, N) with its right vector v, by one inverse step.

    From a shift beside the eigenvalue, which is not told apart from others that are closer than the shift.
    """
    shift = value + _BESIDE * jnp.abs(value)
    left = jnp.linalg.solve((matrix - shift * jnp.eye(jnp.shape(matrix)[-1])).T, right.conj())
    return left / (left @ right)


def triple_by_eigensolver(matrix: Float[Array, "N N"]) -> Triple:
    """The eigenvalue of largest modulus of (N, N) and its vectors."""
    value, right = pair_by_eigensolver(matrix)
    # Right eigenvectors of the transpose are left ones: every backend has those.
    mirrored, candidates = jnp.linalg.eig(matrix.T)
    # Of a multiplier that occurs twice (two equal modes), the left vector that is not orthogonal to the right.
    distance = jnp.abs(mirrored - value)
    same = distance <= jnp.min(distance) + 1e-9 * jnp.abs(value)
    left = candidates[:, jnp.argmax(jnp.where(same, jnp.abs(candidates.T @ right), -1.0))]
    return Triple(value, right, left)


def upper_half(
    value: Complex[Array, ""], vector: Complex[Array, " N"]
) -> tuple[Complex[Array, ""], Complex[Array, " N"]]:
    """Of a conjugate pair of a real matrix, the member with Im ≥ 0."""
    flip = value.imag < 0
    return jnp.where(flip, value.conj(), value), jnp.where(flip, vector.conj(), vector)


@jax.custom_jvp
def largest_modulus(matrix: Float[Array, "N N"]) -> Float[Array, ""]:
    """max|μ| over the eigenvalues of (N, N).

    Its derivative is that of one dominant eigenvalue, dμ = (uᴴ dΦ v)/(uᴴ v) with the left and right
    eigenvectors, which needs no other eigenvalue to be simple: at gain 0 the operator has a nilpotent block,
    where differentiating all of them gives NaN. At a tie of two moduli it is the derivative of one of them;
    at a defective dominant pair (two real multipliers about to become complex) it is infinite or NaN, as
    the true derivative is.
    """
    return jnp.max(jnp.abs(jnp.linalg.eigvals(matrix)))


@largest_modulus.defjvp
def _largest_modulus_jvp(
    primals: tuple[Float[Array, "N N"]], tangents: tuple[Float[Array, "N N"]]
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    (matrix,), (change,) = primals, tangents
    value, right, left = triple_by_eigensolver(matrix)
    slope = (left @ (change @ right)) / (left @ right)
    modulus = jnp.abs(value)
    return modulus, jnp.real(jnp.conj(value) * slope) / modulus
