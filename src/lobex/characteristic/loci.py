"""The rightmost roots of many gains at each speed: followed from some gains to the next, then proven strip by strip.

What is returned as proven was counted: on a line to the left of the foremost root in hand, the number of roots beyond
it, which is the same for all gains of a strip (``strips``), is that of the roots in hand.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from lobex.characteristic.climb import climb
from lobex.characteristic.closed_loop import Loops
from lobex.characteristic.follow import followed, real_or_less
from lobex.characteristic.lanes import placed
from lobex.characteristic.open_loop import Open
from lobex.characteristic.strips import Strips, roots_over

# Foremost roots of a strip differ by so much at most, at first and then.
_WIDTHS = (0.08, 0.02, 0.005)
# Distances of a line from the foremost root of its strip, in widths.
_APART = np.array([0.15, 0.3, 0.5, 0.75, 1.0, 1.4])
_SAME = 1e-6
_REAL = 1e-9
# At what no strip proves.
_ATTEMPTS = 4


def loci(
    opened: Open,
    closed: Callable[[Int[Any, " _"], Int[Any, " _"]], Loops],
    gains: Float[Any, " m"],
) -> tuple[Complex[Any, "n m"], Bool[Any, "n m"]]:
    """The rightmost roots of lanes (n,) at gains (m,), increasing and not 0, and whether they are proven, (n, m).

    Args:
        opened: the lanes.
        closed: gives the loops closed at lanes and numbers of gains.
        gains: K.
    """
    lanes, count = np.shape(opened.present)[1], len(gains)
    there = placed(opened.filled())
    hand = followed(there, lanes, closed, gains)
    proven = np.zeros((lanes, count), dtype=bool)
    for width in _WIDTHS:
        _prove(opened, there, closed, gains, hand, proven, width)
    root = _foremost(hand)
    for attempt in range(_ATTEMPTS):
        row, column = np.nonzero(~proven)
        if not len(row):
            break
        sides = [np.clip(column + side, 0, count - 1) for side in (-1, 1)]
        beside = np.stack([np.where(proven[row, side], root[row, side], np.nan) for side in sides], axis=1)
        # At last from scratch.
        guesses = np.concatenate([hand[row, column], beside], axis=1) if attempt < _ATTEMPTS - 1 else None
        climbed = climb(closed(row, column), guesses, _WIDTHS[-1 if attempt == 0 else 0])
        root[row, column], proven[row, column] = climbed.found[:, 0], climbed.proven
    return root, proven


def _foremost(hand: Complex[Any, "*points r"]) -> Complex[Any, " *points"]:
    """Of roots (…, r), some of them NaN."""
    order = np.argmax(real_or_less(hand), axis=-1)
    return np.take_along_axis(hand, order[..., None], axis=-1)[..., 0]


def _prove(
    opened: Open,
    there: Open,
    closed: Callable[[Int[Any, " _"], Int[Any, " _"]], Loops],
    gains: Float[Any, " m"],
    hand: Complex[Any, "n m r"],
    proven: Bool[Any, "n m"],
    width: float,
) -> None:
    """Prove what can be proven by strips of a width; ``proven`` is written to."""
    ahead = np.max(real_or_less(hand), axis=-1)
    left = np.isfinite(ahead) & ~proven
    row, column = np.nonzero(left)
    if not len(row):
        return
    strip = _strips(ahead, gains, width)[row, column]
    new = np.ones(len(row), dtype=bool)
    new[1:] = (np.diff(row) != 0) | (np.diff(strip) != 0)
    begin, number = np.flatnonzero(new), np.cumsum(new) - 1
    end = np.append(begin[1:], len(row)) - 1
    mine = hand[row, column]
    level = _levels(real_or_less(mine), begin, end, width)
    low, high = gains[column[begin]], gains[column[end]]
    first = np.abs(low) < np.abs(high)
    strongest = np.where(first, column[end], column[begin])
    strips = Strips(row[begin], level, np.where(first, low, high), gains[strongest])
    loops = closed(strips.lane, strongest)
    poles = np.sum(loops.upper.real > level, axis=0) + np.sum(loops.lower.real > level, axis=0)
    roots, decided = roots_over(opened, there, strips, poles)
    proven[row, column] = decided[number] & (_in_hand(mine, level[number]) == roots[number])


def _strips(ahead: Float[Any, "n m"], gains: Float[Any, " m"], width: float) -> Float[Any, "n m"]:
    """Numbers of strips over which the foremost roots' real parts (n, m) do not differ by more, and gains' signs."""
    known = np.maximum.accumulate(np.where(np.isfinite(ahead), np.arange(len(gains)), 0), axis=1)
    filled = np.take_along_axis(ahead, known, axis=1)
    with np.errstate(invalid="ignore"):
        moved = np.abs(np.diff(filled, axis=1, prepend=filled[:, :1]))
    moved = np.where(np.isfinite(moved), moved, 0.0) + 2 * width * np.diff(gains > 0, prepend=gains[0] > 0)
    return np.floor(np.cumsum(moved, axis=1) / width)


def _levels(
    real: Float[Any, "k r"], begin: Int[Any, " strips"], end: Int[Any, " strips"], width: float
) -> Float[Any, " strips"]:
    """The line of each strip: somewhat to the left of the foremost root, and far from the others."""
    least = np.minimum.reduceat(np.max(real, axis=1), begin)
    trial = least[:, None] - width * _APART
    others = np.concatenate([real[part] for part in (begin, (begin + end) // 2, end)], axis=1)
    distance = np.min(np.abs(trial[:, :, None] - others[:, None, :]), axis=2)
    return np.take_along_axis(trial, np.argmax(distance, axis=1)[:, None], axis=1)[:, 0]


def _in_hand(hand: Complex[Any, "k r"], level: Float[Any, " k"]) -> Int[Any, " k"]:
    """How many different roots of the points (k, r) lie beyond the levels (k,); a pair counts twice."""
    size = 1 + np.abs(hand)
    with np.errstate(invalid="ignore"):
        counted = np.where(np.abs(hand.imag) > _REAL * size, 2, 1) * (hand.real > level[:, None])
        for one in range(hand.shape[1]):
            for other in range(one):
                again = np.abs(hand[:, one] - hand[:, other]) < _SAME * size[:, one]
                counted[:, one] *= ~again
    return np.sum(counted, axis=1)
