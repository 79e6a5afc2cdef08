"""Float64 inside public calls, whatever the caller's JAX setting, and no setting changed outside them."""

import functools
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, cast

import jax
import numpy as np

from lobex._checks import is_traced

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


def in_float64(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Run ``function`` in float64 and hand its arrays back as NumPy arrays.

    A call with traced arguments, inside somebody's ``jit``, ``grad`` or ``vmap``, is passed through
    untouched: it follows the precision of its inputs. NumPy, because a float64 JAX array falls back to
    float32 in the first operation outside the scope.
    """

    @functools.wraps(function)
    def wrapped(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        if any(map(is_traced, jax.tree.leaves((args, kwargs)))):
            return function(*args, **kwargs)
        # Inside somebody's jit, plain numbers are still computed with now and not traced.
        with jax.enable_x64(True), jax.ensure_compile_time_eval():
            wide: Any = jax.tree.map(_widen, (args, kwargs))
            return jax.tree.map(_to_numpy, cast(Any, function)(*wide[0], **wide[1]))

    return wrapped


def _widen(leaf: Any) -> Any:
    if isinstance(leaf, jax.Array | np.ndarray | np.generic) and np.issubdtype(leaf.dtype, np.floating):
        return np.asarray(leaf, dtype=np.float64)
    return leaf


def _to_numpy(leaf: Any) -> Any:
    return np.asarray(leaf) if isinstance(leaf, jax.Array) else leaf
