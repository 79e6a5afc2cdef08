"""Integrals of a matrix exponential against Legendre polynomials: Duhamel's integral without quadrature error."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex._shapes import AnyArray
from lobex.operators.elimination import pivoted_inverse

# Gauss quadrature with this many points is exact to rounding up to this norm; above it, the recurrence is stable.
_SAMPLES = 28
_GAUSS_NORM = 28.0


def legendre_values(points: np.ndarray, count: int) -> np.ndarray:
    """P_0 … P_{count−1} of 2σ − 1 at points σ of [0, 1], shape (points, count)."""
    return np.polynomial.legendre.legvander(2 * np.asarray(points) - 1, count - 1)


def cell_phases(widths: np.ndarray) -> np.ndarray:
    """Where exponential_moments samples cells of widths: (cells, samples), measured back from each end."""
    points = np.polynomial.legendre.leggauss(_SAMPLES)[0]
    return widths[:, None] * (1 - points) / 2


def exponential_moments(
    matrix: Float[AnyArray, "*lanes s s"],
    end: Float[Array, "*lanes s s"],
    samples: Float[Array, "p *lanes s s"],
    count: int,
) -> Float[Array, "{count} *lanes s s"]:
    """∫₀¹ exp(Z(1 − σ)) P_k(2σ − 1) dσ for k < count: (…, s, s) → (count, …, s, s), for 2 ≤ count ≤ 14.

    Of small Z by Gauss quadrature. Of large Z by M_{k+1} = M_{k−1} + 2(2k + 1) Z⁻¹ M_k, which follows from
    integration by parts and P′_{k+1} − P′_{k−1} = (2k + 1) P_k, and is stable while k is below |Z|/2 (it is the
    recurrence of the spherical Bessel functions, DLMF 10.51).

    Args:
        matrix: Z, (…, s, s).
        end: exp(Z), (…, s, s).
        samples: exp(Z(1 − σ)) at the points of ``cell_phases``, (samples, …, s, s).
        count: number of moments.
    """
    points, weights = np.polynomial.legendre.leggauss(_SAMPLES)
    values = legendre_values((points + 1) / 2, count)
    small = jnp.tensordot((weights[:, None] / 2 * values).T, samples, axes=1)
    unit = jnp.eye(jnp.shape(matrix)[-1], dtype=matrix.dtype)
    size = jnp.min(jnp.sqrt(jnp.sum(matrix**2, axis=-1)), axis=-1)
    large = (size > _GAUSS_NORM)[..., None, None]
    # Where the recurrence is not wanted it sees the identity: it must not meet a singular Z.
    inverse = _inverse(jnp.where(large, matrix, unit))
    zeroth = inverse @ (end - unit)
    first = inverse @ (2 * zeroth - end - unit)

    def step(
        pair: tuple[Float[Array, "*lanes s s"], Float[Array, "*lanes s s"]], k: Float[Array, ""]
    ) -> tuple[tuple[Float[Array, "*lanes s s"], Float[Array, "*lanes s s"]], Float[Array, "*lanes s s"]]:
        before, now = pair
        after = before + 2 * (2 * k + 1) * (inverse @ now)
        return (now, after), after

    _, later = jax.lax.scan(step, (zeroth, first), jnp.arange(1.0, count - 1))
    return jnp.where(large, jnp.concatenate([zeroth[None], first[None], later]), small)


def _inverse(matrix: Float[Array, "*lanes s s"]) -> Float[Array, "*lanes s s"]:
    """Of (…, s, s); in closed form for s ≤ 2, since small LAPACK calls are slow."""
    size = jnp.shape(matrix)[-1]
    if size == 1:
        return 1 / matrix
    if size > 2:
        return pivoted_inverse(matrix)
    a, b, c, d = matrix[..., 0, 0], matrix[..., 0, 1], matrix[..., 1, 0], matrix[..., 1, 1]
    adjugate = jnp.stack([jnp.stack([d, -b], -1), jnp.stack([-c, a], -1)], -2)
    return adjugate / (a * d - b * c)[..., None, None]
