"""Modes of mass and stiffness matrices, and what a contact sees of them."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from lobex import _checks
from lobex.structures.contact_shapes import seen_at
from lobex.structures.damping import coupled_modes, modal_damping, proportional_damping
from lobex.structures.eigenproblem import vibration_modes
from lobex.structures.matrices import check_same_size, size_of, whole


def modes_of_matrices(
    mass: Any,
    stiffness: Any,
    contact: Any,
    damping_ratio: Any,
    keep: Sequence[int] | None,
    *,
    damping: Any,
    force: Any,
    triangle: str | None,
    condense: bool,
) -> tuple[Any, ...]:
    """Fields of ``Modes``; arguments, errors and warnings as of ``Modes.from_matrices``."""
    if (damping_ratio is None) == (damping is None):
        raise ValueError("give either damping_ratio or damping, a matrix")
    given = {"mass": mass, "stiffness": stiffness} | ({} if damping is None else {"damping": damping})
    mass, stiffness, *matrix = (whole(name, value, triangle) for name, value in given.items())
    check_same_size("stiffness", stiffness, mass)
    check_contact(mass, contact, force)
    angular_frequency, vectors = vibration_modes(mass, stiffness, keep, condense)
    shape, loading = seen_at(vectors, contact), None if force is None else seen_at(vectors, force)
    if not matrix:
        ratio = modal_damping(damping_ratio, np.shape(vectors)[1])
        return angular_frequency, ratio, shape, loading
    model = matrix[0], mass, stiffness, angular_frequency, vectors
    ratio = proportional_damping(*model)
    if ratio is None:
        return tuple(coupled_modes(*model, shape, shape if loading is None else loading))
    return angular_frequency, ratio, shape, loading


def check_contact(mass: Any, contact: Any, force: Any) -> None:
    """Require combinations of the degrees of freedom of a mass matrix, of one shape, each of some of them."""
    dof = size_of(mass)[0]
    given = _checks.as_numbers("contact", contact)
    if len(np.shape(contact)) not in (1, 2) or np.shape(contact)[0] != dof:
        raise ValueError(f"contact has shape {np.shape(contact)}; give ({dof},) or ({dof}, directions)")
    if given is not None and not np.all(np.any(given != 0, axis=0)):
        raise ValueError("contact has a direction of zeros alone; give degrees of freedom that the contact sees")
    if force is not None:
        _checks.as_numbers("force", force)
        if np.shape(force) != np.shape(contact):
            raise ValueError(f"force has shape {np.shape(force)}; give that of contact, {np.shape(contact)}")
