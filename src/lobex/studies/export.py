"""A study as one NetCDF-4 file, written chunk by chunk, and back."""

import json
import os
from pathlib import Path
from typing import Any

import h5netcdf
import numpy as np
import xarray

from lobex.results.saving import checked, in_one_step, save_dataset
from lobex.results.stored import Stored
from lobex.studies.blocks import InFile
from lobex.studies.plan import Plan
from lobex.studies.slabs import coordinates_of
from lobex.studies.study import FORM, Study
from lobex.studies.variation import ATTRIBUTES, Axes, check_name, shape_of

_AXES = "over"


def write_study(study: Study, path: str | os.PathLike[str]) -> None:
    """Write ``path`` in one step; as NetCDF-4 chunk by chunk."""
    target = checked(path)
    if target.suffix.lower() != ".nc":
        return save_dataset(study.to_xarray(), path)

    def write(partial: Path) -> None:
        with h5netcdf.File(partial, "w") as file:
            _fill(study, file)

    in_one_step(target, write)


def _fill(study: Study, file: h5netcdf.File) -> None:
    plan = study.blocks.plan
    first = study.blocks.chunk(0)
    sizes = {str(name): size for name, size in first.sizes.items()}
    sizes[study.along] = plan.lanes
    shape = shape_of(plan.axes)
    file.dimensions = {**dict(zip(plan.axes, shape, strict=True)), **sizes}
    for name, values in plan.axes.items():
        file.create_variable(name, (name,), data=values)
    for name, coordinate in first.coords.items():
        values = study.speed if name == "speed" else coordinate.to_numpy()
        made = file.create_variable(str(name), coordinate.dims, data=values)
        made.attrs.update(coordinate.attrs)
    for name, variable in first.data_vars.items():
        made = file.create_variable(str(name), (*plan.axes, *variable.dims), dtype=variable.dtype)
        made.attrs.update(variable.attrs)
    attributes = file.create_variable(ATTRIBUTES, tuple(plan.axes), dtype=_text())
    for combination in range(plan.combinations):
        index = tuple(int(i) for i in np.unravel_index(combination, shape)) if shape else ()
        whole = study.whole(combination)
        for name, variable in whole.data_vars.items():
            file.variables[str(name)][(*index, ...)] = variable.to_numpy()
        attributes[(*index, ...)] = json.dumps(_listed(whole.attrs), ensure_ascii=False)
    file.attrs.update({"format": FORM, "verb": study.verb, _AXES: json.dumps(list(plan.axes))})
    file.attrs.update(coordinates_of(first))


def _text() -> Any:
    import h5py

    return h5py.string_dtype()


def _listed(attributes: dict[Any, Any]) -> dict[str, Any]:
    return {str(k): v if isinstance(v, str) else np.asarray(v).tolist() for k, v in attributes.items()}


def study_from(dataset: xarray.Dataset, source: str) -> Study:
    """The study that a file was made of, once every result in it has been looked at."""
    from lobex.results.register import result_of

    stored = Stored(dataset, source)
    axes: Axes = {}
    verb = stored.text("verb")
    for name in stored.names(_AXES):
        check_name(name, verb)
        axes[name] = stored.known(name, name, increasing=True)
    lanes = stored.size("lane" if "lane" in dataset.sizes else "speed")
    stored.array(ATTRIBUTES, *axes, kind="U")
    blocks = InFile(Plan(axes, lanes, lanes), dataset, source)
    result_of(blocks.chunk(0), source)
    # The arrays are the same in all combinations, and what is said of them is much alike.
    for number in range(1, blocks.plan.combinations):
        if set(blocks.attributes(number)) != set(blocks.attributes(0)):
            stored.refuse(f"has other fields in {ATTRIBUTES!r} of combination {number} than in the first")
    return Study(verb, blocks)
