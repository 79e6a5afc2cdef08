"""Where delays find what is remembered: in which piece of the past, at which place of it."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from lobex._shapes import AnyArray
from lobex.systems.mesh import Mesh
from lobex.systems.system import DelaySystem

# Of a piece, what rounding may put before the oldest one that is remembered.
_ROUNDING = 1e-6
# Of a piece, so far from its ends that a delay which jumps there is that of the piece.
_INSIDE = 1e-12


def pieces_back(mesh: Mesh) -> np.ndarray:
    """The numbers of the H pieces before each piece, oldest first, and its own, (M, H + 1)."""
    return (np.arange(mesh.pieces)[:, None] + np.arange(-mesh.history, 1)) % mesh.pieces


def look_up(system: DelaySystem, mesh: Mesh, points: np.ndarray) -> tuple[Int[Array, "M K q"], Float[Array, "M K q"]]:
    """Where each of K delays finds what acts at points of every piece.

    Args:
        system: the delay system.
        mesh: its mesh.
        points: places within a piece, from 0 to 1, (q,).

    Returns:
        Which of the H pieces before, oldest first, or H for the piece itself, and where within it, from 0 to 1; both
        (M, K, q). A delay that is not in the range that the system says is found nowhere: NaN.
    """
    turns = (np.arange(mesh.pieces)[:, None] + np.arange(-mesh.history, 1)) // mesh.pieces
    order = pieces_back(mesh)

    def at_piece(
        starts: Float[AnyArray, " H"], lengths: Float[AnyArray, " H"]
    ) -> tuple[Int[Array, "K q"], Float[Array, "K q"]]:
        phase, within = (starts[-1] + lengths[-1] * part for part in (points, np.clip(points, _INSIDE, 1 - _INSIDE)))
        place = phase - jnp.stack(system.lags(within))
        slot: Any = jnp.sum(place[..., None] >= starts[1:], axis=-1)
        inside = (place - starts[slot]) / jnp.where(lengths[slot] > 0, lengths[slot], 1.0)
        reached = inside >= -_ROUNDING
        if not mesh.recent:
            reached &= (slot < mesh.history) | (inside <= _ROUNDING)
        # No number, rather than a wrong one.
        return slot, jnp.where(reached, inside, jnp.nan)

    return jax.vmap(at_piece)(mesh.start[order] + turns, mesh.length[order])
