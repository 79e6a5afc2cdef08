"""Parts of lines Re z = x, halved until a bound decides each of them."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np

from lobex.characteristic.closed_loop import Loops

Array = Any

# A cell that is no wider than rounding is taken as what it is in its middle.
_NARROWEST = 1e-14
_ROUNDS = 100
_MOST = 2**21


class Cells(NamedTuple):
    """Each (c,): the number of the line, and where the part begins and ends."""

    line: Array
    low: Array
    high: Array


class Bounds(NamedTuple):
    """Over a cell, of |M|, |M′| and |M″|, with its middle and half its width."""

    value: Array
    slope: Array
    bend: Array
    middle: Array
    half: Array

    @property
    def narrow(self) -> Array:
        """Whether rounding is as wide."""
        return self.half < _NARROWEST * (1 + jnp.abs(self.middle))


def bounds(loops: Loops, level: Array, low: Array, high: Array) -> Bounds:
    """By the triangle inequality, from the distances of the cells of Re z = ``level`` to the poles."""
    middle, half = (low + high) / 2, (high - low) / 2

    def inverse_distance(pole: Array) -> Array:
        outside = jnp.maximum(jnp.abs(middle - pole.imag) - half, 0.0)
        return 1 / jnp.sqrt(jnp.square(level - pole.real) + jnp.square(outside))

    upper, lower = inverse_distance(loops.upper), inverse_distance(loops.lower)
    both, either = upper * lower, upper + lower
    first = jnp.abs(loops.first)
    top = first * (jnp.sqrt(jnp.square(level) + jnp.square(middle)) + half) + jnp.abs(loops.constant)
    return Bounds(
        value=jnp.sum(top * both, axis=0),
        slope=jnp.sum(both * (first + top * either), axis=0),
        bend=2 * jnp.sum(both * (first * either + top * (jnp.square(either) - both)), axis=0),
        middle=middle,
        half=half,
    )


def first_cells(loops: Loops, level: Array, least: Array) -> Cells:
    """From 0 over the height of every pole to a height beyond which log |M| is below ``least``, (lines,)."""
    heights = np.sort(np.abs(loops.upper.imag), axis=0)
    first, constant, beyond = np.abs(loops.first), np.abs(loops.constant), np.ones(len(level))
    for _ in range(400):
        with np.errstate(divide="ignore"):
            size = np.log(np.sum((first * (np.abs(level) + heights[-1] + beyond) + constant) / beyond**2, axis=0))
        large = size > least - 0.1
        if not np.any(large):
            break
        beyond = np.where(large, 1.5 * beyond, beyond)
    edges = np.concatenate([np.zeros((1, len(level))), heights, heights[-1:] + beyond])
    low, high = edges[:-1].T.ravel(), edges[1:].T.ravel()
    line = np.repeat(np.arange(len(level)), len(edges) - 1)
    kept = high > low
    return Cells(line[kept], low[kept], high[kept])


def decide(cells: Cells, look: Callable[[Cells], Array], lines: int) -> Array:
    """Halve the cells that ``look`` is undecided about, until it is about none; whether each of the lines is decided."""
    decided = np.ones(lines, dtype=bool)
    for _ in range(_ROUNDS):
        if not len(cells.line):
            return decided
        if len(cells.line) > _MOST:
            break
        undecided = look(cells)
        line, low, high = (part[undecided] for part in cells)
        middle = (low + high) / 2
        cells = Cells(*map(np.concatenate, ((line, line), (low, middle), (middle, high))))
    decided[cells.line] = False
    return decided
