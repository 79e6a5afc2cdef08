"""What of a system changes within its period otherwise than it says: jumps that no break names, and coefficients whose
functions contradict one another.
"""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex._shapes import AnyArray
from lobex.systems.coefficients import Bending, Coefficient, Following, Function, Piece, gauss_nodes
from lobex.systems.delays import OneOfMany, Varying
from lobex.systems.system import DelaySystem
from lobex.systems.terms import Forcing

# Parts of the period in each of which a jump is looked for, and halvings of each.
_PARTS, _HALVINGS = 256, 36
# Of the largest value: less is what a rounded period leaves, or a steep flank over a millionth of a millionth of it.
JUMP = 1e-5
# So close to a break jumps are those that it names.
_NAMED = 1e-9
# Of a piece, where a coefficient of one's own is looked at.
_INSIDE = np.array([0.1, 0.3, 0.5, 0.7, 0.9])
# Of the largest value: means are held against Gauss' rule over a short part of a piece.
STRAY = 1e-4
STRAYS = (
    ("says that it is constant, and is not", "leave constant False"),
    ("has pieces that do not follow one another through a period", "give start and length of each, in order"),
    ("is at work in a piece that it calls idle", "give idle=False"),
    ("is not the same by within as by at, inside of a piece", "return the same matrices"),
    ("has another mean than what its at gives", "give lobex.systems.coefficients.mean_by_quadrature"),
)
"""What a coefficient may be otherwise than it says, and what would be right, in the order of ``strays_of``."""


class Jump(NamedTuple):
    """The largest jump that no break names.

    Attributes:
        size: relative to the largest value.
        phase: t/T.
    """

    size: Float[AnyArray, ""]
    phase: Float[AnyArray, ""]


def jumps_unnamed(system: DelaySystem) -> list[Jump]:
    """Of each function of time in the feedback, the forcing and the delays of a system."""
    found: list[tuple[Callable[[Any], Any], Any]] = []
    for term in _each_once(system):
        found += [(node.at, _breaks(node)) for node in _coefficients(term) if not isinstance(node, Bending)]
        delay: Any = getattr(term, "delay", None)
        if isinstance(delay, Varying) or is_own(delay):
            found.append((lambda phase, delay=delay: delay.shares(phase, system.period), _breaks(delay)))
    return [_largest_jump(*one) for one in found]


def strays_of(system: DelaySystem) -> list[Float[Array, "5"]]:
    """By how much each coefficient of a class that is none of lobex' contradicts itself, as ``STRAYS`` says."""
    own = [node for term in _each_once(system) for node in _coefficients(term) if is_own(node)]
    return [_strays(node) for node in own if not isinstance(node, Bending)]


def _each_once(system: DelaySystem) -> Iterator[Any]:
    """Terms; of the many that stand for a distributed delay one."""
    seen: set[Any] = set()
    for term in (*system.feedback, *system.forcing):
        if not isinstance(term, Forcing) and isinstance(term.delay, OneOfMany):
            form = jax.tree.structure(term.coefficient)
            if form in seen:
                continue
            seen.add(form)
        yield term


def _coefficients(term: Any) -> list[Any]:
    """The functions and the coefficients of another's class that the coefficient of a term is made of."""

    def known(node: Any) -> bool:
        return isinstance(node, Function | Following) or (is_own(node) and isinstance(node, Coefficient))

    nodes = jax.tree.leaves(term.coefficient, is_leaf=known)
    return [node for node in nodes if known(node) and not isinstance(node, Following)]


def is_own(node: Any) -> bool:
    """Whether the class is another's; those of lobex are held against themselves in its tests."""
    return node is not None and not f"{type(node).__module__}.".startswith("lobex.")


def _breaks(node: Any) -> Float[AnyArray, " b"]:
    if isinstance(node, Coefficient):
        starts = [jnp.asarray(piece.start, dtype=float) for piece in node.pieces()]
        return jnp.stack(starts) if starts else jnp.zeros(0)
    return jnp.ravel(jnp.asarray(getattr(node, "breaks", ()), dtype=float))


def _largest_jump(value: Callable[[Any], Any], breaks: Float[AnyArray, " b"]) -> Jump:
    """By halving each part of the period towards the half that changes more."""

    def at(phase: Float[AnyArray, " p"]) -> Float[Array, "p v"]:
        return jnp.asarray(value(phase)).reshape(_PARTS, -1)

    def apart(first: Float[Array, "p v"], second: Float[Array, "p v"]) -> Float[Array, " p"]:
        return jnp.max(jnp.abs(second - first), axis=1)

    # Between the phases that people name.
    start = (np.arange(_PARTS) + 1 / np.pi) / _PARTS
    low, high = jnp.asarray(start), jnp.asarray(start + 1 / _PARTS)
    ends = at(low), at(high)
    size = jnp.max(jnp.abs(ends[0]))

    def halve(_: Any, state: Any) -> Any:
        low, high, below, above = state
        middle = (low + high) / 2
        there = at(middle)
        left = apart(below, there) >= apart(there, above)
        either = left[:, None]
        return (
            jnp.where(left, low, middle),
            jnp.where(left, middle, high),
            jnp.where(either, below, there),
            jnp.where(either, there, above),
        )

    low, high, *ends = jax.lax.fori_loop(0, _HALVINGS, halve, (low, high, *ends))
    named = jnp.any(jnp.mod(breaks - start[:, None] + _NAMED, 1.0) <= 1 / _PARTS + 2 * _NAMED, axis=1)
    # What is no number is told of elsewhere.
    jump = jnp.nan_to_num(jnp.where(named, 0.0, apart(*ends)))
    largest = jnp.argmax(jump)
    relative = jump[largest] / jnp.where(size > 0, size, 1.0)
    return Jump(jnp.nan_to_num(relative), high[largest])


def _strays(own: Any) -> Float[Array, "5"]:
    pieces = own.pieces() or (Piece(0.0, 1.0, False),)
    start, length, idle = (jnp.stack([jnp.asarray(part) for part in parts]) for parts in zip(*pieces, strict=True))
    phases = start[:, None] + length[:, None] * _INSIDE
    at = own.at(phases.ravel()).reshape(*phases.shape, -1)
    size = jnp.max(jnp.abs(at)) + jnp.finfo(at.dtype).tiny
    inside = jnp.stack([own.within(phase[2], phase).reshape(len(_INSIDE), -1) for phase in phases])
    points, weights = gauss_nodes(12)
    short = length / 64
    among = (phases[:, 2:3] + short[:, None] * points).ravel()
    mean = jnp.einsum("g,pgv->pv", weights, own.at(among).reshape(len(pieces), len(points), -1))
    gap = start + length - jnp.roll(start, -1)
    off = (
        jnp.max(jnp.abs(at - at[:1, :1])) / size if own.constant else jnp.zeros(()),
        jnp.maximum(jnp.max(jnp.abs(gap - jnp.round(gap))), jnp.abs(jnp.sum(length) - 1)),
        jnp.max(jnp.where(jnp.asarray(idle, dtype=bool), jnp.max(jnp.abs(at), axis=(1, 2)), 0.0)) / size,
        jnp.max(jnp.abs(inside - at)) / size,
        jnp.max(jnp.abs(own.mean(phases[:, 2], phases[:, 2] + short).reshape(len(pieces), -1) - mean)) / size,
    )
    return jnp.nan_to_num(jnp.stack(off))
