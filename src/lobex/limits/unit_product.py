"""Where a product of blades has the modulus 1, for each frequency on all its branches."""

from typing import Any

import jax
import numpy as np
from jaxtyping import Complex, Float, Int

from lobex._namespace import namespace
from lobex._roots import bracketed_root
from lobex._shapes import AnyArray
from lobex.limits.sections import Sections, modal_response

# Parts of the axis of x, each half of the next, with which the search for all branches begins, and of x the width of a
# part that is not divided further.
_OCTAVES, _NARROW = 10, 1e-9
_DIVISIONS = 60
# In place of 1/G where a blade does not answer.
_STIFF = 1e150j

Points = Float[np.ndarray, "5 *points"]
"""ω, x, the turns of the product less whole ones, and the slopes of x and of the turns by ω; NaN for none."""


def logarithm(
    sections: Sections, omega: Float[AnyArray, " p"], x: Float[AnyArray, " p"]
) -> tuple[Complex[AnyArray, " p"], Complex[AnyArray, " p"], Complex[AnyArray, " p"]]:
    """ln ∏ (1 + x/Gⱼ), of principal values, and its derivatives by ω and x."""
    inverse, slope = _inverse(sections, omega)
    lib, factor = namespace(inverse), 1 + x[:, None] * inverse
    value = lib.sum(lib.log(factor), axis=1)
    return value, lib.sum(x[:, None] * slope / factor, axis=1), lib.sum(inverse / factor, axis=1)


def _inverse(
    sections: Sections, omega: Float[AnyArray, " p"]
) -> tuple[Complex[AnyArray, "p N"], Complex[AnyArray, "p N"]]:
    """1/Gⱼ(ω), and its derivative."""
    parts = []
    for j in range(np.shape(sections.angular_frequency)[0]):
        one = jax.tree.map(lambda part, j=j: part[j], sections)
        lib = namespace(one, omega)
        response, slope, _ = modal_response(one, lib.asarray(one.angular_frequency) - omega[:, None], omega)
        answers = response != 0
        response = lib.where(answers, response, 1 / _STIFF)
        parts.append((1 / response, lib.where(answers, -slope / response**2, 0.0)))
    lib = namespace(parts)
    inverse, slope = (lib.stack(part, axis=1) for part in zip(*parts, strict=True))
    return inverse, slope


def branches_of_one(sections: Sections, omega: Float[np.ndarray, " p"]) -> Float[np.ndarray, "5 p r"]:
    """All branches at ω, (p,), in the order of x."""
    inverse: Any = _inverse(sections, omega)[0]
    real, size = inverse.real, np.abs(inverse) ** 2
    point, low, high = _brackets(real, size)
    x = _root(real[point], size[point], low, high)
    most = max(int(np.bincount(point, minlength=1).max(initial=0)), 1)
    order = np.lexsort((x, point))
    point, x = point[order], x[order]
    column = np.arange(len(point)) - np.searchsorted(point, point)
    found = np.full((5, len(omega), most), np.nan)
    value, by_omega, by_x = logarithm(sections, omega[point], x)
    # At the end of two branches there is none.
    slope = np.where(by_x.real == 0, np.nan, by_x.real)
    x_slope = -by_omega.real / slope
    turns = np.mod(value.imag / (2 * np.pi), 1.0)
    turn_slope = (by_omega.imag + by_x.imag * x_slope) / (2 * np.pi)
    found[:, point, column] = omega[point], x, turns, x_slope, turn_slope
    return found


def _brackets(
    real: Float[np.ndarray, "p N"], size: Float[np.ndarray, "p N"]
) -> tuple[Int[np.ndarray, " b"], Float[np.ndarray, " b"], Float[np.ndarray, " b"]]:
    """Of each point, parts of the axis of x in which the modulus of the product passes 1 once, and all of them.

    Between bounds of its factors, which are quadratic in x, a part is left out where the modulus stays on one side of
    1, kept where it rises or falls all along, and divided else.
    """
    with np.errstate(all="ignore"):
        # From twice its least place on every factor is above 1.
        last = 2.1 * np.max(np.nan_to_num(np.where(real < 0, -real / size, 0.0)), axis=1)
    reached = np.flatnonzero(last > 0)
    ends = 2.0 ** -np.arange(_OCTAVES, -1, -1.0)
    point: Any = np.repeat(reached, _OCTAVES + 1)
    low = (last[reached, None] * np.append(0.0, ends[:-1])).ravel()
    high = (last[reached, None] * ends).ravel()
    done: list[tuple[Any, Any, Any]] = []
    for _ in range(_DIVISIONS):
        if not len(point):
            break
        least, most, falling, rising, before, after = _bounds(real, size, point, low, high)
        # Where x vanishes the modulus is 1, and on the side of its slope.
        start = np.where(low == 0, np.sum(real[point], axis=1), before)
        open_ = ~((least > 0) | (most < 0))
        settled = falling | rising | (high - low <= _NARROW * high) | (high <= _NARROW * last[point])
        kept = open_ & settled & (np.sign(start) != np.sign(after))
        done.append((point[kept], low[kept], high[kept]))
        again = open_ & ~settled
        point, low, high = point[again], low[again], high[again]
        middle = (low + high) / 2
        point, low, high = (np.concatenate(pair) for pair in ((point, point), (low, middle), (middle, high)))
    if not done:
        return point, low, high
    found, starts, stops = (np.concatenate(part) for part in zip(*done, strict=True))
    return found, starts, stops


def _bounds(
    real: Float[np.ndarray, "p N"],
    size: Float[np.ndarray, "p N"],
    point: Int[np.ndarray, " b"],
    low: Float[np.ndarray, " b"],
    high: Float[np.ndarray, " b"],
) -> tuple[Any, ...]:
    """Of ln ∏ |1 + x/Gⱼ|² in parts (b,): the least and the most that it may be, whether it falls or rises all along,
    and its values at the ends.
    """
    none = np.zeros(len(point))
    least, most, slope_least, slope_most, before, after = (none.copy() for _ in range(6))
    with np.errstate(all="ignore"):
        # One blade after the other: all of them at once would not stay in cache.
        for j in range(np.shape(real)[1]):
            a, b = real[point, j], size[point, j]
            first, last = (1 + x * (2 * a + x * b) for x in (low, high))
            lowest = np.where((-a > low * b) & (-a < high * b), 1 - a * a / b, np.minimum(first, last))
            highest = np.maximum(first, last)
            steep = 2 * (a + low * b), 2 * (a + high * b)
            before += np.log(first)
            after += np.log(last)
            least += np.log(lowest)
            most += np.log(highest)
            slope_least += np.where(steep[0] < 0, steep[0] / lowest, steep[0] / highest)
            slope_most += np.where(steep[1] > 0, steep[1] / lowest, steep[1] / highest)
    return least, most, slope_most < 0, slope_least > 0, before, after


def _root(
    real: Float[np.ndarray, "p N"],
    size: Float[np.ndarray, "p N"],
    low: Float[np.ndarray, " p"],
    high: Float[np.ndarray, " p"],
) -> Float[np.ndarray, " p"]:
    """The x between two at which the product's modulus passes 1."""

    def value_of(given: Any, x: Any) -> tuple[Any, Any]:
        real, size = given
        factor = 1 + x[:, None] * (2 * real + x[:, None] * size)
        return np.sum(np.log(factor), axis=1), np.sum((2 * real + 2 * x[:, None] * size) / factor, axis=1)

    with np.errstate(all="ignore"):
        rising = value_of((real, size), high)[0] > 0
        return np.asarray(bracketed_root(value_of, (real, size), low, high, rising, (low + high) / 2, 0.0))
