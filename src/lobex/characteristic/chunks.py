"""Work over many lanes in chunks of one size, on every core."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import jax
import numpy as np

from lobex._devices import on_device

Array = Any

_THREADS = 2


def in_chunks(function: Callable[[Array, int], Any], index: Array, sizes: tuple[int, ...]) -> list[Any]:
    """``function(chunk, count)`` for parts of ``index``, each filled up with repeats behind its ``count`` members.

    Chunks have the least of the increasing ``sizes`` that holds all, or the largest. The first is done before the
    others begin, so that nothing is compiled twice.
    """
    size = next((s for s in sizes if s >= len(index)), sizes[-1])

    def work(start: int) -> Any:
        part = index[start : start + size]
        with on_device(start // size):
            return function(np.resize(part, size), len(part))

    if len(index) == 0:
        return []
    first = work(0)
    with ThreadPoolExecutor(max(_THREADS, len(jax.local_devices()))) as pool:
        return [first, *pool.map(work, range(size, len(index), size))]
