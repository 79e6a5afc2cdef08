"""A compiled function over many points, in batches of one size, so that it is compiled once, on every core."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import jax
import numpy as np

from lobex._devices import on_device, workers
from lobex._timing import carried

# Of points that are computed together on a core: these stay in its cache.
_TOGETHER = 16


def in_batches(function: Callable[..., Any], arrays: tuple[np.ndarray, ...], size: int = 64) -> Any:
    """``function(*arrays)`` for one point or more along the arrays' first axis, ``size`` at a time, as NumPy arrays.

    The last batch is filled up with repeats. Call it in the scope of float64.
    """
    total = len(arrays[0])

    def work(number: int) -> Any:
        start = number * size
        index = np.resize(np.arange(start, min(start + size, total)), size)
        with on_device(number):
            return jax.tree.map(np.asarray, function(*(a[index] for a in arrays)))

    # The first alone, so that nothing is compiled twice.
    parts = [work(0)]
    if total > size:
        with ThreadPoolExecutor(workers()) as pool:
            parts += pool.map(carried(work), range(1, -(-total // size)))
    return jax.tree.map(lambda *part: np.concatenate(part)[:total], *parts)


def together(size: int) -> int:
    """How many of the points of a batch are best computed side by side: few on a core, all on a GPU."""
    return min(size, _TOGETHER) if jax.default_backend() == "cpu" else size


def over_few(function: Callable[..., Any], several: int, *arrays: Any) -> Any:
    """A traced ``function`` of single points along the arrays' first axis, ``several`` of them side by side."""
    return jax.lax.map(lambda point: function(*point), arrays, batch_size=several)
