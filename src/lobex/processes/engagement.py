"""The angles at which teeth enter and leave the cut."""

import math
from typing import Any

import numpy as np
from jaxtyping import Float

from lobex import _checks
from lobex._namespace import namespace
from lobex._shapes import AnyArray, Number
from lobex.processes.teeth import ALONE, WHOLE, Parts

# Of an angle, what is left of one that was said in degrees.
_ROUNDING = 1e-12


def cutting_angles(radial_immersion: Number, direction: str) -> tuple[Number, Number]:
    """Entry and exit angles of a tooth, rad, from the feed-normal axis (Appendix A)."""
    lib = namespace(radial_immersion)
    immersion = lib.asarray(radial_immersion, dtype=lib.result_type(float))
    # acos(2a − 1) and acos(1 − 2a) without their loss of digits at both ends.
    sides = lib.sqrt(1 - immersion), lib.sqrt(immersion)
    return (2 * lib.arctan2(*sides), lib.pi) if direction == "down" else (0.0, 2 * lib.arctan2(*sides[::-1]))


def angles_to_wall(
    wall: Number, radius: Float[AnyArray, " discs"], direction: str
) -> tuple[Float[AnyArray, " discs"], Float[AnyArray, " discs"]]:
    """Entry and exit angles, rad, of discs of several radii that cut what stands beyond a wall.

    Args:
        wall: how far it is from the axis on the side that is cut, m; below 0 on the other.
        radius: (discs,), m. Of a disc that does not reach it, both angles are one.
        direction: "down" or "up".
    """
    lib = namespace(wall, radius)
    arc = lib.arccos(lib.clip(wall / lib.asarray(radius), -1.0, 1.0))
    none, half = lib.zeros_like(arc), lib.full_like(arc, np.pi)
    return (np.pi - arc, half) if direction == "down" else (none, arc)


def parts_of(arc: float, teeth: int) -> Parts:
    """Of a period of as many straight teeth to a turn."""
    engaged = arc * teeth / (2 * math.pi)
    if abs(engaged - round(engaged)) < _ROUNDING and round(engaged) > 0:
        return ALONE if round(engaged) == 1 else WHOLE
    return ("cut", "idle") if engaged < 1 else ("cut", "cut")


def arc_of(process: Any) -> float | None:
    """The arc of the cut of a milling process, rad, if its numbers are known.

    Raises:
        ValueError: unless a radial immersion in (0, 1] is given, or an entry before an exit, from 0 to π.
    """
    if (process.radial_immersion is None) == (process.angles is None):
        immersion, angles = (_checks.brief(part) for part in (process.radial_immersion, process.angles))
        raise ValueError(f"radial_immersion = {immersion}, angles = {angles}: give one of them")
    if process.angles is not None:
        angles = _checks.as_numbers("angles", process.angles, "rad")
        if angles is not None and not 0 <= angles[0] < angles[1] <= np.pi * (1 + _ROUNDING):
            raise ValueError(
                f"angles are {np.degrees(angles[0]):.6g} and {np.degrees(angles[1]):.6g} degrees; "
                "give the entry before the exit, from 0 to 180 degrees"
            )
        return None if angles is None else float(angles[1] - angles[0])
    _checks.scalar("radial_immersion", process.radial_immersion)
    immersion = _checks.as_numbers("radial_immersion", process.radial_immersion)
    if immersion is not None and not 0 < immersion <= 1:
        raise ValueError(
            f"radial_immersion = {float(immersion):.6g} is outside (0, 1]; "
            "give radial depth of cut divided by tool diameter"
        )
    return None if immersion is None else 2 * math.atan2(math.sqrt(immersion), math.sqrt(1 - immersion))
