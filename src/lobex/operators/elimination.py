"""Inverses of many small matrices at once, without LAPACK."""

import jax
import jax.numpy as jnp


@jax.custom_batching.custom_vmap
def inverse(matrix: jax.Array) -> jax.Array:
    """The inverse of (n, n) by Gauss-Jordan elimination without pivoting.

    Made for matrices I − HP with a causal H, whose leading blocks are those of shorter intervals. Nothing
    looks at the pivots: what is computed with the result must be checked. In a batch the matrices lie along the
    trailing axis, where elimination is elementwise.
    """
    return _inverses(matrix[None])[0]


@inverse.def_vmap
def _(size: int, batched: list[bool], matrix: jax.Array) -> tuple[jax.Array, bool]:
    return _inverses(matrix), True


@jax.custom_batching.custom_vmap
def _inverses(matrices: jax.Array) -> jax.Array:
    """Of (batch, n, n)."""
    columns = jnp.arange(jnp.shape(matrices)[-1])

    def eliminate(k: jax.Array, rest: jax.Array) -> jax.Array:
        here = (columns == k)[:, None]
        row = jax.lax.dynamic_index_in_dim(rest, k, 0, keepdims=False)
        column = jnp.where(here, 0.0, jax.lax.dynamic_index_in_dim(rest, k, 1, keepdims=False))
        row = jnp.where(here, 1.0, row) / jax.lax.dynamic_index_in_dim(row, k, 0, keepdims=False)
        rest = jnp.where(here[None], 0.0, rest) - column[:, None] * row[None]
        return jnp.where(here[:, None], row[None], rest)

    return jnp.moveaxis(jax.lax.fori_loop(0, len(columns), eliminate, jnp.moveaxis(matrices, 0, -1)), -1, 0)


@_inverses.def_vmap
def _(size: int, batched: list[bool], matrices: jax.Array) -> tuple[jax.Array, bool]:
    shape = jnp.shape(matrices)
    return _inverses(matrices.reshape(-1, *shape[-2:])).reshape(shape), True
