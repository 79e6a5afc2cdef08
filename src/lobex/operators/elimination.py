"""Inverses of matrices: of many small ones at once, without LAPACK, and of any, with pivots."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

Inverse = Callable[[Float[Array, "n n"]], Float[Array, "n n"]]

# Larger matrices are halved: products of batched matrices are quicker than elimination, but cost more to start.
_WHOLE = 26


@jax.custom_jvp
def pivoted_inverse(matrix: jax.Array) -> jax.Array:
    """The inverse X of A, (…, n, n), by LAPACK's LU; dX = −X dA X, so that no derivative goes through the LU."""
    return jnp.linalg.inv(matrix)


@pivoted_inverse.defjvp
def _(primals: tuple[jax.Array], tangents: tuple[jax.Array]) -> tuple[jax.Array, jax.Array]:
    found = pivoted_inverse(*primals)
    return found, -(found @ tangents[0] @ found)


@jax.custom_batching.custom_vmap
def inverse(matrix: jax.Array) -> jax.Array:
    """The inverse of (n, n) by elimination without pivoting.

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
    size = jnp.shape(matrices)[-1]
    return _by_halves(matrices, size // 2) if size > _WHOLE else _eliminated(matrices)


@_inverses.def_vmap
def _(size: int, batched: list[bool], matrices: jax.Array) -> tuple[jax.Array, bool]:
    shape = jnp.shape(matrices)
    return _inverses(matrices.reshape(-1, *shape[-2:])).reshape(shape), True


def _by_halves(matrices: jax.Array, half: int) -> jax.Array:
    """By the Schur complement of the leading block."""
    a, b = matrices[:, :half, :half], matrices[:, :half, half:]
    c, d = matrices[:, half:, :half], matrices[:, half:, half:]
    leading = _inverses(a)
    ca = c @ leading
    complement = _inverses(d - ca @ b)
    above = leading @ b @ complement
    rows = [[leading + above @ ca, -above], [-complement @ ca, complement]]
    return jnp.concatenate([jnp.concatenate(row, axis=2) for row in rows], axis=1)


# Halves of a size are traced once.
@jax.jit
def _eliminated(matrices: jax.Array) -> jax.Array:
    """By Gauss-Jordan elimination, two columns a step: half as many passes over the batch as one by one."""
    size = jnp.shape(matrices)[-1]
    even = size + size % 2
    index = jnp.arange(even)
    rest = jnp.pad(jnp.moveaxis(matrices, 0, -1), ((0, even - size), (0, even - size), (0, 0)))
    rest = rest + jnp.diag(jnp.where(index < size, 0.0, 1.0).astype(rest.dtype))[:, :, None]

    def eliminate(step: jax.Array, rest: jax.Array) -> jax.Array:
        k = 2 * step
        here = ((index == k) | (index == k + 1))[:, None]
        rows = jax.lax.dynamic_slice_in_dim(rest, k, 2, axis=0)
        columns = jax.lax.dynamic_slice_in_dim(rest, k, 2, axis=1)
        (a, b), (c, d) = jax.lax.dynamic_slice_in_dim(rows, k, 2, axis=1)
        # The pivots of the two steps in turn: that of the second is what the first leaves of it.
        second = 1 / (d - c / a * b)
        pivot = jnp.stack(
            [jnp.stack([(1 + b * second * c / a) / a, -b * second / a]), jnp.stack([-second * c / a, second])]
        )
        new = pivot[:, 0, None] * rows[0] + pivot[:, 1, None] * rows[1]
        new = jax.lax.dynamic_update_slice_in_dim(new, pivot, k, axis=1)
        rest = jnp.where(here, 0.0, rest) - columns[:, 0, None] * new[0] - columns[:, 1, None] * new[1]
        return jax.lax.dynamic_update_slice_in_dim(rest, new, k, axis=0)

    rest = jax.lax.fori_loop(0, even // 2, eliminate, rest)
    return jnp.moveaxis(rest[:size, :size], -1, 0)
