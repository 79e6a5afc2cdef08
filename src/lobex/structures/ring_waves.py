"""The travelling waves of a ring as several contacts meet them that run along it, each at an angle of its own."""

from typing import Any

import numpy as np
from jaxtyping import Float

from lobex import _checks
from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.structures.modes import Modes, unchecked
from lobex.structures.ring import Ring

# Of the decay of a wave, how slowly it may turn before the contacts to be told as a mode.
_SLOWEST = 1e-2


@pytree()
class PassingWaves:
    """Waves as contacts meet them at one speed: a contact at the angle α of a wave meets Re ζ e^{jα} times how it is
    seen, and a force F there drives ζ̇ + (σ − jρ) ζ = −j e^{−jα} F times how it is pushed.

    Attributes:
        decay: σ, (waves,), rad/s.
        rotation: ρ, (waves,), rad/s, of either sign, and zero of a wave that stands still before the contacts.
        seen: (waves,), 1/√kg.
        acting: how waves are pushed, (waves,), s/√kg.
        angle: α, (waves, contacts), rad.
    """

    decay: Float[AnyArray, " waves"]
    rotation: Float[AnyArray, " waves"]
    seen: Float[AnyArray, " waves"]
    acting: Float[AnyArray, " waves"]
    angle: Float[AnyArray, "waves contacts"]

    @property
    def directions(self) -> int:
        """One for each contact."""
        return np.shape(self.angle)[1]

    @in_float64
    def states(
        self,
    ) -> tuple[Float[AnyArray, "waves 2 2"], Float[AnyArray, "waves 2 contacts"], Float[AnyArray, "waves contacts 2"]]:
        """A, E and C of the states (Re ζ, Im ζ)."""
        lib = namespace(self)
        rows = [[-self.decay, -self.rotation], [self.rotation, -self.decay]]
        sine, cosine = lib.sin(self.angle), lib.cos(self.angle)
        seen, acting = lib.asarray(self.seen)[:, None, None], lib.asarray(self.acting)[:, None, None]
        return (
            lib.stack([lib.stack(row, axis=-1) for row in rows], axis=-2),
            -acting * lib.stack([sine, cosine], axis=1),
            seen * lib.stack([cosine, -sine], axis=2),
        )

    @in_float64
    def modes(self) -> Modes:
        """Each wave as a complex mode of the state (x, ẋ/|λ|), λ = −σ + jρ, which one that stands still is not: it is
        seen Re e^{jα} − Im e^{jα} Re λ/Im λ of the one and |λ| Im e^{jα}/Im λ of the other.
        """
        lib = namespace(self)
        omega = lib.sqrt(self.decay**2 + self.rotation**2)
        sine, cosine = lib.sin(self.angle), lib.cos(self.angle)
        sigma, rho, seen, acting = (
            lib.asarray(part)[:, None] for part in (self.decay, self.rotation, self.seen, self.acting)
        )
        return unchecked(
            angular_frequency=omega,
            damping_ratio=self.decay / omega,
            shape=seen * (cosine + sine * sigma / rho),
            force_shape=acting * (rho * cosine + sigma * sine),
            quadrature=seen * omega[:, None] * sine / rho,
            force_quadrature=-acting * omega[:, None] * sine,
        )


@pytree()
class RingWaves:
    """A ``Ring`` in as many directions as there are contacts: the waves go past them.

    A contact at the angle θ meets Re ζ e^{jnθ}, and a force F there drives D(∂ − jnΩ) ζ = F e^{−jnθ}/m in the frame of
    the contacts, with D(s) = s² + 2ξωs + ω². Each of its two poles is a wave.

    Attributes:
        ring: the casing.
        angle: of the contacts, in the direction of the motion, (contacts,), rad.
    """

    ring: Ring
    angle: Float[AnyArray, " contacts"]

    @property
    def directions(self) -> int:
        """One for each contact."""
        return np.shape(self.angle)[0]

    def check_speed(self, speed: Any) -> None:
        """Require speeds, Hz, at which each wave is a mode: none stands still before the contacts, or nearly."""
        self.ring.check_speed(speed)
        numbers = _checks.as_numbers("speed", speed, "Hz")
        if numbers is None or _checks.is_traced(self):
            return
        for one in np.unique(numbers):
            decay, rotation, *_ = self.ring.waves(one)
            still = np.flatnonzero(np.abs(rotation) < _SLOWEST * decay)
            if self.directions > 1 and len(still):
                waves = np.tile(self.ring.nodal_diameter, 2)[still[0]]
                raise ValueError(
                    f"speed = {one:.6g} Hz lets the wave of {waves:g} nodal diameters stand still before the blades, "
                    "which a march does not follow; give another speed"
                )

    @in_float64
    def passing(self, speed: Number) -> PassingWaves:
        """The waves at a speed, Hz: the forward ones, then the backward ones."""
        lib, waves = namespace(self.ring, self.angle, speed), self.ring.waves(speed)
        turned = lib.asarray(self.ring.nodal_diameter)[:, None] * self.angle
        return PassingWaves(*waves, lib.concatenate([turned, -turned]))

    def at(self, speed: Number) -> Modes:
        """The same as modes."""
        return self.passing(speed).modes()
