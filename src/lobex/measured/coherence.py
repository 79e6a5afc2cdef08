"""Which lines of a response are trusted, by their coherence."""

import numpy as np
from jaxtyping import Complex, Float

# Lines on either side that the scatter of a coherence of few averages is smoothed over.
_BESIDE = 2
# Of the response's root mean square: noise that a coherence of one is taken to hide.
_FLOOR = 1e-3
_LEAST = 1e-6


def trusted(
    response: Complex[np.ndarray, "n m"], coherence: Float[np.ndarray, "n m"] | None
) -> Float[np.ndarray, "n m"]:
    """Weights of lines from 0 to 1, (n, m): 1 over what their noise is larger by than that of half of the lines.

    The noise of a response G estimated from averages has the deviation |G| √((1 − γ²)/γ²), up to a factor that all
    lines share (Bendat and Piersol, Random Data, 4th ed., 2010, §9.2). Lines better than the median weigh no more than
    that: a coherence of few averages comes near one by chance.

    Args:
        response: as it was measured.
        coherence: γ², NaN of responses that have none; None of none.
    """
    if coherence is None:
        return np.ones(response.shape)
    known = np.clip(np.nan_to_num(coherence, nan=1.0), _LEAST, 1.0)
    noise = _smoothed(np.abs(response) ** 2 * (1 - known) / known)
    size = np.mean(np.abs(response) ** 2, axis=0)
    floor = np.maximum(np.median(noise, axis=0), _FLOOR**2 * size)
    return np.sqrt(np.minimum(1.0, floor / np.maximum(noise, floor)))


def _smoothed(values: Float[np.ndarray, "n m"]) -> Float[np.ndarray, "n m"]:
    """Means over neighbouring lines."""
    padded = np.pad(values, ((_BESIDE, _BESIDE), (0, 0)), mode="edge")
    return np.lib.stride_tricks.sliding_window_view(padded, 2 * _BESIDE + 1, axis=0).mean(axis=-1)
