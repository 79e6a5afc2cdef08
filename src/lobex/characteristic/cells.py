"""Parts of lines Re z = x, divided until a bound decides each of them."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from lobex.characteristic.closed_loop import Loops
from lobex.characteristic.function import inverted

# A cell that is no wider than rounding is taken as what it is in its middle.
_NARROWEST = 1e-14
_ROUNDS = 100
_MOST = 2**19
# That an undecided cell is divided into.
PARTS = 4
# Of poles that cells begin and end at, at most.
_HEIGHTS = 16


class Cells(NamedTuple):
    """Parts of lines, (c, PARTS): those of a row follow each other, and what is fetched for a line serves all of them.

    Attributes:
        line: its number, (c,).
        low: where each part begins.
        high: where it ends.
    """

    line: Int[Any, " c"]
    low: Float[Any, "c parts"]
    high: Float[Any, "c parts"]

    def at(
        self, row: Int[Any, " k"], part: Int[Any, " k"]
    ) -> tuple[Int[Any, " k"], Float[Any, " k"], Float[Any, " k"]]:
        """Single ones, each (k,)."""
        return self.line[row], self.low[row, part], self.high[row, part]


def divided(line: Int[Any, " c"], low: Float[Any, " c"], high: Float[Any, " c"]) -> Cells:
    """Intervals (c,) cut into equal parts."""
    inner = low[:, None] + (high - low)[:, None] * (np.arange(1, PARTS) / PARTS)
    return Cells(line, np.column_stack([low, inner]), np.column_stack([inner, high]))


class Bounds(NamedTuple):
    """Over a cell, of |M|, |M′| and |M″|."""

    value: Float[Any, " *cells"]
    slope: Float[Any, " *cells"]
    bend: Float[Any, " *cells"]


def over_modes(term: Callable[[Loops], Any], loops: Loops, like: Any) -> Any:
    """Sums over the modes of what ``term`` gives, a tree of the shapes of ``like``.

    By a loop: without one the compiler computes the sums again for each of their uses.
    """

    def add(sums: Any, mode: Loops) -> tuple[Any, None]:
        return jax.tree.map(jnp.add, sums, term(mode)), None

    return jax.lax.scan(add, jax.tree.map(jnp.zeros_like, like), loops)[0]


def bounds_of_mode(
    mode: Loops, level: Float[Any, "..."], middle: Float[Any, " *cells"], half: Float[Any, " *cells"]
) -> Bounds:
    """By the triangle inequality, from the distances of cells of Re z = ``level`` to the poles."""

    def distance(pole: Complex[Any, " l"]) -> Float[Any, "..."]:
        outside = jnp.maximum(jnp.abs(middle - pole.imag) - half, 0.0)
        return jnp.sqrt(jnp.square(level - pole.real) + jnp.square(outside))

    upper, lower = distance(mode.upper), distance(mode.lower)
    both = 1 / (upper * lower)
    either = (upper + lower) * both
    first = jnp.abs(mode.first)
    top = first * (jnp.abs(level) + jnp.abs(middle) + half) + jnp.abs(mode.constant)
    return Bounds(
        value=top * both,
        slope=both * (first + top * either),
        bend=2 * both * (first * either + top * (jnp.square(either) - both)),
    )


def value_of_mode(mode: Loops, z: Complex[Any, " *cells"]) -> Complex[Any, " *cells"]:
    """M at z."""
    return (mode.first * z + mode.constant) * inverted((z - mode.upper) * (z - mode.lower))


def narrow(middle: Float[Any, " *cells"], half: Float[Any, " *cells"]) -> Bool[Any, " *cells"]:
    """Whether rounding is as wide as a cell."""
    return half < _NARROWEST * (1 + jnp.abs(middle))


def first_cells(loops: Loops, level: Float[Any, " lines"], least: Float[Any, " lines"]) -> Cells:
    """From 0 over heights of poles to a height beyond which |M| is below ``least``, (lines,)."""
    heights = np.sort(np.abs(loops.upper.imag), axis=0)
    # Most of many poles are quiet, and one bound serves several.
    heights = heights[np.unique(np.linspace(0, len(heights) - 1, _HEIGHTS).astype(int))]
    first, constant = np.abs(loops.first), np.abs(loops.constant)
    # Beyond the highest pole by b, |M| is at most A/b + B/b².
    a = np.sum(first, axis=0) / least
    b = np.sum(first * (np.abs(level) + heights[-1]) + constant, axis=0) / least
    beyond = 1.1 * (a + np.sqrt(a * a + 4 * b)) / 2 + 1e-3
    edges = np.concatenate([np.zeros((1, len(level))), heights, heights[-1:] + beyond])
    low, high = edges[:-1].T.ravel(), edges[1:].T.ravel()
    line = np.repeat(np.arange(len(level)), len(edges) - 1)
    kept = high > low
    return divided(line[kept], low[kept], high[kept])


def decide(
    cells: Cells, look: Callable[[Cells], Bool[Any, "c parts"]], lines: int, rounds: int = _ROUNDS
) -> Bool[Any, " {lines}"]:
    """Divide the cells that ``look`` is undecided about, (c, PARTS), until it is about none; whether each line is."""
    decided = np.ones(lines, dtype=bool)
    for _ in range(rounds):
        if not len(cells.line):
            return decided
        if len(cells.line) > _MOST:
            break
        cells = divided(*cells.at(*np.nonzero(look(cells))))
    decided[cells.line] = False
    return decided
