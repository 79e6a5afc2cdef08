"""The numbers of a figure as one NetCDF-4 file."""

import os
from pathlib import Path

import numpy as np
import xarray

from lobex.gallery.reproduction import Reproduction, Results


def save_numbers(figure: Reproduction, results: Results, path: Path) -> None:
    """Write what ``compute`` returned, all at once or not at all.

    Several results are groups of the file, by name, which ``xarray.open_dataset(path, group=…)`` reads; a single one
    is its root. Complex numbers are in two parts.

    Raises:
        ValueError: where the file cannot be written.
    """
    names = list(results)
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        xarray.Dataset(attrs={"figure": figure.name, "title": figure.title}).to_netcdf(partial, engine="h5netcdf")
        for name in names:
            dataset = results[name] if isinstance(results[name], xarray.Dataset) else results[name].to_xarray()
            group = None if len(names) == 1 else name
            _in_parts(dataset).to_netcdf(partial, mode="a", group=group, engine="h5netcdf")
        os.replace(partial, path)
    except OSError as error:
        raise ValueError(f"path = {str(path)!r} cannot be written ({error}); choose another folder") from error
    finally:
        partial.unlink(missing_ok=True)


def _in_parts(dataset: xarray.Dataset) -> xarray.Dataset:
    """Real and imaginary parts of complex variables, which MATLAB reads."""
    for name in map(str, dataset.data_vars):
        values = dataset[name]
        if np.iscomplexobj(values):
            dataset = dataset.assign({f"{name}_real": values.real, f"{name}_imag": values.imag}).drop_vars(name)
    return dataset
