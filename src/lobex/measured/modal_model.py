"""Responses as sums of modes, with a term below the band and one above it, and their least squares."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Complex, Float
from scipy.optimize import least_squares

# Relative change of a sum of squares and of poles below which they stand still.
_STILL = 1e-12
# By how much a frequency may move from where the stable poles have it, and bounds of damping ratios.
_REACH = 0.05
_DAMPING = (1e-6, 0.9)
# Of the largest response: what rounding and the neglect of modes out of band leave of a fit without noise.
_FLOOR = 1e-7


class Band(NamedTuple):
    """What is fitted.

    Attributes:
        omega: (n,), rad/s.
        response: (n, m), m/N.
        line: weight of each line of each response, (n, m), so that noise is about as large in all of them; and
        pair: 1 over the deviation of that of each response, (m,), up to a factor that all share.
        real: whether residues are real.
    """

    omega: Float[np.ndarray, " n"]
    response: Complex[np.ndarray, "n m"]
    line: Float[np.ndarray, "n m"]
    pair: Float[np.ndarray, " m"]
    real: bool

    @property
    def each(self) -> int:
        """Numbers that a mode has for each response."""
        return 1 if self.real else 2

    def weighed(self, values: Complex[np.ndarray, "n m"]) -> Complex[np.ndarray, "n m"]:
        """Of each response what noise is alike in."""
        return self.line * values * self.pair


class Fitted(NamedTuple):
    """A least-squares fit.

    Attributes:
        omega, damping_ratio: of the modes, (k,), rad/s.
        coefficient: (k · each + 2, m): residues β, and rates α of complex modes, of β + αs over s² + 2ξωs + ω²; then
            L/ω² below the band and U above it.
        residual: (n, m), m/N.
    """

    omega: Float[np.ndarray, " k"]
    damping_ratio: Float[np.ndarray, " k"]
    coefficient: Float[np.ndarray, "c m"]
    residual: Complex[np.ndarray, "n m"]


def columns(
    band: Band, omega: Float[np.ndarray, " k"], damping_ratio: Float[np.ndarray, " k"]
) -> Complex[np.ndarray, "n c"]:
    """What each coefficient multiplies, (n, k · each + 2)."""
    return np.concatenate([_modal(band, omega, damping_ratio), *_residual_columns(band)], axis=1)


def _modal(
    band: Band, omega: Float[np.ndarray, " k"], damping_ratio: Float[np.ndarray, " k"]
) -> Complex[np.ndarray, "n c"]:
    own = 1 / (omega**2 - band.omega[:, None] ** 2 + 2j * damping_ratio * omega * band.omega[:, None])
    if band.real:
        return own
    return np.stack([own, 1j * band.omega[:, None] * own], axis=2).reshape(len(own), -1)


def _residual_columns(band: Band) -> list[Complex[np.ndarray, "n 1"]]:
    return [-1 / band.omega[:, None] ** 2 + 0j, np.ones((len(band.omega), 1), complex)]


def linear(band: Band, omega: Float[np.ndarray, " k"], damping_ratio: Float[np.ndarray, " k"]) -> Fitted:
    """Residues of given poles by linear least squares."""
    basis = columns(band, omega, damping_ratio)
    found = []
    for line, response in zip(band.line.T, band.response.T, strict=True):
        matrix = _parts(line[:, None] * basis)
        size = np.linalg.norm(matrix, axis=0)
        found.append(np.linalg.lstsq(matrix / size, _parts(line * response), rcond=None)[0] / size)
    coefficient = np.stack(found, axis=1)
    return Fitted(omega, damping_ratio, coefficient, band.response - basis @ coefficient)


def polished(band: Band, start: Fitted) -> Fitted:
    """Poles and residues by least squares: residues follow the poles (Golub and Pereyra, SIAM J. Numer. Anal. 10,
    1973), with Kaufman's derivative (BIT 15, 1975).
    """
    k = len(start.omega)
    if k == 0:
        return start
    scale = np.r_[np.maximum(start.damping_ratio, 1e-4), np.ones(k)]
    origin = np.r_[np.log(start.omega), np.log(start.damping_ratio)]

    def at(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        moved = np.exp(origin + scale * x)
        return moved[:k], moved[k:]

    def residual(x: np.ndarray) -> np.ndarray:
        return _parts(band.weighed(linear(band, *at(x)).residual)).T.ravel()

    def slope(x: np.ndarray) -> Any:
        fit = linear(band, *at(x))
        basis, rows = columns(band, *at(x)), []
        for line, one, pair in zip(band.line.T, _moved(band, fit), band.pair, strict=True):
            spanned = _parts(line[:, None] * basis)
            own = np.linalg.qr(spanned / np.linalg.norm(spanned, axis=0))[0]
            moved = _parts(line[:, None] * one * pair)
            # What the columns do not span.
            rows.append(moved - own @ (own.T @ moved))
        return -np.concatenate(rows) * scale

    low, high = np.log(_DAMPING)
    bounds = (
        np.r_[np.full(k, -_REACH), low - origin[k:]] / scale,
        np.r_[np.full(k, _REACH), high - origin[k:]] / scale,
    )
    inside = np.clip(0.0, bounds[0] + 1e-9, bounds[1] - 1e-9)
    jacobian: Any = slope
    found = least_squares(residual, inside, jacobian, bounds, ftol=_STILL, xtol=_STILL, gtol=_STILL, max_nfev=60)
    return linear(band, *at(found.x))


def _moved(band: Band, fitted: Fitted) -> list[Complex[np.ndarray, "n p"]]:
    """Derivatives of each response by ln ω and ln ξ of each mode, residues held, (n, 2k) each."""
    omega, damping_ratio = fitted.omega, fitted.damping_ratio
    own = 1 / (omega**2 - band.omega[:, None] ** 2 + 2j * damping_ratio * omega * band.omega[:, None])
    by_omega = -(2 * omega**2 + 2j * damping_ratio * omega * band.omega[:, None]) * own**2
    by_damping = -(2j * damping_ratio * omega * band.omega[:, None]) * own**2
    moved = []
    for coefficient in fitted.coefficient.T:
        above = coefficient[: len(omega) * band.each].reshape(len(omega), band.each)
        numerator = above[:, 0] + (0 if band.real else 1j * band.omega[:, None] * above[:, 1])
        moved.append(np.concatenate([numerator * by_omega, numerator * by_damping], axis=1))
    return moved


def covariance(band: Band, fitted: Fitted) -> Float[np.ndarray, "q q"]:
    """Of ln ω, ln ξ and the coefficients, response by response, (2k + c m,): of first order, for noise of each response
    of the size of what is left of it. Where that is alike in neighbouring lines, as many fewer count.
    """
    k, (c, m) = len(fitted.omega), fitted.coefficient.shape
    basis = columns(band, fitted.omega, fitted.damping_ratio)
    size = np.linalg.norm(np.max(band.line, axis=1)[:, None] * basis, axis=0)
    inverse = np.zeros((2 * k + c * m, 2 * k + c * m))
    scale = np.r_[np.ones(2 * k), np.tile(1 / size, m)]
    left = band.weighed(fitted.residual)
    for i, (moved, deviation) in enumerate(zip(_moved(band, fitted), _deviations(band, fitted), strict=True)):
        wider = (1 + likeness(left[:, i])) / (1 - likeness(left[:, i]))
        weight = band.line[:, i, None] * band.pair[i] / (deviation * np.sqrt(wider))
        place = np.r_[0 : 2 * k, 2 * k + c * i : 2 * k + c * (i + 1)]
        matrix = _parts(weight * np.concatenate([moved, basis / size], axis=1))
        inverse[np.ix_(place, place)] += matrix.T @ matrix
    return scale[:, None] * np.linalg.pinv(inverse, hermitian=True) * scale


def likeness(left: Complex[np.ndarray, " n"]) -> float:
    """Correlation of what is left in neighbouring lines, 0 of noise; at least 0."""
    alike = np.real(np.vdot(left[:-1], left[1:])) / max(np.sum(np.abs(left) ** 2), np.finfo(float).tiny)
    return float(np.clip(alike, 0.0, 0.99))


def _deviations(band: Band, fitted: Fitted) -> Float[np.ndarray, " m"]:
    """Of the noise of each response, of one part of it, from what is left."""
    lost = len(fitted.coefficient) + 2 * len(fitted.omega) / len(band.pair)
    left = np.sum(np.abs(band.weighed(fitted.residual)) ** 2, axis=0)
    floor = _FLOOR * np.max(np.abs(band.weighed(band.response)), axis=0)
    return np.sqrt(left / max(2 * len(band.omega) - lost, 1.0) + floor**2)


def reweighted(band: Band, fitted: Fitted) -> Band:
    """With weights so that what is left of each response is about one."""
    return band._replace(pair=band.pair / _deviations(band, fitted))


def information(band: Band, fitted: Fitted) -> float:
    """Schwarz' criterion, the smaller the better (Annals of Statistics 6, 1978), for noise of each response alone."""
    count = 2 * len(band.omega)
    left = np.mean(np.abs(band.weighed(fitted.residual)) ** 2, axis=0)
    floor = (_FLOOR * np.max(np.abs(band.weighed(band.response)), axis=0)) ** 2
    numbers = 2 * len(fitted.omega) + fitted.coefficient.size
    return float(count * np.sum(np.log(left + floor)) + numbers * np.log(count * len(band.pair)))


def _parts(values: Complex[np.ndarray, "n ..."]) -> Float[np.ndarray, "two_n ..."]:
    return np.concatenate([np.real(values), np.imag(values)])
