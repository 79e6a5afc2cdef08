"""Where a mode without damping leaves the stability limit undefined.

With ξ = 0 and ω τ = 2πj, the speed being the natural frequency over a whole number j, the mode meets its own track
in phase: 1 − e^{−jωτ} vanishes where the receptance has its pole, and s = jω is a root at every gain. That vibration
neither grows nor dies out, so that no gain is stable. Just below such a speed the contact damps the mode and the
limit is that of the next lobe; just above, the contact feeds it, and the limit is 0. With any damping the limit is
defined, and at this very speed close to the one below.
"""

import numpy as np
from jaxtyping import Bool, Real

from lobex._namespace import namespace
from lobex._shapes import AnyArray
from lobex.limits.sections import Sections

# Rounding of a number of waves, in units of the last place.
_ROUNDING = 8


def undefined(sections: Sections, speed: Real[AnyArray, " *lanes"]) -> Bool[AnyArray, " *lanes"]:
    """Whether a mode that the contact sees has no damping and turns through whole waves per revolution, (n,).

    Args:
        sections: the receptance that the force K [y − y(t − τ)] sees, of one delay per revolution.
        speed: (n,), Hz.
    """
    lib = namespace(sections, speed)
    numbers = sections.angular_frequency, sections.damping_ratio, sections.weight, speed
    angular_frequency, damping_ratio, weight, speed = map(lib.asarray, numbers)
    rounding = lib.finfo(angular_frequency.dtype).eps
    free = (damping_ratio < rounding**2) & (weight != 0)
    waves = angular_frequency / (2 * np.pi) / speed[:, None]
    whole = lib.abs(waves - lib.round(waves)) <= _ROUNDING * rounding * lib.maximum(waves, 1.0)
    return lib.any(free & whole & (waves > 0.5), axis=1)
