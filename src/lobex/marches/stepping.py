"""One step in time of a structure under a contact force: free motion exactly, the force by its mean."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex._shapes import AnyArray, Number
from lobex.operators.exponential import exponential
from lobex.systems.system import DelaySystem


class Step(NamedTuple):
    """What a step h does to every block (n of size s): z ← exp(A h) z + R f with the step's mean force f.

    Attributes:
        propagator: exp(A h), (n, s, s).
        response: R = ∫ exp(A (h − t)) E dt over the step, (n, s, r).
        outputs: C per block, (n, r, s).
        compliance: C R, the change of y by a unit force, (r, r).
    """

    propagator: Float[Array, "n s s"]
    response: Float[Array, "n s r"]
    outputs: Float[AnyArray, "n r s"]
    compliance: Float[Array, "r r"]

    def free(self, state: Float[AnyArray, "n s"]) -> Float[Array, "n s"]:
        """The state (n, s) after a step without force."""
        return jnp.sum(self.propagator * state[:, None, :], axis=-1)

    def push(self, force: Float[AnyArray, "*r"]) -> Float[Array, "n s"]:
        """The change of the state, (n, s), by a mean force (r,), of one number where r is 1."""
        return jnp.sum(self.response * force, axis=-1)

    def output(self, state: Float[AnyArray, "n s"]) -> Float[Array, " r"]:
        """y = C z, (r,)."""
        return jnp.sum(self.outputs * state[:, None, :], axis=(0, 2))


def step_of(system: DelaySystem, size: Number) -> Step:
    """The step of ``size`` seconds."""
    n, s, r = np.shape(system.inputs)
    # exp of [[A h, E h], [0, 0]] holds both integrals and needs no inverse of A.
    wide = jnp.zeros((n, s + r, s + r), dtype=jnp.result_type(system.blocks, size))
    wide = wide.at[:, :s, :s].set(size * jnp.asarray(system.blocks))
    wide = wide.at[:, :s, s:].set(size * jnp.asarray(system.inputs))
    both = exponential(wide)[:, :s]
    outputs, response = jnp.asarray(system.outputs), both[:, :, s:]
    return Step(both[:, :, :s], response, outputs, jnp.einsum("nas,nsb->ab", outputs, response))


def times(matrix: Float[AnyArray, "a b"], vector: Float[Array, " b"]) -> Float[Array, " a"]:
    """Matrix times vector as a sum: XLA's matrix product is slow for one or two rows."""
    return jnp.sum(matrix * vector, axis=-1)
