"""Semi-discretization of the monodromy operator by matrix exponentials, (3.16)-(3.23) and (3.29)."""

from dataclasses import replace
from math import factorial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from lobex import _checks
from lobex._pytree import pytree
from lobex._shapes import AnyArray
from lobex.operators.exponential import exponential
from lobex.operators.operator import MonodromyOperator, in_form
from lobex.systems.delays import Delay, WholePeriod
from lobex.systems.mesh import pieces_of
from lobex.systems.system import DelaySystem, dense_outputs

# The polynomial through samples at 0, 1, … as powers over factorials: rows are powers, columns samples.
_THROUGH = {
    1: np.array([[1.0, 0.0], [-1.0, 1.0]]),
    2: np.array([[1.0, 0.0, 0.0], [-1.5, 2.0, -0.5], [1.0, -2.0, 1.0]]),
}
_MOST_STEPS = 5000
# A loop over so few stretches is written out.
_FEW = 4
# Of a step, what rounding may add to a delay.
_ROUNDING = 1e-6


@pytree(static=("steps", "order", "full"))
class SemiDiscretization:
    """Steps with averaged coefficients and an interpolated delay, each solved exactly.

    Second order in the step for every order on periodic coefficients, since these are averaged. A delay need be no
    whole number of steps: what it brings is a polynomial through the samples about it (Insperger and Stépán, 2011,
    ch. 3). One that varies is held over each step at its value in the middle, which is of second order as well, but of
    first order where it jumps within a step.

    Attributes:
        steps: equal steps k per period.
        order: degree of the delayed output over a step, 0, 1 or 2; 0 takes its value in the middle of the step.
        full: keep the history of the whole state and not only of what is remembered; of systems whose only delay is the
            period.
    """

    steps: int = 40
    order: int = 0
    full: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "steps", _checks.integer("steps", self.steps, 3, _MOST_STEPS))
        _checks.choice("order", self.order, (0, 1, 2))
        _checks.choice("full", self.full, (True, False))

    def operator(self, system: DelaySystem) -> MonodromyOperator:
        """The monodromy operator; its state is (z, w one step ago, w two steps ago, …) as far as delays reach back."""
        return in_form(self._operator, system, self.full)

    def size(self, system: DelaySystem) -> int:
        """N = d + m·(steps that the longest delay reaches back)."""
        remembered = system.state_size if self.full else np.shape(system.recalled)[1]
        return system.state_size + remembered * self._reach(system.longest)

    def finer(self) -> "SemiDiscretization":
        """The same with twice as many steps."""
        return replace(self, steps=2 * self.steps)

    def resolved_radians(self, system: DelaySystem) -> float:
        """Eight steps per wave."""
        return 2 * np.pi * self.steps / 8

    def _reach(self, share: float) -> int:
        """How many steps before its own the oldest sample lies that a delay, as a share of the period, brings.

        The samples are those about the middle of the step, and none is later than now.
        """
        nearest = np.ceil(share * self.steps - _ROUNDING) if self.order == 2 else np.floor(share * self.steps + 0.5)
        return int(max(nearest, self.order, 1))

    def _operator(self, system: DelaySystem) -> MonodromyOperator:
        k, d = self.steps, system.state_size
        output, memory = system.output_matrix(), dense_outputs(system.recalled)
        m, reach = len(memory), self._reach(system.longest)
        identity = jnp.eye(self.size(system), dtype=jnp.result_type(system.blocks))
        start = identity[:d]
        oldest_first = identity[d:].reshape(reach, m, -1)[::-1]
        past = jnp.concatenate([oldest_first, (memory @ start)[None]])
        edges = pieces_of(system)[0].start + jnp.arange(k + 1) / k
        lags = zip(system.delays, system.lags((edges[:-1] + edges[1:]) / 2), strict=True)
        brought = [self._brought(system, delay, lag) for delay, lag in lags]

        def advance(
            z: Float[Array, "d N"], step: tuple[Float[Array, "d d"], Float[Array, "d p m"], Float[Array, "p m N"]]
        ) -> tuple[Float[Array, "d N"], Float[Array, "d N"]]:
            propagator, response, delayed = step
            z = propagator @ z + jnp.einsum("dpr,prn->dn", response, delayed)
            return z, z

        def over(
            state: tuple[Float[Array, "d N"], Float[Array, "back m N"]], steps: Any
        ) -> tuple[tuple[Float[Array, "d N"], Float[Array, "back m N"]], Float[Array, "steps r N"]]:
            z, past = state
            propagators, responses, oldest = steps
            delayed = [self._samples(past, back, len(propagators)) for back in oldest]
            z, states = jax.lax.scan(advance, z, (propagators, responses, jnp.concatenate(delayed, axis=1)))
            outputs = jnp.einsum("rd,kdn->krn", output, states)
            kept = outputs if system.remembered is None else jnp.einsum("md,kdn->kmn", memory, states)
            return (z, jnp.concatenate([past[len(states) :], kept])), outputs

        # As many steps are taken at once as the shortest delay lets be known before.
        stretch = min(self._reach(system.shortest) - max(self.order, 1) + 1, k)
        count, rest = divmod(k, stretch)
        steps = *self._steps(system, edges, brought), tuple(part.oldest for part in brought)
        # The first by itself: products with what is the same at all points of a batch are quicker.
        state, first = over((start, past), jax.tree.map(lambda part: part[:stretch], steps))
        outputs = [(output @ start)[None], first]
        if count > 1:
            many = jax.tree.map(lambda part: part[stretch : k - rest].reshape(-1, stretch, *part.shape[1:]), steps)
            state, others = jax.lax.scan(over, state, many, unroll=count <= _FEW or 1)
            outputs.append(others.reshape(-1, *jnp.shape(first)[1:]))
        if rest:
            state, last = over(state, jax.tree.map(lambda part: part[k - rest :], steps))
            outputs.append(last)
        end, past = state
        # The next state holds w one step ago first; w now is of z itself.
        matrix = jnp.concatenate([end, past[:-1][::-1].reshape(reach * m, -1)])
        weight = jnp.asarray(np.r_[0.5, np.ones(k - 1), 0.5] / k, dtype=matrix.dtype)
        return MonodromyOperator(matrix, edges, weight, jnp.concatenate(outputs))

    def _brought(self, system: DelaySystem, delay: Delay, lag: Float[Array, " k"]) -> "_Brought":
        """The samples that a delay brings to every step."""
        k = self.steps
        if isinstance(delay, WholePeriod):
            return _Brought(None, _polynomials(self.order, 0.0))
        steps = k * lag
        nearest = jnp.ceil(steps - _ROUNDING) if self.order == 2 else jnp.floor(steps + 0.5)
        least, most = self._reach(system.shortest), self._reach(system.longest)
        oldest = jnp.clip(jnp.nan_to_num(nearest), least, most)
        return _Brought(oldest.astype(int), jax.vmap(lambda late: _polynomials(self.order, late))(oldest - steps))

    def _samples(
        self, past: Float[Array, "back m N"], oldest: Int[Array, " count"] | None, count: int
    ) -> Float[Array, "{count} p m N"]:
        """What a delay brings to the next ``count`` steps, (count, samples, m, N)."""
        samples = max(self.order, 1) + 1
        now = len(past) - 1
        if oldest is None:
            first = now - self.steps
            return jnp.stack([past[first + p : first + p + count] for p in range(samples)], axis=1)
        return past[now - oldest[:, None] + jnp.arange(count)[:, None] + jnp.arange(samples)]

    def _steps(
        self, system: DelaySystem, edges: Float[AnyArray, " edges"], brought: list["_Brought"]
    ) -> tuple[Float[Array, "k d d"], Float[Array, "k d p m"]]:
        """Propagators (k, d, d) and the responses to all delayed samples (k, d, samples, m) of all steps."""
        k, d, e = self.steps, system.state_size, system.force_size
        powers = self.order + 1
        step = system.period / k
        drift, inputs, output = system.drift(), system.input_matrix(), system.output_matrix()
        ends = (edges[:1], edges[1:2]) if system.constant else (edges[:-1], edges[1:])
        means = system.mean(*ends)

        def one(
            present: Float[AnyArray, "e r"],
            delayed: tuple[Float[AnyArray, "e m"], ...],
            weights: tuple[Float[AnyArray, "powers p"], ...],
        ) -> tuple[Float[Array, "d d"], Float[Array, "d p m"]]:
            # exp of the augmented matrix has h φ_p(A h) E beside exp(A h) (Al-Mohy and Higham, 2011): unlike
            # (3.18) it needs no inverse of A.
            wide = d + e * powers
            augmented = jnp.zeros((wide, wide), dtype=jnp.result_type(drift))
            augmented = augmented.at[:d, :d].set(step * (drift + inputs @ present @ output))
            augmented = augmented.at[:d, d : d + e].set(step * inputs)
            augmented = augmented.at[d : wide - e, d + e :].set(jnp.eye(e * (powers - 1)))
            solution = exponential(augmented)[:d]
            integrals = solution[:, d:].reshape(d, powers, e)
            each = [jnp.einsum("dpb,ps,bc->dsc", integrals, *part) for part in zip(weights, delayed, strict=True)]
            return solution[:, :d], jnp.concatenate(each, axis=1)

        weights = tuple(part.weights for part in brought)
        axes = 0, 0, tuple(None if np.ndim(part) == 2 else 0 for part in weights)
        propagators, responses = jax.vmap(one, in_axes=axes)(means.present, means.delayed, weights)
        return (
            jnp.broadcast_to(propagators, (k, d, d)),
            jnp.broadcast_to(responses, (k, *jnp.shape(responses)[1:])),
        )


class _Brought(NamedTuple):
    """What a delay brings to every step.

    Attributes:
        oldest: how many steps before its own the oldest of its samples lies, (k,); None for a period.
        weights: powers of the phase over factorials, from the samples, (powers, samples), or (k, powers, samples).
    """

    oldest: Int[Array, " k"] | None
    weights: Float[AnyArray, "*k powers p"]


def _polynomials(order: int, late: Any) -> Float[AnyArray, "powers p"]:
    """What a delay brings over a step as powers of the step's phase over factorials, from samples, (powers, samples).

    The step begins ``late`` steps after the oldest sample. Order 0 is the value in the middle of a straight line, w_a
    and w_b of (3.17); orders 1 and 2 are Lagrange polynomials (Insperger and Stépán, 2011, ch. 3).
    """
    late = late + 0.5 * (order == 0)
    through = _THROUGH[max(order, 1)]
    # Taylor's shift.
    shift = sum(
        (late**p / factorial(p) * np.eye(len(through), k=p) for p in range(1, len(through))), np.eye(len(through))
    )
    return (shift @ through)[: order + 1]
