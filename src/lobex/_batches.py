"""Compiled functions over many points, in batches of one size, so that each is compiled once."""

from collections import defaultdict
from collections.abc import Callable, Hashable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import pairwise
from threading import Lock
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Int, Shaped

from lobex._devices import on_device, threads
from lobex._timing import carried

# Of points that are computed together on a core: these stay in its cache.
_TOGETHER = 16
# Rows of a batch of lanes.
_ROWS = 1024

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


def side_by_side(work: Callable[[int], Result], count: int, first_alone: bool = True) -> Iterator[Result]:
    """``work(number)`` of parts 0 … count − 1, in their order, on every core and device, in float64.

    What they share is compiled by the first, which is done before the others begin; parts that see to that themselves
    say that it need not be alone.
    """

    def part(number: int) -> Result:
        with on_device(number):
            return work(number)

    alone = min(int(first_alone), count)
    yield from map(part, range(alone))
    if count > alone:
        with ThreadPoolExecutor(threads()) as pool:
            yield from pool.map(carried(part), range(alone, count))


def in_chunks(function: Callable[[Int[Any, " _"]], Any], lanes: int, size: int, first_alone: bool = True) -> list[Any]:
    """``function(numbers of lanes)`` for parts of ``size`` at most, of which the first, if it is alone, is small."""
    first = -(-size // 4) if first_alone else size
    edges = [0, *range(first, lanes, size), lanes] if lanes > size else [0, lanes]
    numbers = [np.arange(*ends) for ends in pairwise(edges) if ends[1] > ends[0]]
    return list(side_by_side(lambda part: function(numbers[part]), len(numbers), first_alone))


def in_batches(
    function: Callable[..., Any], arrays: tuple[np.ndarray, ...], size: int = 64, first: int | None = None
) -> Any:
    """``function(count, *arrays)`` for one point or more along the arrays' first axis, as NumPy arrays.

    It is called with ``size`` points at a time, of which the first ``count`` are wanted: what is missing is filled up
    with repeats. Of the first call, which is made alone so that nothing is compiled twice, ``first`` are, if not all:
    few, where it computes no others. Call it in the scope of float64.
    """
    total = len(arrays[0])
    edges = [0, *range(min(first or size, total), total, size), total]

    def work(part: int) -> Any:
        count, filled = _filled(arrays, edges[part], edges[part + 1], size)
        return jax.tree.map(lambda result: np.asarray(result)[:count], function(count, *filled))

    return jax.tree.map(lambda *part: np.concatenate(part), *side_by_side(work, len(edges) - 1))


def in_one_size(function: Any, arrays: tuple[Shaped[Any, "k ..."], ...], size: int = _ROWS) -> Any:
    """``function(*arrays)`` over the first axis, (k, …), as NumPy arrays, within one thread, which k may be 0 for.

    The last batch is filled up with repeats, so that one program serves however many they are.
    """
    parts = []
    for start in range(0, max(len(arrays[0]), 1), size):
        count, filled = _filled(arrays, start, min(start + size, len(arrays[0])), size)
        parts.append((count, function(*filled)))
    # All are begun before the first is waited for.
    results = [jax.tree.map(lambda part, count=count: np.asarray(part)[:count], result) for count, result in parts]
    return jax.tree.map(lambda *part: np.concatenate(part), *results)


def _filled(arrays: tuple[np.ndarray, ...], start: int, end: int, size: int) -> tuple[int, list[np.ndarray]]:
    """How many rows there are from ``start`` to ``end``, and ``size`` of them with their repeats, or of zeros."""
    count = end - start
    if count == 0:
        return 0, [np.zeros((size, *part.shape[1:]), part.dtype) for part in arrays]
    index = start + np.arange(size) % count
    return count, [part[index] for part in arrays]


def together(size: int, few: int = _TOGETHER) -> int:
    """How many of the points of a batch are best computed side by side: ``few`` on a core, all on a GPU."""
    return min(size, few) if jax.default_backend() == "cpu" else size


def over_few(function: Callable[..., Any], several: int, count: Any, *arrays: Any) -> Any:
    """A traced ``function`` of single points along the arrays' first axis, ``several`` of them side by side.

    Of the first ``count`` points, which is a traced number: what fills up a batch is not computed, but zero.
    """
    groups = jax.tree.map(lambda part: part.reshape(part.shape[0] // several, several, *part.shape[1:]), arrays)
    # Under jit it is traced once, for the shapes of its results and in the loop; and once more under jit for a single
    # point, since mapping what is traced takes less time than mapping every operation while it is traced.
    evaluate = jax.jit(jax.vmap(jax.jit(function)))
    one = jax.tree.map(lambda part: jax.ShapeDtypeStruct(part.shape[1:], part.dtype), groups)
    number = jax.tree.leaves(groups)[0].shape[0]
    nothing = jax.tree.map(lambda part: jnp.zeros((number, *part.shape), part.dtype), jax.eval_shape(evaluate, *one))

    def step(index: Any, results: Any) -> Any:
        group = jax.tree.map(lambda part: jax.lax.dynamic_index_in_dim(part, index, keepdims=False), groups)
        put = partial(jax.lax.dynamic_update_index_in_dim, index=index, axis=0)
        return jax.tree.map(put, results, evaluate(*group))

    results = jax.lax.fori_loop(0, -(-count // several), step, nothing)
    return jax.tree.map(lambda part: part.reshape(number * several, *part.shape[2:]), results)
