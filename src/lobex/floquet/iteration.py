"""The dominant multiplier by subspace iteration: matrix products on the whole batch, and a residual a point."""

from typing import Any

import jax.numpy as jnp
import numpy as np

from lobex.floquet.dense import upper_half

Array = Any

_SUBSPACE = 8
_SWEEPS = 2


def dominant_pair(matrix: Array, squarings: int = 5) -> tuple[Array, Array, Array]:
    """The eigenvalue of largest modulus of (N, N), Im ≥ 0, its unit vector, and the residual |Uv − μv|/|μ|.

    The work is fixed: U to the power 2^squarings, rescaled on the way, acts twice on a block of 8 vectors,
    and the dominant pair is taken from the projection of U on their span. Multipliers within the block need
    no separation. A residual above rounding says that the ninth is too close in modulus to the first, and
    that the pair is not to be trusted: take more squarings, or the dense solver.
    """
    size = jnp.shape(matrix)[-1]
    width = min(_SUBSPACE, size)
    start = np.linalg.qr(np.random.default_rng(7).standard_normal((size, width)))[0]
    power = matrix
    for _ in range(squarings):
        power = power @ power
        power = power / (jnp.sqrt(jnp.sum(power * power)) + jnp.finfo(power.dtype).tiny)
    block = jnp.asarray(start, dtype=power.dtype)
    for _ in range(_SWEEPS):
        block = jnp.linalg.qr(power @ block)[0]
    image = matrix @ block
    values, vectors = jnp.linalg.eig(block.T @ image)
    index = jnp.argmax(jnp.abs(values))
    value, weights = upper_half(values[index], vectors[:, index])
    vector = block @ weights
    residual = jnp.linalg.norm(image @ weights - value * vector) / jnp.abs(value)
    return value, vector, residual
