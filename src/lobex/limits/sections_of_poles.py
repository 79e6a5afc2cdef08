"""The receptance of any structure as sections, by its pairs of poles."""

import numpy as np
from jaxtyping import Float

from lobex.characteristic.closed_loop import FAR, responses
from lobex.limits.sections import Sections

# Of a pole by eigenvalues on the imaginary axis, in units of its size.
_STILL = 1e-14


def sections_of_poles(
    drift: Float[np.ndarray, "d d"], inputs: Float[np.ndarray, "..."], seen: Float[np.ndarray, "..."]
) -> Sections | str:
    """G = C (s − A)⁻¹ E of a force E, (d,), and what it sees, C, (d,), or of several, (d, m) and (m, d); in words why
    there is none.
    """
    one = np.ndim(inputs) == 1
    acting, outputs = np.asarray(inputs)[None] if one else np.asarray(inputs).T, np.atleast_2d(seen)
    alike = (np.broadcast_to(part, (len(acting), *part.shape)) for part in (drift, outputs))
    loops = responses(next(alike), acting, next(alike))
    first, constant = (part[:, 0, 0] if one else part for part in loops[:2])
    upper, lower = (part[:, 0] for part in loops[2:])
    size = np.abs(upper)
    if np.any(lower.real == -FAR):
        return "has a pole without a partner"
    if np.any(np.maximum(upper.real, lower.real) > _STILL * size):
        return "has a structure that is not stable by itself"
    own = np.sqrt((upper * lower).real)
    ratio = np.where(np.abs(upper.real) > _STILL * size, -(upper + lower).real / (2 * own), 0.0)
    return Sections(own, ratio, constant, first)
