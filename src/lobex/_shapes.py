"""What shapes in signatures are of: words for arrays and numbers, to which jaxtyping adds kind and dimensions.

A shape says what a function sees: under ``jax.vmap`` that of one lane. Nothing checks it at run time but the tests.
"""

from typing import Any, TypeAlias

import jax
import numpy as np
from jaxtyping import Complex, Real

# Of NumPy where numbers are at hand, of JAX where they are traced.
AnyArray: TypeAlias = jax.Array | np.ndarray[Any, Any]
# One number, such as a speed at one point.
Number: TypeAlias = int | float | Real[jax.Array, ""] | Real[np.ndarray, ""]
# One number or many, in any shape.
Numbers: TypeAlias = int | float | Real[jax.Array, "..."] | Real[np.ndarray, "..."]
# The same as verbs are given them, lists included.
ArrayLike: TypeAlias = Numbers | list[Any] | tuple[Any, ...]
# Complex numbers, too.
ComplexLike: TypeAlias = ArrayLike | complex | Complex[jax.Array, "..."] | Complex[np.ndarray, "..."]
