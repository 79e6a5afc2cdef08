"""What depends on the form of a process alone is found once for each: its sizes and what is static, not its numbers."""

from collections.abc import Callable
from functools import lru_cache, partial, wraps
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np

Result = TypeVar("Result")

_FORMS = 256


def by_form(function: Callable[[Any, tuple[Any, ...], Any], Result]) -> Callable[[Any], Result]:
    """``function(made, shapes, number)`` of a process as ``function(process)``.

    It is given what makes the process of its numbers, the shapes of these, and the shape of a number: JAX traces it.
    """

    @lru_cache(maxsize=_FORMS)
    def known(tree: Any, shapes: tuple[Any, ...], number: Any) -> Result:
        return function(partial(jax.tree.unflatten, tree), shapes, number)

    @wraps(function)
    def found(process: Any) -> Result:
        leaves, tree = jax.tree.flatten(process)
        shapes = tuple(jax.ShapeDtypeStruct(np.shape(leaf), jnp.result_type(leaf)) for leaf in leaves)
        return known(tree, shapes, jax.ShapeDtypeStruct((), jnp.result_type(float)))

    return found
