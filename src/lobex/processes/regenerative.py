"""Processes with constant regenerative feedback: a blade rubbing its own track, and turning."""

from dataclasses import InitVar, replace
from typing import Any, ClassVar

import numpy as np

from lobex import _checks
from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import Number
from lobex.processes.blade_tracks import blading_system
from lobex.processes.cutting_force import CuttingForce, check_force
from lobex.processes.in_casing import system_in_casing
from lobex.processes.process import check_point
from lobex.processes.process_damping import ProcessDamping, check_damping, with_damping
from lobex.processes.quantity import CONTACT_STIFFNESS, DEPTH_OF_CUT, SPEED_UNITS, Quantity
from lobex.processes.speed_variation import SpeedVariation, check_variation
from lobex.structures.blading import Blading
from lobex.structures.modes import Modes, check_modes
from lobex.structures.ring import Ring
from lobex.structures.ring_waves import PassingWaves, RingWaves
from lobex.structures.rotating_modes import AnyModes
from lobex.systems.coefficients import Constant
from lobex.systems.system import DelaySystem
from lobex.systems.terms import Regenerative


@pytree(static=("speed_unit",))
class Rub:
    """A blade in permanent contact with an abradable casing, (3.4)-(3.9).

    Each pass meets the track that the previous one left: the force on the tip is −K_e [y(t) − y(t − τ)],
    τ = 1/speed. A variation around a steady feed: it holds while the blade does not leave the coating. The
    gain is the contact stiffness K_e, N/m.

    Attributes:
        modes: the blade's modes at the contact, those that follow the speed (``RotatingModes``, ``ModesOverSpeed``), a
            measured ``Receptance``, or a ``Blading``, whose blades rub in the tracks of each other.
        casing: a flexible one: a ``Ring``, whose waves the blades run past, or ``Modes`` at the contacts, of what goes
            round with them, such as those of a rig. A track is worn into the casing, and moves with it: each contact
            meets what the one before it left beyond the casing as that was. It takes modes, or a ``Blading``. None of a
            rigid one.
        speed_unit: in which speeds are drawn, "Hz" or "rpm"; or "1" of a model without units, its time and lengths
            being scaled: speed and gain are plain numbers then, and none of them is said to be implausible.
    """

    modes: AnyModes | Blading
    speed_unit: str = "Hz"
    casing: Modes | Ring | PassingWaves | None = None

    gain: ClassVar[Quantity] = CONTACT_STIFFNESS

    def __post_init__(self) -> None:
        if not isinstance(self.modes, Blading):
            check_modes(self.modes, measured=True, over_speed=True)
        _checks.choice("speed_unit", self.speed_unit, SPEED_UNITS)
        if self.casing is None:
            return
        if not isinstance(self.casing, Modes | Ring | PassingWaves):
            raise ValueError(f"casing = {_checks.brief(self.casing)}; give lobex.Ring or lobex.Modes")
        check_modes(getattr(self.modes, "blade", self.modes), over_speed=True)
        if isinstance(self.casing, Modes) and self.casing.directions != self.modes.directions:
            counts = f"modes has {self.modes.directions} contact directions and casing {self.casing.directions}"
            raise ValueError(f"{counts}; give one each, along the normal of each contact")

    @property
    def passes(self) -> int:
        """How many blades pass in a revolution."""
        return self.modes.count if isinstance(self.modes, Blading) else 1

    @in_float64
    def system(self, speed: Number, gain: Number) -> DelaySystem:
        """The delay system at one speed (Hz) and one contact stiffness (N/m)."""
        check_point(self, speed, gain)
        casing = self._casing_at(speed)
        if isinstance(self.modes, Blading):
            return blading_system(self.modes, speed, gain, casing)
        return _regenerative_system(self.modes, speed, gain, casing)

    @in_float64
    def at_speed(self, speed: Number) -> "Rub":
        """The rub of the structure as it is at a speed, Hz."""
        if isinstance(self.modes, Blading):
            modes: Any = replace(self.modes, blade=self.modes.blade.at(speed))
        else:
            modes = self.modes.at(speed)
        return replace(self, modes=modes, casing=self._casing_at(speed))

    def _casing_at(self, speed: Number) -> Modes | PassingWaves | None:
        """A flexible casing as the contacts meet it."""
        if not isinstance(self.casing, Ring):
            return self.casing
        self.casing.check_speed(speed)
        if isinstance(self.modes, Blading):
            return RingWaves(self.casing, 2 * np.pi * self.modes.places).passing(speed)
        if self.modes.directions == 1:
            return self.casing.at(speed)
        # Those of one tip are at one place.
        return RingWaves(self.casing, np.zeros(self.modes.directions)).passing(speed)


@pytree(static=("speed_unit",))
class Turning:
    """Turning with a flexible tool, (2.12): m ÿ + c ẏ + k y = −K_r b [y(t) − y(t − τ)], τ = 1/speed.

    Attributes:
        modes: the tool's modes in the direction of the chip thickness.
        radial: radial specific cutting force K_r, N/m²; or
        force: a ``CuttingForce``, whose normal part it is. What its edge adds holds the tool deflected, and no more.
        speed_unit: as of ``Rub``.
        diameter: at which is cut, m, where process damping asks for it.
        process_damping: a ``ProcessDamping``, of which friction has no part in the direction of the chip thickness; it
            takes modes. None for none.
        speed_variation: a ``SpeedVariation`` of the spindle, whose mean speed is that of the process; it takes modes.
            The period is then that of the variation. None for none.

    The gain is the depth of cut b, m.
    """

    modes: AnyModes
    radial: Any = None
    speed_unit: str = "rpm"
    diameter: Number | None = None
    process_damping: ProcessDamping | None = None
    speed_variation: SpeedVariation | None = None
    force: InitVar[CuttingForce | None] = None

    gain: ClassVar[Quantity] = DEPTH_OF_CUT
    passes: ClassVar[int] = 1

    def __post_init__(self, force: CuttingForce | None) -> None:
        if (self.radial is None) == (force is None):
            raise ValueError(f"radial = {_checks.brief(self.radial)}, force = {_checks.brief(force)}: give one of them")
        if force is not None:
            check_force(force)
            object.__setattr__(self, "radial", force.normal)
        check_modes(self.modes, measured=True, over_speed=True)
        _checks.positive("radial", self.radial, "N/m²")
        _checks.scalar("radial", self.radial)
        _checks.choice("speed_unit", self.speed_unit, SPEED_UNITS)
        if self.diameter is not None:
            _checks.positive("diameter", self.diameter, "m")
            _checks.scalar("diameter", self.diameter)
        check_damping(self.process_damping, self.diameter, self.modes)
        check_variation(self.speed_variation)
        if self.process_damping is not None or self.speed_variation is not None:
            check_modes(self.modes, over_speed=True)

    @in_float64
    def system(self, speed: Number, gain: Number) -> DelaySystem:
        """The delay system at one spindle speed (revolutions per second) and one depth of cut (m)."""
        check_point(self, speed, gain)
        system = _regenerative_system(self.modes, speed, self.radial * gain)
        varied = self.speed_variation
        if varied is not None:
            revolutions = 1 / varied.frequency_ratio
            shortest, longest = (bound / revolutions for bound in varied.delay_range(1.0, 1.0))
            system = varied.acting_on(system, revolutions, shortest=shortest, longest=longest)
        if self.process_damping is None:
            return system
        unit = namespace(gain).eye(self.modes.directions)
        rubbing: Any = Constant(self.process_damping.per_speed(self.diameter, speed) * gain * unit)
        return with_damping(system, (rubbing if varied is None else varied.per_pace(rubbing),))


def _regenerative_system(
    modes: AnyModes, speed: Number, stiffness: Number, casing: Modes | PassingWaves | None = None
) -> DelaySystem:
    check_modes(modes, over_speed=True)
    lib = namespace(stiffness)
    unit = lib.eye(modes.directions, dtype=lib.result_type(float))
    return system_in_casing(modes.at(speed), casing, 1 / speed, (Regenerative(Constant(stiffness * unit)),))
