"""The exact limits of many structures of as many modes, each at speeds of its own."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from lobex._batches import in_batches
from lobex._compiled import compiled, compiled_quickly
from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._shapes import AnyArray
from lobex.limits.closed_form import Regeneration
from lobex.limits.d_subdivision import every_stretch, limit_at
from lobex.limits.stretches import Stretches

# Structures, and points, that are computed together.
_STRUCTURES, _POINTS = 16, 128


@in_float64
def limits_of_each(
    sources: Regeneration, number: Int[np.ndarray, " p"], speed: Float[AnyArray, " p"]
) -> tuple[Float[AnyArray, " p"], Float[AnyArray, " p"], Bool[AnyArray, " p"]]:
    """Gain, ω and tie of points (p,), NaN where there is no limit, as ``exact_critical`` has them.

    Args:
        sources: with a leading axis in all its fields.
        number: which of them each point is of.
        speed: Hz.
    """
    if namespace(sources, speed) is jnp:
        parts = _stretches_of_each(sources)
        gain, omega, _, tie = _of_points(sources, parts, jnp.asarray(number), speed)
        return gain, omega, tie
    leaves, tree = jax.tree.flatten(sources)

    def stretches(_: int, *leaves: Any) -> Stretches:
        return _stretches_of_each(jax.tree.unflatten(tree, leaves))

    parts = in_batches(stretches, tuple(map(np.asarray, leaves)), _STRUCTURES)
    known, form = jax.tree.flatten((sources, parts))

    def limits(_: int, number: Any, speed: Any) -> Any:
        own, rows = np.unique(number, return_inverse=True)
        # As many rows whatever they are, so that one program serves.
        own = np.resize(own, _POINTS)
        sources, parts = jax.tree.unflatten(form, [np.asarray(leaf)[own] for leaf in known])
        return _of_points(sources, parts, rows, speed)

    gain, omega, _, tie = in_batches(limits, (np.asarray(number), np.asarray(speed)), _POINTS)
    return gain, omega, tie


_stretches_of_each = compiled_quickly(jax.vmap(every_stretch))


@compiled
def _of_points(
    sources: Regeneration, parts: Stretches, number: Int[AnyArray, " p"], speed: Float[AnyArray, " p"]
) -> Any:
    def at(number: Any, speed: Any) -> Any:
        source, own = jax.tree.map(lambda leaf: leaf[number], (sources, parts))
        return limit_at(source, own, None, speed)

    return jax.vmap(at)(number, speed)
