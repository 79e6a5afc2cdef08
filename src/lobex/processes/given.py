"""What a user gives for a delay equation: arrays, numbers, or functions of time, checked and made part of a system."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Real

from lobex import _checks
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.systems.coefficients import Coefficient, Constant, Function
from lobex.systems.delays import ConstantDelay, Delay, Varying, WholePeriod
from lobex.systems.terms import Distributed
from lobex.systems.traits import followers

# A number or an array, or a function of (t, speed, gain) in pure JAX, t in s.
Given = Any


class Point(NamedTuple):
    """Where functions are asked: speed, gain, and the period and its breaks at them."""

    speed: Number
    gain: Number
    period: Number
    breaks: Float[AnyArray, " b"]


@pytree(static=("name", "shape"))
class Shaped:
    """A function that returns an array of the right shape, or a number where that has one entry."""

    function: Any
    name: str
    shape: tuple[int, ...]

    def __call__(self, *point: Number) -> Float[Array, "..."]:
        try:
            value = jnp.asarray(self.function(*point))
        except (TypeError, ValueError) as error:
            reason = str(error).splitlines()[0]
            raise ValueError(f"{self.name} cannot be traced by JAX; write it with jax.numpy ({reason})") from None
        if jnp.iscomplexobj(value):
            raise ValueError(f"{self.name} returns complex numbers; return real ones")
        value = value.astype(jnp.result_type(float))
        if jnp.size(value) == 1 and np.prod(self.shape) == 1:
            return value.reshape(self.shape)
        if jnp.shape(value) != self.shape:
            raise ValueError(f"{self.name} returns the shape {jnp.shape(value)}; return {self.shape}")
        return value


def coefficient_at(function: Callable[..., Any], point: Point) -> Coefficient:
    """What a function is at a point: a constant one where it does not follow the time."""
    if _follows_time(function, point):
        return Function(function, point.speed, point.gain, point.period, point.breaks)
    return Constant(function(jnp.zeros_like(point.period), point.speed, point.gain))


def forcing_at(given: Given, size: int, point: Point) -> Coefficient:
    """Forces (e,) as a coefficient of one column."""
    if callable(given):
        return coefficient_at(jax.tree_util.Partial(_column, Shaped(given, "forcing", (size,))), point)
    return Constant(jnp.asarray(given)[:, None])


def distributed_at(
    name: str, given: tuple[Given, Any], nodes: int, shape: tuple[int, int], point: Point
) -> Distributed:
    """A distributed delay at a point."""
    kernel, ends = given
    start, stop = (
        Shaped(end, f"an end of {name}", ())(point.speed, point.gain) if callable(end) else end for end in ends
    )
    made = (_spread, Shaped(kernel, name, shape), point) if callable(kernel) else (_even, jnp.asarray(kernel))
    return Distributed(jax.tree_util.Partial(*made), start, stop, nodes)


def _spread(kernel: Shaped, point: Point, delay: Number, weight: Number) -> Coefficient:
    return coefficient_at(jax.tree_util.Partial(_weighted, kernel, delay, weight), point)


def _weighted(kernel: Shaped, delay: Number, weight: Number, *point: Number) -> Float[AnyArray, "e r"]:
    return weight * kernel(delay, *point)


def _even(matrix: Real[AnyArray, "e r"], delay: Number, weight: Number) -> Coefficient:
    return Constant(weight * matrix)


def by_gain(function: Shaped, point: Point) -> Coefficient:
    """Of a function that does not follow the time, what it is more than without gain."""
    start, none = jnp.zeros_like(point.period), jnp.zeros_like(point.gain)

    def at(gain: Number) -> Float[Array, "e r"]:
        return function(start, point.speed, gain)

    def slope(gain: Number) -> Float[Array, "e r"]:
        return jax.jvp(at, (gain,), (jnp.ones_like(gain),))[1]

    # Proportional to rounding, where a difference would lose digits.
    if not any(followers(jax.make_jaxpr(slope)(_number()).jaxpr)):
        return Constant(point.gain * slope(none))
    return Constant(at(point.gain) - at(none))


def delay_at(name: str, delay: Given, point: Point) -> Delay:
    """A delay at a point."""
    if delay is None:
        return WholePeriod()
    if not callable(delay):
        return ConstantDelay(delay)
    function = Shaped(delay, name, ())
    if _follows_time(function, point):
        return Varying(function, point.speed, point.gain, point.breaks)
    return ConstantDelay(function(jnp.zeros_like(point.period), point.speed, point.gain))


def period_at(given: Given, speed: Number, gain: Number) -> Number:
    """T, above zero or not."""
    if given is None:
        return 1 / speed
    return Shaped(given, "period", ())(speed, gain) if callable(given) else jnp.asarray(given)


def _number() -> jax.ShapeDtypeStruct:
    return jax.ShapeDtypeStruct((), jnp.result_type(float))


def _column(forces: Shaped, *point: Number) -> Float[Array, "e 1"]:
    return forces(*point)[:, None]


def _follows_time(function: Callable[..., Any], point: Point) -> bool:
    return any(followers(jax.make_jaxpr(lambda t: function(t, point.speed, point.gain))(_number()).jaxpr))


def as_function(given: Any) -> Any:
    """A function as JAX takes it in a pytree."""
    return given if isinstance(given, jax.tree_util.Partial) else jax.tree_util.Partial(given)


def as_matrix(name: str, value: Any) -> Any:
    """A matrix of finite numbers; a number is one of a single entry."""
    numbers = _checks.as_numbers(name, value)
    matrix = jnp.asarray(value) if numbers is None else numbers
    if np.ndim(matrix) == 0:
        matrix = matrix.reshape(1, 1)
    if np.ndim(matrix) != 2 or not np.size(matrix):
        raise ValueError(f"{name} has shape {np.shape(value)}; give a matrix")
    return matrix


def as_coefficient(name: str, given: Given, shape: tuple[int, int]) -> Any:
    """A function, or a matrix of the right shape."""
    if callable(given):
        return as_function(given)
    matrix = as_matrix(name, given)
    if np.shape(matrix) != shape:
        raise ValueError(f"{name} has shape {np.shape(matrix)}; give {shape}")
    return matrix


def as_forces(name: str, given: Given, size: int) -> Any:
    """A function, or a vector of so many forces; a number is one."""
    if callable(given):
        return as_function(given)
    numbers = _checks.as_numbers(name, given)
    vector = jnp.atleast_1d(jnp.asarray(given)) if numbers is None else np.atleast_1d(numbers)
    if np.shape(vector) != (size,):
        raise ValueError(f"{name} has shape {np.shape(given)}; give {(size,)}")
    return vector


def as_duration(name: str, given: Given) -> Any:
    """A function, or a number of seconds above zero."""
    if callable(given):
        return as_function(given)
    _checks.scalar(name, given)
    _checks.positive(name, given, "s")
    return given


def as_each(
    made: Callable[[int, Any, tuple[int, int]], tuple[Any, Any]], name: str, given: Any, shape: tuple[int, int]
) -> tuple[Any, ...]:
    """Of every pair of a list what ``made`` takes it for."""
    if not isinstance(given, tuple | list):
        raise ValueError(f"{name} = {_checks.brief(given)} must be a list of pairs, empty for none")
    return tuple(made(index, pair, shape) for index, pair in enumerate(given))


def as_delayed(index: int, pair: Any, shape: tuple[int, int]) -> tuple[Any, Any]:
    """A matrix and its delay, None for a period."""
    name = f"delayed[{index}]"
    if not isinstance(pair, tuple | list) or len(pair) != 2:
        raise ValueError(f"{name} = {_checks.brief(pair)} must be a pair: a matrix and its delay in s")
    delay = None if pair[1] is None else as_duration(f"the delay of {name}", pair[1])
    return as_coefficient(name, pair[0], shape), delay


def as_distributed(index: int, given: Any, shape: tuple[int, int]) -> tuple[Any, tuple[Any, Any]]:
    """A kernel and the shortest and the longest delay."""
    name = f"distributed[{index}]"
    pair = isinstance(given, tuple | list) and len(given) == 2
    if not pair or not isinstance(given[1], tuple | list) or len(given[1]) != 2:
        raise ValueError(
            f"{name} = {_checks.brief(given)} must be a pair: a kernel, and the shortest and the longest delay in s"
        )
    start, stop = (as_function(end) if callable(end) else end for end in given[1])
    for end in (start, stop):
        if not callable(end):
            _checks.scalar(f"an end of {name}", end)
            _checks.not_negative(f"an end of {name}", end, "s")
    known = not any(callable(end) or _checks.is_traced(end) for end in (start, stop))
    if known and not start < stop:
        raise ValueError(f"{name} reaches from {start:g} to {stop:g} s; give the shorter delay first")
    return as_coefficient(name, given[0], shape), (start, stop)


def as_phases(breaks: Any) -> np.ndarray:
    """Phases of a period."""
    phases = _checks.as_numbers("breaks", breaks)
    if phases is None or phases.ndim != 1 or np.any((phases < 0) | (phases >= 1)):
        raise ValueError(f"breaks = {_checks.brief(breaks)} must be phases t/T from 0 to below 1")
    return phases
