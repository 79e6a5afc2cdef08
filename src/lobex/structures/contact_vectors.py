"""Along what a contact sees a structure and along what it loads it: the normal, and with friction the sliding."""

from typing import Any

import numpy as np
from jaxtyping import Float

from lobex import _checks
from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._shapes import AnyArray, Number

# Of the cosine between normal and sliding.
_ALONG = 1e-6


@in_float64
def contact_vectors(
    normal: Any, sliding: Any, friction: Number, directions: int
) -> tuple[Float[AnyArray, " directions"], Float[AnyArray, " directions"] | None]:
    """The normal n, and with sliding the direction n + μ t, of what the casing does to a blade that slides along t.

    A contact of stiffness K that is pressed in by h = nᵀy holds against it with −K h (n + μ t): a reaction along the
    normal, and Coulomb's friction against the sliding. What it sees of a structure of receptance R is
    G = nᵀ R (n + μ t).

    Args:
        normal: (directions,), of any length, into the casing.
        sliding: (directions,), of any length and along the surface, in which the blade slides; None without friction.
        friction: coefficient μ, 0 or more.
        directions: how many there are.

    Raises:
        ValueError: for vectors of no length or another shape, a sliding that is not at right angles to the normal, and
            a coefficient below zero.
    """
    _checks.not_negative("friction", friction)
    _checks.scalar("friction", friction)
    along = _unit("normal", normal, directions)
    if sliding is None:
        if _checks.is_traced(friction) or friction != 0:
            raise ValueError(f"friction = {_checks.brief(friction)} has no direction; give sliding, along the surface")
        return along, None
    slid = _unit("sliding", sliding, directions)
    lib = namespace(along, slid)
    cosine = lib.sum(along * slid)
    if not _checks.is_traced(cosine) and abs(cosine) > _ALONG:
        angle = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
        raise ValueError(f"sliding is {angle:.4g} degrees from normal; give a direction along the surface, at 90")
    return along, along + friction * slid


def _unit(name: str, vector: Any, directions: int) -> Float[AnyArray, " directions"]:
    numbers = _checks.as_numbers(name, vector)
    given = _checks.as_array(vector)
    if np.shape(given) != (directions,):
        raise ValueError(f"{name} has shape {np.shape(given)}; give one number per direction, ({directions},)")
    if numbers is not None and np.sum(numbers**2) < np.finfo(float).tiny:
        raise ValueError(f"{name} is a vector of no length; give one along which the contact acts")
    lib = namespace(given)
    given = lib.asarray(given, dtype=lib.result_type(float))
    return given / lib.sqrt(lib.sum(given**2))
