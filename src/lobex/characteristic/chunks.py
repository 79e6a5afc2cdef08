"""Work over many lanes in chunks, on every core."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import jax
import numpy as np
from jaxtyping import Int

from lobex._devices import on_device

_THREADS = 2


def in_chunks(function: Callable[[Int[Any, " _"]], Any], lanes: int, size: int) -> list[Any]:
    """``function(numbers of lanes)`` for parts of ``size`` at most.

    The first, a small one, is done before the others begin, so that nothing is compiled twice.
    """
    if lanes == 0:
        return []
    edges = [0, *range(-(-size // 4), lanes, size), lanes] if lanes > size else [0, lanes]

    def work(part: int) -> Any:
        with on_device(part):
            return function(np.arange(edges[part], edges[part + 1]))

    first = work(0)
    with ThreadPoolExecutor(max(_THREADS, len(jax.local_devices()))) as pool:
        return [first, *pool.map(work, range(1, len(edges) - 1))]
