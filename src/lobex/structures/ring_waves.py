"""The travelling waves of a ring as several contacts meet them that run along it, each at an angle of its own."""

from typing import Any

import numpy as np
from jaxtyping import Float

from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.structures.modes import Modes, unchecked
from lobex.structures.ring import Ring


@pytree()
class RingWaves:
    """A ``Ring`` in as many directions as there are contacts: modes over speed, the waves of which go past them.

    A contact at the angle θ meets Re ζ e^{jnθ}, and a force F there drives D(∂ − jnΩ) ζ = F e^{−jnθ}/m in the frame of
    the contacts, with D(s) = s² + 2ξωs + ω². Each of its two poles is a complex mode.

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
        """Require finite speeds, Hz."""
        self.ring.check_speed(speed)

    @in_float64
    def at(self, speed: Number) -> Modes:
        """The waves at a speed, Hz: the forward ones, then the backward ones."""
        lib, (decay, rotation, size) = namespace(self.ring, self.angle, speed), self.ring.waves(speed)
        turned = lib.asarray(self.ring.nodal_diameter)[:, None] * self.angle
        angle = lib.concatenate([turned, -turned])
        return unchecked(**_of_waves(lib, decay, rotation, size[:, None], angle))


def _of_waves(
    lib: Any,
    decay: Float[AnyArray, " waves"],
    rotation: Float[AnyArray, " waves"],
    size: Float[AnyArray, "waves 1"],
    angle: Float[AnyArray, "waves contacts"],
) -> dict[str, Float[AnyArray, "waves ..."]]:
    """Fields of ``Modes`` of the poles λ = −σ + jρ with residues e^{jα} e^{−jα'} · size/2j, and of their conjugates.

    The real form of such a pair has the state (x, ẋ/|λ|): seen Re e^{jα} − Im e^{jα} Re λ/Im λ of the one and
    |λ| Im e^{jα}/Im λ of the other.
    """
    omega = lib.sqrt(decay**2 + rotation**2)
    sine, cosine = lib.sin(angle), lib.cos(angle)
    rho, sigma = rotation[:, None], decay[:, None]
    return {
        "angular_frequency": omega,
        "damping_ratio": decay / omega,
        "shape": cosine + sine * sigma / rho,
        "force_shape": size * (rho * cosine + sigma * sine),
        "quadrature": omega[:, None] * sine / rho,
        "force_quadrature": -size * omega[:, None] * sine,
    }
