"""The further axes of a study: which numbers of the model vary, and the model at every combination of them."""

import dataclasses
from collections.abc import Callable, Mapping
from itertools import combinations
from typing import Any

import jax
import numpy as np

from lobex import _checks
from lobex.limits.parameters import number_names, number_values
from lobex.results.blading_wear import BladingWear
from lobex.results.chart import Chart
from lobex.results.description import describe
from lobex.results.fields import names_of
from lobex.results.limit import Limit
from lobex.results.wear_map import WearMap

Axes = dict[str, np.ndarray]
ATTRIBUTES = "attributes"
"""The array of a saved study that says what is said of each of its results."""

RESULTS = {"sweep": (Chart,), "critical_gain": (Limit,), "march_wear": (WearMap, BladingWear)}
"""What the verbs of studies hand back."""

# What is a model by itself: paths begin within it.
_ALONE = "process"


def axes_of(over: Mapping[str, Any] | None, verb: str) -> Axes:
    """The values of every axis of a study by ``verb``, by name, as increasing float64 grids."""
    if over is None:
        return {}
    if not isinstance(over, Mapping) or not over:
        raise ValueError(f"over = {_checks.brief(over)} must be a dictionary of one or more grids by name")
    for name in over:
        check_name(name, verb)
    return {name: _checks.grid(f"over[{name!r}]", values) for name, values in over.items()}


def check_name(name: Any, verb: str) -> None:
    """Require a name that an axis of the file of a study by ``verb`` can have."""
    if name == ATTRIBUTES or any(name in names_of(kind) for kind in RESULTS.get(verb, ())):
        raise ValueError(f"over names {name!r}, which the result has already; give the name of a number of the model")
    if not isinstance(name, str) or not name or not name.isprintable() or "/" in name:
        raise ValueError(f"over names {_checks.brief(name)}; give a printable name without a slash")


def shape_of(axes: Axes) -> tuple[int, ...]:
    """The number of values of every axis."""
    return tuple(len(values) for values in axes.values())


def numbers_at(axes: Axes, combination: int) -> dict[str, float]:
    """The numbers of a combination; the last axis runs fastest."""
    index = np.unravel_index(combination, shape_of(axes)) if axes else ()
    return {name: float(values[i]) for (name, values), i in zip(axes.items(), index, strict=True)}


class Variation:
    """A model, and how the numbers of the axes enter it.

    The model is what a verb takes by name, each a pytree or a function of a dictionary of numbers. A name of the axes
    is the path of a number, such as "casing.amplitude" or, within a process, "modes.damping_ratio[0]", or without index
    all numbers of an array; every other name is for the functions, which get all of these.
    """

    def __init__(self, model: dict[str, Any], axes: Axes) -> None:
        _checks.untraced("a study", **model)
        self.axes = axes
        self.functions: dict[str, Callable[[Any], Any]] = {k: v for k, v in model.items() if _is_function(v)}
        self.objects = {k: v for k, v in model.items() if k not in self.functions}
        names = [name.removeprefix(f"{_ALONE}.") for name in number_names(self.objects)]
        self.places = {axis: self._places(axis, names) for axis in axes}
        free = [axis for axis, places in self.places.items() if not places]
        if free and not self.functions:
            stem, bracket, _ = free[0].partition("[")
            own = [name for name in names if name.startswith(f"{stem}[")]
            if bracket and own:
                raise ValueError(f"over names {free[0]!r}, which the model has not; {stem} has {own[0]} to {own[-1]}")
            known = dict.fromkeys(name.split("[")[0] for name in names)
            raise ValueError(f"over names {free[0]!r}, no number of the model; it has {', '.join(known)}")
        if self.functions and not free:
            raise ValueError(f"{next(iter(self.functions))} is a function; name its numbers in over")
        for one, other in combinations(axes, 2):
            if not set(self.places[one]).isdisjoint(self.places[other]):
                raise ValueError(f"over names {one!r} and {other!r}, which are the same number; drop one")
        for combination in [0, *(number for along in self._along().values() for number in along[1:])]:
            self.at(combination)

    def at(self, combination: int) -> dict[str, Any]:
        """The model at a combination, its checks passed."""
        numbers = numbers_at(self.axes, combination)
        leaves, tree = jax.tree.flatten(self.objects)
        changed = {place: value for name, value in numbers.items() for place in self.places[name]}
        for leaf in {leaf for leaf, _ in changed}:
            leaves[leaf] = np.array(leaves[leaf], dtype=np.result_type(leaves[leaf], np.float64), order="C")
        for (leaf, number), value in changed.items():
            # A complex number is two.
            leaves[leaf].reshape(-1).view(np.float64)[number] = value
        parts = jax.tree.unflatten(tree, leaves) if changed else self.objects
        free = {name: np.float64(value) for name, value in numbers.items() if not self.places[name]}
        try:
            with jax.enable_x64(True):
                parts = {name: _made_anew(part) if changed else part for name, part in parts.items()}
                parts |= {name: make(dict(free)) for name, make in self.functions.items()}
        except ValueError as error:
            raise ValueError(f"{error}; at {in_words(numbers)}") from None
        return parts

    def describe(self) -> dict[str, Any]:
        """The model at the first value of all axes, and at the last of each."""
        places = {"first": 0, **{name: along[-1] for name, along in self._along().items()}}
        described = {}
        for where, combination in places.items():
            parts = {name: describe(part) for name, part in self.at(combination).items()}
            described[where] = parts.get(_ALONE, parts)
        return described

    def _along(self) -> dict[str, range]:
        """The combinations along every axis, with the first value of the others."""
        shape = shape_of(self.axes)
        strides = [int(np.prod(shape[axis + 1 :])) for axis in range(len(shape))]
        return {name: range(0, n * by, by) for name, n, by in zip(self.axes, shape, strides, strict=True)}

    def _places(self, axis: str, names: list[str]) -> list[tuple[int, int]]:
        """The leaves and their numbers that the name of an axis means."""
        sizes = [number_values(leaf).size for leaf in jax.tree.leaves(self.objects)]
        places = [(leaf, number) for leaf, size in enumerate(sizes) for number in range(size)]
        named = zip(places, names, strict=True)
        return [place for place, name in named if name == axis or name.startswith(f"{axis}[")]


def in_words(numbers: Mapping[str, float]) -> str:
    """Such as "young_modulus = 2.1e+09, damping_ratio = 0.03"."""
    return ", ".join(f"{name} = {value:.6g}" for name, value in numbers.items())


def _is_function(part: Any) -> bool:
    return callable(part) and not isinstance(part, type) and not hasattr(part, "system")


def _made_anew(part: Any) -> Any:
    """The same dataclass through its constructor, which checks it and derives what is not a number."""
    if not dataclasses.is_dataclass(part) or isinstance(part, type):
        return part
    return dataclasses.replace(part, **{f.name: _made_anew(getattr(part, f.name)) for f in dataclasses.fields(part)})
