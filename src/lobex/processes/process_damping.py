"""Process damping: the flank of a tool rubs on the wave that it cuts, and damps it."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from lobex import _checks
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import Number
from lobex._warnings import warn
from lobex.processes.plausible import too_long, too_soft
from lobex.systems.coefficients import Coefficient, Following, Framed
from lobex.systems.system import DelaySystem
from lobex.systems.terms import Delayed, Present, Regenerative, Term

# Of what a force does at once to a velocity through each mode, what may be left of the sum.
_ROUNDING = 1e-9


@pytree()
class ProcessDamping:
    """The force −(C b/v) (n + μ t) nᵀ ẏ on a tool, with its normal n, its cutting direction t and cutting speed v.

    Linear in the velocity (Tunç and Budak, Effect of cutting conditions and tool geometry on process damping in
    machining, Int. J. Mach. Tools Manuf. 57, 2012). Where C is not known, ``from_wear_land`` makes it of the flank.

    Attributes:
        coefficient: C, N/m.
        friction: μ, of the flank; 0 for none.
    """

    coefficient: Number
    friction: Number = 0.0

    def __post_init__(self) -> None:
        for name, unit in (("coefficient", "N/m"), ("friction", "")):
            _checks.not_negative(name, getattr(self, name), unit)
            _checks.scalar(name, getattr(self, name))

    @classmethod
    def from_wear_land(
        cls, indentation_coefficient: Number, wear_land: Number, friction: Number = 0.0
    ) -> "ProcessDamping":
        """That of a flank worn flat, C = K_sp W²/2.

        The force is K_sp a volume pressed in. Of vibrations that are small, and long beside the flat, that volume is
        b W²/2 times the slope −ẏ/v of the surface (Chiou and Liang, Chatter stability of a slender cutting tool in
        turning with tool wear effect, Int. J. Mach. Tools Manuf. 38, 1998).

        Args:
            indentation_coefficient: K_sp, force per volume of material pressed in, N/m³.
            wear_land: W, the width of the flat along the cutting direction, m.
            friction: as of the class.

        Raises:
            ValueError: for an indentation coefficient that is not above 0 and a wear land below 0.
        """
        _checks.positive("indentation_coefficient", indentation_coefficient, "N/m³")
        _checks.scalar("indentation_coefficient", indentation_coefficient)
        _checks.not_negative("wear_land", wear_land, "m")
        _checks.scalar("wear_land", wear_land)
        if not _checks.is_traced((indentation_coefficient, wear_land)):
            for message in (too_soft(indentation_coefficient), too_long("wear_land", wear_land)):
                if message is not None:
                    warn(message)
        return cls(indentation_coefficient * wear_land**2 / 2, friction)

    def per_speed(self, diameter: Any, speed: Number) -> Number:
        """C/v at a spindle speed in revolutions per second, Ns/m²."""
        return self.coefficient / (namespace(diameter, speed).pi * diameter * speed)


def check_damping(damping: Any, diameter: Any, modes: Any) -> None:
    """Require process damping as such, the diameter that makes a cutting speed of a spindle speed, and modes whose
    velocity at the contact is that of their states: of complex ones, a set from which none is missing.
    """
    if damping is None:
        return
    if getattr(modes, "complex", False) and not _checks.is_traced(modes):
        parts = [0.0 if part is None else np.asarray(part) for part in (modes.quadrature, modes.force_quadrature)]
        products = np.asarray(modes.shape) * parts[1] + np.asarray(modes.loading) * parts[0]
        at_once = products / np.asarray(modes.angular_frequency)[..., None]
        if np.any(np.abs(np.sum(at_once, axis=-2)) > _ROUNDING * np.sum(np.abs(at_once), axis=-2)):
            raise ValueError(
                "modes has complex modes of which some are missing, so that a force makes a velocity at once; "
                "give all of them with process damping"
            )
    if not isinstance(damping, ProcessDamping):
        raise ValueError(f"process_damping = {_checks.brief(damping)}; give lobex.ProcessDamping(coefficient)")
    if diameter is None:
        raise ValueError("diameter = None with process damping; give that at which is cut, in m")


def with_damping(system: DelaySystem, rubbing: Iterable[Coefficient]) -> DelaySystem:
    """A modal system with forces −R(t) ẏ as well.

    Outputs are then displacements and velocities, these over the ω of the first mode, of which displacements alone are
    remembered.
    """
    lib = namespace(system.blocks, system.outputs)
    omega, r = system.blocks[:, 0, 1], system.output_size
    rate = lib.einsum("nrs,nst->nrt", system.outputs, system.blocks / omega[0])
    unit = lib.eye(system.force_size)
    place, velocity = lib.eye(2 * r)[:r], lib.eye(2 * r)[r:]

    def framed(left: Any, coefficient: Coefficient, right: Any) -> Present:
        part: Any = Framed(left, coefficient, right)
        return Present(part)

    terms: list[Term] = [framed(-omega[0] * unit, coefficient, velocity) for coefficient in rubbing]
    for term in system.terms:
        if isinstance(term, Regenerative):
            now = term.coefficient if term.coefficient.constant else Following(term.coefficient)
            terms += [framed(-unit, now, place), Delayed(term.coefficient, term.delay)]
        else:
            terms.append(term)
    outputs = lib.concatenate([system.outputs, rate], axis=1)
    return replace(system, outputs=outputs, remembered=system.outputs, terms=tuple(terms))
