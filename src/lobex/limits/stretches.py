"""Stretches of the frequency axis that hold at most one candidate for the limit each, whatever the speed."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Complex, Float, Int

from lobex._namespace import namespace
from lobex._roots import sign_change
from lobex._shapes import AnyArray
from lobex.limits.phase import half_turn_bend, half_turn_rate, turns_of
from lobex.limits.receptance_curve import ReceptanceCurve, clustered
from lobex.limits.sections import on_boundary

# Points on either side of a zero of Re G, where arg G may turn as fast as at a resonance.
_AROUND = 8


class Stretches(NamedTuple):
    """Parts of the frequency axis where Re G < 0 and Re G and d arg G/dω are monotonic, lowest gain first.

    Attributes:
        row: the row of the curve, shape (c,).
        low, high: offsets of the ends of lower and higher gain, (c,), rad/s; high is infinite in the last,
            open stretch of a modal curve.
        low_turns, high_turns: −arg G/π − 1/2 and the turn of the curve at the ends, (c,).
        low_rate, high_rate: its derivative by ω, (c,).
        gain: −1/(2 Re G) at the end of lower gain, (c,), N/m; infinite for a stretch that is none.
    """

    row: Int[AnyArray, " *stretches"]
    low: Float[AnyArray, " *stretches"]
    high: Float[AnyArray, " *stretches"]
    low_turns: Float[AnyArray, " *stretches"]
    high_turns: Float[AnyArray, " *stretches"]
    low_rate: Float[AnyArray, " *stretches"]
    high_rate: Float[AnyArray, " *stretches"]
    gain: Float[AnyArray, " *stretches"]


def stretches(curve: ReceptanceCurve) -> Stretches:
    """The stretches of a curve: its grid, cut at the zeros of Re G and at the extrema of Re G and d arg G/dω.

    Those that are none are left out where numbers are at hand, and last where JAX traces them.
    """
    lib = namespace(curve.anchor)
    row, offset = curve.grid()
    zero_row, zero, width = _zeros(curve, row, offset, _real_part)
    row, offset = _merged((row, offset), (zero_row, zero))
    if curve.most_breaks is not None:
        response, slope, _ = curve.at(zero_row, zero)
        around = clustered(lib.abs(response / slope)[:, None], width[:, None], lib.arange(1, _AROUND + 1) / _AROUND)
        around = lib.where(width[:, None] > 0, lib.concatenate([-around, around], axis=1), 0.0)
        least = offset[lib.searchsorted(row, zero_row, side="left")]
        most = offset[lib.searchsorted(row, zero_row, side="right") - 1]
        near = lib.clip(zero[:, None] + around, least[:, None], most[:, None])
        row, offset = _merged((row, offset), (lib.repeat(zero_row, 2 * _AROUND), near.ravel()))
    breaks = [_zeros(curve, row, offset, function)[:2] for function in (_real_slope, half_turn_bend)]
    row, offset = _merged((row, offset), *breaks)
    return _ordered(curve, row, offset)


def _ordered(curve: ReceptanceCurve, row: Int[AnyArray, " *points"], offset: Float[AnyArray, " *points"]) -> Stretches:
    lib = namespace(row, offset)
    response, slope, _ = curve.at(row, offset)
    middle, _, _ = curve.at(row[1:], (offset[1:] + offset[:-1]) / 2)
    present = (row[1:] == row[:-1]) & (offset[1:] > offset[:-1]) & (middle.real < 0)
    points = (offset, turns_of(curve, response), half_turn_rate(response, slope), response.real)
    reverse = response.real[1:] < response.real[:-1]
    low = [lib.where(reverse, p[1:], p[:-1]) for p in points]
    high = [lib.where(reverse, p[:-1], p[1:]) for p in points]
    row = row[1:]
    if curve.open_ended:
        # Beyond the grid G tends to −Σφψ/ω²: where that is negative, Re G grows, and the phase with ωτ.
        last = [p[-1:] for p in points]
        low = [lib.concatenate(pair) for pair in zip(low, last, strict=True)]
        last[0] = lib.full_like(last[0], lib.inf)
        high = [lib.concatenate(pair) for pair in zip(high, last, strict=True)]
        row = lib.concatenate([row, row[-1:]])
        present = lib.concatenate([present, response.real[-1:] < 0])
    gain: Any = lib.where(present & (low[3] < 0), on_boundary(low[3]), lib.inf)
    order = lib.argsort(gain)
    if lib is np:
        order = order[: max(np.searchsorted(gain[order], np.inf), 1)]
    return Stretches(*(a[order] for a in (row, low[0], high[0], low[1], high[1], low[2], high[2], gain)))


def _zeros(
    curve: ReceptanceCurve,
    row: Int[AnyArray, " *points"],
    offset: Float[AnyArray, " *points"],
    function: Callable[
        [Complex[AnyArray, " *points"], Complex[AnyArray, " *points"], Complex[AnyArray, " *points"]],
        Float[AnyArray, " *points"],
    ],
) -> tuple[Int[AnyArray, " zeros"], Float[AnyArray, " zeros"], Float[AnyArray, " zeros"]]:
    """Row, offset and interval width of the zeros of a function of (G, G′, G″); where JAX traces them, repeats of a
    grid point for none.
    """
    lib = namespace(row, offset)
    sign = lib.sign(function(*curve.at(row, offset)))
    change = (sign[1:] * sign[:-1] < 0) & (row[1:] == row[:-1])
    some = {} if lib is np else {"size": curve.most_breaks or change.shape[0], "fill_value": 0}
    where = lib.flatnonzero(change, **some)
    there, left, right = row[where], offset[where], offset[where + 1]

    def value(row: Any, offset: Any) -> Any:
        return function(*curve.at(row, offset))

    def zero(*lane: Any) -> Any:
        return sign_change(value, *lane)

    found = change[where]
    a = (zero if lib is np else jax.vmap(zero))(there, left, right, found)
    return there, a, lib.where(found, right - left, 0.0)


def _merged(
    *points: tuple[Int[AnyArray, " _"], Float[AnyArray, " _"]],
) -> tuple[Int[AnyArray, " *points"], Float[AnyArray, " *points"]]:
    lib = namespace(points)
    row, offset = (lib.concatenate(parts) for parts in zip(*points, strict=True))
    order = lib.lexsort((offset, row))
    return row[order], offset[order]


def _real_part(
    response: Complex[AnyArray, " *points"], slope: Complex[AnyArray, " *points"], bend: Complex[AnyArray, " *points"]
) -> Float[AnyArray, " *points"]:
    return response.real


def _real_slope(
    response: Complex[AnyArray, " *points"], slope: Complex[AnyArray, " *points"], bend: Complex[AnyArray, " *points"]
) -> Float[AnyArray, " *points"]:
    return slope.real
