"""The growth per period of a march, read from its last delay-states."""

from typing import NamedTuple

import numpy as np

# Directions of the last delay-states below this share of the first hold rounding and not motion.
_NOISE = 1e-9
MOST_PERIODS = 8


class Growth(NamedTuple):
    """The dominant multiplier, Im ≥ 0, (lanes,), and an estimate of the error of its modulus that the fit leaves."""

    multiplier: np.ndarray
    error: np.ndarray


def fit_growth(delay_states: np.ndarray) -> Growth:
    """The dominant multiplier of the linear map that takes each delay-state to the next, (lanes, m + 1, size).

    Each delay-state is the image of the one before under the monodromy operator U, so that the last m + 1 hold
    U on the space that m of them span: the eigenvalues of that projection (Ritz values; Schmid, Dynamic mode
    decomposition, J. Fluid Mech. 656, 2010, reads data the same way). Complex pairs and several multipliers of
    nearly equal modulus are told apart, where a fit to the norm of a single state would swing with their
    beat. The error is the distance of U v from μ v for the vector v of the fit, which falls from period to period.
    """
    lanes, count, _ = delay_states.shape
    if count < 2:
        return Growth(np.full(lanes, np.nan + 0j), np.full(lanes, np.nan))
    norms = np.linalg.norm(delay_states, axis=-1)
    usable = np.isfinite(norms).all(axis=1) & (norms > 0).all(axis=1)
    norms = np.where(usable[:, None], norms, 1.0)
    unit = np.where(usable[:, None, None], delay_states, 1.0) / norms[:, :, None]
    before = np.swapaxes(unit[:, :-1], 1, 2)
    after = np.swapaxes(unit[:, 1:] * (norms[:, 1:] / norms[:, :-1])[:, :, None], 1, 2)
    basis, weight, right = np.linalg.svd(before, full_matrices=False)
    kept = weight > _NOISE * weight[:, :1]
    inverse = np.where(kept, 1 / np.where(kept, weight, 1.0), 0.0)
    image = after @ (np.swapaxes(right, 1, 2) * inverse[:, None, :])
    basis = basis * kept[:, None, :]
    values, vectors = np.linalg.eig(np.swapaxes(basis, 1, 2) @ image)
    lifted = basis @ vectors
    distance, size = (np.linalg.norm(part, axis=1) for part in (image @ vectors - lifted * values[:, None, :], lifted))
    # The zeros of the directions left out are no multipliers.
    distance = np.where(size > 0, distance / np.where(size > 0, size, 1.0), np.inf)
    value, error = _largest_trusted(values, distance)
    value = np.where(np.imag(value) < 0, np.conj(value), value)
    return Growth(np.where(usable, value, np.nan), np.where(usable, error, np.nan))


def _largest_trusted(values: np.ndarray, distance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The largest value among those that the motion bears out."""
    trusted = distance <= np.maximum(1e3 * distance.min(axis=1, keepdims=True), 1e-6 * np.abs(values))
    index = np.argmax(np.where(trusted, np.abs(values), -1.0), axis=1)[:, None]
    return np.take_along_axis(values, index, 1)[:, 0], np.take_along_axis(distance, index, 1)[:, 0]
