"""How the root that a limit is of moves with the gain: growth from the frequency response alone.

On the limit ln K + ln κG(s) + ln(1 − e^{−sτ}) is an odd multiple of πi at s = iω. An analytic G has the derivative
−i dG/dω there whichever way s goes, so that what is measured along the axis tells how G goes on beside it.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Complex, Float

from lobex._warnings import warn
from lobex.limits.closed_form import Regeneration, closed_form
from lobex.limits.modal_curve import ModalCurve
from lobex.limits.receptance import Receptance, SampledCurve
from lobex.limits.receptance_curve import ReceptanceCurve
from lobex.limits.receptance_matrix import MatrixCurve
from lobex.limits.tooth_harmonics import harmonics_of
from lobex.processes.at_speeds import has_followers
from lobex.results.growth_rate import GrowthRate
from lobex.results.limit import Limit
from lobex.results.rebuild import rebuild

# Of rates of modes, relative; and the error up to which a rate is one.
_ROUNDING, _USABLE = 1e-8, 0.5
_BY_MODES = "give lobex.spectral_radius at gains beside it"

# G along the axis and its derivatives by ω, of limits at ω.
Along = Callable[[Float[np.ndarray, " n"]], tuple[Complex[np.ndarray, " n"], ...]]


class _Roots(NamedTuple):
    """First and second derivative of s by ln K, 1/s, (n,)."""

    first: Complex[np.ndarray, " n"]
    second: Complex[np.ndarray, " n"]


def growth_of(limit: Limit) -> GrowthRate:
    """What ``Limit.growth`` says.

    Raises:
        ValueError: for a limit that was found otherwise than from one frequency response, in words.

    Warns:
        LobexWarning: for rates that noise hides, which are NaN.
    """
    process = rebuild(limit.process)
    along, halves, passes = _responses(process, limit)
    omega, delay = 2 * np.pi * np.asarray(limit.chatter_frequency, float), 1 / (np.asarray(limit.speed) * passes)
    roots = _roots(along, omega, delay)
    error = _ROUNDING * np.abs(np.real(roots.first))
    if halves:
        off = [np.abs(np.real(_roots(half, omega, delay).first - roots.first)) for half in halves]
        error = np.maximum(error, np.max(off, axis=0))
    unsure = error > _USABLE * np.abs(np.real(roots.first))
    if unsure.any():
        roots = _Roots(*(np.where(unsure, np.nan, part) for part in roots))
        warn(
            f"{np.sum(unsure)} of {len(omega)} rates of growth are lost in what neighbouring lines differ by, and are "
            "NaN; give modes fitted to them, by Frf.modes"
        )
    return GrowthRate(
        limit=limit,
        rate=np.real(roots.first),
        bend=np.real(roots.second),
        drift=np.imag(roots.first) / omega,
        error=error,
        delay=delay,
    )


def _responses(process: Any, limit: Limit) -> tuple[Along, list[Along], int]:
    """The response whose root the limit is of; of a measurement those of every second line; and passes a revolution."""
    method = limit.method["type"]
    if method == "ZeroOrder":
        forces = harmonics_of(process, 0)
        if not forces.alike:
            raise ValueError(f"limit is of teeth at unequal angles, whose delays are several; {_BY_MODES}")
        known = forces.mean, _on_limit(limit, process.teeth)
        along, *halves = (partial(_of_matrix, MatrixCurve(one), *known) for one in _thinned(process.modes))
        return along, halves, process.teeth
    if method != "DSubdivision":
        raise ValueError(f"limit was found by {method}, whose root is no function of one response; {_BY_MODES}")
    found = None if has_followers(process) else closed_form(process)
    if not isinstance(found, Regeneration):
        raise ValueError(
            f"limit of {type(process).__name__} is not of one frequency response, the same at all speeds; {_BY_MODES}"
        )
    source = found.receptance
    if not isinstance(source, Receptance):
        return partial(_of_curve, ModalCurve(source)), [], 1
    along, *halves = (partial(_of_curve, SampledCurve(one)) for one in _thinned(source))
    return along, halves, 1


def _thinned(source: Any) -> list[Any]:
    """A measurement, and each half of its lines where there are enough; modes alone."""
    if not hasattr(source, "response") or len(source.frequency) < 8:
        return [source]
    return [source, *(jax.tree.map(lambda part, first=first: part[first::2], source) for first in (0, 1))]


def _of_curve(curve: ReceptanceCurve, omega: Float[np.ndarray, " n"]) -> tuple[Complex[np.ndarray, " n"], ...]:
    anchor = np.asarray(curve.anchor)
    row = np.clip(np.searchsorted(anchor, omega, side="right") - 1, 0, len(anchor) - 1)
    found: Any = curve.at(row, omega - anchor[row])
    return found


def _on_limit(limit: Limit, passes: int) -> Complex[np.ndarray, " n"]:
    """−1/(K (1 − e^{−iωτ})), which the response is at each limit."""
    waves = np.asarray(limit.chatter_frequency, float) / (np.asarray(limit.speed) * passes)
    return -1 / (np.asarray(limit.gain, float) * (1 - np.exp(-2j * np.pi * waves)))


def _of_matrix(
    curve: MatrixCurve,
    mean: Complex[np.ndarray, "r r"],
    wanted: Complex[np.ndarray, " n"],
    omega: Float[np.ndarray, " n"],
) -> tuple[Complex[np.ndarray, " n"], ...]:
    """Of the eigenvalue λ of G H₀ next to ``wanted``: λ′ = w M′ v, λ″ = w M″ v + 2 Σ (w M′ vⱼ)(wⱼ M′ v)/(λ − λⱼ)."""
    found = np.full((3, len(omega)), np.nan, dtype=complex)
    there = np.flatnonzero(np.isfinite(omega))
    if there.size:
        value, slope, bend = (part @ mean for part in curve.with_slopes(omega[there]))
        values, right = np.linalg.eig(value)
        slope, bend = (np.linalg.inv(right) @ part @ right for part in (slope, bend))
        lane, mine = np.arange(there.size), np.argmin(np.abs(values - wanted[there, None]), axis=1)
        apart = values[lane, mine][:, None] - values
        pairs = np.where(apart == 0, 0.0, slope[lane, mine] * slope[lane, :, mine])
        coupled = np.sum(pairs / np.where(apart == 0, 1.0, apart), axis=1)
        found[:, there] = values[lane, mine], slope[lane, mine, mine], bend[lane, mine, mine] + 2 * coupled
    return tuple(found)


def _roots(along: Along, omega: Float[np.ndarray, " n"], delay: Float[np.ndarray, " n"]) -> _Roots:
    """From the response and its derivatives by ω: those by s are −i and −1 times."""
    with np.errstate(invalid="ignore", divide="ignore"):
        there = np.isfinite(omega)
        response, slope, bend = along(omega)
        before = np.exp(-1j * omega * delay)
        lost = delay * before / (1 - before)
        first = -1j * slope / response + lost
        second = -bend / response + (slope / response) ** 2 - delay * lost / (1 - before)
        move = np.where(there, -1 / first, np.nan)
        return _Roots(move, second * move**3)
