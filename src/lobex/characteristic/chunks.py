"""Work over many speeds in chunks of one size, on two threads."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from lobex._devices import on_device

Array = Any

# Speeds of a chunk: what is known of them at one time stays in cache.
SPEEDS = 32
_THREADS = 2


def in_chunks(function: Callable[[Array, int], Any], index: Array) -> list[Any]:
    """``function(chunk, count)`` for parts of ``index``, each filled up with repeats behind its ``count`` members.

    The first chunk is done before the others begin, so that nothing is compiled twice.
    """

    def work(start: int) -> Any:
        part = index[start : start + SPEEDS]
        with on_device(start // SPEEDS):
            return function(np.resize(part, SPEEDS), len(part))

    if len(index) == 0:
        return []
    first = work(0)
    with ThreadPoolExecutor(_THREADS) as pool:
        return [first, *pool.map(work, range(SPEEDS, len(index), SPEEDS))]
