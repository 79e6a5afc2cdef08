"""A compiled function over many points, in batches of one size, so that it is compiled once."""

from collections.abc import Callable
from typing import Any

import jax
import numpy as np


def in_batches(
    function: Callable[..., Any], fixed: tuple[Any, ...], arrays: tuple[np.ndarray, ...], size: int = 64
) -> Any:
    """``function(*fixed, *arrays)`` for one point or more along the arrays' first axis, ``size`` at a time.

    The last batch is filled up with repeats. ``fixed`` goes to every batch as it is.
    """
    total = len(arrays[0])
    parts = []
    for start in range(0, total, size):
        index = np.arange(start, min(start + size, total))
        padded = np.resize(index, size)
        parts.append(function(*fixed, *(a[padded] for a in arrays)))
    return jax.tree.map(lambda *part: np.concatenate(part)[:total], *parts)
