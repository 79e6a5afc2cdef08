"""A result's dataset as a file: NetCDF-4, Zarr, MATLAB or a table, by the ending of its name."""

import os
import shutil
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lobex import _checks
from lobex._optional import needed
from lobex.results.netcdf import COMPLEX, in_two

if TYPE_CHECKING:
    import xarray

ENDINGS = (".nc", ".zarr", ".mat", ".csv")


def save_dataset(dataset: "xarray.Dataset", path: str | os.PathLike[str], read_back: tuple[str, ...] = ()) -> None:
    """Write ``path`` in one step, in the format of its ending; arrays that serve for reading back go to .nc and .zarr.

    Raises:
        ValueError: for an ending other than .nc, .zarr, .mat and .csv, a place that cannot be written, a dataset that
            the format cannot hold, and a package that is not installed.
    """
    target = checked(path)
    with in_this_process():
        if target.suffix.lower() == ".nc":
            in_one_step(target, lambda file: write_netcdf(in_parts(dataset), file))
        elif target.suffix.lower() == ".zarr":
            codecs = needed("zarr", f"path = {str(path)!r}", "zarr").codecs
            # Packed as by default, and then a checksum.
            pipeline = {"compressors": (codecs.ZstdCodec(), codecs.Crc32cCodec())}
            in_one_step(target, lambda folder: _write_zarr(dataset, folder, pipeline))
        elif target.suffix.lower() == ".mat":
            from lobex.results.matlab import write_matlab

            in_one_step(target, lambda file: write_matlab(dataset.drop_vars(read_back), file))
        else:
            from lobex.results.table import write_table

            in_one_step(target, lambda file: write_table(in_parts(dataset.drop_vars(read_back)), file))


def write_netcdf(dataset: "xarray.Dataset", file: Path, **how: Any) -> None:
    """Write a NetCDF-4 file, which takes texts at once and other arrays as they are computed."""
    with in_this_process():
        _with_texts(dataset, str).to_netcdf(file, engine="h5netcdf", format="NETCDF4", **how)


def _write_zarr(dataset: "xarray.Dataset", folder: Path, pipeline: dict[str, Any]) -> None:
    whole = _with_texts(dataset, object)
    whole.to_zarr(folder, zarr_format=3, consolidated=False, encoding=dict.fromkeys(whole.variables, pipeline))


def _with_texts(dataset: "xarray.Dataset", kind: type) -> "xarray.Dataset":
    """The dataset with its texts at hand, as a format takes them: of one length, or each of its own."""
    texts = {name: array for name, array in dataset.variables.items() if array.dtype.kind in "OU"}
    return dataset.assign({name: array.load().astype(kind) for name, array in texts.items()})


def in_this_process() -> AbstractContextManager[object]:
    """Within, what is lazy is computed here, whatever cluster there is, or was: xarray and dask would ask for that."""
    dask = sys.modules.get("dask.config")
    return nullcontext() if dask is None else dask.set(scheduler="synchronous")


def checked(path: str | os.PathLike[str]) -> Path:
    """Require a place that can be written, of a known ending."""
    target = _checks.writable("path", path)
    if target.suffix.lower() not in ENDINGS:
        wrong = f"ends in {target.suffix!r}" if target.suffix else "has no ending"
        raise ValueError(f"path = {str(path)!r} {wrong}; give .nc (which lobex.load reads back), .zarr, .mat or .csv")
    return target


def in_one_step(target: Path, write: Callable[[Path], object]) -> None:
    """Have a file or folder beside ``target`` written, which then takes its place: all at once or not at all."""
    partial = target.with_name(f".{target.name}.{os.getpid()}.partial")
    try:
        write(partial)
        os.replace(partial, target)
    # HDF5 reports a full disk in either way.
    except (OSError, RuntimeError) as error:
        raise ValueError(f"path = {str(target)!r} cannot be written ({error}); choose another place") from error
    # What a format cannot hold.
    except ValueError as error:
        raise ValueError(f"path = {str(target)!r}: {error}") from error
    finally:
        if partial.is_dir():
            shutil.rmtree(partial, ignore_errors=True)
        with suppress(OSError):
            partial.unlink(missing_ok=True)


def in_parts(dataset: "xarray.Dataset") -> "xarray.Dataset":
    """Complex arrays in two parts."""
    import xarray

    arrays: dict[str, xarray.DataArray] = {}
    for name, whole in dataset.data_vars.items():
        if np.issubdtype(whole.dtype, np.complexfloating):
            apart = in_two(whole, str(name), whole.attrs)
            arrays |= {own: part.assign_attrs(said) for own, (part, said) in apart.items()}
        else:
            arrays[str(name)] = whole
    return xarray.Dataset(arrays, dataset.coords, dataset.attrs)


def joined(dataset: "xarray.Dataset") -> "xarray.Dataset":
    """Complex arrays in place of what ``in_parts`` made of them."""
    import xarray

    (real, words), (imaginary, _) = COMPLEX.items()
    arrays: dict[str, xarray.DataArray] = {}
    for name, part in dataset.data_vars.items():
        own = str(name).removesuffix(real)
        if own != name:
            attributes = {**part.attrs, "long_name": part.attrs["long_name"].removesuffix(words)}
            arrays[own] = (part + 1j * dataset[f"{own}{imaginary}"]).assign_attrs(attributes)
        elif not own.endswith(imaginary):
            arrays[own] = part
    return xarray.Dataset(arrays, dataset.coords, dataset.attrs)
