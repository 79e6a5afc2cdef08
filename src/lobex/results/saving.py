"""A result's dataset as a file: NetCDF-4, MATLAB or a table, by the ending of its name."""

import os
import sys
from collections.abc import Callable
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import Any

import numpy as np
import xarray

from lobex import _checks

ENDINGS = (".nc", ".mat", ".csv")
PARTS = {"_real": ", real part", "_imag": ", imaginary part"}
"""What the names and long names of a complex array's parts end in."""


def save_dataset(dataset: xarray.Dataset, path: str | os.PathLike[str]) -> None:
    """Write ``path`` in one step, in the format of its ending.

    Raises:
        ValueError: for an ending other than .nc, .mat and .csv, a place that cannot be written, and a dataset that the
            format cannot hold.
    """
    target = checked(path)
    if target.suffix.lower() == ".nc":
        in_one_step(target, lambda file: write_netcdf(in_parts(dataset), file))
    elif target.suffix.lower() == ".mat":
        from lobex.results.matlab import write_matlab

        in_one_step(target, lambda file: write_matlab(dataset, file))
    else:
        from lobex.results.table import write_table

        in_one_step(target, lambda file: write_table(in_parts(dataset), file))


def write_netcdf(dataset: xarray.Dataset, file: Path, **how: Any) -> None:
    """Write a NetCDF-4 file in this process, whatever cluster there is, or was: xarray would ask for that."""
    dask = sys.modules.get("dask.config")
    with nullcontext() if dask is None else dask.set(scheduler="synchronous"):
        dataset.to_netcdf(file, engine="h5netcdf", format="NETCDF4", **how)


def checked(path: str | os.PathLike[str]) -> Path:
    """Require a place that can be written, of a known ending."""
    target = _checks.writable("path", path)
    if target.suffix.lower() not in ENDINGS:
        wrong = f"ends in {target.suffix!r}" if target.suffix else "has no ending"
        raise ValueError(f"path = {str(path)!r} {wrong}; give .nc (which lobex.load reads back), .mat or .csv")
    return target


def in_one_step(target: Path, write: Callable[[Path], object]) -> None:
    """Have a file beside ``target`` written, which then takes its place: all at once or not at all."""
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
        with suppress(OSError):
            partial.unlink(missing_ok=True)


def in_parts(dataset: xarray.Dataset) -> xarray.Dataset:
    """Real and imaginary parts: a complex type is outside the NetCDF-4 standard and MATLAB cannot read it."""
    for name, whole in dataset.data_vars.items():
        if np.iscomplexobj(whole):
            about = whole.attrs.get("long_name", name)
            parts = {
                f"{name}{tail}": values.assign_attrs({**whole.attrs, "long_name": f"{about}{words}"})
                for values, (tail, words) in zip((whole.real, whole.imag), PARTS.items(), strict=True)
            }
            dataset = dataset.drop_vars(str(name)).assign(parts)
    return dataset
