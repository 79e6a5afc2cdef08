"""The beam at rest against closed forms, and at its tip; twisted and tapered against collocation."""

import numpy as np
import pytest
import scipy.linalg

import lobex
from beam_collocation import frequencies
from lobex.structures.eigenproblem import vibration_modes
from lobex.structures.rectangle import torsion_constant

LENGTH, WIDTH, THICKNESS, MODULUS, DENSITY = 0.2, 0.05, 0.004, 110e9, 4430.0
GIVEN = {"length": LENGTH, "young_modulus": MODULUS, "density": DENSITY}
UNIFORM = GIVEN | {"width": WIDTH, "thickness": THICKNESS}
AREA, FLAP, EDGE = WIDTH * THICKNESS, WIDTH * THICKNESS**3 / 12, THICKNESS * WIDTH**3 / 12
SHEAR = MODULUS / 2.6
# Of cos z cosh z = −1.
BENDING = np.array([1.8751040687119611, 4.694091132974174, 7.854757438237613])
ODD = (2 * np.arange(3) + 1) * np.pi / (2 * LENGTH)


def closed_forms():
    """ω, rad/s, of three modes of each kind: flap, edge, stretch and torsion."""
    bending = (BENDING / LENGTH) ** 2
    polar = FLAP + EDGE
    return {
        "flap": bending * np.sqrt(MODULUS * FLAP / (DENSITY * AREA)),
        "edge": bending * np.sqrt(MODULUS * EDGE / (DENSITY * AREA)),
        "stretch": ODD * np.sqrt(MODULUS / DENSITY),
        "torsion": ODD * np.sqrt(SHEAR * torsion_constant(WIDTH, THICKNESS) / (DENSITY * polar)),
    }


def test_frequencies_converge_with_the_fourth_power_to_closed_forms():
    sizes = np.array([3, 6, 12])
    found = [
        np.sqrt(scipy.linalg.eigh(m.stiffness, m.mass, eigvals_only=True))
        for m in (lobex.Beam.rectangular(elements=int(n), **UNIFORM).matrices() for n in sizes)
    ]
    for kind, exact in closed_forms().items():
        for omega in exact:
            nearest = np.array([np.min(np.abs(omegas / omega - 1)) for omegas in found])
            order = -np.polyfit(np.log(sizes[1:]), np.log(nearest[1:]), 1)[0]
            assert order == pytest.approx(4, abs=0.15), kind
            assert nearest[-1] < 2e-4, kind


def test_masses_are_symmetric_and_definite_and_coriolis_is_skew():
    m = lobex.Beam.rectangular(
        elements=4, width=[0.05, 0.03], thickness=lambda s: 0.004 * (1 - s / 2), twist_degrees=[0.0, 30.0, 35.0],
        stagger_degrees=20.0, hub_radius=0.3, **GIVEN,
    ).matrices()  # fmt: skip
    for matrix in m[:3]:
        assert matrix == pytest.approx(matrix.T, abs=1e-12 * np.abs(matrix).max())
    assert m.gyroscopic == pytest.approx(-m.gyroscopic.T, abs=1e-15)
    for matrix in m[:2]:
        scale = np.diag(matrix) ** -0.5
        assert np.linalg.eigvalsh(scale[:, None] * matrix * scale)[0] > 0
    # A force of inertia of the whole span that moves as one, but for what the clamped root takes.
    free = lobex.Beam.rectangular(elements=4, root_stiffness=np.ones(6), width=[0.05, 0.03], thickness=0.004, **GIVEN)
    mass = free.matrices().mass
    axial = np.zeros(len(mass))
    axial[3::8] = 1.0
    assert axial @ mass @ axial == pytest.approx(DENSITY * 0.04 * 0.004 * LENGTH, rel=1e-12)


def test_springs_at_the_root_are_between_free_and_clamped():
    clamped = lobex.Beam.rectangular(elements=3, **UNIFORM).modes(0.0, [1, 2, 3])
    stiff = lobex.Beam.rectangular(elements=3, root_stiffness=np.full(6, 1e14), **UNIFORM).modes(0.0, [1, 2, 3])
    assert stiff.angular_frequency == pytest.approx(clamped.angular_frequency, rel=1e-6)
    # A stiff blade that rolls on a soft spring about its root: ω² = k/(ρ A L³/3).
    soft = np.full(6, 1e12)
    soft[2] = 10.0
    rolling = lobex.Beam.rectangular(elements=3, root_stiffness=soft, **UNIFORM).modes(0.0, [1])
    inertia = DENSITY * AREA * LENGTH**3 / 3
    assert rolling.angular_frequency[0] == pytest.approx(np.sqrt(10.0 / inertia), rel=0.05)
    assert rolling.angular_frequency[0] < np.sqrt(10.0 / inertia)


def static(beam, **contact):
    """What a unit force at a contact moves it by: exact in nodes of a uniform beam."""
    seen, loading = beam.contact(**contact)
    return (seen.T @ np.linalg.solve(beam.matrices().stiffness, seen if loading is None else loading))[0, 0]


def test_a_contact_sees_what_the_tip_does_by_closed_form():
    chord = 0.02
    # The chord lies in the plane of the disc: flap along the axis, edge along the motion.
    beam = lobex.Beam.rectangular(elements=3, stagger_degrees=90.0, **UNIFORM)
    radial = LENGTH / (MODULUS * AREA)
    flap, edge = (LENGTH**3 / (3 * MODULUS * part) for part in (FLAP, EDGE))
    twist = LENGTH / (SHEAR * torsion_constant(WIDTH, THICKNESS))
    assert static(beam) == pytest.approx(radial, rel=1e-10)
    assert static(beam, normal=(0.0, 0.0, 2.0)) == pytest.approx(flap, rel=1e-8)
    assert static(beam, normal=(0.0, -1.0, 0.0)) == pytest.approx(edge, rel=1e-8)
    # A force beside the axis turns the tip: about the axis of the rotor, or about the span.
    assert static(beam, chord=chord) == pytest.approx(radial + chord**2 * LENGTH / (MODULUS * EDGE), rel=1e-8)
    assert static(beam, normal=(0, 0, 1), chord=chord) == pytest.approx(flap + chord**2 * twist, rel=1e-8)
    # Friction along the motion bends the edge, which the chord beyond the axis moves in by: nᵀR(n + μt).
    rubbing = {"sliding": (0.0, 1.0, 0.0), "friction": 0.3, "chord": chord}
    coupling = -chord * LENGTH**2 / (2 * MODULUS * EDGE)
    assert static(beam, **rubbing) - static(beam, chord=chord) == pytest.approx(0.3 * coupling, rel=1e-8)
    # The other edge of the chord.
    both = beam.contact(chord=[chord, -chord])[0]
    assert both.shape == (24, 2)
    assert both[:, 1] == pytest.approx(beam.contact(chord=-chord)[0][:, 0])


def test_each_contact_of_a_tip_has_its_own_normal_sliding_and_friction():
    beam = lobex.Beam.rectangular(elements=2, stagger_degrees=30.0, **UNIFORM)
    normals, slidings = [(1.0, 0.3, 0.1), (1.0, 0.0, 0.0)], [(-0.3, 1.0, 0.0), (0.0, 0.0, 2.0)]
    every = beam.contact(normals, slidings, [0.2, 0.4], chord=[0.02, -0.01])
    own = zip(normals, slidings, [0.2, 0.4], [0.02, -0.01], strict=True)
    each = [beam.contact(*one) for one in own]
    for side in (0, 1):
        assert every[side] == pytest.approx(np.concatenate([one[side] for one in each], axis=1))
    # What is said once is that of all.
    seen, loading = beam.contact(normals[0], slidings[0], [0.2, 0.4], chord=0.02)
    assert seen == pytest.approx(np.repeat(each[0][0], 2, axis=1))
    assert loading == pytest.approx(seen + (each[0][1] - each[0][0]) * [1.0, 2.0])
    modes = beam.modes(0.01, [1, 2, 3])
    assert beam.modes(0.01, [1, 2, 3], normal=normals).directions == 2
    assert modes.directions == 1


def test_modes_have_the_receptance_of_matrices_with_friction():
    beam = lobex.Beam.rectangular(elements=2, stagger_degrees=30.0, twist_degrees=[0.0, 20.0], **UNIFORM)
    contact = {"normal": (1.0, 0.3, 0.1), "sliding": (-0.3, 1.0, 0.0), "friction": 0.2, "chord": 0.02}
    modes = beam.modes(0.0, range(1, 17), **contact)
    seen, loading = beam.contact(**contact)
    mass, stiffness = beam.matrices()[:2]
    for omega in (300.0, 5000.0):
        direct = seen.T @ np.linalg.solve(stiffness - omega**2 * mass, loading)
        share = modes.shape * modes.loading / (modes.angular_frequency[:, None] ** 2 - omega**2)
        assert share.sum() == pytest.approx(direct[0, 0], rel=1e-8)


def test_one_contact_of_several_directions_is_seen_along_its_normal():
    shapes = np.array([[1.0, 0.2], [0.3, -0.5]])
    modes = lobex.Modes([100.0, 300.0], [0.01, 0.02], shapes)
    one = modes.in_contact([3.0, 4.0])
    assert one.shape[:, 0] == pytest.approx(shapes @ [0.6, 0.8])
    assert one.force_shape is None
    rubbing = modes.in_contact([3.0, 4.0], sliding=[-4.0, 3.0], friction=0.25)
    assert rubbing.loading[:, 0] == pytest.approx(shapes @ [0.6 - 0.2, 0.8 + 0.15])
    two = modes.in_contact([[3.0, 4.0], [1.0, 0.0]], [[-4.0, 3.0], [0.0, 1.0]], [0.25, 0.5])
    assert two.shape == pytest.approx(np.stack([one.shape[:, 0], shapes[:, 0]], axis=1))
    assert two.loading == pytest.approx(np.stack([rubbing.loading[:, 0], shapes @ [1.0, 0.5]], axis=1))
    poles = lobex.Modes.from_poles([-2.0 + 80.0j], np.outer([1.0, 0.5j], [0.4, 1.0])[None])
    whirling = poles.in_contact([3.0, 4.0], sliding=[-4.0, 3.0], friction=0.25)
    for name, vector in (("shape", [0.6, 0.8]), ("quadrature", [0.6, 0.8]), ("force_shape", [0.4, 0.95]),
                         ("force_quadrature", [0.4, 0.95])):  # fmt: skip
        assert getattr(whirling, name)[:, 0] == pytest.approx(getattr(poles, name) @ vector)


def test_a_twisted_tapered_beam_is_that_of_its_equations():
    def width(share):
        return WIDTH * (1 - 0.3 * share)

    def thickness(share):
        return THICKNESS * (1 - 0.5 * share)

    def section(x):
        b, h = width(x / LENGTH), thickness(x / LENGTH)
        return {"area": b * h, "flap": b * h**3 / 12, "edge": h * b**3 / 12, "angle": np.deg2rad(30 + 40 * x / LENGTH)}

    parts = {name: (lambda x, name=name: section(x)[name]) for name in ("area", "flap", "edge", "angle")}
    exact = frequencies(22, LENGTH, MODULUS, DENSITY, **parts, count=3)
    errors = []
    for elements in (6, 12):
        beam = lobex.Beam.rectangular(
            elements=elements, width=width, thickness=thickness, stagger_degrees=30.0,
            twist_degrees=lambda share: 40 * share, **GIVEN,
        )  # fmt: skip
        omega, _ = vibration_modes(*beam.matrices()[:2], range(1, 9))
        errors.append([np.min(np.abs(omega / one - 1)) for one in exact])
    order = np.log2(np.divide(*errors))
    assert order == pytest.approx(4, abs=0.4)
    assert np.max(errors[1]) < 2e-3
    # Values at equal steps are lines between them.
    steps = lobex.Beam.rectangular(
        elements=12, width=[WIDTH, 0.7 * WIDTH], thickness=[THICKNESS, 0.5 * THICKNESS], stagger_degrees=30.0,
        twist_degrees=[0.0, 40.0], **GIVEN,
    )  # fmt: skip
    for one, other in zip(steps.matrices(), beam.matrices(), strict=True):
        assert one == pytest.approx(other, rel=1e-9, abs=1e-12 * np.abs(other).max())


def test_the_torsion_constant_is_that_of_tables():
    # Timoshenko and Goodier, Theory of Elasticity, §109: 0.1406, 0.229, 0.312, and 1/3 − 0.21 h/b of a thin one.
    for ratio, factor in ((1.0, 0.1406), (2.0, 0.229), (10.0, 0.312)):
        assert torsion_constant(ratio, 1.0) == pytest.approx(factor * ratio, rel=2e-3)
    assert torsion_constant(50.0, 1.0) / 50 == pytest.approx(1 / 3 - 0.2100830 / 50, rel=1e-6)
    assert torsion_constant(1.0, 2.0) == pytest.approx(torsion_constant(2.0, 1.0), rel=1e-8)
