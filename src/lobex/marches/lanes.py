"""The lanes of a march: their points, the steps that they need, and those that are lost."""

import warnings
from typing import Any

import numpy as np

from lobex import _checks
from lobex._memory import check_memory
from lobex.grids.sweep import SweepWarning
from lobex.processes.process import Process, check_gain, check_speed
from lobex.processes.quantity import Quantity
from lobex.processes.system import DelaySystem

_STEPS_PER_WAVE = 8
# What is kept of a step is there in JAX, in NumPy, and once more while it is put in order.
_COPIES = 3


def lanes_of(process: Process, speed: Any, gain: Any, name: str = "gain") -> tuple[np.ndarray, np.ndarray]:
    """Speeds and gains of all lanes, both of the broadcast shape."""
    check_speed(process, speed)
    check_gain(process, gain)
    for argument, value in (("speed", speed), (name, gain)):
        if _checks.is_traced(value):
            raise ValueError(
                f"{argument} is traced by JAX; a march runs outside jit, grad and vmap: give plain numbers"
            )
    try:
        speeds, gains = np.broadcast_arrays(np.asarray(speed, dtype=float), np.asarray(gain, dtype=float))
    except ValueError:
        raise ValueError(
            f"{name} has shape {np.shape(gain)} and speed {np.shape(speed)}; give shapes that broadcast"
        ) from None
    if speeds.size == 0:
        raise ValueError(f"speed and {name} have no values, shape {speeds.shape}; give at least one")
    return np.array(speeds), np.array(gains)


def check_steps(name: str, system: DelaySystem, speeds: np.ndarray, steps: int) -> None:
    """Require eight steps per wave of the slowest vibration, in every lane."""
    turning = np.max(np.imag(np.linalg.eigvals(system.blocks)), axis=-1)
    needed = np.ceil(_STEPS_PER_WAVE / (2 * np.pi) * np.min(turning, axis=-1) * system.delay)
    worst = int(np.argmax(needed))
    if steps < needed[worst]:
        raise ValueError(
            f"{name} = {steps} is too few at speed = {speeds[worst]:.6g} Hz; give {needed[worst]:.0f} or more, "
            f"{_STEPS_PER_WAVE} per wave of the first mode"
        )


def check_length(lanes: int, periods: int, steps: int, kept: float) -> None:
    """Require that a march fits into memory that keeps so many numbers of every step of every lane."""
    check_memory(
        f"{periods} periods of {steps} steps at {lanes} points",
        8 * _COPIES * lanes * (periods + 1) * steps * kept,
        "march fewer, or keep every n-th step alone (every=)",
    )


def warn_of_lost_lanes(lost: Any, quantity: Quantity, speeds: np.ndarray, gains: np.ndarray) -> None:
    """Count the lanes that went beyond floating point, and name the first."""
    if lost.any():
        first = int(np.argmax(lost))
        warnings.warn(
            f"{lost.sum()} of {lost.size} lanes grew beyond floating point and are NaN from there on, the first at "
            f"speed = {speeds.ravel()[first]:.6g} Hz, {quantity.name} = "
            f"{in_unit(gains.ravel()[first], quantity.unit)}; march fewer periods",
            SweepWarning,
            stacklevel=3,
        )


def in_unit(number: float, unit: str) -> str:
    """A number with its unit, where it has one."""
    return f"{number:.6g}" if unit == "1" else f"{number:.6g} {unit}"
