"""How the root that a limit is of moves with the gain: growth from the frequency response alone.

On the limit ln K + ln L(s) is an odd multiple of πi at s = iω, L being the loop: κG(s) (1 − e^{−sτ}) of one response,
an eigenvalue of the loop of milling. An analytic G has the derivative −i dG/dω there whichever way s goes, so that what
is measured along the axis tells how L goes on beside it.
"""

from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Complex, Float

from lobex._warnings import warn
from lobex.limits.closed_form import Regeneration, closed_form
from lobex.limits.loop_of_teeth import ALL, MEAN, Loop, loops_of
from lobex.limits.modal_curve import ModalCurve
from lobex.limits.receptance import Receptance, SampledCurve
from lobex.limits.receptance_curve import ReceptanceCurve
from lobex.limits.receptance_matrix import MatrixCurve
from lobex.limits.simple_eigenvalue import moved_by
from lobex.processes.at_speeds import has_followers
from lobex.results.growth_rate import GrowthRate
from lobex.results.limit import Limit
from lobex.results.rebuild import rebuild

# Of rates of modes, relative; and the error up to which a rate is one.
_ROUNDING, _USABLE = 1e-8, 0.5
_BY_MODES = "give lobex.spectral_radius at gains beside it"


class _Roots(NamedTuple):
    """First and second derivative of s by ln K, 1/s, (n,)."""

    first: Complex[np.ndarray, " n"]
    second: Complex[np.ndarray, " n"]


class _Loops(NamedTuple):
    """What is known of the loops of a limit at its speeds.

    Attributes:
        roots: of the response; of a measurement also those of each half of its lines.
        delay: between two passes, (n,), s.
        sense: −1 where the chatter frequency falls as the root's rises, (n,).
    """

    roots: list[_Roots]
    delay: Float[np.ndarray, " n"]
    sense: Float[np.ndarray, " n"]


def growth_of(limit: Limit) -> GrowthRate:
    """What ``Limit.growth`` says.

    Raises:
        ValueError: for a limit that was found otherwise than from frequency responses, in words.

    Warns:
        LobexWarning: for rates that noise hides, which are NaN.
    """
    (roots, *halves), delay, sense = _loops(rebuild(limit.process), limit)
    error = _ROUNDING * np.abs(np.real(roots.first))
    if halves:
        off = [np.abs(np.real(half.first - roots.first)) for half in halves]
        error = np.maximum(error, np.max(off, axis=0))
    unsure = error > _USABLE * np.abs(np.real(roots.first))
    if unsure.any():
        roots = _Roots(*(np.where(unsure, np.nan, part) for part in roots))
        warn(
            f"{np.sum(unsure)} of {len(delay)} rates of growth are lost in what neighbouring lines differ by, and are "
            "NaN; give modes fitted to them, by Frf.modes"
        )
    return GrowthRate(
        limit=limit,
        rate=np.real(roots.first),
        bend=np.real(roots.second),
        drift=sense * np.imag(roots.first) / (2 * np.pi * np.asarray(limit.chatter_frequency, float)),
        error=error,
        delay=delay,
    )


def _loops(process: Any, limit: Limit) -> _Loops:
    method, speed = limit.method["type"], np.asarray(limit.speed, float)
    if method in (MEAN, ALL):
        loops = loops_of(limit, process)
        roots = [_of_teeth(MatrixCurve(one), loops) for one in _thinned(process.modes)]
        return _Loops(
            roots, 1 / (speed * process.teeth), np.array([-1.0 if loop and loop.against else 1.0 for loop in loops])
        )
    if method != "DSubdivision":
        raise ValueError(f"limit was found by {method}, whose root is no function of one response; {_BY_MODES}")
    found = None if has_followers(process) else closed_form(process)
    if not isinstance(found, Regeneration):
        raise ValueError(
            f"limit of {type(process).__name__} is not of one frequency response, the same at all speeds; {_BY_MODES}"
        )
    source, omega, delay = found.receptance, 2 * np.pi * np.asarray(limit.chatter_frequency, float), 1 / speed
    if isinstance(source, Receptance):
        curves: list[ReceptanceCurve] = [SampledCurve(one) for one in _thinned(source)]
    else:
        curves = [ModalCurve(source)]
    return _Loops([_of_curve(curve, omega, delay) for curve in curves], delay, np.ones(len(speed)))


def _thinned(source: Any) -> list[Any]:
    """A measurement, and each half of its lines where there are enough; modes alone."""
    if not hasattr(source, "response") or len(source.frequency) < 8:
        return [source]
    return [source, *(jax.tree.map(lambda part, first=first: part[first::2], source) for first in (0, 1))]


def _of_curve(curve: ReceptanceCurve, omega: Float[np.ndarray, " n"], delay: Float[np.ndarray, " n"]) -> _Roots:
    """From the response and its derivatives by ω: those by s are −i and −1 times."""
    anchor = np.asarray(curve.anchor)
    row = np.clip(np.searchsorted(anchor, omega, side="right") - 1, 0, len(anchor) - 1)
    with np.errstate(invalid="ignore", divide="ignore"):
        response, slope, bend = (np.asarray(part) for part in curve.at(row, omega - anchor[row]))
        before = np.exp(-1j * omega * delay)
        lost = delay * before / (1 - before)
        first = -1j * slope / response + lost
        second = -bend / response + (slope / response) ** 2 - delay * lost / (1 - before)
        return _moving(np.where(np.isfinite(omega), first, np.nan), second)


def _of_teeth(curve: MatrixCurve, loops: list[Loop | None]) -> _Roots:
    """From an eigenvalue of the loop of milling, and its derivatives by ω."""
    by_s = np.full((2, len(loops)), np.nan, dtype=complex)
    for number, loop in enumerate(loops):
        if loop is not None:
            matrix, slope, bend = loop.matrices(curve)
            found = loop.eigenvalue(matrix)
            first, second = moved_by(found, matrix, slope, bend)
            share = first / found.value
            by_s[:, number] = -1j * share, -second / found.value + share**2
    return _moving(*by_s)


def _moving(first: Complex[np.ndarray, " n"], second: Complex[np.ndarray, " n"]) -> _Roots:
    """Of the derivatives of ln L by s, (n,)."""
    move = -1 / first
    return _Roots(move, second * move**3)
