"""Where contacts meet the casing: each runs in a track, from its own place on, one cell per step."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex._shapes import AnyArray

# (cells, tracks · lanes) and (steps, contacts · blades · lanes): dimensions of length 1 between others cost a copy.
Depth = Float[AnyArray, "_ kept"]
Visited = Float[AnyArray, "_ visited"]


class Tracks(NamedTuple):
    """The places of all contacts, which a compiled march knows.

    Attributes:
        cells: of each track.
        track: of each contact of a blade, (contacts,).
        start: the cell at which each contact of each blade begins, (contacts, blades).
        stretch: for so many steps, a divisor of ``cells``, no two contacts come to the same cell.
    """

    cells: int
    track: tuple[int, ...]
    start: tuple[tuple[int, ...], ...]
    stretch: int

    @classmethod
    def of(cls, cells: int, track: tuple[int, ...], start: np.ndarray) -> "Tracks":
        """Of cells at which the contacts begin, (contacts, blades).

        Raises:
            ValueError: for two contacts in one cell.
        """
        least = cells
        for number in set(track):
            places = np.sort(np.concatenate([row for row, own in zip(start, track, strict=True) if own == number]))
            least = min(least, int(np.min(np.diff(np.append(places, places[0] + cells)))))
        if least == 0:
            raise ValueError(
                f"steps_per_revolution = {cells} puts two contacts of one track into one cell; give more, or other "
                "places"
            )
        stretch = max(size for size in range(1, least + 1) if cells % size == 0)
        return cls(cells, track, tuple(tuple(int(cell) for cell in row) for row in start), stretch)

    @property
    def number(self) -> int:
        """Number of tracks."""
        return max(self.track) + 1

    @property
    def alone(self) -> bool:
        """Whether no contact meets what another one has left within a revolution."""
        return self.stretch == self.cells

    @property
    def begin(self) -> tuple[tuple[int, ...], ...]:
        """As ``start``, in the depth as it is kept: from where its contact begins, of a track that has but one."""
        return tuple((0,) for _ in self.start) if self.alone else self.start

    def in_place(self, depth: Float[np.ndarray, "... tracks cells"]) -> Float[np.ndarray, "... tracks cells"]:
        """Depth as it is kept, over the cells of the casing."""
        if not self.alone:
            return depth
        placed = np.empty_like(depth)
        for track, row in zip(self.track, self.start, strict=True):
            placed[..., track, :] = np.roll(depth[..., track, :], row[0], axis=-1)
        return placed

    def unworn(self, profiles: Float[np.ndarray, "tracks cells"]) -> Float[np.ndarray, "cells contacts blades"]:
        """The profiles in the order in which the contacts come to them."""
        places = (np.arange(self.cells)[:, None, None] + np.array(self.start)) % self.cells
        return profiles[np.array(self.track)[:, None], places]

    def here(self, depth: Depth) -> Float[Array, "contacts blades lanes"]:
        """The depth in the cells at which the contacts begin."""
        lanes = depth.shape[1] // self.number
        rows = zip(self.track, self.begin, strict=True)
        return jnp.stack(
            [jnp.stack([depth[cell, track * lanes : (track + 1) * lanes] for cell in row]) for track, row in rows]
        )

    def longer(self, depth: Depth) -> Depth:
        """The tracks with their first cells once more at the end, so that no stretch breaks off there."""
        return jnp.concatenate([depth, depth[: self.stretch]])

    def ahead(self, longer: Depth, stretch: Any) -> Visited:
        """The depth in the cells that the contacts come to in a stretch of the given number."""
        if self.alone and self.track == tuple(range(self.number)):
            return longer
        size = (self.stretch, longer.shape[1] // self.number)
        return jnp.concatenate([jax.lax.dynamic_slice(longer, at, size) for at in self._at(stretch, size[1])], axis=1)

    def left(self, longer: Depth, stretch: Any, depth: Visited) -> Depth:
        """The tracks after a stretch that leaves these depths."""
        if self.alone and self.track == tuple(range(self.number)):
            return depth
        lanes = longer.shape[1] // self.number
        for number, at in enumerate(self._at(stretch, lanes)):
            longer = jax.lax.dynamic_update_slice(longer, depth[:, number * lanes : (number + 1) * lanes], at)
        if self.alone:
            return longer
        # What both ends say of the same cells: nothing is ever put back.
        first = jnp.maximum(longer[: self.stretch], longer[self.cells :])
        longer = jax.lax.dynamic_update_slice(longer, first, (0, 0))
        return jax.lax.dynamic_update_slice(longer, first, (self.cells, 0))

    def _at(self, stretch: Any, lanes: int) -> list[tuple[Any, int]]:
        """Row and column at which each contact of each blade begins a stretch."""
        return [
            ((cell + stretch * self.stretch) % self.cells, track * lanes)
            for track, row in zip(self.track, self.begin, strict=True)
            for cell in row
        ]
