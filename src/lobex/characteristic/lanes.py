"""Functions of many lanes, in batches of few sizes so that each is compiled once."""

from typing import Any

import jax
import numpy as np

Array = Any

_SIZES = (1024, 16384)


def in_batches(function: Any, arrays: tuple[Array, ...]) -> tuple[Array, ...]:
    """``function(*arrays)`` over the first axis, (k, …), as NumPy arrays: the last batch is filled up with repeats."""
    count = len(arrays[0])
    size = next((s for s in _SIZES if s >= count), _SIZES[-1])
    parts = []
    for start in range(0, max(count, 1), size):
        part = [a[start : start + size] for a in arrays]
        filled = (np.resize(a, size) if count else np.zeros(size, a.dtype) for a in part)
        parts.append([np.asarray(result)[: len(part[0])] for result in function(*filled)])
    return tuple(map(np.concatenate, zip(*parts, strict=True)))


def take(lanes: Any, index: Array) -> Any:
    """The lanes of the given numbers, of a tree whose trailing axis they are."""
    return jax.tree.map(lambda a: a[..., index], lanes)
