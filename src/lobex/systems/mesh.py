"""The mesh of a period: pieces that end at the jumps of the coefficients and where the delays carry them."""

from math import ceil
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from lobex.systems.coefficients import Piece, pieces_between
from lobex.systems.delays import Delay
from lobex.systems.system import DelaySystem

Array = Any

# Of a delay that varies, steps to where it carries a jump: each is off by the share |τ′| < 1 of the one before.
_STEPS = 60
# A share of a piece that is rounding.
_ROUNDING = 1e-9


class Mesh(NamedTuple):
    """The pieces in which forces act, in order.

    Attributes:
        start: phases t/T, (M,).
        length: in periods, (M,). Pieces of no length are harmless.
        gap: what follows each without force, in periods, (M,), or None.
        history: how many pieces hold the longest delay.
        repeats: every delay is the whole period, so that what acts lies M pieces back.
        recent: a delay may be shorter than a piece.
    """

    start: Array
    length: Array
    gap: Array | None
    history: int
    repeats: bool
    recent: bool

    @property
    def pieces(self) -> int:
        """M."""
        return np.shape(self.start)[0]


def pieces_of(system: DelaySystem) -> tuple[Piece, ...]:
    """The smooth pieces of one period, in order; the first may start anywhere.

    A force that jumps bends what is remembered, and so the forces of every delay later, unless that is the whole
    period: these first images of the jumps end pieces as well. Their images in turn are weaker by two more orders.
    """
    own = [pieces for term in system.terms if (pieces := term.coefficient.pieces())]
    if not own:
        return (Piece(0.0, 1.0, False),)
    if len(system.terms) == 1 and system.repeats:
        return own[0]
    jumps = jnp.stack([jnp.asarray(piece.start, dtype=float) for pieces in own for piece in pieces])
    places = [jumps, *(_image(jumps, delay, system.period) for delay in system.delays)]
    return pieces_between(jumps if system.repeats else jnp.concatenate(places))


def mesh_of(system: DelaySystem) -> Mesh:
    """The pieces of ``pieces_of`` in which forces act, each in equal parts where a delay is far shorter."""
    pieces = pieces_of(system)
    if system.repeats:
        contacts = [index for index, piece in enumerate(pieces) if piece.idle is not True]
        start, length, gap = [], [], []
        for first, after in zip(contacts, [*contacts[1:], len(pieces)], strict=True):
            start.append(jnp.asarray(pieces[first].start, dtype=float))
            length.append(jnp.asarray(pieces[first].length, dtype=float))
            gap.append(sum((jnp.asarray(piece.length) for piece in pieces[first + 1 : after]), jnp.zeros(())))
        gaps = jnp.stack(gap) if len(contacts) < len(pieces) else None
        return Mesh(jnp.stack(start), jnp.stack(length), gaps, len(contacts), True, False)
    alike = len(pieces) == 1
    parts = _parts(system, len(pieces))
    share = np.arange(parts) / parts
    start = jnp.stack([jnp.asarray(piece.start) + piece.length * part for piece in pieces for part in share])
    length = jnp.stack([jnp.asarray(piece.length / parts) for piece in pieces for _ in share])
    reach = ceil(system.longest * parts - _ROUNDING) if alike else ceil(system.longest - _ROUNDING) * len(start)
    recent = not alike or system.shortest < (1 - _ROUNDING) / parts
    return Mesh(start, length, None, max(reach, 1), False, recent)


def _parts(system: DelaySystem, pieces: int) -> int:
    """Into how many parts each piece is cut, so that most are not longer than the shortest delay.

    In the next few numbers, that whose parts exceed the longest delay by least: what is remembered is whole pieces.
    """
    # Of a shortest delay that nobody has bounded, what the longest asks for.
    least = max(ceil(1 / ((system.shortest or system.longest) * pieces) - _ROUNDING), 1)
    if pieces > 1:
        return least
    return min(
        range(least, 2 * least + 2),
        key=lambda parts: ceil(system.longest * parts - _ROUNDING) / parts + parts * _ROUNDING,
    )


def _image(jumps: Array, delay: Delay, period: Array) -> Array:
    """The phases at which what happened at ``jumps`` acts."""

    def closer(_: int, phase: Array) -> Array:
        return jumps + delay.shares(phase, period)

    return jax.lax.fori_loop(0, _STEPS, closer, jumps)
