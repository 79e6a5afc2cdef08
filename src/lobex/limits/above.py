"""The stretches of a receptance above a gain, and whether the system is stable at it."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from lobex._roots import bracketed_root
from lobex._shapes import AnyArray
from lobex.limits.phase import half_turn_rate, turns_of
from lobex.limits.receptance_curve import ReceptanceCurve
from lobex.limits.sections import on_boundary
from lobex.limits.stretches import Stretches

# Beyond its grid a modal curve is that of a mass, whose gain grows with ω²: by less than this share besides.
_SPARE = 1.1


def above(
    curve: ReceptanceCurve, stretches: Stretches, speed: Float[Array, ""], gain: Float[Array, ""]
) -> tuple[Stretches, Bool[Array, ""]]:
    """The stretches with their parts of lower gain cut off, and whether no root is to the right at ``gain``.

    Every frequency with a lobe's phase and a lower gain has let a pair of roots pass, to the right where the phase
    rises with ω and back where it falls. Over the frequencies of lower gain the difference counts them.

    Args:
        curve: the receptance.
        stretches: all its stretches.
        speed: Hz, a scalar.
        gain: contact stiffness, a scalar, N/m.
    """
    there, closed = stretches.gain < jnp.inf, jnp.isfinite(stretches.high)
    known: Array = jnp.where(there, stretches.gain, 1.0)
    reached = (curve.anchor[stretches.row] + stretches.low) * jnp.sqrt(gain / known) * _SPARE
    last: Array = jnp.where(closed, stretches.high, jnp.maximum(reached - curve.anchor[stretches.row], stretches.low))
    target = on_boundary(gain)
    below = there & closed & (curve.at(stretches.row, last)[0].real <= target)
    through = there & ~below & (stretches.gain < gain)

    def cut(
        row: Int[Array, ""], low: Float[Array, ""], high: Float[Array, ""], wanted: Bool[Array, ""]
    ) -> Float[Array, ""]:
        def miss(offset: Float[Array, ""]) -> tuple[Float[AnyArray, ""], Float[AnyArray, ""]]:
            response, slope, _ = curve.at(row, offset)
            return response.real - target, slope.real

        tolerance = 2 * jnp.finfo(target.dtype).eps * jnp.abs(target)
        return bracketed_root(miss, low, high, jnp.asarray(True), (low + high) / 2, tolerance, wanted)

    edge: Array = jax.vmap(cut)(stretches.row, stretches.low, last, through)
    end: Array = jnp.where(through, edge, last)
    response, slope, _ = curve.at(stretches.row, end)
    rate = 1 / (2 * jnp.pi * speed)
    turns = curve.anchor * rate
    begin = (turns - jnp.floor(turns))[stretches.row]
    first, final = begin + stretches.low * rate + stretches.low_turns, begin + end * rate + turns_of(curve, response)
    passed = jnp.sign(end - stretches.low) * (jnp.floor(final) - jnp.floor(first))
    pairs = jnp.sum(jnp.where(below | through, passed, 0.0))
    rest = stretches._replace(
        low=jnp.where(through, edge, stretches.low),
        low_turns=jnp.where(through, turns_of(curve, response), stretches.low_turns),
        low_rate=jnp.where(through, half_turn_rate(response, slope), stretches.low_rate),
        gain=jnp.where(below, jnp.inf, jnp.maximum(stretches.gain, gain)),
    )
    order = jnp.argsort(rest.gain)
    return Stretches(*(part[order] for part in rest)), pairs == 0
