"""One step in time of a structure under a contact force: free motion exactly, the force by its mean."""

from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np

from lobex.operators.exponential import exponential
from lobex.systems.system import DelaySystem

Array = Any


class Step(NamedTuple):
    """What a step h does to every block (n of size s): z ← exp(A h) z + R f with the step's mean force f.

    Attributes:
        propagator: exp(A h), (n, s, s).
        response: R = ∫ exp(A (h − t)) E dt over the step, (n, s, r).
        outputs: C per block, (n, r, s).
        compliance: C R, the change of y by a unit force, (r, r).
    """

    propagator: Array
    response: Array
    outputs: Array
    compliance: Array

    def free(self, state: Array) -> Array:
        """The state (n, s) after a step without force."""
        return jnp.sum(self.propagator * state[:, None, :], axis=-1)

    def push(self, force: Array) -> Array:
        """The change of the state, (n, s), by a mean force (r,)."""
        return jnp.sum(self.response * force, axis=-1)

    def output(self, state: Array) -> Array:
        """y = C z, (r,)."""
        return jnp.sum(self.outputs * state[:, None, :], axis=(0, 2))


def step_of(system: DelaySystem, size: Array) -> Step:
    """The step of ``size`` seconds."""
    n, s, r = np.shape(system.inputs)
    # exp of [[A h, E h], [0, 0]] holds both integrals and needs no inverse of A.
    wide = jnp.zeros((n, s + r, s + r), dtype=jnp.result_type(system.blocks, size))
    wide = wide.at[:, :s, :s].set(size * jnp.asarray(system.blocks))
    wide = wide.at[:, :s, s:].set(size * jnp.asarray(system.inputs))
    both = exponential(wide)[:, :s]
    outputs, response = jnp.asarray(system.outputs), both[:, :, s:]
    return Step(both[:, :, :s], response, outputs, jnp.einsum("nas,nsb->ab", outputs, response))


def times(matrix: Array, vector: Array) -> Array:
    """Matrix times vector as a sum: XLA's matrix product is slow for one or two rows."""
    return jnp.sum(matrix * vector, axis=-1)
