"""The point of lowest gain on the lobes at one speed, among the stretches of a receptance."""

from typing import NamedTuple, cast

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from lobex._roots import bracketed_root
from lobex._shapes import AnyArray
from lobex.limits.phase import phase
from lobex.limits.receptance_curve import ReceptanceCurve
from lobex.limits.sections import on_boundary
from lobex.limits.stretches import Stretches

# Gains within this relative distance are a tie, and roots this close in ω are one root found twice.
_TIE = 1e-9
_SAME_ROOT = 1e-6


class LobePoint(NamedTuple):
    """Where the phase is that of a lobe: row and offset on the curve, lobe number, gain (∞ for none), tie."""

    row: Int[Array, ""]
    offset: Float[Array, ""]
    lobe: Float[Array, ""]
    gain: Float[Array, ""]
    tie: Bool[Array, ""]


def lowest_lobe_point(curve: ReceptanceCurve, stretches: Stretches, speed: Float[Array, ""]) -> LobePoint:
    """The point of lowest gain at a scalar speed.

    Stretches come in the order of their least gain. Those that hold a point of a lobe, by the phases at their ends and
    the tangents there, are solved in turn until the next one cannot hold a lower gain than the best found.
    """
    rate = 1 / (2 * jnp.pi * speed)
    rounding = jnp.finfo(rate.dtype).eps
    turns = curve.anchor * rate
    whole = jnp.floor(turns)
    # In one revolution's ω the phase gains a turn: the open stretch need not be longer.
    stretches = stretches._replace(
        high=jnp.where(jnp.isinf(stretches.high), stretches.low + 2 * jnp.pi * speed * 1.001, stretches.high)
    )
    begin = (turns - whole)[stretches.row]
    low = begin + stretches.low * rate + stretches.low_turns
    high = begin + stretches.high * rate + stretches.high_turns
    low_rate, high_rate = rate + stretches.low_rate, rate + stretches.high_rate
    turning = low_rate * high_rate < 0
    length = stretches.high - stretches.low
    # The phase is convex or concave in a stretch, so that its extremum lies before where the end tangents meet.
    along = (high - low - high_rate * length) / jnp.where(turning, low_rate - high_rate, 1.0)
    tangents = jnp.where(turning, low + low_rate * along, low)
    least, most = jnp.minimum(jnp.minimum(low, high), tangents), jnp.maximum(jnp.maximum(low, high), tangents)
    slack = 16 * rounding * (2 + jnp.maximum(jnp.abs(least), jnp.abs(most)))
    held = (jnp.ceil(least - slack) <= most + slack) & (stretches.gain < jnp.inf)
    index = jnp.arange(held.shape[0])

    def solve(i: Int[Array, ""]) -> LobePoint:
        row, first, last = stretches.row[i], stretches.low[i], stretches.high[i]

        def at(offset: Float[Array, ""]) -> tuple[Float[AnyArray, ""], Float[AnyArray, ""], Float[AnyArray, ""]]:
            return phase(curve, speed, row, offset)

        middle = first + jnp.clip(along[i] / length[i], 0.01, 0.99) * length[i]
        extreme = bracketed_root(
            lambda x: at(x)[1:], first, last, high_rate[i] > 0, middle, 4 * rounding * rate, turning[i]
        )
        extreme = jnp.where(turning[i], extreme, last)
        top = jnp.where(turning[i], at(extreme)[0], high[i])
        near, near_held = _first_level(low[i], top, slack[i])
        far, far_held = _first_level(top, high[i], slack[i])
        level = jnp.where(near_held, near, far)
        start, stop = jnp.where(near_held, first, extreme), jnp.where(near_held, extreme, last)
        start_phase, stop_phase = jnp.where(near_held, low[i], top), jnp.where(near_held, top, high[i])
        part = (level - start_phase) / jnp.where(stop_phase == start_phase, 1.0, stop_phase - start_phase)
        guess = start + jnp.clip(part, 0.0, 1.0) * (stop - start)

        def miss(offset: Float[Array, ""]) -> tuple[Float[AnyArray, ""], Float[AnyArray, ""]]:
            value, slope, _ = at(offset)
            return value - level, slope

        tolerance = 2 * rounding * (1 + jnp.abs(level))
        offset = bracketed_root(miss, start, stop, stop_phase > start_phase, guess, tolerance)
        response, _, _ = curve.at(row, offset)
        there = (near_held | far_held) & (response.real < 0)
        gain = jnp.where(there, _gain(response.real, there), jnp.inf)
        return LobePoint(row, offset, whole[row] + level, gain, jnp.asarray(False))

    def following(i: Int[Array, ""]) -> tuple[Int[Array, ""], Float[Array, ""]]:
        """The next stretch with a point of a lobe, and the least gain it can hold."""
        rest = held & (index > i)
        after = jnp.argmax(rest)
        return after, jnp.where(jnp.any(rest), stretches.gain[after], jnp.inf)

    def promising(state: tuple[Int[Array, ""], Float[Array, ""], LobePoint]) -> Bool[Array, ""]:
        _, bound, best = state
        return (bound < jnp.inf) & (bound <= best.gain * (1 + _TIE))

    def search(
        state: tuple[Int[Array, ""], Float[Array, ""], LobePoint],
    ) -> tuple[Int[Array, ""], Float[Array, ""], LobePoint]:
        i, _, best = state
        return *following(i), _better(curve, best, solve(i))

    zero = jnp.zeros_like(rate)
    none = LobePoint(stretches.row[0], stretches.low[0], zero, zero + jnp.inf, jnp.asarray(False))
    return jax.lax.while_loop(promising, search, (*following(jnp.asarray(-1)), none))[2]


def _gain(real: Float[AnyArray, ""], there: Bool[Array, ""]) -> Float[AnyArray, ""]:
    safe: Array = cast(Array, jnp.where(there, real, -1.0))
    return on_boundary(safe)


def _better(curve: ReceptanceCurve, best: LobePoint, new: LobePoint) -> LobePoint:
    lower = new.gain < best.gain
    smaller, larger = jnp.minimum(best.gain, new.gain), jnp.maximum(best.gain, new.gain)
    close = (larger <= smaller * (1 + _TIE)) & (larger < jnp.inf)
    omega, other = (curve.anchor[c.row] + c.offset for c in (best, new))
    distinct = (best.lobe != new.lobe) | (jnp.abs(omega - other) > _SAME_ROOT * omega)
    tie = jnp.where(close, best.tie | distinct, ~lower & best.tie)
    row, offset, lobe, gain = (jnp.where(lower, n, b) for n, b in zip(new[:4], best[:4], strict=True))
    return LobePoint(row, offset, lobe, gain, tie)


def _first_level(
    start: Float[Array, ""], stop: Float[Array, ""], slack: Float[Array, ""]
) -> tuple[Float[Array, ""], Bool[Array, ""]]:
    """The first whole number on the way from one phase to another, and whether there is one."""
    up = stop > start
    level = jnp.where(up, jnp.ceil(start - slack), jnp.floor(start + slack))
    return level, jnp.where(up, level <= stop + slack, level >= stop - slack)
