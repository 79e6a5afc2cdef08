"""What a file says of a result, each field checked as it is taken out."""

import json
import math
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from lobex.processes.quantity import Quantity
from lobex.results.codes import Code

if TYPE_CHECKING:
    import xarray

_KINDS = {"f": "float64", "i": "whole numbers", "U": "text"}


class Stored:
    """The fields of a dataset. What is missing or is not what it must be is a ``ValueError`` of one line that names
    the file and the field.

    Args:
        dataset: as a file holds it.
        source: where it is from, as messages begin: "path = 'mill.nc'".
    """

    def __init__(self, dataset: "xarray.Dataset", source: str) -> None:
        self._dataset, self._source = dataset, source

    def array(self, name: str, *dims: str, kind: str = "f") -> np.ndarray:
        """A variable over ``dims``: of float64 numbers ("f"), whole numbers ("i") or text ("U")."""
        # xarray would number the places of a dimension without a coordinate 0, 1, 2, ….
        if name not in self._dataset.variables:
            self.refuse(f"has no variable {name!r}")
        variable = self._dataset.variables[name]
        if variable.dims != dims:
            self.refuse(f"has variable {name!r} over ({_list(variable.dims)}) in place of ({_list(dims)})")
        values = variable.to_numpy()
        text = values.dtype.kind in "OT" and all(isinstance(v, str) for v in values.flat)
        if ("U" if text else values.dtype.kind) != kind or (kind == "f" and values.dtype != np.float64):
            self.refuse(f"has variable {name!r} of type {values.dtype} in place of {_KINDS[kind]}")
        return values

    def known(self, name: str, *dims: str, increasing: bool = False) -> np.ndarray:
        """A variable of one or more finite numbers, such as what the others lie over."""
        values = self.array(name, *dims)
        if values.size == 0:
            self.refuse(f"has variable {name!r} without values")
        if not np.isfinite(values).all():
            self.refuse(f"has variable {name!r} with NaN or infinite values")
        if increasing and np.any(np.diff(values) <= 0):
            self.refuse(f"has variable {name!r} that does not increase")
        return values

    def complex(self, name: str, *dims: str) -> np.ndarray:
        """A complex variable, which is stored as its real and imaginary part."""
        return self.array(f"{name}_real", *dims) + 1j * self.array(f"{name}_imag", *dims)

    def flags(self, name: str, codes: type[Code], *dims: str) -> np.ndarray:
        """A variable of members of an enumeration."""
        values = self.array(name, *dims, kind="i")
        if not np.isin(values, list(codes)).all():
            self.refuse(f"has variable {name!r} with values other than {_list(map(str, map(int, codes)))}")
        return values

    def size(self, dim: str) -> int:
        """The length of a dimension."""
        if dim not in self._dataset.sizes:
            self.refuse(f"has no dimension {dim!r}")
        return int(self._dataset.sizes[dim])

    def number(self, name: str) -> float:
        """An attribute that is a real number."""
        return float(self._single(name, "fi", "a number"))

    def count(self, name: str) -> int:
        """An attribute that is a whole number of 0 or more."""
        value = int(self._single(name, "iu", "a whole number"))
        if value < 0:
            self.refuse(f"has attribute {name!r} = {value}, which must not be negative")
        return value

    def numbers(self, name: str, size: int) -> tuple[float, ...]:
        """An attribute of several real numbers."""
        values = np.asarray(self._attribute(name))
        if values.shape != (size,) or values.dtype.kind not in "fi":
            self.refuse(f"has attribute {name!r} that is not {size} numbers")
        return tuple(values.astype(float).tolist())

    def text(self, name: str) -> str:
        """An attribute that is text."""
        value = self._attribute(name)
        if not isinstance(value, str):
            self.refuse(f"has attribute {name!r} that is not text")
        return str(value)

    def unit(self, name: str) -> str:
        """An attribute that is a unit of speeds."""
        value = self.text(name)
        if value not in ("Hz", "rpm", "1"):
            self.refuse(f"has attribute {name!r} = {value!r} in place of 'Hz', 'rpm' or '1'")
        return value

    def json(self, name: str) -> Any:
        """An attribute that is JSON text."""
        try:
            return json.loads(self.text(name))
        except (json.JSONDecodeError, RecursionError):
            self.refuse(f"has attribute {name!r} that is no whole JSON text")

    def names(self, name: str) -> tuple[str, ...]:
        """An attribute that is a list of text in JSON."""
        value = self.json(name)
        if not isinstance(value, list) or not all(isinstance(v, str) for v in value):
            self.refuse(f"has attribute {name!r} that is not a list of names")
        return tuple(value)

    def places(self, dim: str) -> tuple[int, ...]:
        """The shape, an attribute in JSON, of the places that lie along one dimension."""
        name, size = f"{dim}s", self.size(dim)
        shape = self.json(name)
        if not isinstance(shape, list) or not all(type(v) is int and v >= 0 for v in shape):
            self.refuse(f"has attribute {name!r} that is not a list of sizes")
        if math.prod(shape) != size:
            self.refuse(f"has attribute {name!r} = {shape}, which are not the {size} {name} it holds")
        return tuple(shape)

    def description(self, name: str) -> dict[str, Any]:
        """An attribute that describes a model; see ``results.description``."""
        value = self.json(name)
        self._check_description(name, value)
        return value

    def descriptions(self, name: str, *parts: str) -> dict[str, Any]:
        """An attribute that describes several ``parts`` of a model by name."""
        value = self.json(name)
        if not isinstance(value, dict) or set(value) != set(parts):
            self.refuse(f"has attribute {name!r} that does not describe {_list(parts)}")
        for part in parts:
            self._check_description(name, value[part])
        return value

    def quantity(self, name: str) -> Quantity:
        """An attribute that says what the gain is."""
        value, types = self.json(name), Quantity.__annotations__
        # JSON has no difference between 1.0 and 1, and Python none between True and 1.
        allowed = {str: (str,), bool: (bool,), float: (float, int)}
        if not isinstance(value, dict) or set(value) != set(types):
            self.refuse(f"has attribute {name!r} that does not name {_list(types)}")
        wrong = [part for part, made in types.items() if type(value[part]) not in allowed.get(made, (made,))]
        if wrong or not value["scale"] > 0:
            self.refuse(f"has attribute {name!r} with a bad {_list(wrong or ['scale'])}")
        return Quantity(**value)

    def refuse(self, what: str) -> NoReturn:
        """Say what is wrong with the file."""
        raise ValueError(f"{self._source} {what}; it is damaged or was changed: compute it again")

    def _attribute(self, name: str) -> Any:
        if name not in self._dataset.attrs:
            self.refuse(f"has no attribute {name!r}")
        return self._dataset.attrs[name]

    def _single(self, name: str, kinds: str, what: str) -> Any:
        value = np.asarray(self._attribute(name))
        if value.size != 1 or value.dtype.kind not in kinds:
            self.refuse(f"has attribute {name!r} that is not {what}")
        return value.item()

    def _check_description(self, name: str, value: Any) -> None:
        if not isinstance(value, dict) or not isinstance(value.get("type"), str):
            self.refuse(f"has attribute {name!r} that describes no model")


def _list(names: Any) -> str:
    return ", ".join(map(str, names))
