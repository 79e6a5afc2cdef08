"""The result of a study: a verb over further axes."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray
from xarray.core import indexing

from lobex.results.description import wall_time
from lobex.results.saving import PARTS
from lobex.studies.blocks import Blocks, InStore
from lobex.studies.lazy import LazyArray
from lobex.studies.store import Store
from lobex.studies.variation import in_words, shape_of

if TYPE_CHECKING:
    from lobex.results.blading_wear import BladingWear
    from lobex.results.chart import Chart
    from lobex.results.limit import Limit
    from lobex.results.wear_map import WearMap

FORM = "lobex study 1"
_COUNTS = ("failed",)


@dataclass(frozen=True, eq=False, repr=False)
class Study:
    """Labelled arrays over further axes, speed and, of a sweep, gain: what a verb found at every combination.

    ``study["multiplier"]`` is an ``xarray.DataArray`` of shape (axes…, speed, gain) that reads what is asked of it
    and no more: a study in a store is never in memory as a whole, unless its ``values`` are asked for.

    Attributes:
        verb: "sweep", "critical_gain" or "march_wear".
        blocks: the chunks, in memory, in a store or in a file.
        seconds: wall time of the call that made it, compiling included; NaN of one that was opened.
        compiling: the part of it in which JAX traced and compiled programs in this process.
    """

    verb: str
    blocks: Blocks
    seconds: float = float("nan")
    compiling: float = float("nan")

    @classmethod
    def open(cls, folder: str | os.PathLike[str]) -> "Study":
        """The study in a store. ValueError where that is not complete, or no store; the chunks are read when needed."""
        store = Store.open(folder)
        return cls(str(store.manifest["verb"]), InStore(store))

    @property
    def over(self) -> dict[str, np.ndarray]:
        """The values of the further axes, by name."""
        return self.blocks.plan.axes

    @property
    def along(self) -> str:
        """The axis of the speeds: "speed", or "lane" of a wear march, whose speeds may change."""
        return "lane" if "lane" in self._first.sizes else "speed"

    @property
    def sizes(self) -> dict[str, int]:
        """The length of every axis, by name."""
        own = {str(name): size for name, size in self._first.sizes.items()}
        further = dict(zip(self.over, shape_of(self.over), strict=True))
        return {**further, **own, self.along: self.blocks.plan.lanes}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the arrays."""
        return tuple(str(name) for name in self.to_xarray().data_vars)

    @property
    def speed(self) -> np.ndarray:
        """The speeds, Hz, (n,)."""
        return self.to_xarray()["speed"].to_numpy()

    def __getitem__(self, name: str) -> xarray.DataArray:
        """An array by name, labelled."""
        whole = self.to_xarray()
        if name not in whole:
            raise ValueError(f"name = {name!r} is no array of this study; it has {', '.join(self.names)}")
        return whole[name]

    def __repr__(self) -> str:
        sizes = {**dict(zip(self.over, shape_of(self.over), strict=True)), "speed": self.blocks.plan.lanes}
        if "gain" in self._first.sizes:
            sizes["gain"] = self._first.sizes["gain"]
        values = {**self.over, "speed": self.speed}
        lines = [f"Study by {self.verb}: {' × '.join(f'{size} {name}' for name, size in sizes.items())}"]
        lines += [f"  {name:<16} {v.min():.6g} to {v.max():.6g}" for name, v in values.items()]
        lines += [f"  {'arrays':<16} {', '.join(self.names)}"]
        if isinstance(self.blocks, InStore):
            lines += [f"  {'store':<16} {self.blocks.store.folder}, {self.blocks.plan.chunks} chunks"]
        if np.isfinite(self.seconds):
            lines += [f"  {'wall time':<16} {wall_time(self, self.blocks.plan.chunks, 'chunk')}"]
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

        dataset = self.whole(self._combination(where))
        result: Any = result_of(dataset, self.blocks.source)
        return trimmed(result) if isinstance(result, Limit) else result

    def chart(self, where: Mapping[str, float] | tuple[int, ...] | int = ()) -> "Chart":
        """The chart at one combination of the axes of a sweep; see ``at``."""
        from lobex.results.chart import Chart

        chart = self.at(where)
        if not isinstance(chart, Chart):
            raise ValueError(f"a study by {self.verb} holds no charts; take study.at")
        return chart

    def whole(self, combination: int) -> xarray.Dataset:
        """The chunks of a combination as one dataset, its attributes those of the result."""
        plan = self.blocks.plan
        parts = [self.blocks.chunk(combination * plan.blocks + block) for block in range(plan.blocks)]
        attributes = {k: v for k, v in parts[0].attrs.items() if k not in ("study", "chunk")}
        attributes |= {n: np.sum([part.attrs[n] for part in parts]) for n in _COUNTS if n in attributes}
        if len(parts) > 1:
            whole = xarray.concat(
                parts,
                dim=self.along,
                data_vars="minimal",
                coords="minimal",
                compat="override",
                join="override",
                combine_attrs="override",
            )
        else:
            whole = parts[0].copy()
        whole.attrs = attributes
        return whole

    def to_xarray(self) -> xarray.Dataset:
        """All arrays as a labelled dataset that reads what is asked of it."""
        return self._labelled

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the study to one file, all at once or not at all; its ending says which: .nc (NetCDF-4), which
        ``lobex.load`` reads back, .mat (MATLAB) or .csv (one row per point).

        A .nc file is written chunk by chunk, so that a study larger than memory can be, and holds all that the chunks
        do; the others hold the arrays that ``names`` tells. Those of wear marches share no rows: .csv is refused.

        Raises:
            ValueError: for any other ending, and a place that cannot be written.
        """
        from lobex.studies.export import write_study

        write_study(self, path)

    @cached_property
    def _first(self) -> xarray.Dataset:
        return self.blocks.chunk(0)

    @cached_property
    def _labelled(self) -> xarray.Dataset:
        further = tuple(self.over)
        sizes = self.sizes
        arrays: dict[str, Any] = {}
        (real, real_part), (imaginary, _) = PARTS.items()
        for name, variable in self._first.data_vars.items():
            own, about = str(name).removesuffix(real), variable.attrs["long_name"].removesuffix(real_part)
            if own.endswith(imaginary):
                continue
            dims = tuple(map(str, variable.dims))
            lazy = LazyArray(self.blocks, own, dims, self.along, tuple(sizes[d] for d in dims))
            attributes = {**variable.attrs, "long_name": about}
            arrays[own] = ((*further, *dims), indexing.LazilyIndexedArray(lazy), attributes)
        blocks = [self.blocks.chunk(i)["speed"].to_numpy() for i in range(self.blocks.plan.blocks)]
        first = {str(name): coordinate for name, coordinate in self._first.coords.items()}
        coordinates: dict[str, Any] = {name: (name, values) for name, values in self.over.items()}
        coordinates |= {name: (c.dims, c.to_numpy(), c.attrs) for name, c in first.items() if name != "speed"}
        coordinates["speed"] = (self.along, np.concatenate(blocks), first["speed"].attrs)
        return xarray.Dataset(arrays, coordinates, {"format": FORM, "verb": self.verb})

    def _combination(self, where: Mapping[str, float] | tuple[int, ...] | int) -> int:
        shape = shape_of(self.over)
        if isinstance(where, Mapping):
            if set(where) != set(self.over):
                raise ValueError(f"where names {sorted(where)}; give a value of each of {list(self.over)}")
            index = tuple(_place(name, values, where[name]) for name, values in self.over.items())
        else:
            index = where if isinstance(where, tuple) else (where,)
            if len(index) != len(shape) or not all(-n <= i < n for i, n in zip(index, shape, strict=True)):
                raise ValueError(f"where = {where!r} is no index of the axes {list(self.over)} of lengths {shape}")
            index = tuple(int(i) % n for i, n in zip(index, shape, strict=True))
        return int(np.ravel_multi_index(index, shape)) if shape else 0


def _place(name: str, values: np.ndarray, value: float) -> int:
    nearest = int(np.argmin(np.abs(values - value)))
    if not np.isclose(values[nearest], value, rtol=1e-9, atol=0):
        raise ValueError(f"{in_words({name: value})} is no value of that axis; the nearest is {values[nearest]:.6g}")
    return nearest
