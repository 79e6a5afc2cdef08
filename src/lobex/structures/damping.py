"""Modal damping of a matrix: ratios where the modes diagonalise it (Caughey and O'Kelly, 1965), else complex modes."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex import _checks
from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._shapes import AnyArray
from lobex._warnings import warn
from lobex.structures.complex_modes import Quadrature, of_damping
from lobex.structures.matrices import check_symmetric, diagonal, is_sparse

# Of a mode's damping force: what matrices written with few digits leave.
_LOST = 1e-3
# Of the largest damping force: a mode that has none, to rounding.
_NONE = 1e-12


@in_float64
def modal_damping(damping_ratio: Any, count: int) -> Float[AnyArray, " n"]:
    """Damping ratios of ``count`` modes, shape (count,), from one number or one per mode."""
    _checks.not_negative("damping_ratio", damping_ratio)
    if np.shape(damping_ratio) not in ((), (count,)):
        raise ValueError(
            f"damping_ratio has shape {np.shape(damping_ratio)}; give one number or one per mode, ({count},)"
        )
    lib = namespace(damping_ratio)
    return lib.broadcast_to(lib.asarray(damping_ratio, dtype=lib.result_type(float)), (count,))


def proportional_damping(
    damping: Any, mass: Any, stiffness: Any, angular_frequency: Float[AnyArray, " n"], vectors: Float[AnyArray, "dof n"]
) -> Float[AnyArray, " n"] | None:
    """Damping ratios ξ, (n,), of mass-normalised vectors (dof, n) under a damping matrix C, (dof, dof), N s/m.

    2ξω = vᵀCv, which is all of it where C v = 2ξω M v. What that leaves over of the force C v is measured at every
    degree of freedom beside the root of its stiffness, so that reactions of fixed ones do not count.

    Returns:
        None where more than 1e-3 is left over, of numbers that are known.

    Raises:
        ValueError: for a matrix that is not symmetric or has another size, or that drives a mode.
    """
    check_symmetric("damping", damping)
    shape, dof = damping.shape if is_sparse(damping) else np.shape(damping), np.shape(vectors)[0]
    if shape != (dof, dof):
        raise ValueError(f"damping has shape {shape} and mass {(dof, dof)}; give the same size")
    force, own = _forces(damping, vectors)
    if not any(map(_checks.is_traced, (own, mass, stiffness))):
        size = np.linalg.norm(_weight(stiffness) * force, axis=0)
        own = np.where(size <= _NONE * np.max(size), 0.0, own)
        _checks.not_negative("damping (in the modes)", own, "1/s")
        if np.max(_lost(force, _times(mass, vectors) * own, stiffness)) > _LOST:
            return None
    return own / (2 * angular_frequency)


def coupled_modes(
    damping: Any,
    mass: Any,
    stiffness: Any,
    angular_frequency: Float[AnyArray, " n"],
    vectors: Float[AnyArray, "dof n"],
    shape: Float[AnyArray, "n r"],
    loading: Float[AnyArray, "n r"],
) -> Quadrature:
    """Complex modes of a damping matrix that couples modes, as far as it couples those given among themselves.

    Args:
        damping, mass, stiffness, angular_frequency, vectors: as of ``proportional_damping``.
        shape, loading: of these modes at the contact.
    """
    force, vectors = np.asarray(_forces(damping, vectors)[0]), np.asarray(vectors)
    among = vectors.T @ force
    lost = _lost(force, np.asarray(_times(mass, vectors)) @ among, stiffness)
    if np.max(lost) > _LOST:
        worst = np.argmax(lost)
        warn(
            f"damping couples the mode of {angular_frequency[worst] / (2 * np.pi):.6g} Hz to others than those kept, "
            f"and {100 * lost[worst]:.3g} % of its force is lost; keep more modes, or all and select"
        )
    return of_damping(np.asarray(angular_frequency), (among + among.T) / 2, np.asarray(shape), np.asarray(loading))


def _weight(stiffness: Any) -> Float[AnyArray, "dof 1"]:
    return diagonal(stiffness)[:, None] ** -0.5


def _lost(force: Any, kept: Any, stiffness: Any) -> Float[AnyArray, " n"]:
    """The share of the force of each mode that is not kept, (dof, n) both."""
    size, rest = (np.linalg.norm(_weight(stiffness) * part, axis=0) for part in (force, force - kept))
    return rest / np.maximum(size, max(1e3 * _NONE * np.max(size), np.finfo(float).tiny))


@in_float64
def _forces(damping: Any, vectors: Float[AnyArray, "dof n"]) -> tuple[Float[Array, "dof n"], Float[Array, " n"]]:
    """C v, (dof, n), and vᵀ C v, (n,)."""
    force = jnp.asarray(_times(damping, vectors))
    return force, jnp.sum(vectors * force, axis=0)


def _times(matrix: Any, vectors: Float[AnyArray, "dof n"]) -> Float[AnyArray, "dof n"]:
    return matrix @ np.asarray(vectors) if is_sparse(matrix) else jnp.asarray(matrix) @ vectors
