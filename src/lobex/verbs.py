"""The verbs at points: monodromy operator, multipliers and spectral radius of a process."""

from functools import partial
from typing import Any

import jax
import numpy as np

from lobex import _checks
from lobex._broadcast import over_points
from lobex._float64 import in_float64
from lobex.floquet.dense import all_multipliers, largest_modulus
from lobex.operators.chebyshev import Chebyshev
from lobex.operators.operator import Method
from lobex.processes.plausible import warn_of_implausible
from lobex.processes.process import Process, check_gain, check_process, check_speed

Array = Any

DEFAULT_METHOD = Chebyshev(nodes=40)


def monodromy(process: Process, speed: Array, gain: Array, method: Method = DEFAULT_METHOD) -> Array:
    """The monodromy operator U of a process: the state one delay later is U times the state.

    Args:
        process: a process, such as ``Rub(modes)``.
        speed: speeds in Hz (revolutions per second), any shape.
        gain: gains, broadcast against ``speed``: K_e in N/m or depth of cut in m.
        method: ``Chebyshev(…)`` or ``SemiDiscretization(…)``.

    Returns:
        Array of shape (broadcast shape of speed and gain, N, N). Of concrete arguments a float64 NumPy
        array; under ``jit``, ``grad`` or ``vmap`` a JAX array that follows the precision of its inputs.

    Raises:
        ValueError: for NaN, infinite or non-positive speeds and for gains that the process cannot have.

    Warns:
        LobexWarning: for numbers that can hardly be meant: speeds in rpm, damping in per cent, depths in mm.
    """
    speed, gain = _checked(process, speed, gain, method)
    return _monodromy(process, speed, gain, method)


def multipliers(process: Process, speed: Array, gain: Array, method: Method = DEFAULT_METHOD) -> Array:
    """The Floquet multipliers, complex, largest modulus first: shape (broadcast shape, N).

    Arguments, precision, errors and warnings as for ``monodromy``.
    """
    speed, gain = _checked(process, speed, gain, method)
    return _multipliers(process, speed, gain, method)


def spectral_radius(process: Process, speed: Array, gain: Array, method: Method = DEFAULT_METHOD) -> Array:
    """max|μ|: the motion dies out below 1 and grows above. Shape: that of speed and gain, broadcast.

    Differentiable with respect to speed, gain and every number in ``process``. Arguments, precision,
    errors and warnings as for ``monodromy``.
    """
    speed, gain = _checked(process, speed, gain, method)
    return _spectral_radius(process, speed, gain, method)


def _checked(process: Any, speed: Any, gain: Any, method: Any) -> tuple[Array, Array]:
    check_process(process)
    check_method(method)
    check_speed(process, speed)
    check_gain(process, gain)
    speed, gain = (np.asarray(value) if isinstance(value, list | tuple) else value for value in (speed, gain))
    try:
        np.broadcast_shapes(np.shape(speed), np.shape(gain))
    except ValueError:
        raise ValueError(
            f"gain has shape {np.shape(gain)} and speed {np.shape(speed)}; give shapes that broadcast"
        ) from None
    warn_of_implausible(process, speed, gain)
    return speed, gain


def check_method(method: Any) -> None:
    """Require something that makes a monodromy operator."""
    if isinstance(method, type) or not callable(getattr(method, "operator", None)):
        raise ValueError(
            f"method = {_checks.brief(method)} is no method; give such as lobex.Duhamel() or lobex.Chebyshev()"
        )


def _matrix(process: Process, method: Method, speed: Array, gain: Array) -> Array:
    return method.operator(process.system(speed, gain)).matrix


@in_float64
@jax.jit
def _monodromy(process: Process, speed: Array, gain: Array, method: Method) -> Array:
    return over_points(partial(_matrix, process, method), speed, gain)


@in_float64
@jax.jit
def _multipliers(process: Process, speed: Array, gain: Array, method: Method) -> Array:
    return over_points(lambda s, g: all_multipliers(_matrix(process, method, s, g)), speed, gain)


@in_float64
@jax.jit
def _spectral_radius(process: Process, speed: Array, gain: Array, method: Method) -> Array:
    return over_points(lambda s, g: largest_modulus(_matrix(process, method, s, g)), speed, gain)
