"""NumPy for numbers at hand and JAX for numbers that it traces: the same functions under the same names.

JAX compiles a program for every function and shape that it meets outside ``jit``; work of a few numbers, such as
the modes of a structure, takes a thousandth of that by NumPy.
"""

from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np

from lobex._checks import is_traced

Tree = TypeVar("Tree")


def namespace(*values: Any) -> Any:
    """``numpy``, or ``jax.numpy`` where a number in ``values`` is traced."""
    return jnp if any(map(is_traced, values)) else np


def still(tree: Tree) -> Tree:
    """The tree without its derivatives, where JAX traces it."""
    return tree if namespace(tree) is np else jax.lax.stop_gradient(tree)
