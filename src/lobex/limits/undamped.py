"""Where a mode without damping leaves the stability limit undefined.

With ξ = 0 and ω τ = 2πj, the speed being the natural frequency over a whole number j, the mode meets its own track
in phase: 1 − e^{−jωτ} vanishes where the receptance has its pole, and s = jω is a root at every gain. That vibration
neither grows nor dies out, so that no gain is stable. Just below such a speed the contact damps the mode and the
limit is that of the next lobe; just above, the contact feeds it, and the limit is 0. With any damping the limit is
defined, and at this very speed close to the one below.
"""

from typing import Any

import jax.numpy as jnp
import numpy as np

from lobex import _checks
from lobex.structures.modes import Modes

Array = Any

# Rounding of a number of waves, in units of the last place.
_ROUNDING = 8


def undefined(modes: Modes, speed: Array) -> Array:
    """Whether a mode that the contact sees has no damping and turns through whole waves per revolution, (n,).

    Args:
        modes: of a rub or of turning, with one delay per revolution.
        speed: (n,), Hz.
    """
    numbers = (modes.angular_frequency, modes.damping_ratio, modes.shape, modes.loading, speed)
    lib = jnp if any(map(_checks.is_traced, numbers)) else np
    angular_frequency, damping_ratio, shape, loading, speed = map(lib.asarray, numbers)
    rounding = lib.finfo(angular_frequency.dtype).eps
    free = (damping_ratio < rounding**2) & lib.any(shape * loading != 0, axis=1)
    waves = angular_frequency / (2 * np.pi) / speed[:, None]
    whole = lib.abs(waves - lib.round(waves)) <= _ROUNDING * rounding * lib.maximum(waves, 1.0)
    return lib.any(free & whole & (waves > 0.5), axis=1)
