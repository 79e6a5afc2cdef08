"""The dominant multiplier by subspace iteration, for points where several have nearly its modulus."""

from typing import Any

import jax.numpy as jnp
import numpy as np

from lobex.floquet.dense import Triple, upper_half

Array = Any

_SUBSPACE = 8
_SQUARINGS = 8


def dominant_triple(matrix: Array) -> tuple[Triple, Array]:
    """The dominant multiplier of (N, N) and both its vectors, and the larger residual |Uv − μv|/|μ| of the two.

    The work is fixed: U to the power 2^8, rescaled on the way, and then lower powers act on a block of 8 vectors,
    and the dominant pair is taken from the projection of U on their span. Multipliers within the block need no
    separation, which ``power`` needs. A residual above rounding says that the ninth is too close in modulus to the
    first, and that the pair is not to be trusted.

    Where another multiplier has the modulus of the dominant one, left and right vector may belong to different
    ones; they are then orthogonal.
    """
    powers = _powers(matrix)
    value, right, residual = _projected(matrix, powers)
    _, left, mirrored = _projected(matrix.T, [power.T for power in powers])
    return Triple(value, right, left), jnp.maximum(residual, mirrored)


def _powers(matrix: Array) -> list[Array]:
    """Three rescaled powers of U, highest first.

    The highest leaves directions of rounding in the block, whose Ritz values can be anything (U is not
    normal); the lower powers turn these towards the next multipliers.
    """
    kept = {_SQUARINGS, _SQUARINGS // 2, 1}
    powers = []
    for count in range(1, _SQUARINGS + 1):
        matrix = matrix @ matrix
        matrix = matrix / (jnp.sqrt(jnp.sum(matrix * matrix)) + jnp.finfo(matrix.dtype).tiny)
        if count in kept:
            powers.append(matrix)
    return powers[::-1]


def _projected(matrix: Array, powers: list[Array]) -> tuple[Array, Array, Array]:
    size = jnp.shape(matrix)[-1]
    start = np.linalg.qr(np.random.default_rng(7).standard_normal((size, min(_SUBSPACE, size))))[0]
    block = jnp.asarray(start, dtype=matrix.dtype)
    for power in powers:
        block = jnp.linalg.qr(power @ block)[0]
    image = matrix @ block
    values, vectors = jnp.linalg.eig(block.T @ image)
    index = jnp.argmax(jnp.abs(values))
    value, weights = upper_half(values[index], vectors[:, index])
    vector = block @ weights
    residual = jnp.linalg.norm(image @ weights - value * vector) / jnp.abs(value)
    return value, vector, residual
