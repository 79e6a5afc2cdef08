"""Places in the period that delays carry to one another: pieces between them leave what acts node to node.

What a tooth leaves at an angle is met by the next one at the same angle. Where a piece ends for one of them, it ends
for the others, and for those that cut at the same time. Of most cutters these places are soon all found.
"""

from collections.abc import Iterator
from dataclasses import replace

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from lobex._compiled import compiled_for
from lobex._namespace import namespace
from lobex._shapes import AnyArray
from lobex.systems.coefficients import AS_ONE, in_period
from lobex.systems.delays import ConstantDelay, Share, WholePeriod
from lobex.systems.links import Link, due_from_before
from lobex.systems.system import Closed, DelaySystem, Places

# A phase, the jump that it comes from, and how often each delay carries it.
_Place = tuple[float, int, tuple[int, ...]]
# Of pieces that are written out one by one.
_MOST = 24
# Nodes that a piece takes, however short, and besides those for a period: for in how many parts it is best cut alone.
_NODES, _NODES_A_PERIOD, _MOST_PARTS = 5, 30, 6
# Of a piece.
_ROUNDING = 1e-6
# Of the period, by how much pieces that are one may differ by numbers that are not quite those that they were found of.
_UNLIKE = 1e-6


def closed_places(system: DelaySystem, jumps: np.ndarray) -> Closed | None:
    """The places to which jumps at phases, (b,), are carried by delays that act there, to and fro, of a system of known
    numbers; None where they are many, or delays not constant.
    """
    if not all(type(delay) in (WholePeriod, Share, ConstantDelay) for delay in system.delays):
        return None
    shares = np.asarray(shares_of(system))
    none: tuple[int, ...] = (0,) * len(shares)
    found: list[_Place] = []
    coming: list[_Place] = [(float(jump), origin, none) for origin, jump in enumerate(in_period(jumps))]
    while coming:
        new = [place for place in _distinct(coming) if not _among(place[0], found)]
        found += new
        if len(found) > _MOST:
            return None
        coming = list(_carried(system, new, shares))
    found.sort()
    start = np.array([place for place, _, _ in found])
    length = np.diff(start, append=start[0] + 1)
    links = _links(system, start, length, shares)
    if links is None:
        return None
    parts = _parts(length)
    closed = Closed(tuple((origin, counts) for _, origin, counts in found), parts, _between_parts(links, parts))
    return _begun_lightly(system, closed)


def _parts(length: np.ndarray) -> tuple[int, ...]:
    """In how many equal parts pieces are best cut, where all have the same number of nodes: as many as the longest asks
    for, and few together.
    """

    def cut(widest: float) -> np.ndarray:
        return np.maximum(np.ceil(length / widest - _ROUNDING), 1).astype(int)

    shares = np.outer(length, 1 / np.arange(1, _MOST_PARTS + 1)).ravel()
    made = [(np.sum(cut(widest)) * (_NODES + _NODES_A_PERIOD * widest), widest) for widest in shares if widest > AS_ONE]
    made = [(cost, widest) for cost, widest in made if np.sum(cut(widest)) <= _MOST]
    return tuple(map(int, cut(min(made)[1])))


def _between_parts(links: tuple[Link, ...], parts: tuple[int, ...]) -> tuple[Link, ...]:
    """Links between parts of pieces, of which each leaves what acts in one."""
    first, count, whole = np.cumsum(parts) - parts, len(parts), sum(parts)

    def between(link: Link) -> Iterator[Link]:
        turns, reader = divmod(link.piece + link.later, count)
        later = int(first[reader] + whole * turns - first[link.piece])
        for part in range(parts[link.piece]):
            yield link._replace(piece=int(first[link.piece]) + part, later=later)

    return tuple(sorted(each for link in links for each in between(link)))


def _begun_lightly(system: DelaySystem, closed: Closed) -> Closed:
    """The same, begun at the place before which the past has least due."""
    count, before = sum(closed.parts), np.cumsum(closed.parts) - closed.parts
    apart = bool(replace(system, places=Places((), 1, True, closed)).chips)

    def begun(place: int) -> tuple[Link, ...]:
        return tuple(sorted(link._replace(piece=int(link.piece - before[place]) % count) for link in closed.links))

    def due(place: int) -> int:
        links = [link._replace(kind=link.delay) if apart else link for link in begun(place)]
        return len(due_from_before(tuple(links), count))

    first = min(range(len(before)), key=due)
    places, parts = closed.places, closed.parts
    return Closed(places[first:] + places[:first], parts[first:] + parts[:first], begun(first))


def between_closed(
    system: DelaySystem, jumps: Float[AnyArray, " b"]
) -> tuple[Float[AnyArray, " M"], Float[AnyArray, " M"]]:
    """Starts and lengths of the pieces between the closed places of a system that jumps at phases, (b,)."""
    assert system.closed is not None
    origins, carried = zip(*system.closed.places, strict=True)
    shares = shares_of(system)
    lib = namespace(jumps, shares)
    place = in_period(jumps[np.array(origins)] + np.array(carried) @ shares)
    length = in_period(place[1:] - place[:-1])
    length = lib.concatenate([length, 1 - lib.sum(length, keepdims=True)]) / np.array(system.closed.parts)
    length = length[np.repeat(np.arange(len(place)), system.closed.parts)]
    # Of other numbers than those that they are of, they are in another order, or do not match: no number, then.
    links = np.array([(link.piece, (link.piece + link.later) % len(length)) for link in system.closed.links])
    unlike = lib.abs(length[links[:, 0]] - length[links[:, 1]])
    known = lib.all(length > -AS_ONE) & lib.all(unlike < _UNLIKE)
    return place[0] + lib.cumsum(length) - length, lib.where(known, length, lib.nan)


def shares_of(system: DelaySystem) -> Float[AnyArray, " K"]:
    """Delays that are constant, in periods, (K,)."""
    shares = [delay.shares(np.zeros(1), system.period)[0] for delay in system.delays]
    return namespace(shares).stack(shares)


def _carried(system: DelaySystem, places: list[_Place], shares: np.ndarray) -> Iterator[_Place]:
    """Where each delay carries places that it meets, and from where what it meets there comes."""
    if not places:
        return
    place = np.array([where for where, _, _ in places])
    here, there = (_acts_about(system, place + sign * shares[:, None]) for sign in (0, 1))
    for index, (_, origin, counts) in enumerate(places):
        for delay, share in enumerate(shares):
            for sign, acts in ((-1, here), (1, there)):
                if acts[delay, index]:
                    moved = tuple(count + sign * (number == delay) for number, count in enumerate(counts))
                    yield float(in_period(place[index] + sign * share)), origin, moved


def _links(system: DelaySystem, start: np.ndarray, length: np.ndarray, shares: np.ndarray) -> tuple[Link, ...] | None:
    """Which piece leaves what acts in which; None where they do not match, as those of rounding."""
    count, middle = len(start), start + length / 2
    acts = _acts(system, np.broadcast_to(middle, (len(shares), count)))
    links = []
    for delay, piece in zip(*np.nonzero(acts), strict=True):
        begun = start[piece] - shares[delay]
        distance = np.abs(np.mod(start - begun + 0.5, 1.0) - 0.5)
        source = int(np.argmin(distance))
        if distance[source] > AS_ONE or abs(length[source] - length[piece]) > AS_ONE:
            return None
        later = int(piece) - source + count * round(float(start[source] - begun))
        # A delay that is itself within rounding is met nowhere.
        if later < 1:
            return None
        links.append(Link(source, later, int(delay)))
    return tuple(sorted(links)) or None


def _acts_about(system: DelaySystem, phase: Float[np.ndarray, "K k"]) -> Bool[np.ndarray, "K k"]:
    """Whether the force of each delay acts just before or just after phases."""
    return _acts(system, phase - AS_ONE) | _acts(system, phase + AS_ONE)


def _acts(system: DelaySystem, phase: Float[np.ndarray, "K k"]) -> Bool[np.ndarray, "K k"]:
    """Whether the force of each delay acts at phases of its own."""
    count = np.shape(phase)[1]
    # Of one shape, for which it is compiled.
    filled = np.pad(phase, ((0, 0), (0, -count % _MOST)), mode="edge")
    return np.asarray(acting_at(system, filled, tuple(range(len(phase)))))[:, :count]


@compiled_for("delays")
def acting_at(system: DelaySystem, phase: Float[Array, "K k"], delays: tuple[int, ...]) -> Bool[Array, "K k"]:
    """Whether forces of the delays act, each at phases of its own."""
    return jnp.stack([system.acting(delay, one) for delay, one in zip(delays, phase, strict=True)])


def _distinct(places: list[_Place]) -> list[_Place]:
    kept: list[_Place] = []
    for place, origin, counts in places:
        if not _among(place, kept):
            kept.append((place, origin, counts))
    return kept


def _among(place: float, others: list[_Place]) -> bool:
    return any(abs((place - other + 0.5) % 1.0 - 0.5) < AS_ONE for other, _, _ in others)
