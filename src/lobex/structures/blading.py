"""A blading: blades around a disc, equal or not, evenly spaced or not, alone or coupled through the disc."""

from typing import Any

import numpy as np
from jaxtyping import Float, Real

from lobex import _checks
from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.structures.modes import Modes, check_modes, unchecked
from lobex.structures.rotating_modes import AnyModes

# Angles that people write down add up to a turn within this, in degrees.
_ROUNDING = 1e-6


@pytree(static=("count", "range_of_gaps"))
class Blading:
    """N blades, of which each rubs in the track that the one before it left: what ``Rub`` takes for a whole stage.

    Blade j follows blade j − 1 after the angle ``spacing[j]``, and the first follows the last.

    Attributes:
        blade: the modes of a blade as its contact sees them, with one contact direction; those that follow the speed
            (``RotatingModes``, ``ModesOverSpeed``), too.
        count: N.
        mistuning: by what share natural frequencies are higher than those of ``blade``, (N,), or (N, n) for each mode;
            None of blades that are equal.
        spacing: angles between each blade and the one before it, (N,), degrees, that add up to 360; None of even ones.
        coupling: ω_c/2π, Hz, one number or one per mode of the blade, (n,): the disc adds ω_c² (2qⱼ − qⱼ₋₁ − qⱼ₊₁) to
            ω² qⱼ of each of the neighbours' modes q; None of blades that are clamped.
        range_of_gaps: the least and the greatest spacing, or less and more, in shares of a revolution; known of numbers
            that are.

    Raises:
        ValueError: for fewer than one blade, modes with several contact directions, numbers that are not finite, lists
            of other lengths, mistuning of −100 % or less, angles that are not above zero or do not add up to 360°, and
            coupling below zero.
    """

    blade: AnyModes
    count: int
    mistuning: Real[AnyArray, "N ..."] | None = None
    spacing: Real[AnyArray, " N"] | None = None
    coupling: Any = None
    range_of_gaps: tuple[float, float] = (0.0, 1.0)

    def __post_init__(self) -> None:
        check_modes(self.blade, over_speed=True, name="blade")
        if self.blade.directions != 1:
            raise ValueError(f"blade has {self.blade.directions} contact directions; give modes with one")
        object.__setattr__(self, "count", _checks.integer("count", self.count, 1))
        blades, modes = self.count, self.blade.count
        if self.mistuning is not None:
            numbers = _checks.as_numbers("mistuning", self.mistuning, "shares of a frequency, 0.02 for 2 %")
            if np.shape(self.mistuning) not in ((blades,), (blades, modes)):
                raise ValueError(
                    f"mistuning has shape {np.shape(self.mistuning)}; give one number per blade, ({blades},), or per "
                    f"blade and mode, ({blades}, {modes})"
                )
            if numbers is not None and np.any(np.abs(numbers) >= 1):
                raise ValueError(
                    f"mistuning = {_checks.brief(self.mistuning)} is 100 % or more; give shares, 0.02 for 2 %"
                )
        if self.spacing is not None:
            _checks.positive("spacing", self.spacing, "degrees")
            if np.shape(self.spacing) != (blades,):
                raise ValueError(f"spacing has shape {np.shape(self.spacing)}; give one angle per blade, ({blades},)")
            angles = _checks.as_numbers("spacing", self.spacing)
            if angles is not None and abs(float(np.sum(angles)) - 360) > _ROUNDING:
                raise ValueError(f"spacing adds up to {float(np.sum(angles)):.9g}°; give angles that make 360°")
            if angles is not None:
                bounds = float(np.min(angles)) / 360, float(np.max(angles)) / 360
                object.__setattr__(self, "range_of_gaps", bounds)
        if self.coupling is not None:
            _checks.not_negative("coupling", self.coupling, "Hz")
            if np.shape(self.coupling) not in ((), (modes,)):
                raise ValueError(
                    f"coupling has shape {np.shape(self.coupling)}; give one number, or one per mode, ({modes},)"
                )
        # JAX compares what is constant, and a description has lists for it.
        object.__setattr__(self, "range_of_gaps", tuple(map(float, self.range_of_gaps)))
        for name in ("mistuning", "spacing", "coupling"):
            if getattr(self, name) is not None:
                # JAX takes a list for a tree of numbers.
                object.__setattr__(self, name, _checks.as_array(getattr(self, name), name))

    @property
    def directions(self) -> int:
        """One for each blade, N."""
        return self.count

    @property
    def angular_frequency(self) -> Float[AnyArray, "..."]:
        """ω of the blade alone, rad/s."""
        return self.blade.angular_frequency

    @property
    def damping_ratio(self) -> Float[AnyArray, "..."]:
        """ξ of the blade alone."""
        return self.blade.damping_ratio

    @property
    @in_float64
    def gaps(self) -> Float[AnyArray, " N"]:
        """The spacing in shares of a revolution, (N,)."""
        if self.spacing is None:
            return np.full(self.count, 1 / self.count)
        angles = namespace(self.spacing).asarray(self.spacing)
        # Exactly one turn of all together.
        return angles / namespace(angles).sum(angles)

    @property
    @in_float64
    def places(self) -> Float[AnyArray, " N"]:
        """Where around the casing each blade is when the first is at 0, in shares of a revolution in the direction of
        the motion, (N,): behind the ones before it.
        """
        lib = namespace(self.gaps)
        return -lib.concatenate([lib.zeros(1), lib.cumsum(self.gaps[1:])])

    @property
    @in_float64
    def detuned(self) -> Float[AnyArray, "N _"]:
        """By what natural frequencies are multiplied, (N, n), or (N, 1) for all modes alike."""
        if self.mistuning is None:
            return np.ones((self.count, 1))
        return 1 + namespace(self.mistuning).asarray(self.mistuning).reshape(self.count, -1)

    @property
    @in_float64
    def coupling_stiffness(self) -> Float[AnyArray, " n"] | None:
        """ω_c² of each mode, (n,), rad²/s²; None of blades that are clamped."""
        if self.coupling is None:
            return None
        lib = namespace(self.coupling)
        return (2 * np.pi * lib.broadcast_to(lib.asarray(self.coupling), (self.blade.count,))) ** 2

    @in_float64
    def modes(self, speed: Number) -> Modes:
        """The modes of all blades without coupling, in N contact directions: mode 1 of each, mode 2 of each, and so on.

        Args:
            speed: Hz.
        """
        one = self.blade.at(speed)
        lib = namespace(self, one)
        frequency = (lib.asarray(one.angular_frequency) * self.detuned).T.ravel()
        unit = lib.eye(self.count)

        def spread(side: Any) -> Any:
            return None if side is None else (lib.asarray(side)[:, :, None] * unit).reshape(-1, self.count)

        return unchecked(
            angular_frequency=frequency,
            damping_ratio=lib.repeat(lib.asarray(one.damping_ratio), self.count),
            shape=spread(one.shape),
            force_shape=spread(one.force_shape),
            quadrature=spread(one.quadrature),
            force_quadrature=spread(one.force_quadrature),
        )

    @property
    @in_float64
    def springs(self) -> Float[AnyArray, "n N N"] | None:
        """What the disc adds to the squares of frequencies of the N coordinates of each mode, (n, N, N), rad²/s²."""
        squared = self.coupling_stiffness
        if squared is None:
            return None
        unit = np.eye(self.count)
        around = 2 * unit - np.roll(unit, 1, axis=0) - np.roll(unit, -1, axis=0)
        return squared[:, None, None] * around
