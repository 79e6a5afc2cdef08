"""Along what a contact sees a structure and along what it loads it: the normal, and with friction the sliding."""

from typing import Any

import numpy as np
from jaxtyping import Float

from lobex import _checks
from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._shapes import AnyArray
from lobex._warnings import warn

# Of the cosine between normal and sliding.
_ALONG = 1e-6
# Of dry friction, more than any pair of materials has.
_ROUGH = 3.0


@in_float64
def contact_vectors(
    normal: Any, sliding: Any, friction: Any, directions: int
) -> tuple[Float[AnyArray, "m directions"], Float[AnyArray, "m directions"] | None]:
    """The normal n, and with sliding the direction n + μ t, of what the casing does to a blade that slides along t.

    A contact of stiffness K that is pressed in by h = nᵀy holds against it with −K h (n + μ t): a reaction along the
    normal, and Coulomb's friction against the sliding. What it sees of a structure of receptance R is
    G = nᵀ R (n + μ t).

    Args:
        normal: (directions,), of any length, into the casing; or those of several contacts, (m, directions).
        sliding: as many, of any length and along the surface, in which the blade slides; None without friction.
        friction: coefficient μ, 0 or more, one number or (m,).
        directions: how many there are.

    Returns:
        Both with one row for each contact, or one for all.

    Raises:
        ValueError: for vectors of no length or another shape, a sliding that is not at right angles to the normal, and
            a coefficient below zero.

    Warns:
        LobexWarning: for a coefficient above 3, which can only be in per cent.
    """
    _checks.not_negative("friction", friction)
    coefficient = _checks.as_array(friction)
    along = _unit("normal", normal, directions)
    slid = None if sliding is None else _unit("sliding", sliding, directions)
    sizes = {np.shape(along)[0], 1 if slid is None else np.shape(slid)[0], np.size(coefficient)} - {1}
    if np.ndim(coefficient) > 1 or np.size(coefficient) == 0 or len(sizes) > 1:
        slides = "" if slid is None else f", sliding {np.shape(slid)[0]}"
        raise ValueError(
            f"friction has shape {np.shape(coefficient)}, where normal has {np.shape(along)[0]} contacts{slides}; give "
            "one for all, or one for each"
        )
    if not _checks.is_traced(coefficient) and np.max(coefficient) > _ROUGH:
        most = float(np.max(coefficient))
        warn(f"friction = {most:.6g} is more than any surfaces have; give a coefficient, 0.15 for 15 %")
    if slid is None:
        if _checks.is_traced(coefficient) or np.any(np.asarray(coefficient) != 0):
            raise ValueError(f"friction = {_checks.brief(friction)} has no direction; give sliding, along the surface")
        return along, None
    lib = namespace(along, slid, coefficient)
    cosine = lib.sum(along * slid, axis=1)
    if not _checks.is_traced(cosine) and np.any(np.abs(cosine) > _ALONG):
        worst = cosine[np.argmax(np.abs(cosine))]
        angle = np.degrees(np.arccos(np.clip(worst, -1, 1)))
        raise ValueError(f"sliding is {angle:.4g} degrees from normal; give a direction along the surface, at 90")
    return along, along + lib.reshape(lib.asarray(coefficient), (-1, 1)) * slid


def _unit(name: str, vector: Any, directions: int) -> Float[AnyArray, "m directions"]:
    numbers = _checks.as_numbers(name, vector)
    given = _checks.as_array(vector)
    if np.ndim(given) not in (1, 2) or np.shape(given)[-1] != directions or np.size(given) == 0:
        raise ValueError(f"{name} has shape {np.shape(given)}; give one number per direction, ({directions},)")
    if numbers is not None and np.any(np.sum(numbers**2, axis=-1) < np.finfo(float).tiny):
        raise ValueError(f"{name} is a vector of no length; give one along which the contact acts")
    lib = namespace(given)
    rows = lib.atleast_2d(lib.asarray(given, dtype=lib.result_type(float)))
    return rows / lib.sqrt(lib.sum(rows**2, axis=1, keepdims=True))
