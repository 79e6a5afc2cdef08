"""Where multiples of the rotational frequency meet natural frequencies, of modes that may follow the speed."""

from typing import Any

import numpy as np
from jaxtyping import Float

_GROWTHS = 12
# Of the speed of divergence: there the frequency vanishes.
_BELOW = 1 - 1e-9


def natural_frequencies(modes: Any, speed: Float[np.ndarray, " n"]) -> Float[np.ndarray, "n modes"]:
    """At speeds (n,), Hz."""
    return np.stack([np.asarray(modes.at(one).frequency) for one in speed])


def speed_range(modes: Any) -> tuple[float, float]:
    """From which speed on there are modes, and up to which one, Hz."""
    table = getattr(modes, "speed", None)
    if table is not None:
        return float(table[0]), float(table[-1])
    return 0.0, _BELOW * float(getattr(modes, "divergence_speed", np.inf))


def crossing_speeds(modes: Any, order: Float[np.ndarray, " k"]) -> Float[np.ndarray, "modes k"]:
    """The lowest speeds f = k · speed of natural frequencies f and orders k, Hz; NaN where they never meet."""
    if not hasattr(modes, "check_speed"):
        return np.asarray(modes.frequency)[:, None] / order
    # Imported here, as that takes longer than most charts.
    from scipy.optimize import brentq

    low, high = speed_range(modes)
    found = np.full((modes.count, len(order)), np.nan)
    for i, column in np.ndindex(found.shape):

        def apart(speed: Any, i: int = i, k: float = float(order[column])) -> float:
            return float(np.asarray(modes.at(speed).frequency)[i]) - k * speed

        if apart(low) <= 0:
            continue
        last = min(high, max(apart(low) / float(order[column]), low))
        for _ in range(_GROWTHS):
            if apart(last) <= 0 or last >= high:
                break
            last = min(high, 1.5 * last)
        if apart(last) <= 0:
            solve: Any = brentq
            found[i, column] = solve(apart, low, last, xtol=1e-300, rtol=1e-13)
    return found
