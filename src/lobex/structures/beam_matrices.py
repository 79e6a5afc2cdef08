"""Matrices of a twisted, tapered beam that turns about an axis across its span, by elements."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from lobex._namespace import namespace
from lobex._shapes import AnyArray, Number
from lobex.structures import span

# What a spring holds at the root, in the order of a node's degrees of freedom.
ROOT = ("radial", "tangential", "rotation in the plane of the disc", "axial", "rotation across it", "twist")


class Section(NamedTuple):
    """What a beam's section is at all points of its span, (elements, points) each.

    Attributes:
        mass: per length, kg/m.
        stretching: E A, N.
        flap, edge: second moments of area, m⁴, of what lies across the chord and along it.
        young_modulus, density: Pa and kg/m³.
        torsion: G J, N m².
        area: m².
        angle: of the chord against the axis of the rotor, rad.
    """

    mass: Float[AnyArray, "elements points"]
    stretching: Float[AnyArray, "elements points"]
    flap: Float[AnyArray, "elements points"]
    edge: Float[AnyArray, "elements points"]
    young_modulus: Number
    density: Number
    torsion: Float[AnyArray, "elements points"]
    area: Float[AnyArray, "elements points"]
    angle: Float[AnyArray, "elements points"]


class BeamMatrices(NamedTuple):
    """M q̈ + Ω C_g q̇ + (K + Ω² K_s) q = f, with Ω in rad/s.

    Attributes:
        mass: M, symmetric and definite.
        stiffness: K, at rest.
        spin_stiffness: K_s, by which the tension of the turning span stiffens and the turning frame softens.
        gyroscopic: C_g, skew: Coriolis forces.
    """

    mass: Float[AnyArray, "dof dof"]
    stiffness: Float[AnyArray, "dof dof"]
    spin_stiffness: Float[AnyArray, "dof dof"]
    gyroscopic: Float[AnyArray, "dof dof"]


def beam_matrices(
    section: Section, length: Number, hub_radius: Number, root_stiffness: Float[AnyArray, " 6"] | None
) -> BeamMatrices:
    """The matrices of a span whose root is held, or stands on springs of (6,) N/m and N m/rad.

    With the displacements u along the span, v in the direction of motion and w along the axis of the rotor, and the
    rotation φ about the span, twice the energies per length are ρA(u̇² + v̇² + ẇ²) + ρI_p φ̇² and
    E A u′² + E(I_vv v″² + 2 I_vw v″w″ + I_ww w″²) + G J φ′², the second moments being those of the principal axes
    turned by the chord's angle. Turning adds, per Ω²: T(v′² + w′² + (I_p/A) φ′²), where T is what the mass outboard
    pulls, −ρA(u² + v²), and ρ(I_vv − I_ww) φ², by which a section turns into the plane of rotation; and per Ω the
    Coriolis forces 2ρA v̇ outward and −2ρA u̇ along the motion (Houbolt and Brooks, NACA Report 1346, 1958, of a section
    without offsets). The rotary inertia of bending, and what the steady deformation adds, are left out.
    """
    lib = namespace(section, length, hub_radius, root_stiffness)
    elements = section.mass.shape[0]
    step = length / elements
    polar = section.flap + section.edge
    sine, cosine = lib.sin(section.angle), lib.cos(section.angle)
    across = section.edge * sine**2 + section.flap * cosine**2
    along = section.edge * cosine**2 + section.flap * sine**2
    both = (section.edge - section.flap) * sine * cosine
    radius = hub_radius + length * span.places(elements)
    tension = span.outboard(section.mass * radius, length)
    (u, du), (turn, dturn) = span.STRETCHED, span.TURNED
    (v, dv, ddv), (w, dw, ddw) = span.DEFLECTED

    def over(density: Any, left: Any, right: Any, order: int) -> Any:
        """∫ of a density times two motions, of which ``order`` derivatives by the span are taken."""
        return step ** (1 - order) * lib.einsum("ep,pi,pj->eij", density * span.WEIGHT, left, right)

    bending = section.young_modulus * lib.stack([across, both, both, along])
    pairs = ((ddv, ddv), (ddv, ddw), (ddw, ddv), (ddw, ddw))
    parts = BeamMatrices(
        mass=sum(over(section.mass, one, one, 0) for one in (u, v, w)) + over(section.density * polar, turn, turn, 0),
        stiffness=over(section.stretching, du, du, 2)
        + over(section.torsion, dturn, dturn, 2)
        + sum(over(part, *pair, 4) for part, pair in zip(bending, pairs, strict=True)),
        spin_stiffness=over(tension, dv, dv, 2)
        + over(tension, dw, dw, 2)
        + over(tension * polar / section.area, dturn, dturn, 2)
        - over(section.mass, u, u, 0)
        - over(section.mass, v, v, 0)
        + over(section.density * (across - along), turn, turn, 0),
        gyroscopic=2 * (over(section.mass, v, u, 0) - over(section.mass, u, v, 0)),
    )
    scale = span.scale(step)
    whole = [span.assembled(scale[:, None] * part * scale) for part in parts]
    if root_stiffness is None:
        return BeamMatrices(*(matrix[span.NODE :, span.NODE :] for matrix in whole))
    springs = lib.concatenate([lib.asarray(root_stiffness), np.zeros(len(whole[0]) - span.NODE)])
    whole[1] = whole[1] + lib.diag(springs)
    return BeamMatrices(*whole)
