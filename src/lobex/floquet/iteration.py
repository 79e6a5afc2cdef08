"""The dominant multiplier by subspace iteration, for points where several have nearly its modulus."""

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float

from lobex.floquet.dense import Triple, upper_half

_SUBSPACE = 8
_SQUARINGS = 8


def triple_by_iteration(matrix: Float[Array, "N N"]) -> tuple[Triple, Float[Array, ""]]:
    """The dominant multiplier of (N, N) and both its vectors, and the larger residual |Uv − μv|/|μ| of the two.

    The work is fixed: U to the power 2^8, rescaled on the way, and then lower powers act on a block of 8 vectors,
    and the dominant pair is taken from the projection of U on their span. Multipliers within the block need no
    separation, which ``power`` needs. A residual above rounding says that the ninth is too close in modulus to the
    first, and that the pair is not to be trusted.

    Where another multiplier has the modulus of the dominant one, left and right vector may belong to different
    ones; they are then orthogonal.
    """
    # Both sides at once, which compiles half as much as one after the other.
    powers = [jnp.stack([power, power.T]) for power in (*_powers(matrix), matrix)]
    values, (right, left), residuals = jax.vmap(lambda *sides: _projected(sides[-1], sides[:-1]))(*powers)
    return Triple(values[0], right, left), jnp.max(residuals)


def _powers(matrix: Float[Array, "N N"]) -> list[Float[Array, "N N"]]:
    """Three rescaled powers of U, highest first.

    The highest leaves directions of rounding in the block, whose Ritz values can be anything (U is not
    normal); the lower powers turn these towards the next multipliers.
    """

    def square(power: Float[Array, "N N"], _: None) -> tuple[Float[Array, "N N"], Float[Array, "N N"]]:
        power = power @ power
        power = power / (jnp.sqrt(jnp.sum(power * power)) + jnp.finfo(power.dtype).tiny)
        return power, power

    _, powers = jax.lax.scan(square, matrix, None, length=_SQUARINGS)
    return [powers[count - 1] for count in (_SQUARINGS, _SQUARINGS // 2, 1)]


def _projected(
    matrix: Float[Array, "N N"], powers: Sequence[Float[Array, "N N"]]
) -> tuple[Complex[Array, ""], Complex[Array, " N"], Float[Array, ""]]:
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
