"""Modal damping ratios of a damping matrix that the modes diagonalise (Caughey and O'Kelly, 1965)."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex import _checks
from lobex._float64 import in_float64
from lobex._shapes import AnyArray
from lobex.structures.matrices import check_symmetric, diagonal, is_sparse

# Of a mode's damping force: what matrices written with few digits leave.
_LOST = 1e-3
# Of the largest damping force: a mode that has none, to rounding.
_NONE = 1e-12


def proportional_damping(
    damping: Any, mass: Any, stiffness: Any, angular_frequency: Float[AnyArray, " n"], vectors: Float[AnyArray, "dof n"]
) -> Float[AnyArray, " n"]:
    """Damping ratios ξ, (n,), of mass-normalised vectors (dof, n) under a damping matrix C, (dof, dof), N s/m.

    2ξω = vᵀCv, which is all of it where C v = 2ξω M v. What that leaves over of the force C v is measured at every
    degree of freedom beside the root of its stiffness, so that reactions of fixed ones do not count.

    Raises:
        ValueError: for a matrix that is not symmetric or has another size, and where more than 1e-3 is left over.
    """
    check_symmetric("damping", damping)
    shape, dof = damping.shape if is_sparse(damping) else np.shape(damping), np.shape(vectors)[0]
    if shape != (dof, dof):
        raise ValueError(f"damping has shape {shape} and mass {(dof, dof)}; give the same size")
    force, own = _forces(damping, vectors)
    if not any(map(_checks.is_traced, (own, mass, stiffness))):
        weight = diagonal(stiffness)[:, None] ** -0.5
        size = np.linalg.norm(weight * force, axis=0)
        own = np.where(size <= _NONE * np.max(size), 0.0, own)
        _checks.not_negative("damping (in the modes)", own, "1/s")
        rest = np.linalg.norm(weight * (force - _times(mass, vectors) * own), axis=0)
        lost = rest / np.maximum(size, max(1e3 * _NONE * np.max(size), np.finfo(float).tiny))
        worst = np.argmax(lost)
        if lost[worst] > _LOST:
            raise ValueError(
                f"damping is not proportional: it couples the mode of {angular_frequency[worst] / (2 * np.pi):.6g} Hz "
                f"to others, and modal damping would lose {100 * lost[worst]:.3g} % of the force; "
                "give damping_ratio, one per mode, if you can do without"
            )
    return own / (2 * angular_frequency)


@in_float64
def _forces(damping: Any, vectors: Float[AnyArray, "dof n"]) -> tuple[Float[Array, "dof n"], Float[Array, " n"]]:
    """C v, (dof, n), and vᵀ C v, (n,)."""
    force = jnp.asarray(_times(damping, vectors))
    return force, jnp.sum(vectors * force, axis=0)


def _times(matrix: Any, vectors: Float[AnyArray, "dof n"]) -> Float[AnyArray, "dof n"]:
    return matrix @ np.asarray(vectors) if is_sparse(matrix) else jnp.asarray(matrix) @ vectors
