"""The numbers of a figure as one NetCDF-4 file."""

import os
from pathlib import Path

import xarray

from lobex.gallery.reproduction import Reproduction, Results
from lobex.results.saving import in_parts, write_netcdf


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
        write_netcdf(xarray.Dataset(attrs={"figure": figure.name, "title": figure.title}), partial)
        for name in names:
            dataset = results[name] if isinstance(results[name], xarray.Dataset) else results[name].to_xarray()
            group = None if len(names) == 1 else name
            write_netcdf(in_parts(dataset), partial, mode="a", group=group)
        os.replace(partial, path)
    except OSError as error:
        raise ValueError(f"path = {str(path)!r} cannot be written ({error}); choose another folder") from error
    finally:
        partial.unlink(missing_ok=True)
