"""The bytes of a chunk: a result as one NetCDF-4 file in memory, and back."""

import hashlib
import io

import h5py
import xarray

from lobex.results.fields import Parts
from lobex.results.netcdf import write_arrays

_DIGITS = 16


def checksum(content: bytes) -> str:
    """The first 16 hexadecimal digits of the SHA-256."""
    return hashlib.sha256(content).hexdigest()[:_DIGITS]


def to_bytes(dataset: xarray.Dataset) -> bytes:
    """A dataset of numbers as a file. The same dataset gives the same bytes: nothing in it tells the time.

    That is, unless another thread holds on to what is being written, as profilers do that look at all frames: HDF5 then
    lays out the same numbers otherwise.
    """
    buffer = io.BytesIO()
    variables, coordinates = (
        {str(name): (array.dims, array.to_numpy(), array.attrs) for name, array in arrays.items()}
        for arrays in (dataset.data_vars, dataset.coords)
    )
    write_arrays(buffer, Parts(variables, coordinates, dataset.attrs))
    return buffer.getvalue()


def from_bytes(content: bytes) -> xarray.Dataset:
    """The dataset of a file in memory; ValueError where it is none, or leads out of itself."""
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            _refuse_ways_out(file)
        with xarray.open_dataset(io.BytesIO(content), engine="h5netcdf") as stored:
            return stored.load()
    except (OSError, KeyError, RuntimeError) as error:
        raise ValueError(f"no readable NetCDF-4 file ({error})") from error


def _refuse_ways_out(group: h5py.Group) -> None:
    """HDF5 can point to other files: such a file is none of ours."""
    for name in group:
        if not isinstance(group.get(name, getlink=True), h5py.HardLink):
            raise ValueError(f"{name!r} is a link")
        item = group[name]
        if not isinstance(item, h5py.Dataset) or item.external or item.is_virtual:
            raise ValueError(f"{name!r} is no plain array")
