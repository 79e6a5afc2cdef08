"""Anybody's own linear delay equation, from arrays and functions of time."""

from collections.abc import Sequence
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Real

from lobex import _checks
from lobex._float64 import in_float64
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.processes.given import (
    Given,
    Point,
    Shaped,
    as_coefficient,
    as_delayed,
    as_distributed,
    as_duration,
    as_each,
    as_forces,
    as_matrix,
    as_phases,
    by_gain,
    coefficient_at,
    delay_at,
    distributed_at,
    forcing_at,
    period_at,
)
from lobex.processes.process import check_point
from lobex.processes.quantity import PLAIN_GAIN, SPEED_UNITS, Quantity
from lobex.systems.coefficients import Coefficient, Constant, gauss_nodes
from lobex.systems.system import DelaySystem
from lobex.systems.terms import Delayed, Forcing, Present, Term

# Point delays of a distributed one: each is looked up by itself.
_MOST_NODES = 100
# Parts of the period whose means make the mean that is taken into the structure.
_PARTS = 4


@pytree(static=("delay_range", "speed_unit", "distributed_nodes"))
class LinearDelay:
    """ẋ = A x + E [P(t) y(t) + Σ B_k(t) y(t − τ_k(t)) + Σ ∫ B(s, t) y(t − s) ds + g(t)], y = C x, all of period T.

    P, B_k, g and τ_k are arrays or numbers, or functions of (t, speed, gain) in pure JAX that return one: t in s, from
    0 to T. With E and C left out, P and B_k are matrices (d, d). Numbers within a function that derivatives are wanted
    of are handed to it by ``jax.tree_util.Partial(function, numbers)``, called as function(numbers, t, speed, gain).
    ``second_order`` takes M q̈ + C q̇ + K(t) q instead.

    Attributes:
        drift: A, (d, d), 1/s.
        delayed: pairs of B_k, (e, r), and τ_k in s; None for a delay of one period.
        present: P, (e, r), or None.
        period: T in s, as a number or a function of (speed, gain). None for 1/speed.
        breaks: phases t/T in [0, 1) at which a function jumps, that of a delay included.
        inputs: E, (d, e): where the forces act. None for the identity.
        outputs: C, (r, d): what they see. None for the identity.
        delay_range: the shortest and the longest delay in periods, whatever speed and gain. Found where all delays are
            periods, or numbers as the period is; to be given where functions decide. A delay that leaves it is refused
            at the ends of the speeds and gains that are asked for, and makes NaN between them.
        speed_unit: "Hz" or "rpm", in which speeds are drawn, or "1" where they have no unit.
        distributed: pairs of a kernel B, (e, r) or a function of (s, t, speed, gain) that returns one, and the shortest
            and the longest delay in s, as numbers or functions of (speed, gain).
        distributed_nodes: point delays for each of these, by Gauss' rule, of which ``error`` knows nothing: exact for
            what is a polynomial of degree 2·nodes − 1 in s; take more to see whether it matters.
        forcing: g, (e,), or None. It has no part in multipliers and limits; ``orbit`` is the motion that it makes.

    Raises:
        ValueError: for arrays of a wrong shape or that are not finite, delays and periods that are not above zero,
            breaks outside a period, delays without a range; and, when a system is asked for, for functions that cannot
            be traced, return a wrong shape, or jump where no break is. Delays and periods that functions return are
            looked at by every verb.
    """

    drift: Real[AnyArray, "d d"]
    delayed: Sequence[tuple[Given, Given]] = ()
    present: Given = None
    period: Given = None
    breaks: Any = ()
    inputs: Real[AnyArray, "d e"] | None = None
    outputs: Real[AnyArray, "r d"] | None = None
    delay_range: tuple[float, float] | None = None
    speed_unit: str = "1"
    forcing: Given = None
    distributed: Sequence[tuple[Given, tuple[Given, Given]]] = ()
    distributed_nodes: int = 10

    gain: ClassVar[Quantity] = PLAIN_GAIN

    def __post_init__(self) -> None:
        drift = as_matrix("drift", self.drift)
        d = np.shape(drift)[0]
        if np.shape(drift) != (d, d):
            raise ValueError(f"drift has shape {np.shape(drift)}; give a square matrix (d, d)")
        inputs = None if self.inputs is None else as_matrix("inputs", self.inputs)
        outputs = None if self.outputs is None else as_matrix("outputs", self.outputs)
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
            "present": None if self.present is None else as_coefficient("present", self.present, forces),
            "delayed": as_each(as_delayed, "delayed", self.delayed, forces),
            "distributed": as_each(as_distributed, "distributed", self.distributed, forces),
            "distributed_nodes": _checks.integer("distributed_nodes", self.distributed_nodes, 1, _MOST_NODES),
            "forcing": None if self.forcing is None else as_forces("forcing", self.forcing, forces[0]),
            "period": None if self.period is None else as_duration("period", self.period),
            "breaks": as_phases(self.breaks),
        }
        for name, value in made.items():
            object.__setattr__(self, name, value)
        object.__setattr__(self, "delay_range", self._range())

    @classmethod
    def second_order(
        cls,
        mass: Any,
        damping: Any,
        stiffness: Given,
        delayed: Sequence[tuple[Given, Given]] = (),
        **others: Any,
    ) -> "LinearDelay":
        """M q̈ + C q̇ + K(t) q = Σ B_k(t) q(t − τ_k(t)) + Σ ∫ B(s, t) q(t − s) ds + g(t), with p coordinates q.

        The state is (q, q̇/ω), ω² = |tr M⁻¹K|/p with K at t = 0, a speed of 1 and no gain: numbers of one size, of which
        errors can be told.

        Args:
            mass: M, (p, p), or a number.
            damping: C, (p, p), or a number.
            stiffness: K, (p, p), or a number, or a function of (t, speed, gain) that returns one.
            delayed: pairs of B_k, (p, p) or a number, and τ_k, as of the class.
            others: distributed, forcing, (p,), period, breaks, delay_range and speed_unit, as of the class.
        """
        masses, dampings = (as_matrix(*pair) for pair in (("mass", mass), ("damping", damping)))
        p = len(masses)
        if np.shape(masses) != (p, p) or np.shape(dampings) != (p, p):
            raise ValueError(f"mass has shape {np.shape(masses)}, damping {np.shape(dampings)}; give two of (p, p)")
        if not _checks.is_traced(masses) and np.linalg.matrix_rank(masses) < p:
            raise ValueError("mass is singular; leave out the coordinates without mass")
        pull = as_coefficient("stiffness", stiffness, (p, p))
        held = jax.tree_util.Partial(_pulling, pull) if callable(pull) else -pull
        none, unit = jnp.zeros((p, p)), jnp.eye(p)
        with jax.enable_x64(True):
            inverse = jnp.linalg.inv(masses)
            turning = _turning(inverse @ (Shaped(held, "stiffness", (p, p))(0.0, 1.0, 0.0) if callable(held) else held))
            drift = jnp.block([[none, turning * unit], [none, -inverse @ dampings]])
            inputs, outputs = jnp.concatenate([none, inverse / turning]), jnp.concatenate([unit, none], axis=1)
        return cls(drift=drift, delayed=delayed, present=held, inputs=inputs, outputs=outputs, **others)

    @in_float64
    def system(self, speed: Number, gain: Number) -> DelaySystem:
        """The delay system at one speed and one gain."""
        check_point(self, speed, gain)
        period = period_at(self.period, speed, gain)
        point = Point(speed, gain, period, self.breaks)
        drift = jnp.asarray(self.drift)
        if callable(self.period):
            # No number is had of a period that is none.
            drift = jnp.where(period > 0, drift, jnp.nan)
        d = jnp.shape(drift)[0]
        inputs = jnp.eye(d) if self.inputs is None else jnp.asarray(self.inputs)
        outputs = jnp.eye(d) if self.outputs is None else jnp.asarray(self.outputs)
        shape = jnp.shape(inputs)[1], jnp.shape(outputs)[0]
        within = self.delay_range or (1.0, 1.0)
        terms: list[Term] = []
        if self.present is not None:
            mean, rest = _present(self.present, shape, point)
            drift = drift + inputs @ mean @ outputs
            terms += [] if rest is None else [Present(rest)]
        for index, (matrix, delay) in enumerate(self.delayed):
            name = f"delayed[{index}]"
            coefficient = (
                coefficient_at(Shaped(matrix, name, shape), point)
                if callable(matrix)
                else Constant(jnp.asarray(matrix))
            )
            terms.append(Delayed(coefficient, delay_at(f"the delay of {name}", delay, point)))
        for index, one in enumerate(self.distributed):
            terms.append(distributed_at(f"distributed[{index}]", one, self.distributed_nodes, shape, point))
        terms = terms or [Delayed(Constant(jnp.zeros(shape)))]
        if self.forcing is not None:
            terms.append(Forcing(forcing_at(self.forcing, shape[0], point)))
        return DelaySystem(
            blocks=drift[None],
            inputs=inputs[None],
            outputs=outputs[None],
            period=period,
            terms=tuple(terms),
            longest=within[1],
            shortest=within[0],
        )

    def _range(self) -> tuple[float, float] | None:
        """The shortest and longest delay in periods; None where every delay is a period."""
        points = [delay for _, delay in self.delayed if delay is not None]
        whole = [1.0] * (len(points) < len(self.delayed))
        windows = [end for _, window in self.distributed for end in window]
        if self.delay_range is not None:
            numbers = _checks.as_numbers("delay_range", self.delay_range)
            if numbers is None or numbers.shape != (2,) or not 0 <= numbers[0] <= numbers[1] or numbers[1] <= 0:
                raise ValueError(
                    f"delay_range = {self.delay_range!r} must be two numbers of periods, the shortest first"
                )
            return float(min([numbers[0], *whole])), float(max([numbers[1], *whole]))
        if not points and not windows:
            return None
        numbers = [*points, *windows, self.period]
        if any(number is None or callable(number) or _checks.is_traced(number) for number in numbers):
            raise ValueError(
                "delay_range is needed where delays or the period follow speed, gain or time; give the shortest and "
                "the longest delay in periods"
            )
        places = gauss_nodes(self.distributed_nodes)[0][[0, -1]]
        spread = [start + (stop - start) * place for _, (start, stop) in self.distributed for place in places]
        shares = [float(delay) / float(self.period) for delay in (*points, *spread)]
        return min(shares + whole), max(shares + whole)


@pytree()
class _Less:
    """A coefficient without its mean."""

    whole: Coefficient
    part: Float[Array, "e r"]

    constant: ClassVar[bool] = False

    @property
    def breaks(self) -> Any:
        """Those of the whole, by which coefficients that share them are known."""
        return getattr(self.whole, "breaks", self)

    def pieces(self) -> Any:
        return self.whole.pieces()

    def at(self, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        return self.whole.at(phase) - self.part

    def within(self, inside: Number, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        return self.whole.within(inside, phase) - self.part

    def mean(self, start: Float[AnyArray, " k"], stop: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        return self.whole.mean(start, stop) - self.part


def _turning(pull: Float[Array, "n n"]) -> Float[Array, ""]:
    """The root mean square angular frequency of q̈ = pull q, 1 where that is none."""
    turning = jnp.sqrt(jnp.abs(jnp.trace(pull)) / len(pull))
    return jax.lax.stop_gradient(jnp.where(jnp.isfinite(turning) & (turning > 0), turning, 1.0))


def _pulling(stiffness: Any, t: Number, speed: Number, gain: Number) -> Float[Array, "n n"]:
    return -jnp.atleast_2d(stiffness(t, speed, gain))


def _present(given: Given, shape: tuple[int, int], point: Point) -> tuple[Float[Array, "e r"], Coefficient | None]:
    """What of P does not follow the gain, as a mean, and the rest.

    The structure is solved exactly, so as much is made a part of it as can be.
    """
    if not callable(given):
        return jnp.asarray(given), None
    function = Shaped(given, "present", shape)
    without = coefficient_at(function, point._replace(gain=jnp.zeros_like(point.gain)))
    whole = coefficient_at(function, point)
    if whole.constant:
        return without.at(jnp.zeros(1))[0], by_gain(function, point)
    edges = np.arange(_PARTS + 1) / _PARTS
    mean = jnp.mean(without.mean(edges[:-1], edges[1:]), axis=0)
    # Whatever is moved, the sum is the same: so are derivatives.
    mean = jax.lax.stop_gradient(jnp.where(jnp.isfinite(mean), mean, 0.0))
    return mean, _Less(whole, mean)
