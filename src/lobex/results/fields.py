"""What a result declares of each of its fields, once; labelled arrays, files and their readers are made of it."""

import dataclasses
import json
import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple, Protocol, TypeVar, dataclass_transform, get_type_hints, runtime_checkable

import numpy as np

from lobex.processes.quantity import Quantity, hertz
from lobex.results.codes import Code, flags
from lobex.results.stored import Stored

Words = str | Callable[[Any], str]
F = TypeVar("F", bound=Callable[..., Any])
R = TypeVar("R", bound="Fields")


class Parts(NamedTuple):
    """What a labelled dataset is made of, by name."""

    variables: dict[str, Any]
    coordinates: dict[str, Any]
    attributes: dict[str, Any]


@runtime_checkable
class Declared(Protocol):
    """How a dataset holds a field."""

    def write(self, name: str, value: Any, result: Any, into: Parts, /) -> None:
        """Add the field ``name`` of ``result`` to a dataset."""
        ...

    def read(self, name: str, stored: Stored, /) -> Any:
        """Its value in a file, checked."""
        ...


@dataclasses.dataclass(frozen=True)
class Array:
    """Numbers over dimensions.

    Attributes:
        dims: the dimensions, such as "speed gain"; "*lane" stands for any number of them, which a file lays along one,
            and "edge=2" has that length.
        long_name, unit: for people; of a result that tells them, a function of it. Empty for none.
        name: in files, where it is not the field's.
        dtype: of the numbers; complex ones are stored in two parts.
        known: whether these are one or more finite numbers.
        increasing: whether they increase.
        coordinate: whether others lie over them.
    """

    dims: str
    long_name: Words = ""
    unit: Words = ""
    name: str = ""
    dtype: Any = np.float64
    known: bool = False
    increasing: bool = False
    coordinate: bool = False

    def write(self, name: str, value: Any, result: Any, into: Parts) -> None:
        """Add the array with its dimensions and what it says for people."""
        dims, values = tuple(self.sizes()), np.asarray(value, dtype=self.dtype)
        if self.dims.startswith("*"):
            free = values.ndim - len(dims) + 1
            into.attributes[f"{dims[0]}s"] = json.dumps(values.shape[:free])
            values = values.reshape(math.prod(values.shape[:free]), *values.shape[free:])
        whole = into.coordinates if self.coordinate else into.variables
        whole[self.name or name] = dims, values, self._notes(result)

    def read(self, name: str, stored: Stored) -> np.ndarray:
        """The array, of the axes that it had."""
        sizes, name = self.sizes(), self.name or name
        values = self._values(stored, name, tuple(sizes))
        for (dim, wanted), size in zip(sizes.items(), values.shape, strict=True):
            if wanted and int(wanted) != size:
                stored.refuse(f"has variable {name!r} with other than {wanted} places along {dim!r}")
        if not self.dims.startswith("*"):
            return values
        return values.reshape(*stored.places(next(iter(sizes))), *values.shape[1:])

    def sizes(self) -> dict[str, str]:
        """The lengths of the dimensions, empty where they are free."""
        return {dim: size for dim, _, size in (part.lstrip("*").partition("=") for part in self.dims.split())}

    def _notes(self, result: Any) -> dict[str, Any]:
        told = {"long_name": self.long_name, "units": self.unit}
        words = {name: text if isinstance(text, str) else text(result) for name, text in told.items()}
        return {name: text for name, text in words.items() if text}

    def _values(self, stored: Stored, name: str, dims: tuple[str, ...]) -> np.ndarray:
        if self.known:
            return stored.known(name, *dims, increasing=self.increasing)
        kind = np.dtype(self.dtype).kind
        return stored.complex(name, *dims) if kind == "c" else stored.array(name, *dims, kind=kind)


@dataclasses.dataclass(frozen=True)
class Coordinate(Array):
    """What other arrays lie over."""

    known: bool = True
    coordinate: bool = True


@dataclasses.dataclass(frozen=True)
class Codes(Array):
    """Members of an enumeration, as flags with their meanings."""

    codes: type[Code] = Code
    dtype: Any = np.int8

    def _notes(self, result: Any) -> dict[str, Any]:
        return {**super()._notes(result), **flags(self.codes)}

    def _values(self, stored: Stored, name: str, dims: tuple[str, ...]) -> np.ndarray:
        return stored.flags(name, self.codes, *dims)


@dataclasses.dataclass(frozen=True)
class Attribute:
    """Something said of the whole: text, a number, several numbers, or what JSON can tell.

    Attributes:
        look: how it is taken from a file, by its name.
    """

    look: Callable[[Stored, str], Any]

    def write(self, name: str, value: Any, result: Any, into: Parts) -> None:
        """Add it as itself, or as JSON text."""
        if isinstance(value, Quantity | dict):
            told = value if isinstance(value, dict) else value._asdict()
            value = json.dumps(told, ensure_ascii=False)
        into.attributes[name] = np.asarray(value, dtype=float) if isinstance(value, tuple) else value

    def read(self, name: str, stored: Stored) -> Any:
        """What a file says."""
        return self.look(stored, name)


def field(declared: Declared) -> Any:
    """A field of which more is to be said than its type does."""
    return dataclasses.field(metadata={"declared": declared})


def derived(declared: Array, after: str) -> Callable[[F], F]:
    """A property that follows from the fields, and that files hold, next to the field ``after``, for other programs."""

    def mark(function: F) -> F:
        function.__dict__["derived"] = after, declared
        return function

    return mark


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(field,))
@dataclasses.dataclass(frozen=True, eq=False)
class Fields:
    """A frozen dataclass of declared fields. Attributes are declared by their types alone."""

    def __init_subclass__(cls) -> None:
        dataclasses.dataclass(frozen=True, eq=False)(cls)


@dataclasses.dataclass(frozen=True)
class Whole:
    """A result within another, which it shares the dataset with."""

    made: type[Fields]

    def write(self, name: str, value: Any, result: Any, into: Parts) -> None:
        """Add all its fields."""
        write(value, into)

    def read(self, name: str, stored: Stored) -> Any:
        """The result within."""
        return read(self.made, stored)


@cache
def declared_of(made: type[Fields]) -> dict[str, Declared]:
    """What a class declares of its fields and of what follows from them, by name."""
    types = get_type_hints(made)
    properties = {name: part.fget.__dict__ for name, part in vars(made).items() if isinstance(part, property)}
    following = {name: marks["derived"] for name, marks in properties.items() if "derived" in marks}
    whole: dict[str, Declared] = {}
    for own in dataclasses.fields(made):
        whole[own.name] = own.metadata.get("declared") or _BY_TYPE[types[own.name]]
        whole |= {name: declared for name, (after, declared) in following.items() if after == own.name}
    return whole


def names_of(made: type[Fields]) -> set[str]:
    """The names that arrays of a class and their dimensions have in files."""
    arrays = {kind.name or name: kind for name, kind in declared_of(made).items() if isinstance(kind, Array)}
    return {*arrays, *(dim for kind in arrays.values() for dim in kind.sizes())}


def write(result: Fields, into: Parts) -> None:
    """Add all fields of a result to a dataset."""
    for name, declared in declared_of(type(result)).items():
        declared.write(name, getattr(result, name), result, into)


def read(made: type[R], stored: Stored) -> R:
    """The result of a class that a file holds; what follows from the others is looked at, and made again."""
    values = {name: declared.read(name, stored) for name, declared in declared_of(made).items()}
    return made(**{f.name: values[f.name] for f in dataclasses.fields(made)})


_BY_TYPE: dict[Any, Attribute] = {
    float: Attribute(Stored.number),
    int: Attribute(Stored.count),
    str: Attribute(Stored.text),
    Quantity: Attribute(Stored.quantity),
    dict[str, Any]: Attribute(Stored.description),
}


def in_hertz(result: Any) -> str:
    """The unit of frequencies: that of a machine, or none."""
    return hertz(result.speed_unit).strip() or "1"


def in_gain(result: Any) -> str:
    """The unit of the gain."""
    return result.quantity.unit
