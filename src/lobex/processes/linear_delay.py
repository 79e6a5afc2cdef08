"""Anybody's own linear delay equation, from arrays and functions of time."""

from collections.abc import Sequence
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from lobex import _checks
from lobex._float64 import in_float64
from lobex._pytree import pytree
from lobex.processes.process import check_point
from lobex.processes.quantity import PLAIN_GAIN, SPEED_UNITS, Quantity
from lobex.systems.coefficients import Coefficient, Constant, Function
from lobex.systems.delays import ConstantDelay, Delay, Varying, WholePeriod
from lobex.systems.system import DelaySystem
from lobex.systems.terms import Delayed, Present, Term

Array = Any
# A number or an array, or a function of (t, speed, gain) in pure JAX, t in s.
Given = Any

# Parts of the period whose means make the mean that is taken into the structure.
_PARTS = 4


@pytree(static=("delay_range", "speed_unit"))
class LinearDelay:
    """ẋ(t) = A x(t) + E [P(t) C x(t) + Σ B_k(t) C x(t − τ_k(t))], with all of it repeating after a period T.

    P, B_k and τ_k are arrays or numbers, or functions of (t, speed, gain) in pure JAX that return one: t in s, from 0
    to T. With E and C left out, P and B_k are matrices (d, d). Numbers within a function that derivatives are wanted of
    are handed to it by ``jax.tree_util.Partial(function, numbers)``, called as function(numbers, t, speed, gain).
    ``second_order`` takes M q̈ + C q̇ + K(t) q instead.

    Attributes:
        drift: A, (d, d), 1/s.
        delayed: pairs of B_k, (e, r), and τ_k in s; None for a delay of one period.
        present: P, (e, r), or None.
        period: T in s, as a number or a function of (speed, gain). None for 1/speed.
        breaks: phases t/T in [0, 1) at which a function jumps.
        inputs: E, (d, e): where the forces act. None for the identity.
        outputs: C, (r, d): what they see. None for the identity.
        delay_range: the shortest and the longest delay in periods, whatever speed and gain. Found where all delays are
            periods, or numbers as the period is; to be given where functions decide. A longer delay makes NaN.
        speed_unit: "Hz" or "rpm", in which speeds are drawn, or "1" where they have no unit.

    Raises:
        ValueError: for arrays of a wrong shape or that are not finite, delays and periods that are not above zero,
            breaks outside a period, delays without a range; and, when a system is asked for, for functions that cannot
            be traced or return a wrong shape.
    """

    drift: Array
    delayed: Sequence[tuple[Given, Given]] = ()
    present: Given = None
    period: Given = None
    breaks: Array = ()
    inputs: Array | None = None
    outputs: Array | None = None
    delay_range: tuple[float, float] | None = None
    speed_unit: str = "1"

    gain: ClassVar[Quantity] = PLAIN_GAIN

    def __post_init__(self) -> None:
        drift = _matrix("drift", self.drift)
        d = np.shape(drift)[0]
        if np.shape(drift) != (d, d):
            raise ValueError(f"drift has shape {np.shape(drift)}; give a square matrix (d, d)")
        inputs = None if self.inputs is None else _matrix("inputs", self.inputs)
        outputs = None if self.outputs is None else _matrix("outputs", self.outputs)
        if (inputs is not None and np.shape(inputs)[0] != d) or (outputs is not None and np.shape(outputs)[1] != d):
            shapes = ["(none)" if given is None else np.shape(given) for given in (inputs, outputs)]
            raise ValueError(
                f"inputs has shape {shapes[0]} and outputs {shapes[1]} where drift has ({d}, {d}); "
                f"give ({d}, e) and (r, {d})"
            )
        forces = (d if inputs is None else np.shape(inputs)[1]), (d if outputs is None else np.shape(outputs)[0])
        _checks.choice("speed_unit", self.speed_unit, SPEED_UNITS)
        made = {
            "drift": drift,
            "inputs": inputs,
            "outputs": outputs,
            "present": None if self.present is None else _coefficient("present", self.present, forces),
            "delayed": tuple(_pair(index, pair, forces) for index, pair in enumerate(self.delayed)),
            "period": None if self.period is None else _duration("period", self.period),
            "breaks": _phases(self.breaks),
        }
        for name, value in made.items():
            object.__setattr__(self, name, value)
        object.__setattr__(self, "delay_range", self._range())

    @classmethod
    def second_order(
        cls,
        mass: Array,
        damping: Array,
        stiffness: Given,
        delayed: Sequence[tuple[Given, Given]] = (),
        **others: Any,
    ) -> "LinearDelay":
        """M q̈ + C q̇ + K(t) q = Σ B_k(t) q(t − τ_k(t)), with p coordinates q; the state is (q, q̇).

        Args:
            mass: M, (p, p), or a number.
            damping: C, (p, p), or a number.
            stiffness: K, (p, p), or a number, or a function of (t, speed, gain) that returns one.
            delayed: pairs of B_k, (p, p) or a number, and τ_k, as of the class.
            others: period, breaks, delay_range and speed_unit, as of the class.
        """
        masses, dampings = (_matrix(*pair) for pair in (("mass", mass), ("damping", damping)))
        p = len(masses)
        if np.shape(masses) != (p, p) or np.shape(dampings) != (p, p):
            raise ValueError(f"mass has shape {np.shape(masses)}, damping {np.shape(dampings)}; give two of (p, p)")
        if not _checks.is_traced(masses) and np.linalg.matrix_rank(masses) < p:
            raise ValueError("mass is singular; leave out the coordinates without mass")
        none, unit = jnp.zeros((p, p)), jnp.eye(p)
        with jax.enable_x64(True):
            inverse = jnp.linalg.inv(masses)
            drift = jnp.block([[none, unit], [none, -inverse @ dampings]])
            inputs, outputs = jnp.concatenate([none, inverse]), jnp.concatenate([unit, none], axis=1)
        held = (
            jax.tree_util.Partial(_pulling, _function(stiffness))
            if callable(stiffness)
            else -_matrix("stiffness", stiffness)
        )
        return cls(drift=drift, delayed=delayed, present=held, inputs=inputs, outputs=outputs, **others)

    @in_float64
    def system(self, speed: Array, gain: Array) -> DelaySystem:
        """The delay system at one speed and one gain."""
        check_point(self, speed, gain)
        period = 1 / speed if self.period is None else self.period
        period = period(speed, gain) if callable(period) else period
        drift = jnp.asarray(self.drift)
        d = jnp.shape(drift)[0]
        inputs = jnp.eye(d) if self.inputs is None else jnp.asarray(self.inputs)
        outputs = jnp.eye(d) if self.outputs is None else jnp.asarray(self.outputs)
        shape = jnp.shape(inputs)[1], jnp.shape(outputs)[0]

        def at_point(name: str, given: Given, gain: Array) -> Coefficient:
            if not callable(given):
                return Constant(jnp.asarray(given))
            return Function(_Shaped(given, name, shape), speed, gain, period, self.breaks)

        terms: list[Term] = []
        if self.present is not None:
            acting = at_point("present", self.present, gain)
            edges = np.arange(_PARTS + 1) / _PARTS
            # The structure is solved exactly, so as much is made a part of it as does not follow the gain.
            mean = jnp.mean(at_point("present", self.present, jnp.zeros_like(gain)).mean(edges[:-1], edges[1:]), axis=0)
            if not acting.constant:
                # Whatever is moved, the sum is the same: so are derivatives.
                mean = jax.lax.stop_gradient(jnp.where(jnp.isfinite(mean), mean, 0.0))
                terms.append(Present(_Less(acting, mean)))
            drift = drift + inputs @ mean @ outputs
        for index, (matrix, delay) in enumerate(self.delayed):
            terms.append(Delayed(at_point(f"delayed[{index}]", matrix, gain), _delay(delay, speed, gain)))
        shortest, longest = self.delay_range or (1.0, 1.0)
        return DelaySystem(
            blocks=drift[None],
            inputs=inputs[None],
            outputs=outputs[None],
            period=period,
            terms=tuple(terms) or (Delayed(Constant(jnp.zeros(shape))),),
            longest=longest,
            shortest=shortest,
        )

    def _range(self) -> tuple[float, float] | None:
        """The shortest and longest delay in periods; None where every delay is a period."""
        delays = [delay for _, delay in self.delayed if delay is not None]
        whole = [1.0] * (len(delays) < len(self.delayed))
        if self.delay_range is not None:
            numbers = _checks.as_numbers("delay_range", self.delay_range)
            if numbers is None or numbers.shape != (2,) or not 0 <= numbers[0] <= numbers[1] or numbers[1] <= 0:
                raise ValueError(
                    f"delay_range = {self.delay_range!r} must be two numbers of periods, the shortest first"
                )
            return float(min([numbers[0], *whole])), float(max([numbers[1], *whole]))
        if not delays:
            return None
        numbers = [*delays, self.period]
        if any(number is None or callable(number) or _checks.is_traced(number) for number in numbers):
            raise ValueError(
                "delay_range is needed where delays or the period follow speed, gain or time; give the shortest and "
                "the longest delay in periods"
            )
        shares = [float(delay) / float(self.period) for delay in delays]
        return min(shares + whole), max(shares + whole)


@pytree(static=("name", "shape"))
class _Shaped:
    """A function that returns a matrix of the right shape, or a number where that has one entry."""

    function: Any
    name: str
    shape: tuple[int, int]

    def __call__(self, *point: Array) -> Array:
        try:
            value = jnp.asarray(self.function(*point), dtype=jnp.result_type(float))
        except jax.errors.JAXTypeError as error:
            reason = str(error).splitlines()[0]
            raise ValueError(f"{self.name} cannot be traced by JAX; write it with jax.numpy ({reason})") from None
        if jnp.size(value) == 1 and self.shape == (1, 1):
            return value.reshape(1, 1)
        if jnp.shape(value) != self.shape:
            raise ValueError(f"{self.name} returns the shape {jnp.shape(value)}; return {self.shape}")
        return value


@pytree()
class _Less:
    """A coefficient without its mean."""

    whole: Coefficient
    part: Array

    constant: ClassVar[bool] = False

    def pieces(self) -> Any:
        return self.whole.pieces()

    def at(self, phase: Array) -> Array:
        return self.whole.at(phase) - self.part

    def within(self, inside: Array, phase: Array) -> Array:
        return self.whole.within(inside, phase) - self.part

    def mean(self, start: Array, stop: Array) -> Array:
        return self.whole.mean(start, stop) - self.part


def _pulling(stiffness: Any, t: Array, speed: Array, gain: Array) -> Array:
    return -jnp.atleast_2d(stiffness(t, speed, gain))


def _delay(delay: Given, speed: Array, gain: Array) -> Delay:
    if delay is None:
        return WholePeriod()
    if not callable(delay):
        return ConstantDelay(delay)
    return Varying(delay, speed, gain)


def _function(given: Any) -> Any:
    """A function as JAX takes it in a pytree."""
    return given if isinstance(given, jax.tree_util.Partial) else jax.tree_util.Partial(given)


def _matrix(name: str, value: Any) -> Any:
    numbers = _checks.as_numbers(name, value)
    matrix = jnp.asarray(value) if numbers is None else numbers
    if np.ndim(matrix) == 0:
        matrix = matrix.reshape(1, 1)
    if np.ndim(matrix) != 2 or not np.size(matrix):
        raise ValueError(f"{name} has shape {np.shape(value)}; give a matrix")
    return matrix


def _coefficient(name: str, given: Given, shape: tuple[int, int]) -> Any:
    if callable(given):
        return _function(given)
    matrix = _matrix(name, given)
    if np.shape(matrix) != shape:
        raise ValueError(f"{name} has shape {np.shape(matrix)}; give {shape}")
    return matrix


def _duration(name: str, given: Given) -> Any:
    if callable(given):
        return _function(given)
    _checks.scalar(name, given)
    _checks.positive(name, given, "s")
    return given


def _pair(index: int, pair: Any, shape: tuple[int, int]) -> tuple[Any, Any]:
    name = f"delayed[{index}]"
    if not isinstance(pair, tuple | list) or len(pair) != 2:
        raise ValueError(f"{name} = {_checks.brief(pair)} must be a pair: a matrix and its delay in s")
    delay = None if pair[1] is None else _duration(f"the delay of {name}", pair[1])
    return _coefficient(name, pair[0], shape), delay


def _phases(breaks: Any) -> np.ndarray:
    phases = _checks.as_numbers("breaks", breaks)
    if phases is None or phases.ndim != 1 or np.any((phases < 0) | (phases >= 1)):
        raise ValueError(f"breaks = {_checks.brief(breaks)} must be phases t/T from 0 to below 1")
    return phases
