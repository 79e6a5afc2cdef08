"""The exact limit of blades, each in the track of the one before it, that are not coupled otherwise.

With the receptances Gⱼ of the blades, ∏ (1 + 1/(K Gⱼ)) = e^{−iωT} on the boundary, T one revolution: only the sum of
the delays matters. In the plane of ω and x = 1/K the places where the product has the modulus 1 are curves whatever the
speed is. They are followed along ω, with all their branches, until cubic polynomials between neighbouring points say
how they go on; on them the turns of the product and ωT make a whole number at a limit.
"""

from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Bool, Float

from lobex import _checks
from lobex._missing import where_there
from lobex._namespace import namespace
from lobex._shapes import AnyArray
from lobex.limits.modal_curve import ModalCurve
from lobex.limits.sections import Sections
from lobex.limits.several_contacts import numbers_of
from lobex.limits.unit_product import Points, branches_of_one, logarithm

# How well cubics between two points know that halfway: of x, and in turns.
_RESOLVED = 1e-3
_ROUNDS = 60
# Of ω, the distance from which on two branches that end together meet.
_MEETING = 1e-12
# Of the slowest decay of a mode, the distance of points on the axis of ω up to so many times the highest frequency,
# unless they become too many.
_STEP, _TOP, _MOST_POINTS = 0.5, 1.5, 20_000
# Of the best one, how near other places come to it that are settled as well, and how many.
_NEAR, _MOST = 0.02, 16
# Newton's method, and how often others are settled where what looked like the best was none.
_STEPS, _TRIES = 8, 20
_TIE = 1e-9
# Speeds at which all arcs are looked at together.
_BATCH = 16


class Uncoupled(NamedTuple):
    """Blades with forces −K [yⱼ − yⱼ₋₁(t − τⱼ)], with the sum of τⱼ one revolution, that nothing else couples.

    Attributes:
        receptance: Gⱼ, its fields of the shape (N, n).
    """

    receptance: Sections


def limits_of_tracks(
    blades: Uncoupled, speed: Float[AnyArray, " s"]
) -> tuple[Float[AnyArray, " s"], Float[AnyArray, " s"], Bool[np.ndarray, " s"]]:
    """The least K on the boundary at speeds (s,), Hz, NaN where there is none; ω there; and whether two are a tie.

    Differentiable once, outside ``jit`` and ``vmap``: a step of Newton's method from the place carries it.
    """
    known, delay = numbers_of(blades.receptance), 1 / np.asarray(numbers_of(speed), dtype=float)
    first, last = _arcs(known)
    parts = [_limits(known, first, last, delay[i : i + _BATCH]) for i in range(0, len(delay), _BATCH)]
    omega, x, tie = (np.concatenate(part) for part in zip(*parts, strict=True))
    there = np.isfinite(x)
    omega, x = np.where(there, omega, known.angular_frequency[0, 0]), np.where(there, x, 1.0)
    if _checks.is_traced((blades, speed)):
        omega, x = jax.jit(_stepped)(blades.receptance, 1 / speed, omega, x)
    return where_there(there, 1 / x), where_there(there, omega), tie & there


def _arcs(sections: Sections) -> tuple[Points, Points]:
    """Parts of the curves, by their first and last points, (5, arcs) each: between them cubics in ω serve, x has no
    extremum, and the turns go on.
    """
    omega = _axis(sections)
    # Every other point is the first middle of its neighbours.
    every, between = branches_of_one(sections, omega), omega[1::2]
    low, high, left, right = omega[:-1:2], omega[2::2], every[:, :-1:2], every[:, 2::2]
    middle: Any = every[:, 1::2]
    done = []
    for _ in range(_ROUNDS):
        if middle is None:
            between = (low + high) / 2
            middle = branches_of_one(sections, between)
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
    return _best(sections, delay, omega, x)


def _best(
    sections: Sections, delay: Float[np.ndarray, " s"], omega: Float[np.ndarray, "s c"], x: Float[np.ndarray, "s c"]
) -> tuple[Float[np.ndarray, " s"], Float[np.ndarray, " s"], Bool[np.ndarray, " s"]]:
    """As ``_limits``, of candidates (s, c), with x of 0 for none, of which those of largest x are settled."""
    lanes, most = np.arange(len(delay)), min(_MOST, x.shape[1])
    place, value, twice = np.full(len(delay), np.nan), np.full(len(delay), np.inf), np.zeros(len(delay), dtype=bool)
    for _ in range(_TRIES):
        lanes = lanes[np.max(x[lanes], axis=1) > 0]
        if not len(lanes):
            break
        index = np.argpartition(-x[lanes], most - 1, axis=1)[:, :most]
        tried, near = (np.take_along_axis(part[lanes], index, axis=1) for part in (x, omega))
        row, column = np.nonzero((tried > 0) & (tried >= (1 - _NEAR) * np.max(tried, axis=1, keepdims=True)))
        at, found, good = _settled(sections, delay[lanes[row]], near[row, column], tried[row, column])
        values, places = np.full(tried.shape, -np.inf), np.full(tried.shape, np.nan)
        values[row, column], places[row, column] = np.where(good, found, -np.inf), at
        winner = np.argmax(values, axis=1)[:, None]
        top, where = (np.take_along_axis(part, winner, axis=1) for part in (values, places))
        same = (values >= top * (1 - _TIE)) & (np.abs(places - where) > 1e-6 * where)
        here = top[:, 0] > 0
        place[lanes[here]], value[lanes[here]] = where[here, 0], top[here, 0]
        twice[lanes[here]] = np.any(same[here], axis=1)
        x[lanes[row], index[row, column]] = 0.0
        lanes = lanes[~here]
    return place, value, twice


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
        value = logarithm(sections, omega, x)[0] + 1j * omega * delay
    turns = value.imag / (2 * np.pi)
    good = (np.abs(value.real) < 1e-9) & (np.abs(turns - np.round(turns)) < 1e-9)
    return omega, x, good & (np.abs(x - began) < 0.05 * began) & (omega > 0)


def _stepped(
    sections: Sections, delay: Float[AnyArray, " p"], omega: Float[AnyArray, " p"], x: Float[AnyArray, " p"]
) -> tuple[Float[AnyArray, " p"], Float[AnyArray, " p"]]:
    """A step of Newton's method towards ln ∏ (1 + x/Gⱼ) + iωT = 2πik of the nearest k."""
    value, by_omega, by_x = logarithm(sections, omega, x)
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
