"""The numbers of a model, by the path that leads to each."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

# Of a complex number, such as a sample of a measurement.
_PARTS = (".real", ".imag")


def number_names(tree: Any) -> tuple[str, ...]:
    """Names of all numbers of a pytree, in the order of ``number_values``, such as "modes.damping_ratio[0]".

    A complex one is two, "modes.response[7].real" and "modes.response[7].imag".
    """
    names = []
    for path, leaf in jax.tree_util.tree_flatten_with_path(tree)[0]:
        stem = ".".join(str(getattr(key, "name", getattr(key, "key", getattr(key, "idx", key)))) for key in path)
        parts = _PARTS if np.iscomplexobj(leaf) else ("",)
        names += [stem + _index(index) + part for index in np.ndindex(np.shape(leaf)) for part in parts]
    return tuple(names)


def number_values(tree: Any) -> np.ndarray:
    """All numbers of a pytree, (p,)."""
    return np.concatenate([_values(np.asarray(leaf)) for leaf in jax.tree.leaves(tree)])


def in_rows(gradients: Any) -> Float[Array, "points parameters"]:
    """Gradients per point, in the order of ``number_values``, (n, p)."""
    return jnp.concatenate([_row(leaf) for leaf in jax.tree.leaves(gradients)], axis=1)


def _values(leaf: np.ndarray) -> np.ndarray:
    flat = leaf.ravel()
    return np.column_stack([np.real(flat), np.imag(flat)]).ravel() if np.iscomplexobj(flat) else flat.astype(np.float64)


def _row(leaf: Any) -> Any:
    # JAX has the derivatives of a real function by x + jy as ∂x − j∂y.
    parts = jnp.stack([leaf.real, -leaf.imag], axis=-1) if jnp.iscomplexobj(leaf) else leaf
    return parts.reshape(leaf.shape[0], -1)


def _index(index: tuple[int, ...]) -> str:
    return f"[{','.join(map(str, index))}]" if index else ""
