"""The forces on blades, each of which meets the track that the one before it left."""

from dataclasses import replace

from lobex._namespace import namespace
from lobex._shapes import Number
from lobex.processes.in_casing import system_in_casing
from lobex.structures.blading import Blading
from lobex.structures.modes import Modes
from lobex.structures.ring_waves import PassingWaves
from lobex.systems.coefficients import Constant
from lobex.systems.coupled_modes import with_springs
from lobex.systems.delays import Share
from lobex.systems.system import DelaySystem
from lobex.systems.terms import Regenerative


def blading_system(
    blading: Blading, speed: Number, stiffness: Number, casing: Modes | PassingWaves | None = None
) -> DelaySystem:
    """−K [yⱼ(t) − yⱼ₋₁(t − τⱼ)] on each blade j, with yⱼ how far it goes beyond a casing, if that is flexible.

    The period is that of a blade passing where they are evenly spaced, since nothing changes with time, and one
    revolution else.
    """
    modes = blading.modes(speed)
    lib = namespace(modes, stiffness)
    unit = lib.eye(blading.count, dtype=lib.result_type(float))
    if blading.spacing is None:
        period, terms = 1 / (blading.count * speed), (Regenerative(Constant(stiffness * unit)),)
        shortest = longest = 1.0
    else:
        period, (shortest, longest) = 1 / speed, blading.range_of_gaps
        rows = (stiffness * unit[j][:, None] * unit[j] for j in range(blading.count))
        terms = tuple(Regenerative(Constant(row), Share(gap)) for row, gap in zip(rows, blading.gaps, strict=True))
    system = system_in_casing(modes, casing, period, terms, shortest=shortest, longest=longest)
    system = replace(system, remembered=lib.roll(lib.asarray(system.outputs), 1, axis=1))
    springs = blading.springs
    return system if springs is None else with_springs(system, springs)
