"""Modes fitted to measured responses, and the report of the fit."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Complex, Float

from lobex import _checks
from lobex._by_name import by_name
from lobex._warnings import warn
from lobex.limits.measurement import MEASURED
from lobex.limits.parameters import number_names
from lobex.measured.coherence import trusted
from lobex.measured.frf import Frf
from lobex.measured.lscf import poles_by_order
from lobex.measured.modal_model import (
    Band,
    Fitted,
    covariance,
    information,
    likeness,
    linear,
    polished,
    reweighted,
)
from lobex.measured.reciprocal_shapes import linked, residues_of, shapes_of
from lobex.measured.stabilisation import Stabilisation, stabilised
from lobex.structures.modes import Modes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Highest order of the denominators, with this many lines for each, and the largest number of modes looked at.
_MOST_ORDER, _LINES_PER_ORDER, _MOST_MODES = 40, 4, 24
# Half-power bands on either side of a mode, and the fewest lines, that its own misfit is taken over.
_BESIDE, _FEW = 2.0, 8
# Correlation of neighbouring residuals and misfit from which on it is no noise.
_CORRELATED, _CONSIDERABLE = 0.5, 0.02
# Step of differences, in relative terms.
_STEP = 1e-6


class Part(NamedTuple):
    """The fit of directions that cross responses link.

    Attributes:
        names: of the directions.
        pairs: that were measured.
        band, fitted: of ``modal_model``.
        covariance: of ln ω, ln ξ and the coefficients.
        stabilisation: where the poles are from.
    """

    names: tuple[str, ...]
    pairs: tuple[tuple[str, str], ...]
    band: Band
    fitted: Fitted
    covariance: Float[np.ndarray, "q q"]
    stabilisation: Stabilisation


@dataclass(frozen=True, eq=False, repr=False)
class ModalFit:
    """Modes fitted to an ``Frf``.

    Directions that no cross response links are fitted each by itself, and their modes stand beside each other.

    Attributes:
        modes: the modes, n of them, in as many directions as were measured, by rising frequency of each part.
        frf: what was measured.
        band: lowest and highest frequency of the fit, Hz.
        directions: names of the contact directions of ``modes``, (r,).
        parts: the fits, one for each group of linked directions.
        misfit: root mean square of what is left of each pair over that of the pair, in what was measured and weighed by
            coherence where there is one, by pair.
        mode_misfit: the same within two half-power bandwidths of each mode, (n,), of all pairs of its part.
        frequency_deviation, damping_deviation: standard deviations of the natural frequencies, Hz, and of the damping
            ratios, (n,).
        names: of the numbers of ``modes`` that are uncertain, such as "modes.damping_ratio[0]".
        correlation: of those numbers, (q, q).
    """

    modes: Modes
    frf: Frf
    band: tuple[float, float]
    directions: tuple[str, ...]
    parts: tuple[Part, ...]
    misfit: dict[tuple[str, str], float]
    mode_misfit: Float[np.ndarray, " n"]
    frequency_deviation: Float[np.ndarray, " n"]
    damping_deviation: Float[np.ndarray, " n"]
    names: tuple[str, ...]
    deviation: Float[np.ndarray, " q"]
    correlation: Float[np.ndarray, "q q"]

    @property
    def relative_standard_deviation(self) -> dict[str, float]:
        """Standard deviations of the numbers of a process with these modes, relative, as ``Limit.band`` takes them.

        They are of noise alone, and hang together: ``Limit.band`` takes ``correlation``, too.
        """
        return dict(zip(self.names, self.deviation.tolist(), strict=True))

    def values(self, response: str | None = None, reference: str | None = None) -> Complex[np.ndarray, " n"]:
        """The fitted receptance of a pair at the lines of the band, m/N; names as of ``Frf.values``."""
        self.frf.values(response, reference)
        pair = self.frf.pairs[0] if response is None else (response, response if reference is None else reference)
        part = next(part for part in self.parts if pair in part.pairs)
        i = part.pairs.index(pair)
        return part.band.response[:, i] - part.fitted.residual[:, i]

    @property
    def frequency(self) -> Float[np.ndarray, " n"]:
        """The lines of the band, Hz."""
        return self.parts[0].band.omega / (2 * np.pi)

    def plot(self) -> "Figure":
        """Measured against fitted, magnitude and phase of every pair, with the modes; returns the figure."""
        return by_name("plots.frf_picture.plot_fit")(self)

    def plot_stabilisation(self) -> "Figure":
        """The poles of every order, and those that were kept, over the responses; returns the figure."""
        return by_name("plots.frf_picture.plot_stabilisation")(self)

    def __repr__(self) -> str:
        lost = ", ".join(f"{100 * share:.2g} % of {i} to {j}" for (i, j), share in self.misfit.items())
        lines = [
            f"ModalFit of {self.frf.source or 'samples'}: {self.modes.count} modes, {self.band[0]:.6g} to "
            f"{self.band[1]:.6g} Hz",
            f"  misfit           {lost}",
            "  mode  frequency (Hz)      damping ratio          "
            + "".join(f"{f'φ {name} (1/√kg)':>18}" for name in self.directions)
            + "    misfit",
        ]
        rows = zip(
            *(np.asarray(self.modes.frequency), self.frequency_deviation, np.asarray(self.modes.damping_ratio)),
            *(self.damping_deviation, np.asarray(self.modes.shape), self.mode_misfit),
            strict=True,
        )
        for number, (frequency, spread, ratio, wide, shape, lost_here) in enumerate(rows, 1):
            lines.append(
                f"  {number:>4}  {frequency:.2f} ± {spread:.2g}".ljust(28)
                + f"{ratio:.5f} ± {wide:.2g}".ljust(23)
                + "".join(f"{one:>18.5g}" for one in shape)
                + f"{100 * lost_here:>8.2g} %"
            )
        return "\n".join(lines)


def fitted(frf: Frf, order: Any, band: Any, real: Any) -> ModalFit:
    """What ``Frf.fit`` does."""
    _checks.choice("real", real, (True, False))
    wanted = None if order is None else _checks.integer("order", order, 1, _MOST_MODES)
    inside = _band(frf, band)
    groups = linked(list(frf.pairs))
    parts = [_part(frf, group, inside, wanted, real) for group in groups]
    names = tuple(sorted(name for part in parts for name in part.names))
    axes = [np.eye(len(names))[[names.index(name) for name in part.names]] for part in parts]
    leaves = [_leaves(part, _numbers(part)) for part in parts]
    modes = _together(leaves, axes)
    uncertain, deviation, correlation = _uncertainty(parts, axes)
    spread = [np.sqrt(np.diag(part.covariance)[: 2 * len(part.fitted.omega)]).reshape(2, -1) for part in parts]
    found = ModalFit(
        modes,
        frf,
        (float(frf.frequency[inside][0]), float(frf.frequency[inside][-1])),
        names,
        tuple(parts),
        {
            pair: share
            for part in parts
            for pair, share in zip(part.pairs, _misfits(part.band, part.fitted), strict=True)
        },
        np.concatenate([_mode_misfits(part) for part in parts]),
        np.concatenate([own[0] for own in spread]) * np.asarray(modes.frequency),
        np.concatenate([own[1] for own in spread]) * np.asarray(modes.damping_ratio),
        uncertain,
        deviation,
        correlation,
    )
    _warn_of_misfit(found)
    return found


def _band(frf: Frf, band: Any) -> np.ndarray:
    """Places of the lines between the two ends."""
    if band is None:
        return np.arange(len(frf.frequency))
    ends = _checks.grid("band", band, "Hz")
    if len(ends) != 2:
        raise ValueError(f"band has {len(ends)} numbers; give the lowest and the highest frequency, Hz")
    inside = np.flatnonzero((frf.frequency >= ends[0]) & (frf.frequency <= ends[1]))
    if len(inside) < 2 * _LINES_PER_ORDER:
        low, high = frf.frequency[[0, -1]]
        raise ValueError(
            f"band = {tuple(ends.tolist())} holds {len(inside)} lines of {low:.6g} to {high:.6g} Hz; give a wider one"
        )
    return inside


def _part(frf: Frf, names: list[str], inside: np.ndarray, order: int | None, real: bool) -> Part:
    """The fit of one group of directions."""
    pairs = tuple(pair for pair in frf.pairs if pair[0] in names)
    if not any(i == j for i, j in pairs):
        measured = ", ".join(f"{i} to {j}" for i, j in pairs)
        raise ValueError(
            f"there is no driving point among {measured}, where force and response are in one direction, and shapes "
            "have no scale without; measure one, or name it by response= and reference= of read_frf"
        )
    omega: np.ndarray = 2 * np.pi * frf.frequency[inside]
    response = np.stack([frf.values(*pair)[inside] for pair in pairs], axis=1)
    kind = omega[:, None] ** float(MEASURED.index(frf.measured))
    trust = trusted(kind * response, _coherence(frf, pairs, inside))
    size = np.sqrt(np.mean(np.abs(trust * kind * response) ** 2, axis=0))
    band = Band(omega, response, trust * kind, 1 / size, real)
    most = min(_MOST_ORDER, len(omega) // _LINES_PER_ORDER)
    chart = stabilised(poles_by_order(frf.frequency[inside], kind * response / size, trust, most))
    if not len(chart.candidate):
        raise ValueError(
            f"no pole of {frf.source or 'the responses'} stays from order to order; give band=, in which there are "
            "resonances, or look at frf.plot()"
        )
    first, found = _chosen(band, chart.candidate, [i == j for i, j in pairs], order)
    numbers = np.argsort(found.omega)
    found = linear(first, found.omega[numbers], found.damping_ratio[numbers])
    return Part(tuple(names), pairs, first, found, covariance(first, found), chart)


def _coherence(frf: Frf, pairs: tuple[tuple[str, str], ...], inside: np.ndarray) -> Float[np.ndarray, "n m"] | None:
    """Of the pairs in the band."""
    if frf.coherence is None:
        return None
    places = [(frf.responses.index(one), frf.references.index(other)) for one, other in pairs]
    return np.stack([frf.coherence[inside, i, j] for i, j in places], axis=1)


def _chosen(
    band: Band, candidate: Complex[np.ndarray, " c"], driving: list[bool], order: int | None
) -> tuple[Band, Fitted]:
    """The modes of stable poles that explain more than noise, or ``order`` of them, and weights by what is left."""
    candidate = candidate[:_MOST_MODES]
    if order is not None and order > len(candidate):
        raise ValueError(
            f"order = {order} is more than the {len(candidate)} poles that are stable; give at most as many"
        )
    fit = linear(band, np.abs(candidate), -np.real(candidate) / np.abs(candidate))
    for _ in range(2):
        fit = polished(band, _fewer(band, fit, driving, order))
        band = reweighted(band, fit)
    while len((fewer := _fewer(band, fit, driving, order)).omega) < len(fit.omega):
        fit = polished(band, fewer)
        band = reweighted(band, fit)
    return band, fit


def _fewer(band: Band, fit: Fitted, driving: list[bool], order: int | None) -> Fitted:
    """Without modes that give energy at a driving point, and, one after the other, without those that tell least."""
    while len(fit.omega) > 1:
        without = [_without(band, fit, i) for i in range(len(fit.omega))]
        told = np.array([information(band, other) for other in without]) - information(band, fit)
        wrong = _gives(band, fit, driving)
        if wrong.any():
            least = int(np.argmin(np.where(wrong, told, np.inf)))
        elif (order is None and told.min() < 0) or (order is not None and len(fit.omega) > order):
            least = int(np.argmin(told))
        else:
            break
        fit = without[least]
    return fit


def _without(band: Band, fit: Fitted, i: int) -> Fitted:
    return linear(band, np.delete(fit.omega, i), np.delete(fit.damping_ratio, i))


def _gives(band: Band, fit: Fitted, driving: list[bool]) -> np.ndarray:
    """Which real modes have a residue at a driving point that is below zero."""
    if not band.real:
        return np.zeros(len(fit.omega), bool)
    residue = fit.coefficient[: len(fit.omega)][:, driving]
    return np.all(residue <= 0, axis=1)


def _numbers(part: Part) -> Float[np.ndarray, " q"]:
    """ln ω, ln ξ and the coefficients of a part, response by response."""
    fit = part.fitted
    return np.concatenate([np.log(fit.omega), np.log(fit.damping_ratio), fit.coefficient.T.ravel()])


def _leaves(part: Part, numbers: Float[np.ndarray, " q"]) -> Modes:
    """The modes that those numbers stand for, in the part's own directions."""
    k, (c, m) = len(part.fitted.omega), part.fitted.coefficient.shape
    omega, ratio = np.exp(numbers[:k]), np.exp(numbers[k : 2 * k])
    coefficient = numbers[2 * k :].reshape(m, c).T[: c - 2].reshape(k, -1, m)
    places = [(part.names.index(one), part.names.index(other)) for one, other in part.pairs]
    index = (2 * k + c * np.arange(m) + part.band.each * np.arange(k)[:, None]).astype(int)
    weight = 1 / np.sqrt(np.diag(part.covariance))[index]
    if part.band.real:
        return Modes(omega, ratio, shapes_of(coefficient[:, 0], weight, places, len(part.names)))
    pole, residue = residues_of(coefficient, omega, ratio)
    shape = shapes_of(residue, weight, places, len(part.names))
    return Modes.from_poles(pole, shape[:, :, None] * shape[:, None, :])


def _together(parts: list[Modes], axes: list[np.ndarray]) -> Modes:
    """Modes of directions of their own beside each other."""
    if len(parts) == 1:
        return parts[0]
    turned = [
        jax.tree.map(lambda leaf, a=axis: leaf @ a if np.ndim(leaf) == 2 else leaf, m)
        for m, axis in zip(parts, axes, strict=True)
    ]
    return jax.tree.map(lambda *leaves: np.concatenate(leaves), *turned)


def _uncertainty(
    parts: list[Part], axes: list[np.ndarray]
) -> tuple[tuple[str, ...], Float[np.ndarray, " q"], Float[np.ndarray, "q q"]]:
    """Names, relative standard deviations and correlation of the numbers of all modes that are not zero."""
    modes = [_leaves(part, _numbers(part)) for part in parts]

    def flat(changed: list[Modes]) -> np.ndarray:
        return np.concatenate([np.ravel(leaf) for leaf in jax.tree.leaves(_together(changed, axes))])

    value = flat(modes)
    total = np.zeros((len(value), len(value)))
    for i, part in enumerate(parts):
        numbers, size = _numbers(part), np.sqrt(np.diag(part.covariance))
        slopes = []
        for j in range(len(numbers)):
            step = (
                _STEP
                * np.where(j < 2 * len(part.fitted.omega), 1.0, abs(numbers[j]) or size[j])
                * np.eye(len(numbers))[j]
            )
            ends = [flat([*modes[:i], _leaves(part, numbers + sign * step), *modes[i + 1 :]]) for sign in (1, -1)]
            slopes.append((ends[0] - ends[1]) / (2 * step[j]))
        slope = np.stack(slopes, axis=1)
        total += slope @ part.covariance @ slope.T
    names = number_names({"modes": _together(modes, axes)})
    known = np.flatnonzero((value != 0) & (np.diag(total) > 0))
    deviation = np.sqrt(np.diag(total)[known])
    correlation = total[np.ix_(known, known)] / np.outer(deviation, deviation)
    return tuple(names[i] for i in known), deviation / np.abs(value[known]), correlation


def _misfits(band: Band, fit: Fitted) -> list[float]:
    """Of every pair."""
    left, whole = (np.mean(np.abs(band.weighed(values)) ** 2, axis=0) for values in (fit.residual, band.response))
    return np.sqrt(left / whole).tolist()


def _mode_misfits(part: Part) -> Float[np.ndarray, " k"]:
    """Beside every mode, of all pairs."""
    found = []
    for omega, ratio in zip(part.fitted.omega, part.fitted.damping_ratio, strict=True):
        apart = np.abs(part.band.omega - omega)
        near = apart <= max(2 * _BESIDE * ratio * omega, np.sort(apart)[min(_FEW, len(apart)) - 1])
        left, whole = (
            np.sum(np.abs(part.band.weighed(own)[near]) ** 2) for own in (part.fitted.residual, part.band.response)
        )
        found.append(np.sqrt(left / whole))
    return np.array(found)


def _warn_of_misfit(fit: ModalFit) -> None:
    """Warn of what is left where neighbouring lines have it alike, which noise has not."""
    for part in fit.parts:
        for i, pair in enumerate(part.pairs):
            left = part.band.weighed(part.fitted.residual)[:, i]
            if fit.misfit[pair] > _CONSIDERABLE and likeness(left) > _CORRELATED:
                worst = fit.frequency[int(np.argmax(np.abs(left)))]
                warn(
                    f"the fit leaves {100 * fit.misfit[pair]:.2g} % of {pair[0]} to {pair[1]}, most at {worst:.4g} Hz, "
                    "and that is no noise; give another band= or order=, or real=False, and look at fit.plot()"
                )
