"""A loop over lanes that end each in its own time, with one body for NumPy and for JAX."""

from collections.abc import Callable
from typing import Any, TypeVar

import jax
import numpy as np
from jaxtyping import Bool

from lobex._namespace import namespace
from lobex._shapes import AnyArray

State = TypeVar("State")


def repeated(
    improve: Callable[[Any, State], State],
    unfinished: Callable[[Any, State], Bool[AnyArray, " *lanes"]],
    given: Any,
    state: State,
) -> State:
    """``improve(given, state)`` of every lane for as long as that is ``unfinished(given, state)``.

    Traced by JAX, ``given`` and ``state`` are those of one lane, and ``vmap`` has many. In NumPy they have a leading
    axis of lanes, and only lanes that are unfinished are computed again; what is given as one number is so for all.

    Args:
        improve: a new state, of the same tree.
        unfinished: whether a lane goes on.
        given: a tree of what does not change.
        state: a tree.
    """
    if namespace(given, state) is not np:
        return jax.lax.while_loop(lambda now: unfinished(given, now), lambda now: improve(given, now), state)
    parts, tree = jax.tree.flatten(state)
    whole = [np.array(part) for part in parts]
    known, form = jax.tree.flatten(given)
    left = np.arange(len(whole[0]))
    rest, own = [part.copy() for part in whole], [_of_lanes(part, len(left)) for part in known]
    while len(left):
        on = unfinished(jax.tree.unflatten(form, own), jax.tree.unflatten(tree, rest))
        if not np.all(on):
            for part, new in zip(whole, rest, strict=True):
                part[left] = new
            left, rest, own = left[on], [part[on] for part in rest], [part[on] for part in own]
        if len(left):
            rest = jax.tree.leaves(improve(jax.tree.unflatten(form, own), jax.tree.unflatten(tree, rest)))
    return jax.tree.unflatten(tree, whole)


def _of_lanes(part: Any, lanes: int) -> np.ndarray:
    part = np.asarray(part)
    return part if part.ndim else np.broadcast_to(part, lanes)
