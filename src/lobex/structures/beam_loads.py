"""What is watched of a beam besides its contact: how its tip moves, what its root carries, and the stress there."""

from typing import Any

import numpy as np
from jaxtyping import Float

from lobex._namespace import namespace
from lobex._shapes import AnyArray, Number
from lobex.structures import span
from lobex.structures.beam_matrices import Section, beam_matrices

TIP = (span.STRETCH, span.ACROSS, span.ALONG)


def root_loads(
    section: Section, length: Number, root_stiffness: Float[AnyArray, " 6"] | None
) -> Float[AnyArray, "dof 6"]:
    """The forces and moments that hold the root, of the degrees of freedom that are left, as those of ``ROOT``.

    Springs hold with what they are stretched by; a clamp with what the elements next to it need of its degrees of
    freedom, which is as exact as the displacements are (the consistent reactions).
    """
    lib = namespace(section, length, root_stiffness)
    if root_stiffness is not None:
        size = span.ELEMENT - span.NODE
        rest = lib.zeros((size * section.mass.shape[0], span.NODE))
        return lib.concatenate([-lib.diag(lib.asarray(root_stiffness)), rest])
    free = beam_matrices(section, length, 0.0, np.zeros(span.NODE))
    return free.stiffness[span.NODE :, : span.NODE]


def root_stress(
    section: Section, loads: Float[AnyArray, "dof 6"], chord: Any, thickness: Any
) -> Float[AnyArray, "dof points"]:
    """The stress along the span, Pa, in points of the section at the root, from the loads there.

    E u′ − E y v″ − E z w″ with y and z of the points, (points,) each along the chord and across it, m; of the loads
    that the clamp holds with, the section carries the opposite.
    """
    lib = namespace(section, loads, chord, thickness)
    flap, edge, angle, area = (part[0, 0] for part in (section.flap, section.edge, section.angle, section.area))
    sine, cosine = lib.sin(angle), lib.cos(angle)
    across = edge * sine**2 + flap * cosine**2
    along = edge * cosine**2 + flap * sine**2
    both = (edge - flap) * sine * cosine
    pull = -loads[:, span.STRETCH]
    one, other = -loads[:, span.ACROSS_SLOPE], -loads[:, span.ALONG_SLOPE]
    # E times the curvatures.
    determinant = across * along - both**2
    bent = (along * one - both * other) / determinant, (across * other - both * one) / determinant
    places = chord * sine + thickness * cosine, chord * cosine - thickness * sine
    return (pull / area)[:, None] - bent[0][:, None] * places[0] - bent[1][:, None] * places[1]
