"""The rightmost root over a grid of speeds and gains."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from lobex._batches import in_chunks
from lobex.characteristic.climb import ROOTS, climb
from lobex.characteristic.closed_loop import Loops, close, responses
from lobex.characteristic.function import Contact
from lobex.characteristic.lanes import LANES, take
from lobex.characteristic.last_digits import polish
from lobex.characteristic.loci import loci
from lobex.characteristic.open_loop import Open
from lobex.characteristic.rehearsal import rehearse
from lobex.characteristic.several_delays import SeveralDelays

# Every so many gains are looked at from scratch.
_STRIDE = 8
# Roots of a neighbour that are begun with.
_KEPT = 2
# Gains at which the loop is closed together.
_GAINS = 64
# From so many gains on whole strips of them are proven at once; speeds of a part, and parts.
_MANY_GAINS, _MANY_POINTS = 64, 8192
_FEWEST_SPEEDS, _PARTS, _MOST_POINTS = 16, 2, 2**17
_GOLDEN = (5**0.5 - 1) / 2


class Structure(NamedTuple):
    """ż = A z + E K(p y + q y(t − θ τ)), y = C z, at n speeds.

    Attributes:
        drift: A, (n, d, d), 1/s.
        inputs: E, (n, d).
        outputs: C, (n, o, d).
        present: p, (n, o).
        delayed: q, (n, o).
        delay: τ, the longest, (n,), s.
        period: T, (n,), s.
        lag: θ of each output, (n, o), of which the first is what acts now; None where there is one delay.
    """

    drift: Float[Any, "*n d d"]
    inputs: Float[Any, "*n d"]
    outputs: Float[Any, "*n o d"]
    present: Float[Any, "*n o"]
    delayed: Float[Any, "*n o"]
    delay: Float[Any, " *n"]
    period: Float[Any, " *n"]
    lag: Float[Any, "*n o"] | None = None

    @property
    def same(self) -> bool:
        """Whether the speed enters through delays and period alone."""
        return all(bool(np.all(part == part[:1])) for part in self[:5])

    @property
    def opened(self) -> Open:
        """L of every speed in sτ."""
        lag = None if self.lag is None else self.lag.T
        return Open(self.present.T, self.delayed.T, self.alone().at_delay(self.delay), lag)

    def alone(self) -> Loops:
        """H of every speed in s."""
        row = np.zeros(len(self.delay), dtype=int) if self.same else np.arange(len(self.delay))
        return take(responses(*(part[: 1 if self.same else None] for part in self[:3])), row)

    def closed(self, row: Int[Any, " l"], gain: Float[Any, " l"]) -> Loops:
        """The loops in s of speeds and gains, (l,) each."""
        drift, inputs, outputs = (part[row] for part in self[:3])
        present, delayed = (gain[:, None] * part[row] for part in (self.present, self.delayed))
        now = (present[:, None] @ outputs)[:, 0]
        if self.lag is not None:
            return close(drift, inputs, now, (delayed[:, :, None] * outputs)[:, 1:])
        return close(drift, inputs, now, (delayed[:, None] @ outputs)[:, 0])


def rightmost_roots(
    structure: Structure, contact: Contact, gains: Float[Any, " m"]
) -> tuple[Complex[Any, "n m"], Float[Any, "n m"], Bool[Any, "n m"]]:
    """The rightmost roots z, Im z ≥ 0, their errors, and whether they are proven, each (n, m), for gains (m,) ≠ 0."""
    shape = len(structure.delay), len(gains)
    row, column = np.indices(shape)
    if structure.lag is None and shape[1] >= _MANY_GAINS and shape[0] * shape[1] >= _MANY_POINTS:
        return _by_strips(structure, contact, gains)
    return _polished(contact, row, gains[column], *_from_neighbours(structure, gains))


def _by_strips(
    structure: Structure, contact: Contact, gains: Float[Any, " m"]
) -> tuple[Complex[Any, "n m"], Float[Any, "n m"], Bool[Any, "n m"]]:
    """As ``rightmost_roots``, by strips of neighbouring gains."""
    shape = len(structure.delay), len(gains)
    root, error, proven = np.full(shape, np.nan + 0j), np.full(shape, np.nan), np.zeros(shape, dtype=bool)
    opened = structure.opened
    closed = _closed_at(structure, gains)

    # Neighbours take as long as each other: each part gets some of all.
    order = np.argsort(np.arange(shape[0]) * _GOLDEN % 1)

    def work(part: Int[Any, " _"]) -> None:
        index = order[part]
        row, column = np.meshgrid(index, np.arange(shape[1]), indexing="ij")
        found = loci(take(opened, index), lambda lane, column: closed(index[lane], column), gains)
        results = _polished(contact, row, gains[column], *found)
        root[index], error[index], proven[index] = results

    rehearse(opened, closed(order[:1], np.zeros(1, dtype=int)), contact, gains)
    in_chunks(work, shape[0], _speeds_of_a_part(shape), first_alone=False)
    return root, error, proven


def _speeds_of_a_part(shape: tuple[int, int]) -> int:
    """So that each of two threads has one part, or more if they would become too large."""
    return max(_FEWEST_SPEEDS, min(math.ceil(shape[0] / _PARTS), _MOST_POINTS // shape[1]))


def _from_neighbours(structure: Structure, gains: Float[Any, " m"]) -> tuple[Complex[Any, "n m"], Bool[Any, "n m"]]:
    """The rightmost roots, and whether they are proven, each (n, m): some from scratch, others from those beside."""
    shape = len(structure.delay), len(gains)
    found: Any = np.full((*shape, ROOTS), np.nan + 0j)
    proven = np.zeros(shape, dtype=bool)
    closed = _closed_at(structure, gains)
    coarse = np.unique(np.append(np.arange(0, shape[1], _STRIDE), shape[1] - 1))

    def at_columns(columns: Int[Any, " _"], beside: tuple[Int[Any, " _"], ...]) -> None:
        """Fill columns of the grid, from the roots in the columns beside them."""
        row, number = (a.ravel() for a in np.meshgrid(np.arange(shape[0]), np.arange(len(columns)), indexing="ij"))

        def work(index: Int[Any, " _"]) -> None:
            i, j = row[index], columns[number[index]]
            guesses = [found[i, other[number[index]], :_KEPT] for other in beside]
            found[i, j], proven[i, j] = climb(closed(i, j), np.concatenate(guesses, axis=1) if guesses else None)
            # Roots beside may lead past the foremost.
            again = np.flatnonzero(~proven[i, j]) if guesses else index[:0]
            if len(again):
                i, j = i[again], j[again]
                found[i, j], proven[i, j] = climb(closed(i, j))

        in_chunks(work, len(row), LANES)

    between = np.setdiff1d(np.arange(shape[1]), coarse)
    after = np.searchsorted(coarse, between)
    at_columns(coarse, ())
    at_columns(between, (coarse[after - 1], coarse[np.minimum(after, len(coarse) - 1)]))
    return found[..., 0], proven


def rightmost_at_points(
    structure: Structure, contact: Contact, row: Int[Any, " p"], gain: Float[Any, " p"]
) -> tuple[Complex[Any, " p"], Float[Any, " p"], Bool[Any, " p"]]:
    """As ``rightmost_roots`` at points: the numbers of their speeds, (p,), and their gains ≠ 0, (p,)."""
    found, proven = np.full(len(row), np.nan + 0j), np.zeros(len(row), dtype=bool)
    gains, column = np.unique(gain, return_inverse=True)
    closed = _closed_at(structure, gains)

    def work(index: Int[Any, " _"]) -> None:
        climbed = climb(closed(row[index], column[index]))
        found[index], proven[index] = climbed.found[:, 0], climbed.proven

    in_chunks(work, len(row), LANES)
    return _polished(contact, row, gain, found, proven)


def _polished(
    contact: Contact,
    row: Int[Any, " *points"],
    gain: Float[Any, " *points"],
    root: Complex[Any, " *points"],
    proven: Bool[Any, " *points"],
) -> tuple[Complex[Any, " *points"], Float[Any, " *points"], Bool[Any, " *points"]]:
    root, error = root.copy(), np.full(root.shape, np.nan)
    root[proven], error[proven] = polish(contact, row[proven], gain[proven], root[proven])
    return root, error, proven & np.isfinite(error)


def _closed_at(structure: Structure, gains: Float[Any, " m"]) -> Callable[[Int[Any, " _"], Int[Any, " _"]], Any]:
    """Gives the loops in sτ, closed at numbers of speeds and of gains, (l,) each."""

    shared = None
    if structure.same:
        parts = in_chunks(lambda part: structure.closed(np.zeros_like(part), gains[part]), len(gains), _GAINS)
        shared = Loops(*(np.concatenate(part, axis=-1) for part in zip(*parts, strict=True)))

    def closed(row: Int[Any, " l"], column: Int[Any, " l"]) -> Any:
        loops = structure.closed(row, gains[column]) if shared is None else take(shared, column)
        loops = loops.at_delay(structure.delay[row])
        return loops if structure.lag is None else SeveralDelays(loops, structure.lag[row, 1:].T)

    return closed
