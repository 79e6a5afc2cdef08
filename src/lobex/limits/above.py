"""The stretches of a receptance above a gain, and whether the system is stable at it."""

from typing import Any

import jax
import numpy as np
from jaxtyping import Bool, Float

from lobex._namespace import namespace
from lobex._roots import bracketed_root
from lobex._shapes import AnyArray, Number
from lobex.limits.phase import half_turn_rate, turns_of
from lobex.limits.receptance_curve import ReceptanceCurve
from lobex.limits.sections import on_boundary
from lobex.limits.stretches import Stretches

# Beyond its grid a modal curve is that of a mass, whose gain grows with ω²: by less than this share besides.
_SPARE = 1.1


def above(
    curve: ReceptanceCurve, stretches: Stretches, speed: Float[AnyArray, " *lanes"], gain: Number
) -> tuple[Stretches, Bool[AnyArray, " *lanes"]]:
    """The stretches with their parts of lower gain cut off, and whether no root is to the right at ``gain``.

    Every frequency with a lobe's phase and a lower gain has let a pair of roots pass, to the right where the phase
    rises with ω and back where it falls. Over the frequencies of lower gain the difference counts them.

    Args:
        curve: the receptance.
        stretches: all its stretches.
        speed: Hz, of one lane that JAX traces, or of many in NumPy.
        gain: contact stiffness, a scalar, N/m.
    """
    lib = namespace(curve.anchor, stretches, speed, gain)
    there, closed = stretches.gain < lib.inf, lib.isfinite(stretches.high)
    known = lib.where(there, stretches.gain, 1.0)
    reached = (curve.anchor[stretches.row] + stretches.low) * lib.sqrt(gain / known) * _SPARE
    last = lib.where(closed, stretches.high, lib.maximum(reached - curve.anchor[stretches.row], stretches.low))
    target = on_boundary(gain)
    below = there & closed & (curve.at(stretches.row, last)[0].real <= target)
    through = there & ~below & (stretches.gain < gain)

    def miss(row: Any, offset: Any) -> tuple[Float[AnyArray, " *stretches"], Float[AnyArray, " *stretches"]]:
        response, slope, _ = curve.at(row, offset)
        return response.real - target, slope.real

    tolerance = 2 * lib.finfo(curve.anchor.dtype).eps * lib.abs(target)

    def cut(row: Any, low: Any, high: Any, wanted: Any) -> Float[AnyArray, " *stretches"]:
        return bracketed_root(miss, row, low, high, True, (low + high) / 2, tolerance, wanted)

    each = cut if lib is np else jax.vmap(cut)
    edge = each(stretches.row, stretches.low, last, through)
    end = lib.where(through, edge, last)
    response, slope, _ = curve.at(stretches.row, end)
    rate = 1 / (2 * np.pi * speed[..., None])
    turns = curve.anchor[stretches.row] * rate
    begin = turns - lib.floor(turns)
    first, final = begin + stretches.low * rate + stretches.low_turns, begin + end * rate + turns_of(curve, response)
    passed = lib.sign(end - stretches.low) * (lib.floor(final) - lib.floor(first))
    pairs = lib.sum(lib.where(below | through, passed, 0.0), axis=-1)
    rest = stretches._replace(
        low=lib.where(through, edge, stretches.low),
        low_turns=lib.where(through, turns_of(curve, response), stretches.low_turns),
        low_rate=lib.where(through, half_turn_rate(response, slope), stretches.low_rate),
        gain=lib.where(below, lib.inf, lib.maximum(stretches.gain, gain)),
    )
    order = lib.argsort(rest.gain)
    return Stretches(*(part[order] for part in rest)), pairs == 0
