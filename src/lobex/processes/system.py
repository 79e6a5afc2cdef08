"""The one model that everything shares: delayed output feedback on a linear structure."""

from typing import Any

import jax.numpy as jnp
import numpy as np

from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex.processes.feedback import Feedback, WholeStateFeedback
from lobex.structures.modes import Modes, check_modes

Array = Any


@pytree()
class DelaySystem:
    """ż(t) = A z(t) + E [P(t) y(t) + Q(t) y(t − τ)],  y = C z,  with P and Q constant or of period τ.

    A is block-diagonal with n blocks of size s (s = 2 for a vibration mode), so the state size is d = n·s.

    Attributes:
        blocks: the diagonal blocks of A, shape (n, s, s), 1/s.
        inputs: the rows of E per block, shape (n, s, r).
        outputs: the columns of C per block, shape (n, r, s).
        delay: τ, s.
        feedback: P and Q over one period.
    """

    blocks: Array
    inputs: Array
    outputs: Array
    delay: Array
    feedback: Feedback

    @property
    def state_size(self) -> int:
        """d, the size of z."""
        return np.shape(self.blocks)[0] * np.shape(self.blocks)[1]

    @property
    def output_size(self) -> int:
        """r, the size of y."""
        return np.shape(self.inputs)[2]

    def drift(self) -> Array:
        """A as a dense matrix, (d, d)."""
        n, s = np.shape(self.blocks)[:2]
        return jnp.einsum("ij,iab->iajb", jnp.eye(n), self.blocks).reshape(n * s, n * s)

    def input_matrix(self) -> Array:
        """E as a dense matrix, (d, r)."""
        return jnp.reshape(self.inputs, (self.state_size, self.output_size))

    def output_matrix(self) -> Array:
        """C as a dense matrix, (r, d)."""
        return jnp.swapaxes(self.outputs, 0, 1).reshape(self.output_size, self.state_size)


def modal_system(modes: Modes, delay: Array, feedback: Feedback) -> DelaySystem:
    """The delay system of vibration modes under a contact force; the state of a mode is (u, u̇/ω)."""
    check_modes(modes)
    lib = namespace(modes)
    omega = lib.asarray(modes.angular_frequency)
    zero, one = lib.zeros_like(omega), lib.ones_like(omega)
    unit = lib.stack([lib.stack([zero, one], -1), lib.stack([-one, -2 * modes.damping_ratio], -1)], -2)
    shape, loading = lib.asarray(modes.shape), lib.asarray(modes.loading)
    none = lib.zeros_like(shape)
    return DelaySystem(
        blocks=omega[:, None, None] * unit,
        inputs=lib.stack([none, loading / omega[:, None]], axis=1),
        outputs=lib.stack([shape, none], axis=2),
        delay=delay,
        feedback=feedback,
    )


def whole_state(system: DelaySystem) -> DelaySystem:
    """The same system with y = z: the thesis' form, in which the delay acts on the whole state (3.1)."""
    n, s = np.shape(system.blocks)[:2]
    unit = jnp.eye(n * s, dtype=jnp.result_type(system.blocks)).reshape(n, s, n * s)
    return DelaySystem(
        blocks=system.blocks,
        inputs=unit,
        outputs=jnp.swapaxes(unit, 1, 2),
        delay=system.delay,
        feedback=WholeStateFeedback(system.feedback, system.input_matrix(), system.output_matrix()),
    )
