"""The dominant multiplier of a large operator by orthogonal iteration: products with few vectors, not with itself.

Of a delay, multipliers fall off quickly beyond those of the structure's modes (Hale and Verduyn Lunel, Introduction to
Functional Differential Equations, 1993, ch. 8): a few vectors turn into the space of the largest within a few periods
(Golub and Van Loan, Matrix Computations, 4th ed., 2013, sec. 7.3.2), in which the operator is a small matrix.
"""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from lobex.floquet.power import Pair, matched, pair_by_squaring

# Vectors besides as many as the structure has multipliers, and rows, in numbers of vectors, up to which squaring the
# operator itself takes less.
_BESIDE, _SMALL = 8, 3.5
# So many fewer steps than squarings turn the block, and so many more squarings its small matrix takes.
_FEWER, _FEWEST, _MORE = 4, 2, 3
# Of a vector, the square of what it has beside others for it to be counted.
_DEPENDENT = 1e-9
# Steps that the left vector goes on for.
_MIRRORED = 2


def dominant_pair(matrix: Float[Array, "N N"], state: int, squarings: int | Int[Array, ""], periods: int = 1) -> Pair:
    """The eigenvalue of largest modulus of (N, N) with its vectors, as ``pair_by_squaring`` has them: check them too.

    Of a matrix that is large beside the ``state`` of the structure, d, by orthogonal iteration of d + 8 vectors, as
    many steps as ``squarings`` less a few: what these leave of the others falls with their share of the largest. Where
    the longest delay takes several ``periods``, over which multipliers fall off, a step takes as many, and 8 vectors
    stand for each.
    """
    size = state + _BESIDE * periods
    if jnp.shape(matrix)[-1] <= _SMALL * size:
        return pair_by_squaring(matrix, squarings)
    start = np.linalg.qr(np.random.default_rng(7).standard_normal((jnp.shape(matrix)[-1], size)))[0]

    def turned(step: Int[Array, ""], block: Float[Array, "N b"]) -> Float[Array, "N b"]:
        for _ in range(periods - 1):
            block = matrix @ block
        return _orthonormal(matrix @ block)

    steps = jnp.maximum(squarings - _FEWER, _FEWEST)
    block = jax.lax.fori_loop(0, steps, turned, jnp.asarray(start, dtype=matrix.dtype))
    image = matrix @ block
    # What rounding leaves of angles in the block is taken out to second order.
    unit = 2 * jnp.eye(size, dtype=matrix.dtype) - block.T @ block
    inner = pair_by_squaring(unit @ (block.T @ image), squarings + _MORE)
    vector = _unit(image @ inner.vector)
    # The left vector in the block has no part of the others in it, and those beyond are soon gone.
    left = block @ inner.left
    for _ in range(_MIRRORED * periods):
        left = _unit(matrix.T @ left)
    left = matched(left, vector)
    (a, b), (c, d) = left.T @ (matrix @ vector)
    return Pair(jnp.stack([a - d, b + c]), vector, left)


def _orthonormal(block: Float[Array, "N b"]) -> Float[Array, "N b"]:
    """By Cholesky's factor L of the products of its columns, as Y L⁻ᵀ; without LAPACK, whose small calls are slow."""
    block = block * (1 / (jnp.sqrt(jnp.sum(block**2, axis=0)) + jnp.finfo(block.dtype).tiny))
    size = jnp.shape(block)[1]
    unit, index = jnp.eye(size, dtype=block.dtype), jnp.arange(size)

    def eliminate(step: Int[Array, ""], rest: Float[Array, "b 2b"]) -> Float[Array, "b 2b"]:
        pivot = rest[step, step]
        # What is rounding of the vectors before it is none of its own.
        scale = jnp.where(pivot > _DEPENDENT, 1 / jnp.sqrt(jnp.maximum(pivot, _DEPENDENT)), 0.0)
        row, below = scale * rest[step], jnp.where(index > step, scale * rest[:, step], 0.0)
        return jnp.where((index == step)[:, None], row, rest - below[:, None] * row)

    # Two steps of the loop as one: after one alone XLA copies all of it.
    reduced = jax.lax.fori_loop(0, size, eliminate, jnp.concatenate([block.T @ block, unit], axis=1), unroll=2)
    return block @ reduced[:, size:].T


def _unit(vector: Float[Array, "N 2"]) -> Float[Array, "N 2"]:
    return vector / jnp.sqrt(jnp.sum(vector**2))
