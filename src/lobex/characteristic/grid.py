"""The rightmost root over a grid of speeds and gains: some gains from scratch, the others from their neighbours'."""

from typing import Any, NamedTuple

import numpy as np

from lobex.characteristic.chunks import in_chunks
from lobex.characteristic.climb import ROOTS, climb
from lobex.characteristic.closed_loop import Loops, close
from lobex.characteristic.function import Contact
from lobex.characteristic.lanes import take
from lobex.characteristic.polish import polish

Array = Any

# Every so many gains are looked at from scratch, and lanes are looked at so many at a time.
_STRIDE = 8
_LANES = (64, 2048)


class Structure(NamedTuple):
    """ż = A z + E K(p y + q y(t − τ)), y = C z, at n speeds.

    Attributes:
        drift: A, (n, d, d), 1/s.
        inputs: E, (n, d).
        outputs: C, (n, d).
        present: p, (n,).
        delayed: q, (n,).
        delay: τ, (n,), s.
    """

    drift: Array
    inputs: Array
    outputs: Array
    present: Array
    delayed: Array
    delay: Array

    @property
    def same(self) -> bool:
        """Whether the speed enters through the delay alone."""
        return all(bool(np.all(part == part[:1])) for part in self[:-1])


def rightmost_roots(structure: Structure, contact: Contact, gains: Array) -> tuple[Array, Array, Array]:
    """The rightmost roots z, Im z ≥ 0, their errors, and whether they are proven, each (n, m), for gains (m,) ≠ 0."""
    shape = len(structure.delay), len(gains)
    root: Array = np.full(shape, np.nan + 0j)
    found: Array = np.full((*shape, ROOTS), np.nan + 0j)
    proven, error = np.zeros(shape, dtype=bool), np.full(shape, np.nan)
    shared = _closed(structure, np.zeros(len(gains), dtype=int), gains) if structure.same else None
    coarse = np.unique(np.append(np.arange(0, shape[1], _STRIDE), shape[1] - 1))
    for columns in (coarse, np.setdiff1d(np.arange(shape[1]), coarse)):
        row, column = (a.ravel() for a in np.meshgrid(np.arange(shape[0]), columns, indexing="ij"))
        before = coarse[np.searchsorted(coarse, column, side="right") - 1]
        after = coarse[np.minimum(np.searchsorted(coarse, column), len(coarse) - 1)]

        def work(index: Array, count: int) -> None:
            i, j = row[index], column[index]
            if shared is None:
                loops = _closed(structure, i, gains[j])
            else:
                loops = take(shared, j)
            loops = loops.at_delay(structure.delay[i])
            guesses = None
            if columns is not coarse:
                guesses = np.concatenate([found[i, before[index]], found[i, after[index]]], axis=1)
            climbed = climb(loops, guesses)
            i, j = i[:count], j[:count]
            found[i, j], proven[i, j] = climbed.found[:count], climbed.proven[:count]
            root[i, j] = climbed.root[:count]

        in_chunks(work, np.arange(len(row)), _LANES)
    row, column = np.nonzero(proven)
    root[row, column], error[row, column] = polish(contact, row, gains[column], root[row, column])
    return root, error, proven & np.isfinite(error)


def _closed(structure: Structure, row: Array, gain: Array) -> Loops:
    """The loops at speeds and gains, (l,), in s."""
    drift, inputs, outputs, present, delayed = (part[row] for part in structure[:-1])
    return close(drift, inputs, outputs, gain * present, gain * delayed)
