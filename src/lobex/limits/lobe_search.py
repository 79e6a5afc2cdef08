"""The point of lowest gain on the lobes at one speed, among the stretches of a receptance."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from lobex._lockstep import repeated
from lobex._namespace import namespace
from lobex._roots import bracketed_root
from lobex._shapes import AnyArray
from lobex.limits.phase import phase
from lobex.limits.receptance_curve import ReceptanceCurve
from lobex.limits.sections import on_boundary
from lobex.limits.stretches import Stretches

# Gains within this relative distance are a tie, and roots this close in ω are one root found twice.
_TIE = 1e-9
_SAME_ROOT = 1e-6
# Stretches that are looked at together in NumPy: a few of the lowest are enough for most speeds.
_TOGETHER = 32


class LobePoint(NamedTuple):
    """Where the phase is that of a lobe: row and offset on the curve, lobe number, gain (∞ for none), tie."""

    row: Int[AnyArray, " *lanes"]
    offset: Float[AnyArray, " *lanes"]
    lobe: Float[AnyArray, " *lanes"]
    gain: Float[AnyArray, " *lanes"]
    tie: Bool[AnyArray, " *lanes"]


class _Ends(NamedTuple):
    """Of stretches at a speed.

    Attributes:
        last: the offset of the end of higher gain.
        low, high: the phases at both ends, less whole turns.
        high_rate: that by ω at the end of higher gain.
        turning: whether the phase has an extremum within.
        along: how far from the end of lower gain the tangents meet, rad/s.
        slack: rounding of phases.
        least, most: what phases may be within.
    """

    last: Float[AnyArray, " *points"]
    low: Float[AnyArray, " *points"]
    high: Float[AnyArray, " *points"]
    high_rate: Float[AnyArray, " *points"]
    turning: Bool[AnyArray, " *points"]
    along: Float[AnyArray, " *points"]
    slack: Float[AnyArray, " *points"]
    least: Float[AnyArray, " *points"]
    most: Float[AnyArray, " *points"]


def lowest_lobe_point(curve: ReceptanceCurve, stretches: Stretches, speed: Float[AnyArray, " *lanes"]) -> LobePoint:
    """The point of lowest gain at a speed, of one lane that JAX traces, or of many in NumPy.

    Stretches come in the order of their least gain. Those that hold a point of a lobe, by the phases at their ends and
    the tangents there, are solved in turn until the next one cannot hold a lower gain than the best found.
    """
    lib = namespace(curve.anchor, stretches, speed)
    zero = lib.zeros_like(speed)
    row, offset = (lib.full(lib.shape(speed), part[0]) for part in (stretches.row, stretches.low))
    best = LobePoint(row, offset, zero, zero + lib.inf, zero > 0)
    if lib is not np:
        return _lowest_of(curve, stretches, speed, best)
    for start in range(0, len(stretches.gain), _TOGETHER):
        left = np.flatnonzero(stretches.gain[start] <= best.gain * (1 + _TIE))
        part = _at(stretches, np.arange(start, min(start + _TOGETHER, len(stretches.gain))))
        found = _lowest_of(curve, part, speed[left], LobePoint(*(whole[left] for whole in best)))
        for whole, new in zip(best, found, strict=True):
            whole[left] = new
    return best


def _lowest_of(
    curve: ReceptanceCurve, stretches: Stretches, speed: Float[AnyArray, " *lanes"], best: LobePoint
) -> LobePoint:
    """As above, beside the best point of other stretches."""
    lib = namespace(curve.anchor, stretches, speed)
    ends = _ends(curve, stretches, speed[..., None])
    held = (lib.ceil(ends.least - ends.slack) <= ends.most + ends.slack) & (stretches.gain < lib.inf)
    index = np.arange(held.shape[-1])

    def following(held: Any, i: Any) -> tuple[Any, Any]:
        """The next stretch with a point of a lobe, and the least gain it can hold."""
        rest = held & (index > i[..., None])
        after = lib.argmax(rest, axis=-1)
        return after, lib.where(lib.any(rest, axis=-1), stretches.gain[after], lib.inf)

    def promising(_: Any, state: tuple[Any, Any, LobePoint]) -> Any:
        _, bound, best = state
        return (bound < lib.inf) & (bound <= best.gain * (1 + _TIE))

    def search(given: tuple[Any, Any], state: tuple[Any, Any, LobePoint]) -> tuple[Any, Any, LobePoint]:
        speed, held = given
        i, _, best = state
        return *following(held, i), _better(curve, best, _solved(curve, _at(stretches, i), speed))

    first = following(held, lib.full(lib.shape(speed), -1))
    return repeated(search, promising, (speed, held), (*first, best))[2]


def _at(stretches: Stretches, index: Int[AnyArray, " *lanes"]) -> Stretches:
    return Stretches(*(part[index] for part in stretches))


def _ends(curve: ReceptanceCurve, stretches: Stretches, speed: Float[AnyArray, " *points"]) -> _Ends:
    """Of stretches at speeds, which broadcast."""
    lib = namespace(curve.anchor, stretches, speed)
    rate = 1 / (2 * np.pi * speed)
    turns = curve.anchor[stretches.row] * rate
    begin = turns - lib.floor(turns)
    # In one revolution's ω the phase gains a turn: the open stretch need not be longer.
    last = lib.where(lib.isinf(stretches.high), stretches.low + 2 * np.pi * speed * 1.001, stretches.high)
    low = begin + stretches.low * rate + stretches.low_turns
    high = begin + last * rate + stretches.high_turns
    low_rate, high_rate = rate + stretches.low_rate, rate + stretches.high_rate
    turning = low_rate * high_rate < 0
    # The phase is convex or concave in a stretch, so that its extremum lies before where the end tangents meet.
    along = (high - low - high_rate * (last - stretches.low)) / lib.where(turning, low_rate - high_rate, 1.0)
    tangents = lib.where(turning, low + low_rate * along, low)
    least, most = lib.minimum(lib.minimum(low, high), tangents), lib.maximum(lib.maximum(low, high), tangents)
    slack = 16 * lib.finfo(rate.dtype).eps * (2 + lib.maximum(lib.abs(least), lib.abs(most)))
    return _Ends(last, low, high, high_rate, turning, along, slack, least, most)


def _solved(curve: ReceptanceCurve, stretch: Stretches, speed: Float[AnyArray, " *lanes"]) -> LobePoint:
    """The point of lowest gain in one stretch of each lane."""
    lib = namespace(curve.anchor, stretch, speed)
    ends, first, row = _ends(curve, stretch, speed), stretch.low, stretch.row
    last, turning, slack = ends.last, ends.turning, ends.slack
    rate, rounding = 1 / (2 * np.pi * speed), lib.finfo(speed.dtype).eps
    length = last - first
    middle = first + lib.clip(ends.along / length, 0.01, 0.99) * length
    extreme = bracketed_root(
        lambda given, x: phase(curve, given[0], given[1], x)[1:],
        (speed, row),
        first,
        last,
        ends.high_rate > 0,
        middle,
        4 * rounding * rate,
        turning,
    )
    extreme = lib.where(turning, extreme, last)
    top = lib.where(turning, phase(curve, speed, row, extreme)[0], ends.high)
    near, near_held = _first_level(ends.low, top, slack)
    far, far_held = _first_level(top, ends.high, slack)
    level = lib.where(near_held, near, far)
    start, stop = lib.where(near_held, first, extreme), lib.where(near_held, extreme, last)
    start_phase, stop_phase = lib.where(near_held, ends.low, top), lib.where(near_held, top, ends.high)
    part = (level - start_phase) / lib.where(stop_phase == start_phase, 1.0, stop_phase - start_phase)
    guess = start + lib.clip(part, 0.0, 1.0) * (stop - start)

    def miss(given: tuple[Any, ...], offset: Any) -> tuple[Any, Any]:
        speed, row, level = given
        value, slope, _ = phase(curve, speed, row, offset)
        return value - level, slope

    tolerance = 2 * rounding * (1 + lib.abs(level))
    rising = stop_phase > start_phase
    offset = bracketed_root(miss, (speed, row, level), start, stop, rising, guess, tolerance)
    response, _, _ = curve.at(row, offset)
    there = (near_held | far_held) & (response.real < 0)
    gain = lib.where(there, on_boundary(lib.where(there, response.real, -1.0)), lib.inf)
    return LobePoint(row, offset, lib.floor(curve.anchor[row] * rate) + level, gain, lib.zeros_like(there))


def _better(curve: ReceptanceCurve, best: LobePoint, new: LobePoint) -> LobePoint:
    lib = namespace(curve.anchor, best, new)
    lower = new.gain < best.gain
    smaller, larger = lib.minimum(best.gain, new.gain), lib.maximum(best.gain, new.gain)
    close = (larger <= smaller * (1 + _TIE)) & (larger < lib.inf)
    omega, other = (curve.anchor[c.row] + c.offset for c in (best, new))
    distinct = (best.lobe != new.lobe) | (lib.abs(omega - other) > _SAME_ROOT * omega)
    tie = lib.where(close, best.tie | distinct, ~lower & best.tie)
    row, offset, lobe, gain = (lib.where(lower, n, b) for n, b in zip(new[:4], best[:4], strict=True))
    return LobePoint(row, offset, lobe, gain, tie)


def _first_level(
    start: Float[AnyArray, " *lanes"], stop: Float[AnyArray, " *lanes"], slack: Float[AnyArray, " *lanes"]
) -> tuple[Float[AnyArray, " *lanes"], Bool[AnyArray, " *lanes"]]:
    """The first whole number on the way from one phase to another, and whether there is one."""
    lib = namespace(start, stop)
    up = stop > start
    level = lib.where(up, lib.ceil(start - slack), lib.floor(start + slack))
    return level, lib.where(up, level <= stop + slack, level >= stop - slack)
