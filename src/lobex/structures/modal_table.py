"""Modes of a table: frequency, damping, mass or stiffness, and the direction of each."""

from typing import Any

import numpy as np
from jaxtyping import Float

from lobex import _checks
from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._shapes import AnyArray

_AXES = ("x", "y", "z")


@in_float64
def table_of(
    frequency: Any, damping_ratio: Any, mass: Any, stiffness: Any, direction: Any
) -> tuple[Float[AnyArray, " n"], Float[AnyArray, " n"], Float[AnyArray, "n r"]]:
    """ω, ξ and mass-normalised shapes of the rows of a table; arguments as of ``Modes.from_table``."""
    if (mass is None) == (stiffness is None):
        raise ValueError(
            f"mass = {_checks.brief(mass)}, stiffness = {_checks.brief(stiffness)}: give one of them, modal"
        )
    inertia = ("mass", mass, "kg") if stiffness is None else ("stiffness", stiffness, "N/m")
    _checks.positive("frequency", frequency, "Hz")
    _checks.not_negative("damping_ratio", damping_ratio)
    _checks.positive(*inertia)
    lib = namespace(frequency, damping_ratio, inertia[1], direction)
    rows = np.shape(_checks.as_array(frequency))
    if len(rows) > 1 or rows == (0,):
        raise ValueError(f"frequency has shape {rows}; give one number per mode, (n,)")
    count = rows or (1,)

    def column(name: str, value: Any) -> Float[AnyArray, " n"]:
        number = lib.asarray(_checks.as_array(value), dtype=lib.result_type(float))
        if np.shape(number) not in ((), count):
            raise ValueError(f"{name} has shape {np.shape(number)}; give one number or one per mode, {count}")
        return lib.broadcast_to(number, count)

    omega = 2 * np.pi * column("frequency", frequency)
    size = column(*inertia[:2])
    size = 1 / lib.sqrt(size) if stiffness is None else omega / lib.sqrt(size)
    return omega, column("damping_ratio", damping_ratio), size[:, None] * _directions(direction, count[0])


def _directions(direction: Any, count: int) -> Float[AnyArray, "n r"]:
    """Unit vectors of ``count`` modes."""
    if direction is None:
        return np.ones((count, 1))
    named = [direction] if isinstance(direction, str) else direction
    if all(isinstance(name, str) for name in named):
        for name in named:
            _checks.choice("direction", name, _AXES)
        axis = [_AXES.index(name) for name in named]
        if len(axis) not in (1, count):
            raise ValueError(f"direction has {len(axis)} axes; give one, or one per mode, {count}")
        return np.broadcast_to(np.eye(len(_AXES))[axis, : max(axis) + 1], (count, max(axis) + 1))
    vectors = _checks.as_array(direction)
    lib = namespace(vectors)
    numbers = _checks.as_numbers("direction", vectors)
    if np.ndim(vectors) != 2 or np.shape(vectors)[0] != count or not 1 <= np.shape(vectors)[1] <= len(_AXES):
        raise ValueError(f"direction has shape {np.shape(vectors)}; give one vector per mode, ({count}, 1 to 3)")
    if numbers is not None and not np.all(np.any(numbers != 0, axis=1)):
        raise ValueError("direction has a vector of no length; give one along which the mode moves")
    return vectors / lib.sqrt(lib.sum(vectors**2, axis=1, keepdims=True))
