"""An array of a study that reads the chunks that it is asked for, and no others."""

from typing import Any

import numpy as np
import xarray
from jaxtyping import Shaped
from xarray.backends import BackendArray
from xarray.core import indexing

from lobex.results.saving import PARTS
from lobex.studies.blocks import Blocks
from lobex.studies.variation import shape_of


def values_of(dataset: xarray.Dataset, name: str) -> np.ndarray:
    """An array of a chunk, complex where that holds its parts."""
    if name in dataset:
        return dataset[name].to_numpy()
    real, imaginary = (dataset[f"{name}{tail}"].to_numpy() for tail in PARTS)
    return real + 1j * imaginary


class LazyArray(BackendArray):
    """The array ``name`` of all chunks: the further axes first, then those of a result."""

    def __init__(self, blocks: Blocks, name: str, dims: tuple[str, ...], along: str, shape: tuple[int, ...]) -> None:
        self.blocks, self.name, self.dims, self.along = blocks, name, dims, along
        self.shape = (*shape_of(blocks.plan.axes), *shape)
        self.dtype = values_of(blocks.chunk(0), name).dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Shaped[np.ndarray, "..."]:
        """What xarray asks for: every axis by a number, a slice, or a list of numbers."""
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER, self._read)

    def _read(self, key: tuple[Any, ...]) -> np.ndarray:
        lines = [np.atleast_1d(np.arange(size)[k]) for size, k in zip(self.shape, key, strict=True)]
        values = np.empty([len(line) for line in lines], dtype=self.dtype)
        further = len(self.blocks.plan.axes)
        for place in np.ndindex(*values.shape[:further]):
            index = [int(line[i]) for line, i in zip(lines[:further], place, strict=True)]
            combination = int(np.ravel_multi_index(index, self.shape[:further])) if further else 0
            self._fill(values[place], combination, lines[further:])
        scalar = [isinstance(k, int | np.integer) for k in key]
        return values.reshape([n for n, single in zip(values.shape, scalar, strict=True) if not single])

    def _fill(self, target: np.ndarray, combination: int, lines: list[np.ndarray]) -> None:
        plan = self.blocks.plan
        first = combination * plan.blocks
        if self.along not in self.dims:
            target[...] = values_of(self.blocks.chunk(first), self.name)[np.ix_(*lines)]
            return
        axis = self.dims.index(self.along)
        block = lines[axis] // plan.lanes_per_chunk
        for number in np.unique(block):
            values = values_of(self.blocks.chunk(first + int(number)), self.name)
            own = np.flatnonzero(block == number)
            chosen = [*lines]
            chosen[axis] = lines[axis][own] - int(number) * plan.lanes_per_chunk
            target[(slice(None),) * axis + (own,)] = values[np.ix_(*chosen)]
