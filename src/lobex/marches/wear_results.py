"""What a wear march records of every revolution, and the result that it becomes."""

from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from lobex.marches.arrangement import Arrangement
from lobex.marches.decimation import lag_of, usable_orders
from lobex.marches.rub_revolution import Revolution
from lobex.marches.tracks import Tracks
from lobex.results.blading_wear import BladingWear
from lobex.results.description import describe
from lobex.results.wear_map import WearMap

_TOUCHING = ("contact", "force", "removed", "input_energy", "removal_energy", "friction_energy", "casing_amplitude")


class Record:
    """Of all lanes, first: what ``revolve`` leaves of every revolution.

    Attributes:
        history: speed, Hz, (lanes, revolutions).
        touching: by name, (lanes, contacts, blades, revolutions).
        amplitude: of all that is seen, (lanes, seen, blades, revolutions).
        damping, start, stored: energies of each body, (lanes, blades, revolutions).
        seen: (lanes, seen, blades, samples).
        depth: (lanes, tracks, cells).
    """

    def __init__(self, history: np.ndarray, shape: tuple[int, int, int, int], bodies: int, sizes: tuple[int, int, int]):
        lanes, revolutions = history.shape
        contacts, seen, blades, tracks = shape
        samples, cells, _ = sizes
        self.history, self.samples = history, samples
        self.touching = {name: np.zeros((lanes, contacts, blades, revolutions)) for name in _TOUCHING}
        self.amplitude = np.empty((lanes, seen, blades, revolutions))
        every = [[np.empty((lanes, blades if n == 0 else 1, revolutions)) for n in range(bodies)] for _ in range(3)]
        self.damping, self.start, self.stored = every
        self.seen = np.empty((lanes, seen, blades, revolutions * samples))
        self.depth = np.empty((lanes, tracks, cells))

    @classmethod
    def empty(cls, arranged: Arrangement, history: np.ndarray, cells: int, factor: int) -> "Record":
        """For a march."""
        contacts, blades = arranged.place.shape
        shape = contacts, arranged.blades.blade.directions, blades, max(arranged.track) + 1
        return cls(history, shape, len(arranged.structures), (cells // factor, cells, factor))

    def put(self, block: Int[np.ndarray, " lanes"], turn: int, result: Revolution) -> None:
        """What one revolution of some lanes left."""
        totals = result.totals
        for name, whole in self.touching.items():
            values = getattr(totals, name)
            if values is not None:
                whole[block, ..., turn] = _lanes_first(values)
        self.amplitude[block, ..., turn] = _lanes_first(totals.amplitude)
        parts = (
            (self.damping, totals.damping_energy),
            (self.start, result.start_energy),
            (self.stored, result.stored_energy),
        )
        for wholes, values in parts:
            for whole, value in zip(wholes, values, strict=True):
                whole[block, ..., turn] = _lanes_first(value)
        samples = np.moveaxis(np.asarray(result.seen), 0, -1)
        self.seen[block, ..., turn * self.samples : (turn + 1) * self.samples] = np.moveaxis(samples, -2, 0)

    def lose(self, radius: float) -> Bool[np.ndarray, " lanes"]:
        """Lanes that are not finite, or whose tip has left the casing by more than its radius; they become NaN."""
        whole = [*self.touching.values(), self.amplitude, *self.damping, *self.start, *self.stored]
        totals = np.sum([values.reshape(len(values), -1).sum(axis=1) for values in whole], axis=0)
        contacts = self.touching["contact"].shape[1]
        moved = self.amplitude[:, :contacts].reshape(len(self.amplitude), -1).max(axis=1)
        failed = ~np.isfinite(totals) | ~(moved < radius)
        if failed.any():
            for values in (*whole, self.seen, self.depth):
                values[failed] = np.nan
        return failed

    @property
    def speeding(self) -> Float[np.ndarray, "lanes blades revolutions"]:
        """What the blades gained between revolutions, as their modes became those of another speed, J."""
        return _gained(self.start[0], self.stored[0])

    @property
    def casing_speeding(self) -> Float[np.ndarray, "lanes revolutions"]:
        """The same of a casing."""
        return sum((_gained(a, b)[:, 0] for a, b in zip(self.start[1:], self.stored[1:], strict=True)), self._none)

    @property
    def casing_damping(self) -> Float[np.ndarray, "lanes revolutions"]:
        """Lost in the casing's damping, J."""
        return sum((part[:, 0] for part in self.damping[1:]), self._none)

    @property
    def casing_stored(self) -> Float[np.ndarray, "lanes revolutions"]:
        """Kinetic and strain energy of the casing, J."""
        return sum((part[:, 0] for part in self.stored[1:]), self._none)

    @property
    def _none(self) -> np.ndarray:
        return np.zeros(self.history.shape)


def result_of(
    record: Record,
    arranged: Arrangement,
    profiles: Float[np.ndarray, "tracks cells"],
    places: Tracks,
    factor: int,
    described: dict[str, Any],
    spent: Any,
) -> WearMap | BladingWear:
    """A ``WearMap`` of one contact, a ``BladingWear`` of several."""
    cells, first = places.cells, arranged.casings[0]
    contacts, blades = arranged.place.shape
    cell = 2 * np.pi * float(first.radius) / cells
    modes = arranged.blades.at(record.history.flat[0])
    common: dict[str, Any] = {
        "speed": record.history[:, 0].copy(),
        "speed_history": record.history,
        "angle": 2 * np.pi * np.arange(cells) / cells,
        "samples_per_revolution": cells // factor,
        "lag": lag_of(factor),
        "usable_orders": usable_orders(cells, factor),
        "natural_frequency": np.asarray(modes.frequency),
        "nodal_diameters": first.nodal_diameters,
        "radius": float(first.radius),
        "axial_width": float(first.axial_width),
        "model": {name: describe(value) for name, value in described.items()},
        "seconds": spent.seconds,
        "compiling": spent.compiling,
        "failed": int(np.isnan(record.amplitude[:, 0, 0, 0]).sum()),
    }
    removed = record.touching.pop("removed") * cell
    if arranged.single:
        touching = {name: values[:, 0, 0] for name, values in record.touching.items()}
        return WearMap(
            unworn=profiles[0],
            depth=record.depth[:, 0],
            wear=removed[:, 0, 0],
            displacement=record.seen[:, 0, 0],
            amplitude=record.amplitude[:, 0, 0],
            watched=record.seen[:, 1:, 0],
            watched_amplitude=record.amplitude[:, 1:, 0],
            damping_energy=record.damping[0][:, 0] + record.casing_damping,
            stored_energy=record.stored[0][:, 0] + record.casing_stored,
            speeding_energy=record.speeding[:, 0] + record.casing_speeding,
            **touching,
            **common,
        )
    lanes, revolutions = record.history.shape

    def flat(values: np.ndarray) -> np.ndarray:
        """Contacts in one axis, those of each blade together."""
        return np.moveaxis(values, 2, 1).reshape(lanes, -1, values.shape[-1])

    wear = np.zeros((lanes, places.number, revolutions))
    for contact, track in enumerate(places.track):
        wear[:, track] += removed[:, contact].sum(axis=1)
    return BladingWear(
        blade=np.repeat(np.arange(blades), contacts),
        track=np.tile(np.array(places.track), blades),
        place=2 * np.pi * (np.array(places.start).T.ravel() / cells),
        unworn=profiles,
        depth=record.depth,
        wear=wear,
        displacement=flat(record.seen[:, :contacts]),
        amplitude=flat(record.amplitude[:, :contacts]),
        watched=np.moveaxis(record.seen[:, contacts:], 2, 1),
        watched_amplitude=np.moveaxis(record.amplitude[:, contacts:], 2, 1),
        **{name: flat(values) for name, values in record.touching.items()},
        damping_energy=record.damping[0],
        stored_energy=record.stored[0],
        speeding_energy=record.speeding,
        casing_damping_energy=record.casing_damping,
        casing_stored_energy=record.casing_stored,
        casing_speeding_energy=record.casing_speeding,
        **common,
    )


def _gained(start: np.ndarray, stored: np.ndarray) -> np.ndarray:
    """Between the end of each revolution and the start of the next, counted in the latter."""
    gained = np.zeros_like(stored)
    gained[..., 1:] = start[..., 1:] - stored[..., :-1]
    return gained


def _lanes_first(values: Any) -> np.ndarray:
    return np.moveaxis(np.asarray(values), -1, 0)
