"""What a study computes: a verb, told for any chunk of it."""

import os
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lobex.results.blading_wear import BladingWear
from lobex.results.chart import Chart
from lobex.results.limit import Limit
from lobex.results.wear_map import WearMap
from lobex.studies.variation import Variation

Result = Chart | Limit | WearMap | BladingWear
Path = str | os.PathLike[str]
Over = Mapping[str, Any]


if TYPE_CHECKING:
    from distributed import Client

    AnyExecutor = Executor | Client
else:
    # Dask's clusters are not everybody's.
    AnyExecutor = Any


@dataclass(frozen=True)
class Task:
    """A verb over the combinations of further axes and over speeds.

    Attributes:
        verb: its name.
        variation: the model at every combination.
        speed: the speeds, one per lane, (n,) or (n, revolutions).
        settings: the other arguments.
        compute: the verb of a model, some of the speeds and the settings, by name; one that can be sent.
        implausible: what is implausible about a model, all speeds, and the other arguments, in words.
        points: points per lane, for the progress bar.
        lanes: lanes that make up a chunk of a few seconds.
        bytes: memory that the results of one lane take.
    """

    verb: str
    variation: Variation
    speed: np.ndarray
    settings: dict[str, Any]
    compute: Callable[..., Result]
    implausible: Callable[[Any], list[str]]
    points: int
    lanes: int
    bytes: int
