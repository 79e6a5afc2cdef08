"""Files of results and studies, read back."""

import os

import xarray

from lobex import _checks
from lobex.results.register import result_of
from lobex.results.result import Result
from lobex.studies.assembly import FORM as STUDY
from lobex.studies.study import Study, study_from


def load(path: str | os.PathLike[str]) -> Result | Study:
    """Read what the ``save`` of a result or a study wrote to a .nc file.

    Raises:
        ValueError: for any other file, or none, and for a field that is missing or not what a result has there.
    """
    source = _checks.place("path", path)
    if not source.is_file():
        raise ValueError(f"path = {str(path)!r} is not a file; give the .nc file that a result was saved to")
    try:
        with xarray.open_dataset(source, engine="h5netcdf") as stored:
            dataset = stored.load()
    except (OSError, ValueError, KeyError, RuntimeError) as error:
        why = str(error).partition("\n")[0]
        raise ValueError(f"path = {str(path)!r} is no readable NetCDF-4 file ({why})") from error
    return made_of(dataset, f"path = {str(path)!r}")


def made_of(dataset: xarray.Dataset, source: str) -> Result | Study:
    """The result or the study that a file's dataset stands for; ``source`` says in messages where it is from."""
    if dataset.attrs.get("format") == STUDY:
        return study_from(dataset, source)
    return result_of(dataset, source, STUDY)
