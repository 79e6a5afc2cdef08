"""Evaluation over broadcast arrays of speed and gain."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp


def over_points(function: Callable[[Any, Any], Any], speed: Any, gain: Any) -> Any:
    """Map ``function(speed, gain)`` of two scalars over the broadcast shape of two arrays.

    One ``vmap`` per axis, over the arguments that vary along it: with a speed of shape (n, 1) and a gain of
    shape (m,), whatever depends on the speed alone is computed n times and not n·m times.
    """
    arrays = [jnp.asarray(a, dtype=jnp.result_type(float)) for a in (speed, gain)]
    dimensions = len(jnp.broadcast_shapes(*(a.shape for a in arrays)))
    arrays = [a.reshape((1,) * (dimensions - a.ndim) + a.shape) for a in arrays]
    shapes = [a.shape for a in arrays]
    mapped = function
    for axis in reversed(range(dimensions)):
        varies = [shape[axis] != 1 for shape in shapes]
        if not any(varies):
            varies[0] = True
        mapped = jax.vmap(mapped, in_axes=tuple(0 if v else None for v in varies))
        arrays = [a if v else a.squeeze(axis) for a, v in zip(arrays, varies, strict=True)]
    return mapped(*arrays)
