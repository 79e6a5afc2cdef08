"""Trees of many lanes, whose trailing axis they are, filled up so that their shapes are few."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Inexact, Int

# Lanes that a chunk has at most.
LANES = 4096


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
