"""A dataset as a MATLAB file."""

import keyword
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import xarray
from scipy.io import savemat
from scipy.io.matlab import MatWriteError

# MATLAB cuts longer names off.
_LONGEST = 63
# Of the words that MATLAB reserves, those that Python does not.
_RESERVED = {"case", "catch", "end", "function", "otherwise", "parfor", "persistent", "spmd", "switch"}
_ABOUT, _ATTRIBUTES = "about", "attributes"


def write_matlab(dataset: xarray.Dataset, path: Path) -> None:
    """Every array under its name, complex ones as such; what it lies over and its unit in the struct ``about``, which
    has a field for every array; and in the struct ``attributes`` what the result says of itself, models as JSON."""
    names = legal([_ABOUT, _ATTRIBUTES, *map(str, dataset.variables)])
    content: dict[str, Any] = {_ABOUT: {}, _ATTRIBUTES: {}}
    for name, variable in dataset.variables.items():
        own = names[str(name)]
        values = variable.to_numpy()
        content[own] = values.astype(object) if values.dtype.kind in "UT" else values
        notes = {**variable.attrs, "name": str(name), "dimensions": ", ".join(map(str, variable.dims))}
        content[_ABOUT][own] = _struct(notes)
    content[_ATTRIBUTES] = _struct(dataset.attrs)
    with open(path, "wb") as file:
        try:
            savemat(file, content, long_field_names=True, do_compression=True, oned_as="column")
        except MatWriteError as error:
            raise ValueError(f"an array is larger than a .mat file can hold ({error}); give .nc") from error


def legal(names: Iterable[str]) -> dict[str, str]:
    """Names that MATLAB takes for variables and fields, each its own."""
    made: dict[str, str] = {}
    for name in names:
        own = re.sub(r"[^A-Za-z0-9_]", "_", name)
        if not own[:1].isalpha() or own in _RESERVED or keyword.iskeyword(own):
            own = f"x_{own}"
        own, number = own[:_LONGEST], 1
        while own in made.values():
            number += 1
            tail = f"_{number}"
            own = own[: _LONGEST - len(tail)] + tail
        made[name] = own
    return made


def _struct(attributes: Any) -> dict[str, Any]:
    names = legal(map(str, attributes))
    return {names[str(k)]: v if isinstance(v, str) else np.asarray(v) for k, v in attributes.items()}
