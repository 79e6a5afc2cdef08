"""Coefficients at the nodes of pieces times matrices whose rows or columns are of the nodes."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from lobex._shapes import AnyArray


def rows(coefficient: Float[AnyArray, "*M q e r"], matrix: Float[Array, "*M qr p"]) -> Float[AnyArray, "*M qe p"]:
    """blockdiag(coefficient) · matrix: (…, q, e, r) by (…, q·r, p) → (…, q·e, p)."""
    *lanes, q, e, r = jnp.shape(coefficient)
    return acting(coefficient, matrix.reshape(*lanes, q, r, -1)).reshape(*lanes, q * e, -1)


def acting(coefficient: Float[AnyArray, "*M q e r"], samples: Float[Array, "*M q r p"]) -> Float[AnyArray, "*M q e p"]:
    """(…, q, e, r) times (…, q, r, p): as sums, since XLA is slow at products of a few rows."""
    parts = [coefficient[..., j, None] * samples[..., j, None, :] for j in range(jnp.shape(samples)[-2])]
    return sum(parts[1:], parts[0])


def framed(matrix: Float[AnyArray, "*M p qe"], coefficient: Float[AnyArray, "*M q e c"]) -> Float[AnyArray, "*M p qc"]:
    """matrix · blockdiag(coefficient): (…, p, q·e) by (…, q, e, c) → (…, p, q·c)."""
    *lanes, q, e, c = jnp.shape(coefficient)
    parts = matrix.reshape(*lanes, -1, q, e)
    found = sum(parts[..., j, None] * coefficient[..., None, :, j, :] for j in range(e))
    return jnp.reshape(found, (*lanes, -1, q * c))
