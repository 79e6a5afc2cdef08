"""The chunks of a computed study as datasets, from memory, from a store, or from one file."""

import json
from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable

import numpy as np
import xarray

from lobex.studies.plan import Plan
from lobex.studies.slabs import plain
from lobex.studies.store import Store
from lobex.studies.variation import ATTRIBUTES

# Chunks of a store that are kept for the next question.
_KEPT = 4


@runtime_checkable
class Blocks(Protocol):
    """Chunks by number, and in messages what holds them."""

    plan: Plan
    source: str

    def chunk(self, number: int) -> xarray.Dataset:
        """The result of a chunk, as its file holds it."""
        ...


class InMemory:
    """Chunks that were computed and kept."""

    source = "the study"

    def __init__(self, plan: Plan, datasets: Mapping[int, xarray.Dataset]) -> None:
        self.plan, self._datasets = plan, datasets

    def chunk(self, number: int) -> xarray.Dataset:
        """The result of a chunk."""
        return self._datasets[number]


class InStore:
    """Chunks that are read, and compared with their checksums, when they are asked for."""

    def __init__(self, store: Store) -> None:
        self.plan, self.store, self.source = store.plan, store, f"store = {str(store.folder)!r}"
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

    def __init__(self, plan: Plan, dataset: xarray.Dataset, source: str) -> None:
        self.plan, self.source, self._dataset = plan, source, dataset

    def chunk(self, number: int) -> xarray.Dataset:
        """The result of a combination."""
        part = self._part(self._dataset, number).drop_vars([ATTRIBUTES, *self.plan.axes])
        part.attrs = self.attributes(number)
        return plain(part)

    def attributes(self, number: int) -> dict[str, Any]:
        """The attributes of the result of a combination."""
        try:
            attributes = json.loads(str(self._part(self._dataset[ATTRIBUTES], number).item()))
        except (json.JSONDecodeError, RecursionError):
            attributes = None
        if not isinstance(attributes, dict):
            raise ValueError(
                f"{self.source} has variable {ATTRIBUTES!r} that is no whole JSON text at combination {number}; "
                "it is damaged or was changed: compute it again"
            )
        return attributes

    def _part(self, whole: Any, number: int) -> Any:
        index = np.unravel_index(number, [len(v) for v in self.plan.axes.values()])
        return whole.isel({name: int(i) for name, i in zip(self.plan.axes, index, strict=True)})
