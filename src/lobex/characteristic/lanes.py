"""Functions of many lanes, in batches of few sizes so that each is compiled once."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Inexact, Int, Shaped

# Lanes that a chunk has at most, and arguments that a batch has.
LANES = 4096
_SIZES = (512, 4096)
# So many batches of a smaller size take no longer than one of the next.
_FEW = 4


def in_few_sizes(
    function: Any, arrays: tuple[Shaped[Any, "k ..."], ...], sizes: tuple[int, ...] = _SIZES
) -> tuple[Shaped[Any, "k ..."], ...]:
    """``function(*arrays)`` over the first axis, (k, …), as NumPy arrays: the last batch is filled up with repeats.

    A function that is compiled for one size alone names it.
    """
    count = len(arrays[0])
    size = next((s for s in sizes if _FEW * s >= count), sizes[-1])
    parts = []
    for start in range(0, max(count, 1), size):
        part = [a[start : start + size] for a in arrays]
        filled = (
            np.resize(a, (size, *a.shape[1:])) if count else np.zeros((size, *a.shape[1:]), a.dtype) for a in part
        )
        parts.append((len(part[0]), function(*filled)))
    # All are begun before the first is waited for.
    results = [[np.asarray(result)[:length] for result in results] for length, results in parts]
    return tuple(map(np.concatenate, zip(*results, strict=True)))


def take(lanes: Any, index: Int[Any, " _"]) -> Any:
    """The lanes of the given numbers, of a tree whose trailing axis they are."""
    return jax.tree.map(lambda a: a[..., index], lanes)


def placed(lanes: Any) -> Any:
    """A tree of lanes where it is computed with, filled up to whole ``LANES`` so that its shapes are few."""

    def filled(part: Inexact[Any, "*others _"]) -> Inexact[Any, "*others _"]:
        missing = -np.shape(part)[-1] % LANES
        return jnp.asarray(np.pad(part, [(0, 0)] * (np.ndim(part) - 1) + [(0, missing)], mode="edge"))

    return jax.tree.map(filled, lanes)


def with_modes(part: Inexact[Any, "modes ..."], fill: Inexact[Any, "..."]) -> Inexact[Any, "_ ..."]:
    """An array (modes, …) filled up to one of few numbers of modes."""
    return np.concatenate([part, np.broadcast_to(fill, (few(len(part)) - len(part), *np.shape(part)[1:]))])


def few(count: int) -> int:
    """The next of few numbers: powers of two, and those half-way between."""
    power = 2 ** max(count - 1, 0).bit_length()
    return 3 * power // 4 if power >= 4 and count <= 3 * power // 4 else power
