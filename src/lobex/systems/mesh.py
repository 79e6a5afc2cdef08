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
from lobex.systems.closed_places import acting_at, closed_places, shares_of
from lobex.systems.coefficients import Jumps, Piece, in_period, jumps_of, spans_between
from lobex.systems.delays import Delay, OneOfMany, WholePeriod
from lobex.systems.links import Link, due_from_before, dues_of
from lobex.systems.system import DelaySystem, Places

# Images of images of jumps: each generation bends forces by two orders less. The last one only where places are fewer.
_IMAGES, _MANY = 2, 24
# Of a delay that varies, steps to where it carries a jump: each is off by the share |τ′| < 1 of the one before.
_STEPS = 60
# Pieces that hold the longest delay for a shorter one's sake: the state grows with them.
_MOST_BACK = 16
# A share of a piece that is rounding.
_ROUNDING = 1e-9
# Of the period, by how much pieces that are one may differ by numbers that are not quite those that they were found of.
_UNLIKE = 1e-6


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
        return tuple(Piece(*piece, False) for piece in zip(*_between_closed(system), strict=True))
    if len(system.feedback) == 1 and system.repeats:
        return system.feedback[0].coefficient.pieces()
    return tuple(Piece(*piece, False) for piece in zip(*_between(system), strict=True))


def places_that_matter(system: DelaySystem) -> Places:
    """Of all jumps and their images, of a system of known numbers, those that differ and at which a force acts.

    To be asked by processes whose jumps and delays keep their order whatever speed and gain, once when they are made:
    each place that is left out is a piece less.
    """
    generations = [np.mod(np.asarray(part), 1.0) for part in _generations(system, _IMAGES + 1)]
    places = np.concatenate(generations)
    distinct: list[int] = []
    for index in np.flatnonzero(_bending(system, generations)):
        distance = np.abs(np.mod(places[index] - places[distinct] + 0.5, 1.0) - 0.5)
        if not np.any(distance < _ROUNDING):
            distinct.append(int(index))
    kept = [index for index in distinct if index < sum(map(len, generations[: 1 + _IMAGES]))]
    start = np.sort(places[kept])
    # How many starts lie within the longest delay before each, and one more for the piece that its end falls into.
    before = np.mod(start[:, None] - start, 1.0)
    reach = int(np.max(np.sum((before > 0) & (before < system.longest - _ROUNDING), axis=1))) + 1
    reach = min(reach, len(kept)) if system.longest <= 1 else ceil(system.longest) * len(kept)
    closed = closed_places(system, np.asarray(_starts(system)))
    # What takes more to remember node to node is looked up between the nodes.
    if closed is not None and len(due_from_before(closed.links, len(closed.places))) > reach:
        closed = None
    return Places(tuple(kept), reach, len(kept) == len(distinct), closed, len(generations[0]))


def places_by_angle(system: DelaySystem, repeats: int) -> Places:
    """Of all places of a system that repeats in angle, whose delays are not above such a part of it, wherever they are.

    To be asked by processes whose jumps move.
    """
    every = sum(map(len, _generations(system, _IMAGES)))
    # As many in each part of the turning, and the piece that its end falls into.
    return Places(tuple(range(every)), every // repeats + 1, False)


def _bending(system: DelaySystem, generations: list[np.ndarray]) -> np.ndarray:
    """Whether a force acts at each place, and acted at the one of which it is the image, and so on; of all in turn."""
    bent = [np.ones(len(generations[0]), dtype=bool)]
    carriers = _carriers(system)
    for images in generations[1:]:
        around = np.split(np.stack([images - _ROUNDING, images + _ROUNDING]), len(carriers), axis=1)
        acts = np.asarray(acting_at(system, np.stack([side.ravel() for side in around]), tuple(carriers)))
        acts = [part.reshape(2, -1).any(axis=0) for part in acts]
        bent.append(np.concatenate([part & bent[-1] for part in acts]))
    return np.concatenate(bent)


def seen_to_bend(system: DelaySystem) -> int | None:
    """How many generations of images of jumps end pieces; None where nothing bends a force within a piece."""
    if system.to_nodes or not _jumping(system):
        return None
    if system.places is None:
        return len(_few_generations(system)) - 1
    return None if system.places.complete else _IMAGES


def _jumping(system: DelaySystem) -> list[Jumps]:
    """The jumps of the coefficients that do; of those that share their breaks one."""
    own: dict[int, Jumps | None] = {}
    for coefficient in (term.coefficient for term in system.feedback):
        breaks = id(getattr(coefficient, "breaks", coefficient))
        if breaks not in own:
            own[breaks] = jumps_of(coefficient)
    return [jumps for jumps in own.values() if jumps is not None]


def _carriers(system: DelaySystem) -> dict[int, Delay]:
    """The delays that carry a phase to another one, by their numbers in ``DelaySystem.delays``."""
    kept = (WholePeriod, OneOfMany)

    def carries(delay: Delay) -> bool:
        # By an angle after which all repeats, jumps come to jumps.
        return not isinstance(delay.inner if isinstance(delay, SinceAngle) else delay, kept)

    return {index: delay for index, delay in enumerate(system.delays) if carries(delay)}


def _generations(system: DelaySystem, images: int) -> list[Float[AnyArray, " _"]]:
    """The phases at which coefficients jump, and unless every delay is the whole period their images by each delay in
    turn, the images of those, and so on.
    """
    generations = [_starts(system)]
    carriers = _carriers(system).values()
    for _ in range(images if carriers else 0):
        parts = [_image(generations[-1], delay, system.period) for delay in carriers]
        generations.append(namespace(parts).concatenate(parts))
    return generations


def _starts(system: DelaySystem) -> Float[AnyArray, " b"]:
    """The phases at which coefficients jump."""
    parts = [jumps.phase for jumps in _jumping(system)]
    return namespace(parts).concatenate(parts) if parts else np.zeros(0)


def _few_generations(system: DelaySystem) -> list[Float[AnyArray, " _"]]:
    """The phases at which pieces may end."""
    generations = _generations(system, _IMAGES)
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
    if system.closed is not None:
        start, length = _between_closed(system)
        links = system.closed.links
        if system.chips:
            # Each tooth meets a chip of its own.
            links = tuple(link._replace(kind=link.delay) for link in links)
        return Mesh(start, length, None, max(link.later for link in links), False, links)
    first, whole = _between(system) if _jumping(system) else (np.zeros(1), np.ones(1))
    alike = len(first) == 1
    parts = _parts(system, len(first))
    start = (first[:, None] + whole[:, None] * (np.arange(parts) / parts)).ravel()
    length = (whole[:, None] / parts * np.ones(parts)).ravel()
    if alike:
        reach = ceil(system.longest * parts - _ROUNDING)
    else:
        reach = ceil(system.longest - _ROUNDING) * len(start) if system.places is None else system.places.reach * parts
    recent = not alike or system.shortest < (1 - _ROUNDING) / parts
    reach = max(reach, 1)
    links = tuple(Link(piece, later, None) for piece in range(len(start)) for later in range(1, reach + 1))
    return Mesh(start, length, None, reach, recent, links)


def _between_closed(system: DelaySystem) -> tuple[Float[AnyArray, " M"], Float[AnyArray, " M"]]:
    """Starts and lengths of the pieces between places that are closed, in their order."""
    assert system.closed is not None
    origins, carried = zip(*system.closed.places, strict=True)
    starts, shares = _starts(system), shares_of(system)
    lib = namespace(starts, shares)
    place = in_period(starts[np.array(origins)] + np.array(carried) @ shares)
    length = lib.concatenate([place[1:], place[:1] + 1]) - place
    # Of other numbers than those that they are of, they are in another order, or do not match: no number, then.
    links = np.array([(link.piece, (link.piece + link.later) % len(place)) for link in system.closed.links])
    unlike = lib.abs(length[links[:, 0]] - length[links[:, 1]])
    return place, lib.where(lib.all(length > 0) & lib.all(unlike < _UNLIKE), length, lib.nan)


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
    least = max(ceil(1 / (shortest * pieces) - _ROUNDING), 1)
    if pieces > 1:
        return least
    return min(
        range(least, 2 * least + 2),
        key=lambda parts: ceil(system.longest * parts - _ROUNDING) / parts + parts * _ROUNDING,
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
