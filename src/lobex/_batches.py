"""A compiled function over many points, in batches of one size, so that it is compiled once, on every core."""

from collections import defaultdict
from collections.abc import Callable, Hashable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from threading import Lock
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np

from lobex._devices import on_device, workers
from lobex._timing import carried

# Of points that are computed together on a core: these stay in its cache.
_TOGETHER = 16

Result = TypeVar("Result")


class FirstAlone:
    """Calls from several threads that share compiled programs by kind: the first of each kind is made alone, since side
    by side every one of them would compile.
    """

    def __init__(self) -> None:
        self._locks: defaultdict[Hashable, Lock] = defaultdict(Lock)
        self._made: set[Hashable] = set()

    def call(self, kind: Hashable, function: Callable[[], Result]) -> Result:
        """``function()``."""
        if kind not in self._made:
            with self._locks[kind]:
                if kind not in self._made:
                    result = function()
                    self._made.add(kind)
                    return result
        return function()


def in_batches(function: Callable[..., Any], arrays: tuple[np.ndarray, ...], size: int = 64) -> Any:
    """``function(count, *arrays)`` for one point or more along the arrays' first axis, as NumPy arrays.

    It is called with ``size`` points at a time, of which the first ``count`` are wanted: the last batch is filled up
    with repeats. Call it in the scope of float64.
    """
    total = len(arrays[0])

    def work(number: int) -> Any:
        start = number * size
        count = min(size, total - start)
        index = start + np.arange(size) % count
        with on_device(number):
            return jax.tree.map(np.asarray, function(count, *(a[index] for a in arrays)))

    # The first alone, so that nothing is compiled twice.
    parts = [work(0)]
    if total > size:
        with ThreadPoolExecutor(workers()) as pool:
            parts += pool.map(carried(work), range(1, -(-total // size)))
    return jax.tree.map(lambda *part: np.concatenate(part)[:total], *parts)


def together(size: int, few: int = _TOGETHER) -> int:
    """How many of the points of a batch are best computed side by side: ``few`` on a core, all on a GPU."""
    return min(size, few) if jax.default_backend() == "cpu" else size


def over_few(function: Callable[..., Any], several: int, count: Any, *arrays: Any) -> Any:
    """A traced ``function`` of single points along the arrays' first axis, ``several`` of them side by side.

    Of the first ``count`` points, which is a traced number: what fills up a batch is not computed, but zero.
    """
    groups = jax.tree.map(lambda part: part.reshape(part.shape[0] // several, several, *part.shape[1:]), arrays)
    # Under jit it is traced once, for the shapes of its results and in the loop.
    evaluate = jax.jit(jax.vmap(function))
    one = jax.tree.map(lambda part: jax.ShapeDtypeStruct(part.shape[1:], part.dtype), groups)
    number = jax.tree.leaves(groups)[0].shape[0]
    nothing = jax.tree.map(lambda part: jnp.zeros((number, *part.shape), part.dtype), jax.eval_shape(evaluate, *one))

    def step(index: Any, results: Any) -> Any:
        group = jax.tree.map(lambda part: jax.lax.dynamic_index_in_dim(part, index, keepdims=False), groups)
        put = partial(jax.lax.dynamic_update_index_in_dim, index=index, axis=0)
        return jax.tree.map(put, results, evaluate(*group))

    results = jax.lax.fori_loop(0, -(-count // several), step, nothing)
    return jax.tree.map(lambda part: part.reshape(number * several, *part.shape[2:]), results)
