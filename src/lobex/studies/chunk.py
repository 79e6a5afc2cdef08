"""One chunk's work, as it is sent to whoever does it, and what comes back."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray

from lobex.studies.store import Place
from lobex.studies.task import Result
from lobex.studies.warned import Warned, heard


@dataclass(frozen=True)
class Chunk:
    """What a chunk is made of: arrays, numbers, and functions that can be named.

    Attributes:
        number: of the chunk.
        where: the combination of the further axes in words, for errors.
        compute: the verb at a model and some of the speeds.
        model: the model at that combination.
        speed: the chunk's speeds.
        place: where it goes to; None for back to whoever asked.
    """

    number: int
    where: str
    compute: Callable[[Any, np.ndarray], Result]
    model: Any
    speed: np.ndarray
    place: Place | None


@dataclass(frozen=True)
class Computed:
    """A chunk's dataset, empty where it has another place, and what was warned of."""

    dataset: xarray.Dataset
    warned: list[Warned]


def compute(chunk: Chunk) -> Computed:
    """Compute a chunk, and write it where it has a place.

    What depends on the hour is left out of it, so that the same chunk is the same file.

    Raises:
        ValueError: what the verb refuses, and a place that cannot be written.
    """
    with heard() as warned:
        try:
            result: Any = chunk.compute(chunk.model, chunk.speed)
        except ValueError as error:
            raise ValueError(f"{error}{f'; at {chunk.where}' if chunk.where else ''}") from error
        dataset = replace(result, seconds=float("nan"), compiling=float("nan")).to_xarray()
    if chunk.place is None:
        return Computed(dataset, warned)
    chunk.place.write(chunk.number, dataset)
    return Computed(xarray.Dataset(), warned)
