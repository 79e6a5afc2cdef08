"""Central differences, (1.16)-(1.17), in modal form: every mode steps by itself, blades and lanes side by side.

The state is kept as displacement u and increment d = u_i − u_{i−1}, in which (1.17) reads

    d ← e d − s (u + c F),  u ← u + d,    e = (1 − ζ)/(1 + ζ), s = (ωΔt)²/(1 + ζ), ζ = ξωΔt, c = ψ/ω²

with F the force that pushes the tip back. It needs two coefficients per mode and lane, loses less to rounding
than (u_i, u_{i−1}), and overwrites its state in place.

A complex mode, u̇ = ωv − χ̂F/ω and v̇ = −ωu − 2ξωv − ψF/ω, steps alike: d is ωΔt v at half a step, and the force, taken
for impulses at the instants of the steps, makes u jump by −κF there, κ = Δt χ̂/ω. Half of the jump lies before the
instant itself, and v there is the mean of both sides, so that what the contact sees of it, φu + χv, has a part −γF.
That part takes the force of the step before. All of it is second order in Δt, and without χ and χ̂ it is (1.17).

Modes lie along the first axis, contacts along the next where there are any, then blades and lanes.
"""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex._pytree import pytree
from lobex._shapes import AnyArray
from lobex.marches.bodies import Body
from lobex.structures.modes import Modes

Modal = Float[AnyArray, "modes #blades lanes"]
Touching = Float[AnyArray, "contacts #blades lanes"]


@pytree()
class ModalStep:
    """One step of every mode, for one time step per lane. Axes that all blades or lanes share have length 1.

    Attributes:
        body: whose modes they are.
        damping: ξω, rad/s.
        step: Δt, s, (lanes,).
        decay, restoring: e and s, (modes, blades, lanes).
        compliance: c, of complex modes c − κ/2, (modes, contacts, blades, lanes).
        seen, seen_increment: what is seen of u and d, as ``body.shape``; the latter None without complex modes.
        jump: κ, as ``compliance``, or None.
        yielding: γ, of what is seen for each contact's force, (seen, contacts, blades, lanes), or None.
    """

    body: Body
    damping: Float[AnyArray, "modes *#columns"]
    step: Float[AnyArray, " lanes"]
    decay: Float[AnyArray, "modes *#columns"]
    restoring: Float[AnyArray, "modes *#columns"]
    compliance: Float[AnyArray, "modes contacts *#columns"]
    seen: Float[AnyArray, "modes seen *#columns"]
    seen_increment: Float[AnyArray, "modes seen *#columns"] | None = None
    jump: Float[AnyArray, "modes contacts *#columns"] | None = None
    yielding: Float[AnyArray, "seen contacts *#columns"] | None = None

    @classmethod
    def of(cls, body: Body, step: Float[AnyArray, " lanes"]) -> "ModalStep":
        """The coefficients of a body for the time steps ``step``, s, (lanes,)."""
        frequency = body.frequency
        damping = body.damping_ratio * frequency
        share = 1 + damping * step
        decay = (1 - damping * step) / share
        restoring = (frequency * step) ** 2 / share
        compliance = body.loading / frequency[:, None] ** 2
        if body.quadrature is None or body.force_quadrature is None:
            return cls(body, damping, step, decay, restoring, compliance, body.shape)
        jump = step * body.force_quadrature / frequency[:, None]
        compliance = compliance - jump / 2
        # χ v at an instant, of the increments before and after it.
        mean = body.quadrature / (2 * frequency * step)[:, None]
        seen = body.shape - mean * restoring[:, None]
        yielding = jnp.einsum("nsbl,ncbl->scbl", *_alike(body.shape, jump / 2)) + jnp.einsum(
            "nsbl,ncbl->scbl", *_alike(mean * restoring[:, None], compliance)
        )
        return cls(
            body,
            damping,
            step,
            decay,
            restoring,
            compliance,
            seen,
            mean * (1 + decay)[:, None],
            jump,
            yielding,
        )

    def tip(self, displacement: Modal, increment: Modal, force: Touching) -> Float[AnyArray, "seen blades lanes"]:
        """What is seen at an instant, of the state before it, and of the force where that makes it jump."""
        tip = jnp.sum(self.seen * displacement[:, None], axis=0)
        if self.seen_increment is None or self.yielding is None:
            return tip
        tip = tip + jnp.sum(self.seen_increment * increment[:, None], axis=0)
        if self.body.coupling is not None:
            pulled = coupled(self.body, displacement) - displacement
            tip = tip - jnp.sum((self.body.shape - self.seen) * pulled[:, None], axis=0)
        return tip - jnp.sum(self.yielding * force, axis=1)

    def driven(self, displacement: Modal) -> Touching:
        """As ``tip``, along the contact forces: the displacement that they work on, of modes that are not complex."""
        return jnp.sum(self.body.loading * displacement[:, None], axis=0)

    def advance(self, displacement: Modal, increment: Modal, force: Touching) -> tuple[Modal, Modal]:
        """Displacements and increments one step later."""
        if self.jump is None:
            pushed = coupled(self.body, displacement) + jnp.sum(self.compliance * force, axis=1)
            increment = self.decay * increment - self.restoring * pushed
            return displacement + increment, increment
        jump = jnp.sum(self.jump * force, axis=1)
        # Neighbours pull as they stand halfway through the jump; the compliance has that of the mode itself.
        pulled = coupled(self.body, displacement - jump / 2) + jump / 2
        increment = self.decay * increment - self.restoring * (pulled + jnp.sum(self.compliance * force, axis=1))
        return displacement + increment - jump, increment

    def worked(self, displacement: Modal, increment: Modal, after: Modal, force: Touching) -> Touching:
        """What complex modes move by along the contact forces, over both steps around an instant."""
        assert self.body.force_quadrature is not None
        assert self.jump is not None
        middle = displacement - jnp.sum(self.jump * force, axis=1) / 2 + (after - increment) / 4
        moved = self.body.loading * (increment + after)[:, None]
        pulled = 2 * self.step * self.body.frequency * coupled(self.body, middle)
        turned = self.body.force_quadrature * pulled[:, None]
        return jnp.sum(moved + turned, axis=0)

    def start(self, displacement: Modal, velocity: Modal, force: Touching) -> tuple[Modal, Modal]:
        """Displacement before an instant and the increment up to it, from displacement and velocity at it, to second
        order."""
        acceleration = -self._pull(displacement, force) - 2 * self.damping * velocity
        if self.jump is not None:
            displacement = displacement + jnp.sum(self.jump * force, axis=1) / 2
        return displacement, velocity * self.step - acceleration * self.step**2 / 2

    def stop(self, displacement: Modal, increment: Modal, force: Touching) -> tuple[Modal, Modal]:
        """Displacement and velocity at an instant, to second order: the inverse of ``start``."""
        if self.jump is not None:
            displacement = displacement - jnp.sum(self.jump * force, axis=1) / 2
        push = self._pull(displacement, force)
        return displacement, (increment / self.step - push * self.step / 2) / (1 + self.damping * self.step)

    def dissipation(self, velocity: Modal) -> Float[AnyArray, "blades lanes"]:
        """Power of the damping, W."""
        return jnp.sum(2 * self.damping * velocity**2, axis=0)

    def _pull(self, displacement: Modal, force: Touching) -> Modal:
        """What pulls the modes back, per modal mass: stiffness and contact."""
        return self.body.frequency**2 * coupled(self.body, displacement) + jnp.sum(self.body.loading * force, axis=1)


def coupled(body: Body, displacement: Modal) -> Modal:
    """u, and what neighbours pull at each mode, as a displacement of its own."""
    if body.coupling is None:
        return displacement
    return displacement + body.coupling / body.frequency**2 * _around(displacement)


def seen_at(body: Body, displacement: Modal, velocity: Modal) -> Float[AnyArray, "seen blades lanes"]:
    """What is seen of displacements and velocities at an instant."""
    tip = jnp.sum(body.shape * displacement[:, None], axis=0)
    if body.quadrature is None:
        return tip
    return tip + jnp.sum(body.quadrature * (velocity / body.frequency)[:, None], axis=0)


def pace(body: Body, displacement: Modal, velocity: Modal) -> Touching:
    """The velocity along the contact forces, m/s: what they work on."""
    along = jnp.sum(body.loading * velocity[:, None], axis=0)
    if body.force_quadrature is None:
        return along
    pulled = body.frequency * coupled(body, displacement)
    return along + jnp.sum(body.force_quadrature * pulled[:, None], axis=0)


def normal_velocity(body: Body, displacement: Modal, velocity: Modal) -> Float[AnyArray, "seen blades lanes"]:
    """The velocity of what is seen, m/s."""
    seen = jnp.sum(body.shape * velocity[:, None], axis=0)
    if body.quadrature is None:
        return seen
    pulled = body.frequency * coupled(body, displacement) + 2 * body.damping_ratio * velocity
    return seen - jnp.sum(body.quadrature * pulled[:, None], axis=0)


def energy(body: Body, displacement: Modal, velocity: Modal) -> Float[AnyArray, "blades lanes"]:
    """Kinetic and strain energy, J; that of springs between blades, half to each."""
    doubled = jnp.sum(velocity**2 + (body.frequency * displacement) ** 2, axis=0)
    if body.coupling is not None:
        stretch = displacement - jnp.roll(displacement, 1, axis=1)
        springs = jnp.sum(body.coupling * stretch**2, axis=0)
        doubled = doubled + (springs + jnp.roll(springs, -1, axis=0)) / 2
    return doubled / 2


def highest_frequency(modes: Modes, stiffness: np.ndarray) -> float:
    """Highest angular frequency, rad/s, with every contact held by a spring of ``stiffness``, (contacts,), N/m.

    Central differences are stable up to Δt = 2 over this, whatever the damping.
    """
    omega, size = np.asarray(modes.angular_frequency), len(stiffness)
    seen, acting = (np.asarray(side)[:, :size] for side in (modes.shape, modes.loading))
    if not modes.complex:
        square = np.diag(omega**2) + acting @ (stiffness[:, None] * seen.T)
        return float(np.sqrt(np.max(np.abs(np.linalg.eigvals(square)))))
    sides = (
        np.zeros_like(part) if side is None else np.asarray(side)[:, :size]
        for side, part in ((modes.quadrature, seen), (modes.force_quadrature, acting))
    )
    seen_aside, acting_aside = sides
    free = np.block([[np.zeros((len(omega),) * 2), np.diag(omega)], [-np.diag(omega), np.zeros((len(omega),) * 2)]])
    pushed = np.concatenate([acting_aside, acting]) / np.tile(omega, 2)[:, None]
    held = free - pushed @ (stiffness[:, None] * np.concatenate([seen, seen_aside]).T)
    return float(np.max(np.abs(np.linalg.eigvals(held))))


def _around(displacement: Modal) -> Modal:
    """2 u of each blade without that of its neighbours."""
    return 2 * displacement - jnp.roll(displacement, 1, axis=1) - jnp.roll(displacement, -1, axis=1)


def _alike(*parts: Float[AnyArray, "..."]) -> tuple[Float[Array, "..."], ...]:
    """With the blades and lanes of all of them."""
    shape = np.broadcast_shapes(*(part.shape[2:] for part in parts))
    return tuple(jnp.broadcast_to(part, (*part.shape[:2], *shape)) for part in parts)
