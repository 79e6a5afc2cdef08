"""Matrix exponentials without data-dependent work: closed form to 2×2, a static scheme above."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

Array = Any

# A Taylor polynomial of degree 16 is exact to rounding below this norm: 0.5^17/17! = 2e-20.
_TAYLOR_NORM = 0.5
_TAYLOR = 1.0 / np.cumprod(np.r_[1.0, np.arange(1, 17)])
_MOST_SQUARINGS = 14


def exponential(matrix: Array) -> Array:
    """exp of a (…, s, s) matrix: closed form for s ≤ 2, else scaling and squaring."""
    size = jnp.shape(matrix)[-1]
    if size == 1:
        return jnp.exp(matrix)
    return _exponential_2x2(matrix) if size == 2 else scaled_exponential(matrix)


def _exponential_2x2(matrix: Array) -> Array:
    # exp M = e^h [cosh √q I + (sinh √q/√q)(M − hI)], h = tr M/2, q = −det(M − hI): entire in q, so that
    # the crossing from under- to overdamped is smooth. The growth e^√q is taken into e^h against overflow.
    half_trace = (matrix[..., 0, 0] + matrix[..., 1, 1]) / 2
    deviator = matrix - half_trace[..., None, None] * jnp.eye(2, dtype=matrix.dtype)
    q = deviator[..., 0, 0] ** 2 + deviator[..., 0, 1] * deviator[..., 1, 0]
    small = jnp.abs(q) < 1e-2
    safe = jnp.where(small, 1.0, jnp.abs(q))
    root = jnp.sqrt(safe)
    decay = jnp.exp(-2 * root)
    series_even = sum(q**k / float(np.prod(np.arange(1, 2 * k + 1), dtype=float)) for k in range(7))
    series_odd = sum(q**k / float(np.prod(np.arange(1, 2 * k + 2), dtype=float)) for k in range(7))
    real = (q > 0) & ~small
    even = jnp.where(small, series_even, jnp.where(real, (1 + decay) / 2, jnp.cos(root)))
    odd = jnp.where(small, series_odd, jnp.where(real, (1 - decay) / (2 * root), jnp.sin(root) / root))
    growth = jnp.exp(half_trace + jnp.where(real, root, 0.0))
    unit = jnp.eye(2, dtype=matrix.dtype)
    return growth[..., None, None] * (even[..., None, None] * unit + odd[..., None, None] * deviator)


def scaled_exponential(matrix: Array) -> Array:
    """exp of a (…, s, s) matrix by a Taylor polynomial of degree 16 and up to 14 squarings.

    The number of squarings follows the 1-norm of each matrix, in lockstep over a batch and without
    data-dependent loops, so reverse-mode gradients pass. Above a norm of 8192 the result is NaN.
    """
    norm = jax.lax.stop_gradient(jnp.max(jnp.sum(jnp.abs(matrix), axis=-2), axis=-1))
    needed = jnp.ceil(jnp.log2(jnp.maximum(norm / _TAYLOR_NORM, 1.0)))
    needed = jnp.where(needed <= _MOST_SQUARINGS, needed, jnp.nan)
    scaled = matrix / (2.0**needed)[..., None, None]
    unit = jnp.eye(jnp.shape(matrix)[-1], dtype=jnp.result_type(matrix))
    # Paterson-Stockmeyer: four groups of four powers.
    powers = [unit, scaled, scaled @ scaled]
    powers.append(powers[2] @ scaled)
    fourth = powers[2] @ powers[2]
    groups = [sum(_TAYLOR[4 * g + k] * powers[k] for k in range(4)) for g in range(4)]
    result = _TAYLOR[16] * fourth + groups[3]
    for group in reversed(groups[:3]):
        result = group + fourth @ result

    def square(power: Array, done: Array) -> tuple[Array, None]:
        return jnp.where((done < needed)[..., None, None], power @ power, power), None

    return jax.lax.scan(square, result, jnp.arange(_MOST_SQUARINGS))[0]
