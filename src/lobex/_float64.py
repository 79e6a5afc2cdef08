"""Float64 inside public calls, whatever the caller's JAX setting, and no setting changed outside them."""

import functools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, ParamSpec, TypeVar, cast

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import eval_context

from lobex._checks import is_traced

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")
Tree = TypeVar("Tree")


@contextmanager
def at_once() -> Iterator[None]:
    """Float64, and numbers at once: within somebody's jit, too, what depends on nothing traced is not traced."""
    with jax.enable_x64(True), eval_context():
        yield


def widened(tree: Tree) -> Tree:
    """All numbers of a tree as NumPy arrays of double precision."""
    return jax.tree.map(
        lambda leaf: np.asarray(leaf, dtype=np.complex128 if np.iscomplexobj(leaf) else np.float64), tree
    )


def in_float64(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Run ``function`` in float64 and hand its arrays back as NumPy arrays.

    A call with traced arguments, inside somebody's ``jit``, ``grad`` or ``vmap``, follows the precision that JAX is
    set to, and so do all its arguments: a model of float32 arrays joins a float64 speed. NumPy, because a float64 JAX
    array falls back to float32 in the first operation outside the scope.
    """

    @functools.wraps(function)
    def wrapped(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        if is_traced((args, kwargs)):
            alike: Any = jax.tree.map(_as_set, (args, kwargs))
            return cast(Any, function)(*alike[0], **alike[1])
        with at_once():
            wide: Any = jax.tree.map(_as_set, (args, kwargs))
            return jax.tree.map(_to_numpy, cast(Any, function)(*wide[0], **wide[1]))

    return wrapped


def _as_set(leaf: Any) -> Any:
    """Arrays of floating point in the precision that JAX is set to."""
    if not (isinstance(leaf, jax.Array | np.ndarray | np.generic) and np.issubdtype(leaf.dtype, np.floating)):
        return leaf
    precision = jnp.result_type(float)
    return leaf.astype(precision) if is_traced(leaf) else np.asarray(leaf, dtype=precision)


def _to_numpy(leaf: Any) -> Any:
    return np.asarray(leaf) if isinstance(leaf, jax.Array) else leaf
