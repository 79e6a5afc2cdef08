"""The result of a study: a verb over further axes."""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray

from lobex.results.description import wall_time
from lobex.results.saving import in_parts, in_this_process, joined, save_dataset
from lobex.results.stored import Stored
from lobex.studies.assembly import OVER, assembled
from lobex.studies.store import Store
from lobex.studies.variation import ATTRIBUTES, check_name, in_words

if TYPE_CHECKING:
    from lobex.results.blading_wear import BladingWear
    from lobex.results.chart import Chart
    from lobex.results.limit import Limit
    from lobex.results.wear_map import WearMap


@dataclass(frozen=True, eq=False, repr=False)
class Study:
    """Labelled arrays over further axes, speed and, of a sweep, gain: what a verb found at every combination.

    ``study["multiplier"]`` is an ``xarray.DataArray`` of shape (axes…, speed, gain). Those of a store are dask arrays,
    which read what is asked of them and no more: such a study is never in memory as a whole, unless its ``values`` are
    asked for.

    Attributes:
        dataset: all arrays, and what is said of each result, as a file holds them but for complex numbers.
        source: what holds them, for messages.
        seconds: wall time of the call that made it, compiling included; NaN of one that was opened.
        compiling: the part of it in which JAX traced and compiled programs in this process.
    """

    dataset: xarray.Dataset
    source: str = "the study"
    seconds: float = float("nan")
    compiling: float = float("nan")

    @classmethod
    def open(cls, folder: str | os.PathLike[str]) -> "Study":
        """The study in a store. ValueError where that is not complete, or no store; the chunks are read when needed."""
        store = Store.open(folder)
        dataset = assembled(store.manifest["verb"], store.plan, store.manifest["speed"], store.reader())
        return cls(dataset, f"store = {str(store.folder)!r}")

    @property
    def verb(self) -> str:
        """ "sweep", "critical_gain" or "march_wear"."""
        return self.dataset.attrs["verb"]

    @property
    def over(self) -> dict[str, np.ndarray]:
        """The values of the further axes, by name."""
        return {name: self.dataset[name].to_numpy() for name in json.loads(self.dataset.attrs[OVER])}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the arrays."""
        return tuple(str(name) for name in self.dataset.data_vars if name != ATTRIBUTES)

    @property
    def speed(self) -> np.ndarray:
        """The speeds, Hz, (n,)."""
        return self.dataset["speed"].to_numpy()

    def __getitem__(self, name: str) -> xarray.DataArray:
        """An array by name, labelled."""
        if name not in {*self.names, *self.dataset.coords}:
            raise ValueError(f"name = {name!r} is no array of this study; it has {', '.join(self.names)}")
        return self.dataset[name]

    def __repr__(self) -> str:
        values = {**self.over, "speed": self.speed}
        sizes = {name: len(v) for name, v in values.items()}
        sizes |= {str(name): size for name, size in self.dataset.sizes.items() if name == "gain"}
        lines = [f"Study by {self.verb}: {' × '.join(f'{size} {name}' for name, size in sizes.items())}"]
        lines += [f"  {name:<16} {v.min():.6g} to {v.max():.6g}" for name, v in values.items()]
        lines += [f"  {'arrays':<16} {', '.join(self.names)}"]
        if self.dataset.chunks:
            lines += [f"  {'on disk':<16} {self.source}"]
        if np.isfinite(self.seconds):
            combinations = self.dataset[ATTRIBUTES].size
            lines += [f"  {'wall time':<16} {wall_time(self, combinations, 'combination')}"]
        return "\n".join(lines)

    def at(self, where: Mapping[str, float] | tuple[int, ...] | int = ()) -> "Chart | Limit | WearMap | BladingWear":
        """What the verb alone returns at one combination of the further axes.

        Args:
            where: a value of every axis by name, or their indices in order.

        Raises:
            ValueError: for an axis that is missing or unknown, a value that the axis does not have, an index outside.
        """
        from lobex.limits.intervals import trimmed
        from lobex.results.limit import Limit
        from lobex.results.register import result_of

        index = self._index(where)
        with in_this_process():
            part = self.dataset.isel(index).drop_vars(list(index)).load()
        part.attrs = json.loads(part[ATTRIBUTES].item())
        result: Any = result_of(in_parts(part.drop_vars(ATTRIBUTES)), self.source)
        return trimmed(result) if isinstance(result, Limit) else result

    def chart(self, where: Mapping[str, float] | tuple[int, ...] | int = ()) -> "Chart":
        """The chart at one combination of the axes of a sweep; see ``at``."""
        from lobex.results.chart import Chart

        chart = self.at(where)
        if not isinstance(chart, Chart):
            raise ValueError(f"a study by {self.verb} holds no charts; take study.at")
        return chart

    def to_xarray(self) -> xarray.Dataset:
        """All arrays as a labelled dataset."""
        return self.dataset.drop_vars(ATTRIBUTES)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the study to one file, all at once or not at all; its ending says which: .nc (NetCDF-4), which
        ``lobex.load`` reads back, .zarr (a new folder of Zarr 3, packed and with checksums; it takes ``lobex[zarr]``),
        .mat (MATLAB) or .csv (one row per point).

        The first two are written chunk by chunk by this process, so that a study larger than memory can be, and hold
        all that the chunks do; the others hold the arrays that ``names`` tells. Those of wear marches share no rows:
        .csv is refused.

        Raises:
            ValueError: for any other ending, and a place that cannot be written.
        """
        save_dataset(self.dataset, path, (ATTRIBUTES,))

    def _index(self, where: Mapping[str, float] | tuple[int, ...] | int) -> dict[str, int]:
        over = self.over
        if isinstance(where, Mapping):
            if set(where) != set(over):
                raise ValueError(f"where names {sorted(where)}; give a value of each of {list(over)}")
            return {name: _place(name, values, where[name]) for name, values in over.items()}
        index = where if isinstance(where, tuple) else (where,)
        shape = tuple(map(len, over.values()))
        if len(index) != len(shape) or not all(-n <= i < n for i, n in zip(index, shape, strict=True)):
            raise ValueError(f"where = {where!r} is no index of the axes {list(over)} of lengths {shape}")
        return {name: int(i) for name, i in zip(over, index, strict=True)}


def study_from(dataset: xarray.Dataset, source: str) -> Study:
    """The study that a file was made of, once every result in it has been looked at."""
    from lobex.results.register import result_of

    stored, told = Stored(dataset, source), []
    verb, axes = stored.text("verb"), stored.names(OVER)
    for name in axes:
        check_name(name, verb)
        stored.known(name, name, increasing=True)
    for number, text in enumerate(stored.array(ATTRIBUTES, *axes, kind="U").flat):
        try:
            told.append(dict(json.loads(text)))
        except (ValueError, TypeError, RecursionError):
            stored.refuse(f"has variable {ATTRIBUTES!r} that is no whole JSON text at combination {number}")
    first = dataset.isel(dict.fromkeys(axes, 0)).drop_vars([ATTRIBUTES, *axes])
    first.attrs = told[0]
    result_of(first, source)
    # The arrays are the same in all combinations, and what is said of them is much alike.
    for number, attributes in enumerate(told):
        if set(attributes) != set(told[0]):
            stored.refuse(f"has other fields in {ATTRIBUTES!r} of combination {number} than in the first")
    return Study(joined(dataset), source)


def _place(name: str, values: np.ndarray, value: float) -> int:
    nearest = int(np.argmin(np.abs(values - value)))
    if not np.isclose(values[nearest], value, rtol=1e-9, atol=0):
        raise ValueError(f"{in_words({name: value})} is no value of that axis; the nearest is {values[nearest]:.6g}")
    return nearest
