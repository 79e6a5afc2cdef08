"""Semi-discretization of the monodromy operator by matrix exponentials, (3.16)-(3.23) and (3.29)."""

from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from lobex import _checks
from lobex._pytree import pytree
from lobex.operators.exponential import exponential
from lobex.operators.operator import MonodromyOperator, in_form
from lobex.systems.mesh import pieces_of
from lobex.systems.system import DelaySystem

Array = Any

_MOST_STEPS = 5000

# The delayed output over a step as a polynomial in the step's phase: rows are powers over factorials, columns
# the samples at the step's start, its end, and one step on. Order 0 is w_a = w_b = 1/2 of (3.17), orders 1
# and 2 are Lagrange polynomials (Insperger and Stépán, 2011, ch. 3).
_DELAYED = {
    0: np.array([[0.5, 0.5]]),
    1: np.array([[1.0, 0.0], [-1.0, 1.0]]),
    2: np.array([[1.0, 0.0, 0.0], [-1.5, 2.0, -0.5], [1.0, -2.0, 1.0]]),
}


@pytree(static=("steps", "order", "full"))
class SemiDiscretization:
    """Steps with averaged coefficients and an interpolated delay, each solved exactly.

    Second order in the step for every order on periodic coefficients, since these are averaged.

    Attributes:
        steps: equal steps k per delay.
        order: degree of the delayed output over a step, 0, 1 or 2; 0 takes the mean of its ends.
        full: keep the history of the whole state and not only of the output.
    """

    steps: int = 40
    order: int = 0
    full: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "steps", _checks.integer("steps", self.steps, 3, _MOST_STEPS))
        _checks.choice("order", self.order, (0, 1, 2))
        _checks.choice("full", self.full, (True, False))

    def operator(self, system: DelaySystem) -> MonodromyOperator:
        """The monodromy operator; its state is (z, y one step ago, …, y k steps ago)."""
        return in_form(self._operator, system, self.full)

    def size(self, system: DelaySystem) -> int:
        """N = d + r·steps."""
        outputs = system.state_size if self.full else system.output_size
        return system.state_size + outputs * self.steps

    def finer(self) -> "SemiDiscretization":
        """The same with twice as many steps."""
        return replace(self, steps=2 * self.steps)

    def resolved_radians(self, system: DelaySystem) -> float:
        """Eight steps per wave."""
        return 2 * np.pi * self.steps / 8

    def _operator(self, system: DelaySystem) -> MonodromyOperator:
        k, state, r = self.steps, system.state_size, system.output_size
        output = system.output_matrix()
        identity = jnp.eye(self.size(system), dtype=jnp.result_type(system.blocks))
        start = identity[:state]
        oldest_first = identity[state:].reshape(k, r, -1)[::-1]
        history = jnp.concatenate([oldest_first, (output @ start)[None]])
        origin = pieces_of(system)[0].start
        edges = origin + jnp.arange(k + 1) / k
        propagators, responses = self._steps(system, edges)

        def advance(z: Array, step: tuple[Array, Array, Array]) -> tuple[Array, Array]:
            propagator, response, delayed = step
            z = propagator @ z + jnp.einsum("dpr,prn->dn", response, delayed)
            return z, z

        samples = np.shape(_DELAYED[self.order])[1]
        if samples == 3:
            # The last step reaches one step beyond the delay, to the output after the first step.
            first = advance(start, (propagators[0], responses[0], history[:3]))[0]
            history = jnp.concatenate([history, (output @ first)[None]])
        delayed = jnp.stack([history[p : p + k] for p in range(samples)], axis=1)
        end, states = jax.lax.scan(advance, start, (propagators, responses, delayed))
        outputs = jnp.einsum("rd,kdn->krn", output, states)
        # The next state holds y one step ago first; y now is z itself.
        kept = jnp.concatenate([(output @ start)[None], outputs[:-1]])[::-1]
        matrix = jnp.concatenate([end, kept.reshape(k * r, -1)])
        motion = jnp.concatenate([(output @ start)[None], outputs])
        weight = jnp.asarray(np.r_[0.5, np.ones(k - 1), 0.5] / k, dtype=matrix.dtype)
        return MonodromyOperator(matrix, edges, weight, motion)

    def _steps(self, system: DelaySystem, edges: Array) -> tuple[Array, Array]:
        """Propagators (k, d, d) and the responses to the delayed samples (k, d, samples, r) of all steps."""
        k, state, r = self.steps, system.state_size, system.output_size
        weights = _DELAYED[self.order]
        powers = len(weights)
        step = system.period / k
        drift, inputs, output = system.drift(), system.input_matrix(), system.output_matrix()
        ends = (edges[:1], edges[1:2]) if system.constant else (edges[:-1], edges[1:])
        current, (delayed,) = system.mean(*ends)

        def one(current_force: Array, delayed_force: Array) -> tuple[Array, Array]:
            # exp of the augmented matrix has h φ_p(A h) E beside exp(A h) (Al-Mohy and Higham, 2011): unlike
            # (3.18) it needs no inverse of A.
            wide = state + r * powers
            augmented = jnp.zeros((wide, wide), dtype=jnp.result_type(drift))
            augmented = augmented.at[:state, :state].set(step * (drift + inputs @ current_force @ output))
            augmented = augmented.at[:state, state : state + r].set(step * inputs)
            augmented = augmented.at[state : wide - r, state + r :].set(jnp.eye(r * (powers - 1)))
            solution = exponential(augmented)[:state]
            integrals = solution[:, state:].reshape(state, powers, r)
            return solution[:, :state], jnp.einsum("dpb,ps,bc->dsc", integrals, weights, delayed_force)

        propagators, responses = jax.vmap(one)(current, delayed)
        return (
            jnp.broadcast_to(propagators, (k, state, state)),
            jnp.broadcast_to(responses, (k, *jnp.shape(responses)[1:])),
        )
