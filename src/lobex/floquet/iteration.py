"""The dominant multiplier by subspace iteration: matrix products on the whole batch, and a residual a point."""

from typing import Any

import jax.numpy as jnp
import numpy as np

from lobex.floquet.dense import upper_half

Array = Any

# Measured on the rod of Appendix B and the milling of §3.4: at 16 vectors and U⁴⁸ three points in a hundred
# thousand keep a residual above the tolerance, and those go to the dense solver.
_SUBSPACE = 8
_SQUARINGS = 3
_SWEEPS = 3


def dominant_pair(matrix: Array) -> tuple[Array, Array, Array]:
    """The eigenvalue of largest modulus of (N, N), Im ≥ 0, its unit vector, and the residual |Uv − μv|/|μ|.

    The work is fixed: powers of U by repeated squaring act on a block of vectors, and the dominant pair is
    taken from the projection of U on their span. A residual above rounding says that more than the block's
    width of multipliers lie close in modulus to the largest, and that the pair is not to be trusted.
    """
    size = jnp.shape(matrix)[-1]
    width = min(_SUBSPACE, size)
    start = np.linalg.qr(np.random.default_rng(7).standard_normal((size, width)))[0]
    power = matrix
    for _ in range(_SQUARINGS):
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
