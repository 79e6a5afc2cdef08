"""A dataset as a table in a text file: one row per point, one column per array."""

import csv
from pathlib import Path

import numpy as np
import xarray

# Dimensions that number the parts of a quantity, which become columns; "1", "2", … where no names are given.
_PARTS: dict[str, tuple[str, ...] | None] = {
    "interval": None,
    "edge": ("low", "high"),
    "output": None,
    "component": None,
    "mode": None,
    "direction": None,
    "tooth": None,
    "height": None,
}


def write_table(dataset: xarray.Dataset, path: Path) -> None:
    """Comma-separated values with a head, in UTF-8; numbers to the last digit."""
    columns = columns_of(dataset)
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))


def columns_of(dataset: xarray.Dataset) -> dict[str, np.ndarray]:
    """The columns by name, such as "gain_N/m", each (rows,): the last dimension runs fastest.

    Raises:
        ValueError: where no array lies over all dimensions, so that there is no common row.
    """
    dataset = _by_vertex(dataset)
    variables = {**dataset.coords, **dataset.data_vars}
    rows = {name: tuple(d for d in v.dims if not _is_part(dataset, d)) for name, v in variables.items()}
    longest = max(rows.values(), key=len)
    for name, dims in rows.items():
        if not set(dims) <= set(longest):
            widest = next(n for n, d in rows.items() if d == longest)
            raise ValueError(
                f"{widest} over ({', '.join(map(str, longest))}) and {name} over ({', '.join(map(str, dims))}) "
                "have no common rows, and a .csv file holds one table; give .nc or .mat"
            )
    shape = tuple(dataset.sizes[d] for d in longest)
    columns: dict[str, np.ndarray] = {}
    # What rows lie over comes first: by number where it has no values, as lanes and revolutions.
    numbered = longest if len(longest) > 1 else ()
    axes = {d: variables.get(d, xarray.DataArray(np.arange(dataset.sizes[d]), dims=(d,))) for d in numbered}
    for name, variable in {**axes, **variables}.items():
        unit = variable.attrs.get("units", "1")
        for tail, part in _parts(dataset, variable):
            columns["_".join([str(name), *tail, *([] if unit == "1" else [unit])])] = _spread(part, longest, shape)
    return columns


def _by_vertex(dataset: xarray.Dataset) -> xarray.Dataset:
    """What belongs to the curves of a boundary, told of each of their vertices."""
    if "curve_number" not in dataset.dims:
        return dataset
    return dataset.assign(closed=dataset["closed"].isel(curve_number=dataset["curve"]))


def _is_part(dataset: xarray.Dataset, dim: object) -> bool:
    return dim in _PARTS and dim not in dataset.coords


def _parts(dataset: xarray.Dataset, variable: xarray.DataArray) -> list[tuple[list[str], xarray.DataArray]]:
    """A variable in as many parts as its own dimensions have places, with what tells each."""
    found: list[tuple[list[str], xarray.DataArray]] = [([], _in_words(variable))]
    for dim in (d for d in variable.dims if _is_part(dataset, d)):
        size = dataset.sizes[dim]
        names = _PARTS[str(dim)] or [str(i + 1) for i in range(size)]
        found = [([*tail, names[i]], part.isel({dim: i})) for tail, part in found for i in range(size)]
    return found


def _in_words(variable: xarray.DataArray) -> xarray.DataArray:
    """Flags as what they mean."""
    if "flag_meanings" not in variable.attrs:
        return variable
    codes = np.asarray(variable.attrs["flag_values"]).tolist()
    words = [word.replace("_", " ") for word in variable.attrs["flag_meanings"].split()]
    meanings = dict(zip(codes, words, strict=True))
    return xarray.apply_ufunc(np.vectorize(meanings.__getitem__, otypes=[object]), variable)


def _spread(variable: xarray.DataArray, dims: tuple[object, ...], shape: tuple[int, ...]) -> np.ndarray:
    """The values at every row, in order."""
    own = [d for d in dims if d in variable.dims]
    values = variable.transpose(*own).to_numpy()
    size = [values.shape[own.index(d)] if d in own else 1 for d in dims]
    return np.broadcast_to(values.reshape(size), shape).ravel()
