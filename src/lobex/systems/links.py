"""Links: which piece of a period leaves what acts in which."""

from typing import NamedTuple

Due = tuple[int, int]
"""How many pieces later something is due, and its kind: all that is of one kind is one sum."""


class Link(NamedTuple):
    """What one piece leaves to act in another one.

    Attributes:
        piece: that leaves it.
        later: how many pieces after it that is in which it acts.
        delay: by which of ``DelaySystem.delays`` it comes, node to node; None where it may be any of them, and between
            the nodes.
        kind: of what is due by it.
    """

    piece: int
    later: int
    delay: int | None
    kind: int = 0


def links_of(links: tuple[Link, ...], piece: int) -> list[tuple[int, Link]]:
    """Those of what a piece leaves, with their numbers."""
    return [(number, link) for number, link in enumerate(links) if link.piece == piece]


def dues_of(links: tuple[Link, ...], pieces: int) -> tuple[tuple[int, int], ...]:
    """In which pieces something is due, and its kind."""
    return tuple(sorted({((link.piece + link.later) % pieces, link.kind) for link in links}))


def due_from_before(links: tuple[Link, ...], pieces: int) -> tuple[Due, ...]:
    """What is due, from before a period, in pieces from its start on."""
    latest: dict[Due, int] = {}
    for link in links:
        reader = (link.piece + link.later) % pieces, link.kind
        latest[reader] = max(latest.get(reader, 0), link.later)
    pending = [
        (piece + turn, kind) for (piece, kind), most in latest.items() for turn in range(0, most - piece, pieces)
    ]
    return tuple(sorted(pending))
