"""Matrix exponentials without data-dependent work: closed form to 2×2, a static scheme above."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from lobex._shapes import AnyArray

# A Taylor polynomial of degree 16 is exact to rounding below this norm: 0.5^17/17! = 2e-20.
_TAYLOR_NORM = 0.5
_TAYLOR = 1.0 / np.cumprod(np.r_[1.0, np.arange(1, 17)])
_MOST_SQUARINGS = 14
# cosh √q and sinh √q/√q as series in q: where |q| is below 0.01 the next term of either is below 3e-21.
_EVEN, _ODD = _TAYLOR[0:14:2].tolist(), _TAYLOR[1:14:2].tolist()


def exponential(matrix: Float[AnyArray, "*lanes s s"]) -> Float[Array, "*lanes s s"]:
    """exp of a (…, s, s) matrix: closed form for s ≤ 2, else scaling and squaring."""
    size = jnp.shape(matrix)[-1]
    if size == 1:
        return jnp.exp(matrix)
    return _exponential_2x2(matrix) if size == 2 else scaled_exponential(matrix)


def _exponential_2x2(matrix: Float[AnyArray, "*lanes 2 2"]) -> Float[Array, "*lanes 2 2"]:
    # exp M = e^h [cosh √q I + (sinh √q/√q)(M − hI)], h = tr M/2, q = −det(M − hI): entire in q, so that
    # the crossing from under- to overdamped is smooth. The growth e^√q is taken into e^h against overflow.
    a, b, c, d = (matrix[..., i, j] for i in range(2) for j in range(2))
    half_trace, half = (a + d) / 2, (a - d) / 2
    q = half * half + b * c
    small = jnp.abs(q) < 1e-2
    root = jnp.sqrt(jnp.where(small, 1.0, jnp.abs(q)))
    decay = jnp.exp(-2 * root)
    real = (q > 0) & ~small
    even = jnp.where(small, _polynomial(_EVEN, q), jnp.where(real, (1 + decay) / 2, jnp.cos(root)))
    odd = jnp.where(small, _polynomial(_ODD, q), jnp.where(real, (1 - decay) / (2 * root), jnp.sin(root) / root))
    growth = jnp.exp(half_trace + jnp.where(real, root, 0.0))
    even, odd = growth * even, growth * odd
    # As sums of matrices: an entry at a time, XLA would compute the functions for each of them.
    even, odd, middle = (part[..., None, None] for part in (even, odd, half_trace))
    unit = jnp.eye(2, dtype=jnp.result_type(matrix))
    return jnp.add(even * unit, odd * (matrix - middle * unit))


def _polynomial(coefficients: list[float], x: float | Float[AnyArray, "..."]) -> float | Float[AnyArray, "..."]:
    """By Horner's rule, the constant term first."""
    value = coefficients[-1] * x + coefficients[-2]
    for coefficient in coefficients[-3::-1]:
        value = value * x + coefficient
    return value


def scaled_exponential(matrix: Float[AnyArray, "*lanes s s"]) -> Float[Array, "*lanes s s"]:
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

    def square(power: Float[Array, "*lanes s s"], done: Int[Array, ""]) -> tuple[Float[Array, "*lanes s s"], None]:
        return jnp.where((done < needed)[..., None, None], power @ power, power), None

    return jax.lax.scan(square, result, jnp.arange(_MOST_SQUARINGS))[0]
