"""The cells of a receptance above a gain, and whether the system is stable at it."""

from typing import Any

import jax
import jax.numpy as jnp

from lobex.limits.brackets import Cells, half_turn_rate, half_turns
from lobex.limits.receptance import Curve
from lobex.limits.roots import bracketed_root
from lobex.limits.sections import on_boundary

Array = Any

# Beyond its grid a modal curve is that of a mass, whose gain grows with ω²: by less than this share besides.
_SPARE = 1.1


def above(curve: Curve, cells: Cells, speed: Array, gain: Array) -> tuple[Cells, Array]:
    """The cells with their parts of lower gain cut off, and whether no root is to the right at ``gain``.

    Every frequency with a lobe's phase and a lower gain has let a pair of roots pass, to the right where the phase
    rises with ω and back where it falls. Over the frequencies of lower gain the difference counts them.

    Args:
        curve: the receptance.
        cells: all its cells.
        speed: Hz, a scalar.
        gain: contact stiffness, a scalar, N/m.
    """
    there, closed = cells.gain < jnp.inf, jnp.isfinite(cells.high)
    known: Array = jnp.where(there, cells.gain, 1.0)
    reached = (curve.anchor[cells.row] + cells.low) * jnp.sqrt(gain / known) * _SPARE
    last: Array = jnp.where(closed, cells.high, jnp.maximum(reached - curve.anchor[cells.row], cells.low))
    target = on_boundary(gain)
    below = there & closed & (curve.at(cells.row, last)[0].real <= target)
    through = there & ~below & (cells.gain < gain)

    def cut(row: Array, low: Array, high: Array, wanted: Array) -> Array:
        def miss(offset: Array) -> tuple[Array, Array]:
            response, slope, _ = curve.at(row, offset)
            return response.real - target, slope.real

        tolerance = 2 * jnp.finfo(target.dtype).eps * jnp.abs(target)
        return bracketed_root(miss, low, high, jnp.asarray(True), (low + high) / 2, tolerance, wanted)

    edge: Array = jax.vmap(cut)(cells.row, cells.low, last, through)
    end: Array = jnp.where(through, edge, last)
    response, slope, _ = curve.at(cells.row, end)
    rate = 1 / (2 * jnp.pi * speed)
    turns = curve.anchor * rate
    begin = (turns - jnp.floor(turns))[cells.row]
    first, final = begin + cells.low * rate + cells.low_turns, begin + end * rate + half_turns(response)
    passed = jnp.sign(end - cells.low) * (jnp.floor(final) - jnp.floor(first))
    pairs = jnp.sum(jnp.where(below | through, passed, 0.0))
    rest = cells._replace(
        low=jnp.where(through, edge, cells.low),
        low_turns=jnp.where(through, half_turns(response), cells.low_turns),
        low_rate=jnp.where(through, half_turn_rate(response, slope), cells.low_rate),
        gain=jnp.where(below, jnp.inf, jnp.maximum(cells.gain, gain)),
    )
    order = jnp.argsort(rest.gain)
    return Cells(*(part[order] for part in rest)), pairs == 0
