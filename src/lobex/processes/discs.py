"""A stack of straight discs in place of a profile: thickness, lead angle, lag and radius of each."""

from typing import Any

import numpy as np
from jaxtyping import Float

from lobex import _checks
from lobex._namespace import namespace
from lobex._shapes import AnyArray, Number


def stacked(
    thickness: Any, lead_degrees: Any, lag_degrees: Any, radius: Any, diameter: Number
) -> Float[AnyArray, "discs 4"]:
    """Thickness, m, lead angle and lag, rad, and radius, m, of discs from the tip, (discs, 4).

    For None these are 90 and 0 degrees and half the diameter.

    Raises:
        ValueError: for discs without thickness or radius, lead angles that are not above 0 and up to 90 degrees, and
            other lengths than that of ``thickness``.
    """
    thickness = _checks.as_array(thickness, "thickness")
    _checks.positive("thickness", thickness, "m")
    count = np.shape(thickness)
    if len(count) != 1:
        raise ValueError(f"thickness has shape {count}; give one number a disc")

    def of_each(name: str, given: Any, usual: Any, unit: str) -> Any:
        numbers = usual * np.ones(count) if given is None else _checks.as_array(given, name)
        _checks.as_numbers(name, numbers, unit)
        if np.shape(numbers) != count:
            raise ValueError(f"{name} has shape {np.shape(numbers)}; give one number a disc, {count}")
        return numbers

    radius = of_each("radius", radius, diameter / 2, "m")
    _checks.positive("radius", radius, "m")
    lead, lag = (
        of_each(name, given, usual, "degrees") * (np.pi / 180)
        for name, given, usual in (("lead_degrees", lead_degrees, 90.0), ("lag_degrees", lag_degrees, 0.0))
    )
    if not _checks.is_traced(lead) and not np.all((lead > 0) & (lead <= np.pi / 2)):
        raise ValueError(f"lead_degrees = {_checks.brief(lead_degrees)}; give angles above 0 and up to 90")
    lib = namespace(thickness, lead, lag, radius)
    return lib.stack([lib.asarray(part) for part in (thickness, lead, lag, radius)], axis=1)


def sliced(profile: Any, count: int, depth: Number) -> Float[AnyArray, "discs 4"]:
    """The discs of a cutter's profile, in equal parts along it, each as it is at the middle of its part.

    Along the profile, since at the tip of a ball nothing is smooth in the height.

    Args:
        profile: a ``Cutter`` with a diameter and one helix angle, or none.
        count: of discs.
        depth: of all of them, m.
    """
    lib = namespace(profile, depth)
    lead = np.pi / 2 if profile.lead is None else profile.lead
    corner = 0.0 if profile.corner_radius is None else profile.corner_radius
    unit = 1.0 if profile.corner_radius is None else corner
    bottom = lib.minimum(corner * (1 - lib.cos(lead)), depth)
    bend = corner * lib.arccos(1 - bottom / unit)
    part = (bend + (depth - bottom) / lib.sin(lead)) / count

    def at(place: Any) -> tuple[Any, Any, Any]:
        """Lead angle, height and radius beyond the axis of the corner, along the profile."""
        above = lib.maximum(place - bend, 0.0)
        angle = lib.minimum(place, bend) / unit
        height = corner * (1 - lib.cos(angle)) + above * lib.sin(lead)
        return lib.where(place < bend, angle, lead), height, corner * lib.sin(angle) + above * lib.cos(lead)

    _, edge, _ = at(part * np.arange(count + 1))
    angle, height, out = at(part * (np.arange(count) + 0.5))
    radius = profile.diameter / 2 - corner * lib.sin(lead) + out
    lag = (0.0 if profile.helix is None else profile.twist) * height
    return lib.stack([edge[1:] - edge[:-1], angle, lag, radius], axis=1)
