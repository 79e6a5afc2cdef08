"""The numbers of a model, by the path that leads to each."""

from typing import Any

import jax
import numpy as np


def number_names(tree: Any) -> tuple[str, ...]:
    """Names of all numbers of a pytree, in the order of ``number_values``, such as "modes.damping_ratio[0]"."""
    names = []
    for path, leaf in jax.tree_util.tree_flatten_with_path(tree)[0]:
        stem = ".".join(str(getattr(key, "name", getattr(key, "key", getattr(key, "idx", key)))) for key in path)
        names += [stem + _index(index) for index in np.ndindex(np.shape(leaf))]
    return tuple(names)


def number_values(tree: Any) -> np.ndarray:
    """All numbers of a pytree, (p,)."""
    return np.concatenate([np.ravel(np.asarray(leaf, dtype=np.float64)) for leaf in jax.tree.leaves(tree)])


def _index(index: tuple[int, ...]) -> str:
    return f"[{','.join(map(str, index))}]" if index else ""
