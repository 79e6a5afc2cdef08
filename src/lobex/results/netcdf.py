"""Arrays with names and dimensions as a NetCDF-4 file, without xarray: importing that takes longer than a chart."""

import io
from pathlib import Path
from typing import Any

import h5netcdf
import h5py
import numpy as np

from lobex.results.fields import Parts

COMPLEX = {"_real": ", real part", "_imag": ", imaginary part"}
"""What the names and long names of a complex array's parts end in."""


def write_arrays(target: Path | io.BytesIO, parts: Parts) -> None:
    """Write a file of what a dataset is made of; complex arrays in two parts, and texts each of its own length."""
    variables = {**parts.variables, **parts.coordinates}
    arrays = [one for name, about in variables.items() for one in _apart(name, *about)]
    with h5netcdf.File(str(target) if isinstance(target, Path) else target, "w") as file:
        file.dimensions = {
            dim: size for _, dims, values, _ in arrays for dim, size in zip(dims, values.shape, strict=True)
        }
        for name, dims, values, notes in arrays:
            kind = h5py.string_dtype() if values.dtype.kind in "OU" else values.dtype
            made = file.create_variable(name, dims, kind, data=values.astype(kind, copy=False))
            made.attrs.update(notes)
        file.attrs.update(parts.attributes)
        # By this attribute a file names coordinates that are no dimensions.
        if others := [name for name in parts.coordinates if name not in file.dimensions]:
            file.attrs["coordinates"] = " ".join(others)


def in_two(values: Any, name: str, notes: dict[str, Any]) -> dict[str, tuple[Any, dict[str, Any]]]:
    """A complex array's real and imaginary part, with what is said of each, by name: the type is outside the NetCDF-4
    standard, and MATLAB cannot read it.
    """
    about = notes.get("long_name", name)
    return {
        f"{name}{tail}": (part, {**notes, "long_name": f"{about}{words}"})
        for part, (tail, words) in zip((values.real, values.imag), COMPLEX.items(), strict=True)
    }


def _apart(
    name: str, dims: tuple[str, ...], values: np.ndarray, notes: dict[str, Any]
) -> list[tuple[str, tuple[str, ...], np.ndarray, dict[str, Any]]]:
    """An array, or its two parts."""
    if values.dtype.kind != "c":
        return [(name, dims, values, notes)]
    return [(own, dims, part, said) for own, (part, said) in in_two(values, name, notes).items()]
