"""The chunks of a study as one labelled dataset, of dask arrays that read the chunks that they are asked for."""

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import xarray
from jaxtyping import Shaped

from lobex.studies.plan import Plan
from lobex.studies.variation import ATTRIBUTES, shape_of

FORM = "lobex study 1"
OVER = "over"
"""The attribute that names the further axes."""

_SUMS = ("failed",)

Read = Callable[[int], xarray.Dataset]


def assembled(verb: str, plan: Plan, speed: np.ndarray, read: Read) -> xarray.Dataset:
    """All arrays over the further axes and their own, and what is said of the result of each combination as JSON.

    Args:
        verb: what the study is by.
        plan: how it is cut into chunks.
        speed: of every lane, Hz, (lanes,), or of a wear march whose speeds change (lanes, revolutions), of which the
            first count.
        read: a chunk by its number; the first is read at once, the others when they are asked for.
    """
    first, axes, along = read(0), tuple(plan.axes), "speed"
    whole = (*shape_of(plan.axes), plan.blocks)
    lanes = tuple(part.stop - part.start for _, part in map(plan.chunk, range(plan.blocks)))
    from dask import array

    each = tuple((1,) * size for size in whole)
    chunks = array.map_blocks(_boxed, read, whole, chunks=each, dtype=object, meta=_empty(whole, object))

    def of_chunks(name: str, variable: xarray.DataArray) -> xarray.Variable:
        dims = tuple(map(str, variable.dims))
        # What no lane has is the same in all blocks of a combination.
        source = chunks if along in dims else chunks[..., :1]
        made = array.blockwise(
            *(_taken, (*axes, *dims), source, (*axes, along), name, None, len(axes), None),
            concatenate=True,
            new_axes={dim: size for dim, size in zip(dims, variable.shape, strict=True) if dim != along},
            adjust_chunks={along: lanes},
            dtype=variable.dtype,
            meta=_empty((*axes, *dims), variable.dtype),
        )
        return xarray.Variable((*axes, *dims), made, variable.attrs)

    said = array.blockwise(
        *(_said, axes, chunks, (*axes, along)), concatenate=True, dtype=object, meta=_empty(axes, object)
    )
    coordinates: dict[str, Any] = {name: (name, values) for name, values in plan.axes.items()}
    coordinates |= {str(name): own.variable for name, own in first.coords.items()}
    coordinates["speed"] = along, np.reshape(speed, (plan.lanes, -1))[:, 0], first["speed"].attrs
    arrays = {str(name): of_chunks(str(name), variable) for name, variable in first.data_vars.items()}
    about = {"format": FORM, "verb": verb, OVER: json.dumps(axes)}
    return xarray.Dataset({**arrays, ATTRIBUTES: (axes, said)}, coordinates, about)


def _boxed(read: Read, whole: tuple[int, ...], block_id: tuple[int, ...]) -> Shaped[np.ndarray, "..."]:
    """A chunk as an array of one object, for dask."""
    box = _empty(whole, object, 1)
    box[(0,) * len(whole)] = read(int(np.ravel_multi_index(block_id, whole)))
    return box


def _taken(box: Shaped[np.ndarray, "..."], name: str, axes: int) -> Shaped[np.ndarray, "..."]:
    """An array of a chunk, behind the further axes."""
    return box.item()[name].to_numpy()[(None,) * axes]


def _said(boxes: Shaped[np.ndarray, "..."]) -> Shaped[np.ndarray, "..."]:
    """What all chunks of a combination say, as JSON; numbers of lanes are added up."""
    parts = [chunk.attrs for chunk in boxes.flat]
    whole = {**parts[0], **{name: np.sum([part[name] for part in parts]) for name in _SUMS if name in parts[0]}}
    told = {str(name): v if isinstance(v, str) else np.asarray(v).tolist() for name, v in whole.items()}
    text = _empty(boxes.shape[:-1], object, 1)
    text[...] = json.dumps(told, ensure_ascii=False)
    return text


def _empty(dims: Any, dtype: Any, size: int = 0) -> np.ndarray:
    return np.empty((size,) * len(dims), dtype)
