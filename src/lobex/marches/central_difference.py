"""Central differences, (1.16)-(1.17), in modal form: every mode steps by itself, lanes side by side.

The state is kept as displacement u and increment d = u_i − u_{i−1}, in which (1.17) reads

    d ← e d − s (u + c F),  u ← u + d,    e = (1 − ζ)/(1 + ζ), s = (ωΔt)²/(1 + ζ), ζ = ξωΔt, c = ψ/ω²

with F the force that pushes the tip back. It needs two coefficients per mode and lane, loses less to rounding
than (u_i, u_{i−1}), and overwrites its state in place. Modes lie along the first axis, lanes along the last.
"""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex._pytree import pytree
from lobex._shapes import AnyArray
from lobex.structures.modes import Modes


@pytree()
class ModalStep:
    """One step of every mode, for one time step per lane.

    Attributes:
        frequency, damping: ω and ξω, rad/s, each (modes, 1).
        shape, loading: φ and ψ, 1/√kg, each (modes, 1).
        step: Δt, s, (lanes,).
        decay, restoring: e and s, (modes, lanes).
        compliance: c, (modes, 1).
    """

    frequency: Float[Array, "modes 1"]
    damping: Float[Array, "modes 1"]
    shape: Float[Array, "modes 1"]
    loading: Float[Array, "modes 1"]
    step: Float[AnyArray, " lanes"]
    decay: Float[Array, "modes lanes"]
    restoring: Float[Array, "modes lanes"]
    compliance: Float[Array, "modes 1"]

    @classmethod
    def of(cls, modes: Modes, step: Float[AnyArray, " lanes"]) -> "ModalStep":
        """The coefficients of ``modes`` for the time steps ``step``, s, (lanes,)."""
        frequency = jnp.asarray(modes.angular_frequency)[:, None]
        damping = jnp.asarray(modes.damping_ratio)[:, None] * frequency
        shape = jnp.asarray(modes.shape)
        loading = shape if modes.force_shape is None else jnp.asarray(modes.force_shape)
        share = 1 + damping * step
        decay = (1 - damping * step) / share
        restoring = (frequency * step) ** 2 / share
        return cls(frequency, damping, shape, loading, step, decay, restoring, loading / frequency**2)

    def tip(self, displacement: Float[Array, "modes lanes"]) -> Float[Array, " lanes"]:
        """The tip's displacement (or velocity, or increment) of that of the modes, (lanes,)."""
        return jnp.sum(self.shape * displacement, axis=0)

    def driven(self, displacement: Float[Array, "modes lanes"]) -> Float[Array, " lanes"]:
        """As ``tip``, along the contact force: the displacement that it works on, (lanes,)."""
        return jnp.sum(self.loading * displacement, axis=0)

    def advance(
        self,
        displacement: Float[Array, "modes lanes"],
        increment: Float[Array, "modes lanes"],
        force: Float[AnyArray, " lanes"],
    ) -> tuple[Float[Array, "modes lanes"], Float[Array, "modes lanes"]]:
        """Displacements and increments one step later."""
        increment = self.decay * increment - self.restoring * (displacement + self.compliance * force)
        return displacement + increment, increment

    def start(
        self,
        displacement: Float[Array, "modes lanes"],
        velocity: Float[Array, "modes lanes"],
        force: Float[AnyArray, " lanes"],
    ) -> Float[Array, "modes lanes"]:
        """The increment that continues a displacement and velocity to second order."""
        acceleration = -(self.frequency**2) * displacement - 2 * self.damping * velocity - self.loading * force
        return velocity * self.step - acceleration * self.step**2 / 2

    def velocity(
        self,
        displacement: Float[Array, "modes lanes"],
        increment: Float[Array, "modes lanes"],
        force: Float[AnyArray, " lanes"],
    ) -> Float[Array, "modes lanes"]:
        """The velocity at the end of an increment, to second order: the inverse of ``start``."""
        push = self.frequency**2 * displacement + self.loading * force
        return (increment / self.step - push * self.step / 2) / (1 + self.damping * self.step)

    def energy(
        self, displacement: Float[Array, "modes lanes"], velocity: Float[Array, "modes lanes"]
    ) -> Float[Array, " lanes"]:
        """Kinetic and strain energy, J, (lanes,)."""
        return jnp.sum(velocity**2 + (self.frequency * displacement) ** 2, axis=0) / 2

    def dissipation(self, velocity: Float[Array, "modes lanes"]) -> Float[Array, " lanes"]:
        """Power of the damping, W, (lanes,)."""
        return jnp.sum(2 * self.damping * velocity**2, axis=0)


def highest_frequency(modes: Modes, stiffness: float) -> float:
    """Highest angular natural frequency, rad/s, with the tip held by a spring of ``stiffness``, N/m.

    Central differences are stable up to Δt = 2 over this, whatever the damping.
    """
    spring = stiffness * np.outer(np.asarray(modes.loading)[:, 0], np.asarray(modes.shape)[:, 0])
    square = np.diag(np.asarray(modes.angular_frequency) ** 2) + spring
    return float(np.sqrt(np.max(np.abs(np.linalg.eigvals(square)))))
