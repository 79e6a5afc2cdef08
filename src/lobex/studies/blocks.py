"""The chunks of a computed study as datasets, from memory, from a store, or from one file."""

import json
from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
import xarray

from lobex.studies.plan import Plan
from lobex.studies.slabs import plain
from lobex.studies.store import Store

# Chunks of a store that are kept for the next question.
_KEPT = 4
ATTRIBUTES = "attributes"


class Blocks(Protocol):
    """Chunks by number."""

    plan: Plan

    def chunk(self, number: int) -> xarray.Dataset:
        """The result of a chunk, as its file holds it."""
        ...


class InMemory:
    """Chunks that were computed and kept."""

    def __init__(self, plan: Plan, datasets: Mapping[int, xarray.Dataset]) -> None:
        self.plan, self._datasets = plan, datasets

    def chunk(self, number: int) -> xarray.Dataset:
        """The result of a chunk."""
        return self._datasets[number]


class InStore:
    """Chunks that are read, and compared with their checksums, when they are asked for."""

    def __init__(self, store: Store) -> None:
        self.plan, self.store = store.plan, store
        self._names = store.present()
        missing = self.plan.chunks - len(self._names)
        if missing:
            raise ValueError(
                f"store = {str(store.folder)!r} holds {len(self._names)} of {self.plan.chunks} chunks; run the same "
                "study again to complete it"
            )
        self._kept: dict[int, xarray.Dataset] = {}

    def chunk(self, number: int) -> xarray.Dataset:
        """The result of a chunk."""
        if number not in self._kept:
            dataset = plain(self.store.read(number, self._names[number]))
            while len(self._kept) >= _KEPT:
                self._kept.pop(next(iter(self._kept)))
            self._kept[number] = dataset
        return self._kept[number]


class InFile:
    """One chunk per combination, cut from the dataset of a saved study."""

    def __init__(self, plan: Plan, dataset: xarray.Dataset) -> None:
        self.plan, self._dataset = plan, dataset

    def chunk(self, number: int) -> xarray.Dataset:
        """The result of a combination."""
        index = np.unravel_index(number, [len(v) for v in self.plan.axes.values()])
        part = self._dataset.isel({name: int(i) for name, i in zip(self.plan.axes, index, strict=True)})
        attributes: dict[str, Any] = json.loads(str(part[ATTRIBUTES].item()))
        part = part.drop_vars([ATTRIBUTES, *self.plan.axes])
        part.attrs = attributes
        return plain(part)
