"""The mesh of a period: pieces that end at the jumps of the coefficients and where the delays carry them."""

from math import ceil
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from lobex._namespace import namespace
from lobex._shapes import AnyArray, Number
from lobex.systems.at_angle import SinceAngle
from lobex.systems.closed_places import between_closed
from lobex.systems.coefficients import Jumps, Piece, jumps_of, spans_between
from lobex.systems.delays import Delay, OneOfMany, WholePeriod
from lobex.systems.links import Link, dues_of
from lobex.systems.system import DelaySystem

IMAGES = 2
"""Generations of images of jumps that end pieces: each bends forces by two orders less."""
# The last one only where places are fewer.
_MANY = 24
# Of a delay that varies, steps to where it carries a jump: each is off by the share |τ′| < 1 of the one before.
_STEPS = 60
# Pieces that hold the longest delay for a shorter one's sake: the state grows with them.
_MOST_BACK = 16
ROUNDING = 1e-9
"""A share of a piece that is rounding."""


class Mesh(NamedTuple):
    """The pieces in which forces act, in order.

    Attributes:
        start: phases t/T, (M,).
        length: in periods, (M,). Pieces of no length are harmless.
        gap: what follows each without force, in periods, (M,), or None.
        history: how many pieces hold the longest delay.
        recent: a delay may be shorter than a piece.
        links: which pieces leave what acts in which, in order of those that leave it.
    """

    start: Float[AnyArray, " M"]
    length: Float[AnyArray, " M"]
    gap: Float[AnyArray, " M"] | None
    history: int
    recent: bool
    links: tuple[Link, ...]

    @property
    def pieces(self) -> int:
        """M."""
        return np.shape(self.start)[0]

    @property
    def to_nodes(self) -> bool:
        """Whether every delay brings the nodes of a piece to those of another one."""
        return all(link.delay is not None for link in self.links)

    @property
    def as_long_as(self) -> np.ndarray:
        """Of each piece the first one that is known to be as long, (M,): delays bring nodes to nodes."""
        first = np.arange(self.pieces)
        for link in self.links if self.to_nodes else ():
            ends = first[[link.piece, (link.piece + link.later) % self.pieces]]
            first[np.isin(first, ends)] = min(ends)
        return first

    @property
    def alike(self) -> bool:
        """Whether all pieces leave something as many pieces later."""
        kinds = [tuple(link.later for link in self.links if link.piece == piece) for piece in range(self.pieces)]
        return len(set(kinds)) == 1

    @property
    def dues(self) -> tuple[tuple[int, int], ...]:
        """In which pieces something is due, and its kind."""
        return dues_of(self.links, self.pieces)


def pieces_of(system: DelaySystem) -> tuple[Piece, ...]:
    """The smooth pieces of one period, in order; the first may start anywhere.

    A force that jumps bends what is remembered, and so the forces of every delay later, unless that is the whole
    period: these first images of the jumps end pieces as well. Their images in turn are weaker by two more orders,
    and end pieces where there are few places or those that matter are known.
    """
    if not _jumping(system):
        return (Piece(0.0, 1.0, False),)
    if system.closed is not None:
        return tuple(
            Piece(*piece, False) for piece in zip(*between_closed(system, phases_of_jumps(system)), strict=True)
        )
    if len(system.feedback) == 1 and system.repeats:
        return system.feedback[0].coefficient.pieces()
    return tuple(Piece(*piece, False) for piece in zip(*_between(system), strict=True))


def seen_to_bend(system: DelaySystem) -> int | None:
    """How many generations of images of jumps end pieces; None where nothing bends a force within a piece."""
    if system.to_nodes or not _jumping(system):
        return None
    if system.places is None:
        return len(_few_generations(system)) - 1
    return None if system.places.complete else IMAGES


def _jumping(system: DelaySystem) -> list[Jumps]:
    """The jumps of the coefficients and delays that do; of those that share their breaks one."""
    own: dict[int, Jumps | None] = {}
    for coefficient in (term.coefficient for term in system.feedback):
        breaks = id(getattr(coefficient, "breaks", coefficient))
        if breaks not in own:
            own[breaks] = jumps_of(coefficient)
    for breaks in (getattr(delay, "breaks", ()) for delay in system.delays):
        if id(breaks) not in own and np.size(breaks):
            own[id(breaks)] = Jumps(namespace(breaks).asarray(breaks), np.arange(np.size(breaks)) > 0)
    return [jumps for jumps in own.values() if jumps is not None]


def carriers_of(system: DelaySystem) -> dict[int, Delay]:
    """The delays that carry a phase to another one, by their numbers in ``DelaySystem.delays``."""
    kept = (WholePeriod, OneOfMany)

    def carries(delay: Delay) -> bool:
        # By an angle after which all repeats, jumps come to jumps.
        return not isinstance(delay.inner if isinstance(delay, SinceAngle) else delay, kept)

    return {index: delay for index, delay in enumerate(system.delays) if carries(delay)}


def generations_of(system: DelaySystem, images: int) -> list[Float[AnyArray, " _"]]:
    """The phases at which coefficients jump, and unless every delay is the whole period their images by each delay in
    turn, the images of those, and so on.
    """
    generations = [phases_of_jumps(system)]
    carriers = carriers_of(system).values()
    for _ in range(images if carriers else 0):
        parts = [_image(generations[-1], delay, system.period) for delay in carriers]
        generations.append(namespace(parts).concatenate(parts))
    return generations


def phases_of_jumps(system: DelaySystem) -> Float[AnyArray, " b"]:
    """The phases at which coefficients jump."""
    parts = [jumps.phase for jumps in _jumping(system)]
    return namespace(parts).concatenate(parts) if parts else np.zeros(0)


def _few_generations(system: DelaySystem) -> list[Float[AnyArray, " _"]]:
    """The phases at which pieces may end."""
    generations = generations_of(system, IMAGES)
    many = system.places is None and sum(map(len, generations)) > _MANY
    return generations[:2] if many else generations


def _places(system: DelaySystem) -> Float[AnyArray, " b"]:
    """The same in one array."""
    generations = _few_generations(system)
    return namespace(generations).concatenate(generations)


def _between(system: DelaySystem) -> tuple[Float[AnyArray, " b"], Float[AnyArray, " b"]]:
    """Starts and lengths of the pieces between the phases at which they do."""
    places = _places(system)
    kept = np.arange(len(places)) if system.places is None else np.array(system.places.kept)
    return spans_between(places[kept], _ranks(system, len(places))[kept])


def _ranks(system: DelaySystem, count: int) -> np.ndarray:
    """Of the first of ``count`` places that are jumps: a force begins before another one ends, and images of jumps come
    between them, so that what is between two at one place is what acts on both sides.
    """
    own = np.concatenate([2 * jumps.ends for jumps in _jumping(system)])
    return np.r_[own, np.ones(count - len(own), dtype=int)]


def mesh_of(system: DelaySystem) -> Mesh:
    """The pieces of ``pieces_of`` in which forces act, each in equal parts where a delay is far shorter."""
    if system.closed is not None:
        start, length = between_closed(system, phases_of_jumps(system))
        links = system.closed.links
        if system.chips:
            # Each tooth meets a chip of its own.
            links = tuple(link._replace(kind=link.delay) for link in links)
        return Mesh(start, length, None, max(link.later for link in links), False, links)
    if system.repeats:
        pieces = pieces_of(system)
        contacts = [index for index, piece in enumerate(pieces) if piece.idle is not True]
        start, length, gap = [], [], []
        for first, after in zip(contacts, [*contacts[1:], len(pieces)], strict=True):
            start.append(pieces[first].start)
            length.append(pieces[first].length)
            gap.append(sum((piece.length for piece in pieces[first + 1 : after]), 0.0))
        gaps = _array(gap) if len(contacts) < len(pieces) else None
        count = len(contacts)
        links = tuple(Link(piece, count, 0) for piece in range(count))
        return Mesh(_array(start), _array(length), gaps, count, False, links)
    first, whole = _between(system) if _jumping(system) else (np.zeros(1), np.ones(1))
    alike = len(first) == 1
    parts = _parts(system, len(first))
    start = (first[:, None] + whole[:, None] * (np.arange(parts) / parts)).ravel()
    length = (whole[:, None] / parts * np.ones(parts)).ravel()
    if alike:
        reach = ceil(system.longest * parts - ROUNDING)
    else:
        reach = ceil(system.longest - ROUNDING) * len(start) if system.places is None else system.places.reach * parts
    recent = not alike or system.shortest < (1 - ROUNDING) / parts
    reach = max(reach, 1)
    links = tuple(Link(piece, later, None) for piece in range(len(start)) for later in range(1, reach + 1))
    return Mesh(start, length, None, reach, recent, links)


def _array(numbers: list[Any]) -> Float[AnyArray, " b"]:
    """Numbers as one array, at hand where they are."""
    lib = namespace(numbers)
    return lib.stack([lib.asarray(number, dtype=lib.result_type(float)) for number in numbers])


def _parts(system: DelaySystem, pieces: int) -> int:
    """Into how many parts each piece is cut, so that most are not longer than the shortest delay.

    In the next few numbers, that whose parts exceed the longest delay by least: what is remembered is whole pieces.
    """
    # Of a shortest delay that nobody has bounded, what the longest asks for; far shorter ones lie within a piece.
    shortest = max(system.shortest or system.longest, system.longest / _MOST_BACK)
    least = max(ceil(1 / (shortest * pieces) - ROUNDING), 1)
    if pieces > 1:
        return least
    return min(
        range(least, 2 * least + 2),
        key=lambda parts: ceil(system.longest * parts - ROUNDING) / parts + parts * ROUNDING,
    )


def _image(jumps: Float[AnyArray, " b"], delay: Delay, period: Number) -> Float[AnyArray, " b"]:
    """The phases at which what happened at ``jumps`` acts."""
    if isinstance(delay, SinceAngle):
        return delay.carried(jumps)
    # Among traced numbers as a loop alone: of a function of its own ``traits_of`` would not see what it leaves unused.
    if namespace(jumps, delay, period) is jnp:
        return _carried(jumps, delay, period)
    with jax.ensure_compile_time_eval():
        return np.asarray(_carried_at_hand(jumps, delay, period))


def _carried(jumps: Float[AnyArray, " b"], delay: Delay, period: Number) -> Float[AnyArray, " b"]:
    def closer(_: Int[Array, ""], phase: Float[AnyArray, " b"]) -> Float[AnyArray, " b"]:
        return jumps + delay.shares(phase, period)

    return jax.lax.fori_loop(0, _STEPS, closer, jumps)


_carried_at_hand = jax.jit(_carried)
