"""The verbs at points: monodromy operator, multipliers and spectral radius of a process."""

from functools import partial
from typing import Any

import numpy as np
from jaxtyping import Complex, Float

from lobex import _checks
from lobex._broadcast import over_points
from lobex._compiled import compiled
from lobex._float64 import at_once, in_float64, widened
from lobex._shapes import AnyArray, ArrayLike, Numbers
from lobex._timing import spare_programs
from lobex._warnings import SweepWarning, warn
from lobex.characteristic.method import CharacteristicRoots
from lobex.grids.choice import AUTO, AnyMethod, Auto, check_any_method, chosen_method, tolerance_of
from lobex.grids.differentiated import matrix_of, radius, sorted_multipliers
from lobex.grids.evaluation import dominant_at_points
from lobex.grids.resolution import oddities
from lobex.operators.duhamel import Duhamel
from lobex.operators.operator import Method
from lobex.processes.at_speeds import tabled
from lobex.processes.declared import check_system
from lobex.processes.plausible import warn_of_implausible
from lobex.processes.process import Process, check_gain, check_process, check_speed, fine_enough, lanes_shape

GENERAL = Duhamel(nodes=40)
"""The operator of a fixed size that stands in where nobody chose a method."""


def monodromy(
    process: Process, speed: ArrayLike, gain: ArrayLike, method: Method | Auto = AUTO
) -> Float[AnyArray, "*lanes N N"]:
    """The monodromy operator U of a process: the state one period later is U times the state.

    Args:
        process: a process, such as ``Rub(modes)``.
        speed: speeds in Hz (revolutions per second), any shape.
        gain: gains, broadcast against ``speed``: K_e in N/m or depth of cut in m.
        method: ``Auto()``, which is ``Duhamel(nodes=40)`` here, ``Duhamel(…)``, ``Chebyshev(…)`` or
            ``SemiDiscretization(…)``.

    Returns:
        Array of shape (broadcast shape of speed and gain, N, N). Of concrete arguments a float64 NumPy
        array; under ``jit``, ``grad`` or ``vmap`` a JAX array that follows the precision of its inputs.

    Raises:
        ValueError: for NaN, infinite or non-positive speeds and for gains that the process cannot have.

    Warns:
        LobexWarning: for numbers that can hardly be meant: speeds in rpm, damping in per cent, depths in mm.
        SweepWarning: when the default's samples are too few to follow the first mode at the lowest speed.
    """
    process, speed, gain = _checked(process, speed, gain, method)
    return _monodromy(process, speed, gain, _operator(process, speed, gain, method))


def multipliers(
    process: Process, speed: ArrayLike, gain: ArrayLike, method: Method | Auto = AUTO
) -> Complex[AnyArray, "*lanes N"]:
    """The Floquet multipliers, complex, largest modulus first: shape (broadcast shape, N).

    Arguments, precision, errors and warnings as for ``monodromy``.
    """
    process, speed, gain = _checked(process, speed, gain, method)
    return _multipliers(process, speed, gain, _operator(process, speed, gain, method))


def spectral_radius(
    process: Process, speed: ArrayLike, gain: ArrayLike, method: AnyMethod = AUTO
) -> Float[AnyArray, " *lanes"]:
    """max|μ|: the motion dies out below 1 and grows above. Shape: that of speed and gain, broadcast.

    Differentiable with respect to speed, gain and every number in ``process``. By ``Auto()``, ``CharacteristicRoots()``
    and ``Duhamel(…)`` as in ``sweep``, with the error estimated, where nothing is traced; under tracing ``Auto()`` is
    ``Duhamel(nodes=40)``.
    Arguments, precision, errors and warnings as for ``monodromy``.

    Warns:
        SweepWarning: for points that failed and are NaN, and for estimated errors above the tolerance, 1e-8 by default.
    """
    process, speed, gain = _checked(process, speed, gain, method)
    if isinstance(method, Auto | CharacteristicRoots | Duhamel) and not _checks.is_traced((process, speed, gain)):
        with at_once():
            model = tabled(widened(process), speed)
            return _settled(model, np.asarray(speed, dtype=float), np.asarray(gain, dtype=float), method)
    return _spectral_radius(process, speed, gain, _operator(process, speed, gain, method))


def _settled(process: Process, speed: np.ndarray, gain: np.ndarray, method: AnyMethod) -> np.ndarray:
    """As ``sweep`` has it: proven roots, or as many nodes as the estimated error asks for, or the nodes given."""
    speed, gain = np.broadcast_arrays(speed, gain)
    if not speed.size:
        return np.zeros(speed.shape)
    slowest = float(np.min(speed))
    chosen = chosen_method(method, process, slowest)
    for message in oddities(process, chosen, slowest, float(np.max(gain))):
        warn(message, SweepWarning)
    found = dominant_at_points(process, speed.ravel(), gain.ravel(), chosen, every_mode=True)
    tolerance = tolerance_of(chosen)
    if coarse := int(np.sum(~(found.error <= tolerance))):
        warn(f"{coarse} of {speed.size} points failed or have an estimated error above {tolerance:g}", SweepWarning)
    return np.abs(found.multiplier).reshape(speed.shape)


def _checked(process: Any, speed: Any, gain: Any, method: Any) -> tuple[Process, Numbers, Numbers]:
    """What is asked for, once it is checked, of a process that is fine enough for the method."""
    check_process(process)
    spare_programs()
    check_any_method(method)
    check_speed(process, speed)
    check_gain(process, gain)
    speed, gain = (_checks.as_array(value) for value in (speed, gain))
    lanes_shape(speed, gain)
    check_system(process, speed, gain)
    warn_of_implausible(process, speed, gain)
    return fine_enough(process, speed, gain, tolerance_of(method)), speed, gain


def _operator(process: Process, speed: Any, gain: Any, method: AnyMethod) -> Method:
    """The method, or where none was chosen the general one, which is warned of where its nodes are too few."""
    if isinstance(method, CharacteristicRoots):
        raise ValueError(
            "method = CharacteristicRoots() makes no operator, of which multipliers and derivatives are; "
            "give lobex.Duhamel(), or leave it out"
        )
    if not isinstance(method, Auto):
        return method
    if not _checks.is_traced((process, speed, gain)) and np.size(speed) and np.size(gain):
        with at_once():
            for message in oddities(widened(process), GENERAL, float(np.min(speed)), float(np.max(gain))):
                warn(message, SweepWarning)
    return GENERAL


@in_float64
@compiled
def _monodromy(process: Process, speed: Numbers, gain: Numbers, method: Method) -> Float[AnyArray, "*lanes N N"]:
    return over_points(partial(matrix_of, process, method), speed, gain)


@in_float64
@compiled
def _multipliers(process: Process, speed: Numbers, gain: Numbers, method: Method) -> Complex[AnyArray, "*lanes N"]:
    return over_points(partial(sorted_multipliers, process, method), speed, gain)


@in_float64
@compiled
def _spectral_radius(process: Process, speed: Numbers, gain: Numbers, method: Method) -> Float[AnyArray, " *lanes"]:
    return over_points(partial(radius, process, method), speed, gain)
