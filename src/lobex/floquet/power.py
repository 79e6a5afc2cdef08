"""The dominant multiplier by repeated squaring: matrix products alone, with its vectors.

Complex numbers are pairs (real, imaginary) along a last axis of 2 here: XLA compiles and runs real arithmetic faster.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float, Inexact, Int

from lobex.floquet.dense import Triple

# The last squarings cost more than as many products with a vector.
_BY_VECTOR = 4
# Products with a vector between which it is not scaled.
_AT_ONCE = 4
# Weight of the second direction below which its own multiplier is rounding.
_NEGLIGIBLE = 1e-5


class Pair(NamedTuple):
    """A multiplier μ with Im ≥ 0, (2,), its unit vector v, Uv = μv, (N, 2), and its left vector w, wᵀv = 1, (N, 2)."""

    value: Float[Array, "2"]
    vector: Float[Array, "N 2"]
    left: Float[Array, "N 2"]


def pair_by_squaring(matrix: Float[Array, "N N"], squarings: int | Int[Array, ""]) -> Pair:
    """The eigenvalue of largest modulus of (N, N) with its vector.

    What the power 2^squarings of U leaves of the other eigenvalues is (|μ₃|/|μ₁|)^(2^squarings); the dominant one
    and the next, which is its conjugate in most cases, are told apart in the plane of two vectors. Nothing tells
    here whether that was enough: check the pair against the equations. ``squarings`` are 4 or more.
    """
    power = _power(matrix, squarings - _BY_VECTOR)
    # The right space from the left one: no start vector is orthogonal to itself.
    left = _unit(power.T @ _start(matrix))

    def turned(turn: Int[Array, ""], vector: Float[Array, " N"]) -> Float[Array, " N"]:
        for _ in range(_AT_ONCE):
            vector = power @ vector
        return _unit(vector)

    right = jax.lax.fori_loop(0, 2**_BY_VECTOR // _AT_ONCE, turned, left)
    return _in_plane(matrix, right, left)


def triple_by_squaring(matrix: Float[Array, "N N"], squarings: int | Int[Array, ""]) -> tuple[Triple, Float[Array, ""]]:
    """The dominant multiplier and both its vectors, complex, and the larger residual |Uv − μv|/|μ| of the two.

    Where another multiplier has the modulus of the dominant one, left and right vector may belong to different
    ones; they are then orthogonal.
    """
    power = _power(matrix, squarings)
    left = power.T @ _start(matrix)
    right = power @ left
    # Both sides at once, which compiles half as much as one after the other.
    both = jnp.stack([matrix, matrix.T])
    sides = jax.vmap(_in_plane)(both, jnp.stack([right, left]), jnp.stack([left, right]))
    value, (right, left) = as_complex(sides.value[0]), as_complex(sides.vector)
    return Triple(value, right, left), jnp.max(jax.vmap(residual)(both, sides))


def as_complex(pair: Float[Array, "... 2"]) -> Complex[Array, "..."]:
    """(…, 2) to complex (…)."""
    return pair[..., 0] + 1j * pair[..., 1]


def as_pair(number: Inexact[Array, "..."]) -> Float[Array, "... 2"]:
    """Complex (…) to (…, 2)."""
    return jnp.stack([number.real, number.imag], axis=-1)


def rotation(value: Float[Array, "2"]) -> Float[Array, "2 2"]:
    """The matrix R for which x @ R is μx, x of shape (…, 2)."""
    return jnp.stack([jnp.stack([value[0], value[1]]), jnp.stack([-value[1], value[0]])])


def _power(matrix: Float[Array, "N N"], squarings: int | Int[Array, ""]) -> Float[Array, "N N"]:
    def square(_: Int[Array, ""], power: Float[Array, "N N"]) -> Float[Array, "N N"]:
        power = power @ power
        # The sum as a product, since XLA adds up whole matrices one number after the other.
        size = jnp.sqrt(jnp.sum(jnp.ones_like(power[0]) @ (power * power)))
        return power * (1 / (size + jnp.finfo(power.dtype).tiny))

    return jax.lax.fori_loop(0, squarings, square, matrix)


def _start(matrix: Float[Array, "N N"]) -> Float[Array, " N"]:
    return jnp.asarray(np.random.default_rng(7).standard_normal(jnp.shape(matrix)[-1]), dtype=matrix.dtype)


def _in_plane(matrix: Float[Array, "N N"], start: Float[Array, " N"], left: Float[Array, " N"]) -> Pair:
    """The larger eigenvalue, with Im ≥ 0, and its vector, in the plane of U·start and U²·start.

    Its left vector is what ``left``, near the left plane, holds once the other eigenvalue is taken out of it.
    """
    first = _unit(matrix @ start)
    image = matrix @ first
    second = image - (first @ image) * first
    second = second - (first @ second) * first
    weight = jnp.sqrt(second @ second)
    second = second / (weight + jnp.finfo(matrix.dtype).tiny)
    other = matrix @ second
    a, b, c, d = first @ image, first @ other, second @ image, second @ other
    middle, half = (a + d) / 2, (a - d) / 2
    q = half * half + b * c
    root = jnp.sqrt(jnp.abs(q))
    # A second direction that is all but gone holds rounding: its eigenvalue may be anything.
    faint = weight <= _NEGLIGIBLE * jnp.sqrt(image @ image)
    towards = jnp.where(faint, half, middle)
    real = jnp.where(q < 0, middle, middle + jnp.where(towards < 0, -root, root))
    imaginary = jnp.where(q < 0, root, 0.0)
    # Of the two rows of (B − μ)x = 0, the one that does not vanish.
    zero = jnp.zeros_like(real)
    one = jnp.stack([jnp.stack([b, zero]), jnp.stack([real - a, imaginary])])
    two = jnp.stack([jnp.stack([real - d, imaginary]), jnp.stack([c, zero])])
    x = jnp.where(jnp.sum(one**2) > jnp.sum(two**2), one, two)
    x = jnp.where(weight > 0, x, jnp.array([[1.0, 0.0], [0.0, 0.0]]))
    x = x / jnp.sqrt(jnp.sum(x**2))
    vector = first[:, None] * x[0] + second[:, None] * x[1]
    mirrored = jnp.stack([left @ matrix - (a + d - real) * left, imaginary * left], axis=-1)
    return Pair(jnp.stack([real, imaginary]), vector, matched(mirrored, vector))


def matched(left: Float[Array, "N 2"], vector: Float[Array, "N 2"]) -> Float[Array, "N 2"]:
    """The multiple of a left vector w with wᵀv = 1."""
    (p, q), (r, s) = left.T @ vector
    met = jnp.stack([p - s, -q - r])
    return left @ rotation(met) / jnp.sum(met**2)


def _unit(vector: Float[Array, " N"]) -> Float[Array, " N"]:
    return vector * (1 / (jnp.sqrt(vector @ vector) + jnp.finfo(vector.dtype).tiny))


def residual(matrix: Float[Array, "N N"], pair: Pair) -> Float[Array, ""]:
    """|Uv − μv|/|μ|."""
    rest = matrix @ pair.vector - pair.vector @ rotation(pair.value)
    return jnp.sqrt(jnp.sum(rest**2) / jnp.sum(pair.value**2))
