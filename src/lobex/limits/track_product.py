"""The exact limit of blades, each in the track of the one before it, that are not coupled otherwise.

With the receptances Gⱼ of the blades, ∏ (1 + 1/(K Gⱼ)) = e^{−iωT} on the boundary, T one revolution: only the sum of
the delays matters. In the plane of ω and x = 1/K the places where the product has the modulus 1 are curves whatever the
speed is. They are followed along ω, with all their branches, until cubic polynomials between neighbouring points say
how they go on; on them the turns of the product and ωT make a whole number at a limit.
"""

from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from lobex import _checks
from lobex._namespace import namespace
from lobex._shapes import AnyArray
from lobex.limits.modal_curve import ModalCurve
from lobex.limits.sections import Sections, modal_response
from lobex.limits.several_contacts import numbers_of

# How well cubics between two points know that halfway: of x, and in turns.
_RESOLVED = 1e-3
_ROUNDS = 60
# Of ω, the distance from which on two branches that end together meet.
_MEETING = 1e-12
# Parts of the axis of x, each half of the next, with which the search for all branches begins, and of x the width of a
# part that is not divided further.
_OCTAVES, _NARROW = 10, 1e-9
_DIVISIONS = 60
_HALVINGS, _STEPS = 12, 8
# Of the slowest decay of a mode, the distance of points on the axis of ω up to so many times the highest frequency,
# unless they become too many.
_STEP, _TOP, _MOST_POINTS = 0.5, 1.5, 20_000
# Of the best one, how near other places come to it that are settled as well, and how many.
_NEAR, _MOST = 0.02, 16
_TIE = 1e-9
# In place of 1/G where a blade does not answer.
_STIFF = 1e150j
# Speeds at which all arcs are looked at together.
_BATCH = 16


class Tracks(NamedTuple):
    """Blades with forces −K [yⱼ − yⱼ₋₁(t − τⱼ)], with the sum of τⱼ one revolution, that nothing else couples.

    Attributes:
        receptance: Gⱼ, its fields of the shape (N, n).
    """

    receptance: Sections


Points = Float[np.ndarray, "5 *points"]
"""ω, x, the turns of the product less whole ones, and the slopes of x and of the turns by ω; NaN for none."""


def limits_of_tracks(
    tracks: Tracks, speed: Float[AnyArray, " s"]
) -> tuple[Float[AnyArray, " s"], Float[AnyArray, " s"], Bool[np.ndarray, " s"]]:
    """The least K on the boundary at speeds (s,), Hz, NaN where there is none; ω there; and whether two are a tie.

    Differentiable once, outside ``jit`` and ``vmap``: a step of Newton's method from the place carries it.
    """
    known, delay = numbers_of(tracks.receptance), 1 / np.asarray(numbers_of(speed), dtype=float)
    first, last = _arcs(known)
    parts = [_limits(known, first, last, delay[i : i + _BATCH]) for i in range(0, len(delay), _BATCH)]
    omega, x, tie = (np.concatenate(part) for part in zip(*parts, strict=True))
    there = np.isfinite(x)
    omega, x = np.where(there, omega, known.angular_frequency[0, 0]), np.where(there, x, 1.0)
    if _checks.is_traced((tracks, speed)):
        omega, x = jax.jit(_stepped)(tracks.receptance, 1 / speed, omega, x)
    # Products, so that where there is no limit its derivative is no number either.
    some = np.where(there, 1.0, np.nan)
    return some / x, some * omega, tie & there


def _logarithm(
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


def _arcs(sections: Sections) -> tuple[Points, Points]:
    """Parts of the curves, by their first and last points, (5, arcs) each: between them cubics in ω serve, x has no
    extremum, and the turns go on.
    """
    omega = _axis(sections)
    # Every other point is the first middle of its neighbours.
    every, between = _points(sections, omega), omega[1::2]
    low, high, left, right = omega[:-1:2], omega[2::2], every[:, :-1:2], every[:, 2::2]
    middle: Any = every[:, 1::2]
    done = []
    for _ in range(_ROUNDS):
        if middle is None:
            between = (low + high) / 2
            middle = _points(sections, between)
        left, middle, right = _of_one_width(left, middle, right)
        good = _resolved(left, middle, right)
        done += [(left[:, good], middle[:, good]), (middle[:, good], right[:, good])]
        again = ~good & (high - low > _MEETING * high)
        if not again.any():
            break
        left = np.concatenate([left[:, again], middle[:, again]], axis=1)
        right = np.concatenate([middle[:, again], right[:, again]], axis=1)
        low, high = (np.concatenate(pair) for pair in ((low[again], between[again]), (between[again], high[again])))
        middle = None
    ends = [[end[:, np.isfinite(pair[0][1])] for end in pair] for pair in done]
    first, last = (np.concatenate(part, axis=1) for part in zip(*ends, strict=True))
    last[2] = first[2] + _onwards(first, last)
    return _without_extrema(first, last)


def _axis(sections: Sections) -> Float[np.ndarray, " p"]:
    """Frequencies, an odd number, at which no branch is passed by: all poles and zeros of the factors decay about as
    fast as the modes, and so their features are as wide.
    """
    curve = ModalCurve(jax.tree.map(lambda part: np.ravel(np.asarray(part)), sections))
    row, offset = curve.grid()
    own = np.asarray(sections.angular_frequency)
    top, decay = _TOP * np.max(own), np.min(own * np.asarray(sections.damping_ratio))
    even = np.linspace(0.0, top, 2 + int(min(top / (_STEP * decay), _MOST_POINTS)))
    omega = np.unique(np.concatenate([curve.anchor[row] + offset, even]))
    omega = omega[omega > 0]
    return omega if len(omega) % 2 else omega[:-1]


def _points(sections: Sections, omega: Float[np.ndarray, " p"]) -> Float[np.ndarray, "5 p r"]:
    """All branches at ω, (p,), in the order of x."""
    inverse: Any = _inverse(sections, omega)[0]
    real, size = inverse.real, np.abs(inverse) ** 2
    point, low, high = _brackets(real, size)
    x = _root(real[point], size[point], low, high)
    branches = max(int(np.bincount(point, minlength=1).max(initial=0)), 1)
    order = np.lexsort((x, point))
    point, x = point[order], x[order]
    column = np.arange(len(point)) - np.searchsorted(point, point)
    found = np.full((5, len(omega), branches), np.nan)
    value, by_omega, by_x = _logarithm(sections, omega[point], x)
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
    """The x between two at which the product's modulus passes 1, by Newton's method within halves."""

    def value_of(x: Float[np.ndarray, " p"]) -> tuple[Any, Any]:
        factor = 1 + x[:, None] * (2 * real + x[:, None] * size)
        return np.sum(np.log(factor), axis=1), np.sum((2 * real + 2 * x[:, None] * size) / factor, axis=1)

    with np.errstate(all="ignore"):
        after, x = np.sign(value_of(high)[0]), (low + high) / 2
        for _ in range(_HALVINGS + _STEPS):
            value, slope = value_of(x)
            same = np.sign(value) == after
            low, high = np.where(same, low, x), np.where(same, x, high)
            step = x - value / slope
            x = np.where((step > low) & (step < high), step, (low + high) / 2)
    return x


def _of_one_width(*parts: Float[np.ndarray, "5 p r"]) -> list[Float[np.ndarray, "5 p r"]]:
    """With as many branches each, those that are none being NaN."""
    most = max(part.shape[2] for part in parts)
    return [np.concatenate([part, np.full((5, part.shape[1], most - part.shape[2]), np.nan)], axis=2) for part in parts]


def _resolved(
    left: Float[np.ndarray, "5 p r"], middle: Float[np.ndarray, "5 p r"], right: Float[np.ndarray, "5 p r"]
) -> Bool[np.ndarray, " p"]:
    """Whether as many branches begin and end, and cubics between them say where they are halfway."""
    here = np.isfinite(left[1])
    alike = np.all((here == np.isfinite(middle[1])) & (here == np.isfinite(right[1])), axis=1)
    width = right[0] - left[0]
    x = (left[1] + right[1]) / 2 + width * (left[3] - right[3]) / 8
    turned = _onwards(left, right)
    turns = left[2] + turned / 2 + width * (left[4] - right[4]) / 8
    miss = turns - middle[2]
    good = (np.abs(x - middle[1]) <= _RESOLVED * middle[1]) & (np.abs(miss - np.round(miss)) <= _RESOLVED)
    # That cubics fit through turns of which whole ones are not known tells nothing if these are many.
    good &= np.abs(width * (left[4] - right[4])) < 0.5
    return alike & np.all(good | ~here, axis=1)


def _onwards(first: Points, last: Points) -> Float[np.ndarray, " *points"]:
    """The turns from one point to the next, of which whole ones are those that the slopes say."""
    expected = (last[0] - first[0]) * (first[4] + last[4]) / 2
    apart = last[2] - first[2] - expected
    return expected + apart - np.round(apart)


def _hermite(
    first: Points, last: Points, share: Float[np.ndarray, " *points"], what: int
) -> tuple[Float[np.ndarray, " *points"], Float[np.ndarray, " *points"]]:
    """x (1) or the turns (2) at a share of the way between points, and their slope by it."""
    width = last[0] - first[0]
    step, begin, end = last[what] - first[what], width * first[what + 2], width * last[what + 2]
    bend, cubic = 3 * step - 2 * begin - end, begin + end - 2 * step
    value = first[what] + share * (begin + share * (bend + share * cubic))
    return value, begin + share * (2 * bend + share * 3 * cubic)


def _extremum(
    first: Points, last: Points, what: int, more: Float[np.ndarray, "..."] | float = 0.0
) -> Float[np.ndarray, "..."]:
    """The share of the way where x or the turns have an extremum, with a slope of ``more`` in addition; 1 for none."""
    width = last[0] - first[0]
    begin, end = width * (first[what + 2] + more), width * (last[what + 2] + more)
    step = last[what] - first[what] + width * more
    bend, cubic = 3 * step - 2 * begin - end, 3 * (begin + end - 2 * step)
    turning = begin * end < 0
    with np.errstate(all="ignore"):
        root = np.sqrt(np.maximum(bend**2 - cubic * begin, 0.0))
        # Of the two, that which keeps its digits where the slope is all but linear.
        share = -begin / (bend + np.copysign(root, np.where(begin > 0, -1.0, 1.0)))
    return np.where(turning & (share > 0) & (share < 1), share, 1.0)


def _without_extrema(first: Points, last: Points) -> tuple[Points, Points]:
    """Arcs cut where x has an extremum."""
    share = _extremum(first, last, 1)
    cut = share < 1
    one, other = first[:, cut], last[:, cut]
    (x, x_slope), (turns, turn_slope) = (_hermite(one, other, share[cut], what) for what in (1, 2))
    width = other[0] - one[0]
    middle = np.stack([one[0] + share[cut] * width, x, turns, x_slope / width, turn_slope / width])
    firsts, lasts = (first[:, ~cut], one, middle), (last[:, ~cut], middle, other)
    return np.concatenate(firsts, axis=1), np.concatenate(lasts, axis=1)


def _limits(
    sections: Sections, first: Points, last: Points, delay: Float[np.ndarray, " s"]
) -> tuple[Float[np.ndarray, " s"], Float[np.ndarray, " s"], Bool[np.ndarray, " s"]]:
    """ω and the largest x of a limit at each T, s, infinite for none, and whether there is another as large."""
    rate = delay[:, None] / (2 * np.pi)
    share = _extremum(first, last, 2, rate)
    width = last[0] - first[0]
    begin, end = first[2] + first[0] * rate, last[2] + last[0] * rate
    top = _hermite(first, last, share, 2)[0] + (first[0] + share * width) * rate
    found = []
    for start, stop, from_share, to_share in ((begin, top, 0 * share, share), (top, end, share, 0 * share + 1)):
        # The whole number nearest to the end of larger x.
        falling = np.broadcast_to(first[1] > last[1], start.shape)
        near, far = np.where(falling, start, stop), np.where(falling, stop, start)
        level = np.where(far > near, np.ceil(near - _RESOLVED), np.floor(near + _RESOLVED))
        held = np.where(far > near, level <= far + _RESOLVED, level >= far - _RESOLVED) & (to_share > from_share)
        with np.errstate(all="ignore"):
            part = np.clip((level - start) / np.where(stop == start, 1.0, stop - start), 0.0, 1.0)
        at = from_share + part * (to_share - from_share)
        x = np.where(held, _hermite(first, last, at, 1)[0], 0.0)
        found.append((first[0] + at * width, x))
    omega, x = (np.concatenate(part, axis=1) for part in zip(*found, strict=True))
    best = np.max(x, axis=1, keepdims=True)
    most = min(_MOST, x.shape[1])
    index = np.argpartition(-x, most - 1, axis=1)[:, :most]
    omega, x = (np.take_along_axis(part, index, axis=1) for part in (omega, x))
    some = (x > 0) & (x >= (1 - _NEAR) * best)
    lane, column = np.nonzero(some)
    settled_omega, settled_x, good = _settled(sections, delay[lane], omega[lane, column], x[lane, column])
    places, values = np.full(x.shape, np.nan), np.full(x.shape, -np.inf)
    places[lane, column], values[lane, column] = settled_omega, np.where(good, settled_x, -np.inf)
    winner = np.argmax(values, axis=1)[:, None]
    value, place = (np.take_along_axis(part, winner, axis=1) for part in (values, places))
    same = (values >= value * (1 - _TIE)) & (np.abs(places - place) > 1e-6 * place)
    value = value[:, 0]
    return place[:, 0], np.where(value > 0, value, np.inf), np.any(same, axis=1) & (value > 0)


def _settled(
    sections: Sections,
    delay: Float[np.ndarray, " p"],
    omega: Float[np.ndarray, " p"],
    x: Float[np.ndarray, " p"],
) -> tuple[Float[np.ndarray, " p"], Float[np.ndarray, " p"], Bool[np.ndarray, " p"]]:
    """Places near a limit brought to it by Newton's method, and whether they came to one near by."""
    place: Any = omega, x
    began = x
    with np.errstate(all="ignore"):
        for _ in range(_STEPS):
            place = _stepped(sections, delay, *place)
        omega, x = place
        value = _logarithm(sections, omega, x)[0] + 1j * omega * delay
    turns = value.imag / (2 * np.pi)
    good = (np.abs(value.real) < 1e-9) & (np.abs(turns - np.round(turns)) < 1e-9)
    return omega, x, good & (np.abs(x - began) < 0.05 * began) & (omega > 0)


def _stepped(
    sections: Sections, delay: Float[AnyArray, " p"], omega: Float[AnyArray, " p"], x: Float[AnyArray, " p"]
) -> tuple[Float[AnyArray, " p"], Float[AnyArray, " p"]]:
    """A step of Newton's method towards ln ∏ (1 + x/Gⱼ) + iωT = 2πik of the nearest k."""
    value, by_omega, by_x = _logarithm(sections, omega, x)
    lib = namespace(value, delay)
    turns = (value.imag + omega * delay) / (2 * np.pi)
    miss = value.real, 2 * np.pi * (turns - _whole(turns))
    rows = (by_omega.real, by_x.real), (by_omega.imag + delay, by_x.imag)
    determinant = rows[0][0] * rows[1][1] - rows[0][1] * rows[1][0]
    determinant = lib.where(determinant == 0, 1.0, determinant)
    return (
        omega - (miss[0] * rows[1][1] - miss[1] * rows[0][1]) / determinant,
        x - (miss[1] * rows[0][0] - miss[0] * rows[1][0]) / determinant,
    )


def _whole(turns: Float[AnyArray, " p"]) -> Float[AnyArray, " p"]:
    return namespace(turns).round(turns)
