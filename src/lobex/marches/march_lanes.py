"""The lanes of a march: their points, the steps that they need, and those that are lost."""

from typing import Any

import numpy as np

from lobex._memory import check_memory
from lobex._warnings import SweepWarning, warn
from lobex.marches.fed_vibrations import STEPS_PER_WAVE, fastest_fed
from lobex.processes.declared import check_system
from lobex.processes.plausible import warn_of_implausible
from lobex.processes.process import Process, check_gain, check_speed, lanes_shape
from lobex.processes.quantity import Quantity
from lobex.systems.system import DelaySystem

# What is kept of a step is there in JAX, in NumPy, and once more while it is put in order.
_COPIES = 3


def lanes_of(process: Process, speed: Any, gain: Any, name: str = "gain") -> tuple[np.ndarray, np.ndarray]:
    """Speeds and gains of all lanes, both of the broadcast shape."""
    check_speed(process, speed)
    check_gain(process, gain)
    lanes_shape(speed, gain, name)
    speeds, gains = np.broadcast_arrays(np.asarray(speed, dtype=float), np.asarray(gain, dtype=float))
    if speeds.size == 0:
        raise ValueError(f"speed and {name} have no values, shape {speeds.shape}; give at least one")
    check_system(process, speeds, gains)
    warn_of_implausible(process, speeds, gains)
    return np.array(speeds), np.array(gains)


def check_steps(name: str, system: DelaySystem, stiffness: np.ndarray, speeds: np.ndarray, steps: int) -> None:
    """Require eight steps per wave of the first mode and of all that the contact can feed, in every lane.

    Args:
        name: what the steps are called.
        system: of all lanes, each leaf with lanes first.
        stiffness: the largest contact force per displacement, now and a delay ago together, (lanes,).
        speeds: (lanes,).
        steps: steps per period.
    """
    needed, fastest, of_first = steps_needed(system, stiffness)
    worst = int(np.argmax(needed))
    if steps < needed[worst]:
        whose = "first mode" if of_first[worst] else "fastest vibration that the contact can feed"
        raise ValueError(
            f"{name} = {steps} is too few at speed = {speeds[worst]:.6g} Hz; give {needed[worst]:.0f} or more, "
            f"{STEPS_PER_WAVE} per wave of the {whose} ({fastest[worst] / (2 * np.pi):.6g} Hz)"
        )


def steps_needed(system: DelaySystem, stiffness: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The fewest steps per period of ``check_steps``, the ω that asks for them, rad/s, and whether it is that of the
    first mode, (lanes,) each.
    """
    first, fed = fastest_fed(system, stiffness)
    fastest = np.maximum(first, fed)
    return np.ceil(STEPS_PER_WAVE / (2 * np.pi) * fastest * system.period), fastest, fed <= first


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
        warn(
            f"{lost.sum()} of {lost.size} lanes grew beyond floating point and are NaN from there on, the first at "
            f"speed = {speeds.ravel()[first]:.6g} Hz, {quantity.name} = "
            f"{in_unit(gains.ravel()[first], quantity.unit)}; march fewer periods",
            SweepWarning,
        )


def in_unit(number: float, unit: str) -> str:
    """A number with its unit, where it has one."""
    return f"{number:.6g}" if unit == "1" else f"{number:.6g} {unit}"
