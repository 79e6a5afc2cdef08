"""A flexible casing: a ring whose travelling waves a contact that runs along it meets."""

from typing import Any

import numpy as np
from jaxtyping import Float, Real

from lobex import _checks
from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.structures.damping import modal_damping
from lobex.structures.modes import Modes, unchecked

# Of a frequency, what is left of it by rounding.
_STILL = 1e-12


@pytree()
class Ring:
    """A casing that does not turn, with pairs of modes cos nθ and sin nθ, n nodal diameters.

    A contact that runs along it at Ω meets the two travelling waves that a pair is made of at the frequencies ω ± nΩ:
    G(s) = ½/m [1/D(s + jnΩ) + 1/D(s − jnΩ)] with D(s) = s² + 2ξωs + ω². Seen from there its coefficients are constant,
    and each wave is a mode of its own. A backward wave that the contact overtakes, nΩ > ω, has a residue below zero: it
    is pushed where it would be held.

    Attributes:
        nodal_diameter: n, whole numbers from 0 on, (k,). Of 0 the pair is one mode.
        frequency: natural frequencies, (k,), Hz.
        damping_ratio: ξ, below 1, (k,).
        mass: modal mass of each mode of a pair, whose shapes are cos nθ and sin nθ, (k,), kg.

    Raises:
        ValueError: for numbers that are not finite, or not above zero, with damping and nodal diameters 0 or more; for
            nodal diameters that are not whole, damping from 1 on, and lists of other lengths.
    """

    nodal_diameter: Real[AnyArray, " k"]
    frequency: Real[AnyArray, " k"]
    damping_ratio: Real[AnyArray, " k"]
    mass: Real[AnyArray, " k"]

    def __post_init__(self) -> None:
        given = {name: getattr(self, name) for name in ("nodal_diameter", "frequency", "mass")}
        for name, value in given.items():
            check = _checks.not_negative if name == "nodal_diameter" else _checks.positive
            check(name, value, {"frequency": "Hz", "mass": "kg"}.get(name, "waves around the casing"))
            if np.ndim(value) > 1 or np.size(value) == 0:
                raise ValueError(f"{name} has shape {np.shape(value)}; give one number, or one per pair of modes")
        count = max(np.size(value) for value in given.values())
        for name, value in given.items():
            if np.size(value) not in (1, count):
                raise ValueError(f"{name} has {np.size(value)} numbers for {count} pairs of modes; give one each")
        whole = _checks.as_numbers("nodal_diameter", self.nodal_diameter)
        if whole is not None and np.any(whole != np.round(whole)):
            raise ValueError(f"nodal_diameter = {_checks.brief(self.nodal_diameter)}; give whole numbers of waves")
        damping = modal_damping(self.damping_ratio, count)
        most = _checks.as_numbers("damping_ratio", damping)
        if most is not None and np.any(most >= 1):
            raise ValueError(
                f"damping_ratio = {_checks.brief(self.damping_ratio)}; give less than 1, of waves that travel"
            )
        for name, value in {**given, "damping_ratio": damping}.items():
            lib = namespace(value)
            object.__setattr__(self, name, lib.broadcast_to(lib.asarray(value, dtype=lib.result_type(float)), (count,)))

    @property
    def count(self) -> int:
        """Number of waves, two for each pair of modes."""
        return 2 * np.shape(self.frequency)[0]

    @property
    def directions(self) -> int:
        """One: along the normal of the casing."""
        return 1

    def check_speed(self, speed: Any) -> None:
        """Require finite speeds, Hz, at which no wave without damping stands still before the contact."""
        numbers = _checks.as_numbers("speed", speed, "Hz")
        if numbers is None or _checks.is_traced(self):
            return
        swept = np.abs(self.nodal_diameter * np.ravel(numbers)[:, None])
        still = np.abs(swept - self.frequency) <= _STILL * self.frequency
        at = np.argwhere(still & (np.asarray(self.damping_ratio) == 0))
        if len(at):
            one, waves = np.ravel(numbers)[at[0, 0]], self.nodal_diameter[at[0, 1]]
            raise ValueError(
                f"speed = {one:.6g} Hz lets the wave of {waves:g} nodal diameters stand still, which has no damping; "
                "give it damping_ratio, or another speed"
            )

    @in_float64
    def at(self, speed: Number) -> Modes:
        """The waves as a contact meets them that runs along the casing at a speed, Hz: the forward ones, then the
        backward ones.

        With σ = ξω and ω_d = ω√(1 − ξ²) the two terms of G are (ω_d ± nΩ)/ω_d · ½/m / ((s + σ)² + (ω_d ± nΩ)²).
        """
        lib, (decay, rotation, seen, acting) = namespace(self, speed), self.waves(speed)
        frequency = lib.sqrt(decay**2 + rotation**2)
        return unchecked(
            angular_frequency=frequency,
            damping_ratio=decay / frequency,
            shape=seen[:, None],
            force_shape=(acting * rotation)[:, None],
        )

    @in_float64
    def waves(
        self, speed: Number
    ) -> tuple[
        Float[AnyArray, " waves"], Float[AnyArray, " waves"], Float[AnyArray, " waves"], Float[AnyArray, " waves"]
    ]:
        """Of the forward waves, then the backward ones, as they pass a contact that runs along the casing at a speed,
        Hz: σ and ω_d ± nΩ, rad/s, of their poles, and how they are seen, 1/√m, and pushed, ½/(√m ω_d), s/√kg.
        """
        lib = namespace(self, speed)
        own, ratio = 2 * np.pi * lib.asarray(self.frequency), lib.asarray(self.damping_ratio)
        swept = 2 * np.pi * lib.asarray(speed, dtype=lib.result_type(float)) * self.nodal_diameter
        damped, seen = own * lib.sqrt(1 - ratio**2), 1 / lib.sqrt(lib.asarray(self.mass))
        both = (lib.concatenate([part, part]) for part in (ratio * own, seen, seen / (2 * damped)))
        decay, seen, acting = both
        return decay, lib.concatenate([damped + swept, damped - swept]), seen, acting
