"""The turning beam against published frequencies, collocation of its equations, and differences."""

import jax
import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

import lobex
from beam_collocation import frequencies
from lobex.limits.receptance import receptance
from lobex.structures.beam_matrices import BeamMatrices
from test_beam import AREA, DENSITY, EDGE, FLAP, LENGTH, MODULUS, THICKNESS, UNIFORM

# Flapwise ω/√(EI/ρAL⁴) of a uniform clamped beam on the axis, by η = Ω/√(EI/ρAL⁴): Wright, Smith, Thresher and Wang,
# Vibration modes of centrifugally stiffened beams, J. Appl. Mech. 49, 1982.
PUBLISHED = {
    0.0: (3.5160, 22.0345, 61.6972),
    1.0: (3.6816, 22.1810, 61.8418),
    2.0: (4.1373, 22.6149, 62.2732),
    4.0: (5.5850, 24.2733, 63.9668),
    10.0: (11.2023, 33.6404, 74.6493),
}
UNIT = np.sqrt(MODULUS * FLAP / (DENSITY * AREA * LENGTH**4))
# Seen where all motions take part.
CONTACT = {"normal": (1.0, 0.3, 0.1), "sliding": (-0.3, 1.0, 0.0), "friction": 0.2, "chord": 0.02}


def blade(elements=4, stagger=30.0, **changes):
    given = UNIFORM | {"twist_degrees": [0.0, 25.0], "hub_radius": 0.3} | changes
    return lobex.Beam.rectangular(elements=elements, stagger_degrees=stagger, **given)


def still(value):
    return lambda x: value + 0 * x


def flapping(matrices, spin):
    """ω of the vibrations without Coriolis forces."""
    return np.sqrt(
        scipy.linalg.eigh(matrices.stiffness + spin**2 * matrices.spin_stiffness, matrices.mass, eigvals_only=True)
    )


def off(found, exact):
    return np.array([np.min(np.abs(found / one - 1)) for one in np.atleast_1d(exact)])


def test_a_uniform_beam_stiffens_as_published():
    coarse, fine = (
        lobex.Beam.rectangular(elements=n, stagger_degrees=90.0, **UNIFORM).matrices() for n in (5, 10)
    )  # fmt: skip
    for eta, published in PUBLISHED.items():
        # With the chord in the plane of rotation flap is along the axis, where nothing softens nor couples.
        parts = {"area": still(AREA), "flap": still(FLAP), "edge": still(EDGE), "angle": still(np.pi / 2)}
        exact = frequencies(22, LENGTH, MODULUS, DENSITY, **parts, spin=eta * UNIT)
        assert off(exact / UNIT, published) * published == pytest.approx(0, abs=6e-5)
        errors = [off(flapping(m, eta * UNIT), np.array(published) * UNIT) for m in (coarse, fine)]
        assert np.max(errors[1] / [1e-4, 1e-4, 3e-4]) < 1


def test_it_converges_with_the_fourth_power_while_it_turns():
    spin = 2 * np.pi * 200.0
    taper = {
        "area": lambda x: AREA * (1 - x / (2 * LENGTH)),
        "flap": lambda x: FLAP * (1 - x / (2 * LENGTH)) ** 3,
        "edge": lambda x: EDGE * (1 - x / (2 * LENGTH)),
        "angle": lambda x: np.deg2rad(30 + 25 * x / LENGTH),
    }
    exact = frequencies(22, LENGTH, MODULUS, DENSITY, **taper, spin=spin, hub=0.3, count=3)
    tapered = [
        blade(n, thickness=[THICKNESS, THICKNESS / 2]).rotating(0.0, range(1, 9)).at(200.0).angular_frequency
        for n in (6, 12)
    ]
    errors = [off(omega, exact) for omega in tapered]
    assert np.log2(np.divide(*errors)) == pytest.approx(4, abs=0.5)
    assert np.max(errors[1]) < 1e-3


def test_in_the_plane_of_rotation_the_square_is_less_by_that_of_the_speed():
    spin = 2 * np.pi * 150.0
    out_of_plane, in_plane = (
        lobex.Beam.rectangular(elements=4, stagger_degrees=angle, hub_radius=0.1, **UNIFORM).matrices()
        for angle in (90.0, 0.0)
    )
    flap, lag = flapping(out_of_plane, spin), np.sqrt(flapping(in_plane, spin) ** 2 + spin**2)
    assert off(lag, flap[0]) < 1e-9


def test_stiffening_is_that_of_a_string_at_least():
    # Southwell's theorem, of a chain that flaps at Ω and a beam; and his coefficient of the first mode, 1.193.
    m = lobex.Beam.rectangular(elements=10, stagger_degrees=90.0, **UNIFORM).matrices()
    for spin in (0.5 * UNIT, 5 * UNIT):
        assert flapping(m, spin)[0] ** 2 > flapping(m, 0.0)[0] ** 2 + spin**2
    slope = (flapping(m, 0.01 * UNIT)[0] ** 2 - flapping(m, 0.0)[0] ** 2) / (0.01 * UNIT) ** 2
    assert slope == pytest.approx(1.193, abs=1e-3)


def test_torsion_turns_into_the_plane_of_rotation():
    # ω² = (k² GJ)/(ρ I_p) ± Ω² (I_edge − I_flap)/I_p, but for the tension that holds fibres straight.
    spin = 2 * np.pi * 100.0
    hard = UNIFORM | {"length": 0.05}
    squares = []
    for angle in (0.0, 90.0):
        m = lobex.Beam.rectangular(elements=6, stagger_degrees=angle, **hard).matrices()
        turns = np.zeros(len(m.mass), bool)
        turns[1::8] = turns[7::8] = True
        part = np.ix_(turns, turns)
        small = BeamMatrices(*(matrix[part] for matrix in m))
        squares.append(flapping(small, spin)[0] ** 2)
    assert squares[1] - squares[0] == pytest.approx(2 * spin**2 * (EDGE - FLAP) / (EDGE + FLAP), rel=1e-6)


def test_modes_at_a_speed_have_the_receptance_of_the_turning_matrices():
    beam = blade(2)
    m, (seen, loading) = beam.matrices(), beam.contact(**CONTACT)
    spin = 2 * np.pi * 120.0
    modes = beam.rotating(0.0, range(1, 17), **CONTACT).at(120.0)
    assert modes.complex
    for omega in (400.0, 3000.0, 20000.0):
        dynamic = m.stiffness + spin**2 * m.spin_stiffness - omega**2 * m.mass + 1j * omega * spin * m.gyroscopic
        direct = (seen.T @ np.linalg.solve(dynamic, loading))[0, 0]
        assert receptance(modes, omega) == pytest.approx(direct, rel=1e-8)
    # What does not turn has the modes at rest, and without Coriolis forces they stay in phase.
    rest = beam.rotating([0.01, 0.02], [1, 3], **CONTACT).at(1e-9)
    expected = beam.modes([0.01, 0.02], [1, 3], **CONTACT)
    assert receptance(rest, 900.0) == pytest.approx(receptance(expected, 900.0), rel=1e-8)
    given = {"spin_stiffness": m.spin_stiffness, "force": loading}
    real = lobex.Modes.from_matrices(*m[:2], seen, 0.0, range(1, 17), **given).at(120.0)
    assert not real.complex
    direct = seen.T @ np.linalg.solve(m.stiffness + spin**2 * m.spin_stiffness - 900.0**2 * m.mass, loading)
    assert receptance(real, 900.0) == pytest.approx(direct[0, 0], rel=1e-8)


def test_matrices_of_any_model_turn_dense_or_sparse():
    beam = blade(2)
    m, (seen, loading) = beam.matrices(), beam.contact(**CONTACT)
    turning = {"spin_stiffness": m.spin_stiffness, "gyroscopic": m.gyroscopic, "force": loading}
    expected = beam.rotating(0.01, [1, 2], **CONTACT)
    dense = lobex.Modes.from_matrices(*m[:2], seen, 0.01, [1, 2], **turning)
    sparse = {name: scipy.sparse.csr_array(part) for name, part in m._asdict().items()}
    lower = {name: scipy.sparse.tril(sparse[name]) for name in ("mass", "stiffness", "spin_stiffness")}
    half = lobex.Modes.from_matrices(
        **lower, gyroscopic=sparse["gyroscopic"], contact=seen, force=loading, damping_ratio=0.01, keep=[1, 2],
        triangle="lower",
    )  # fmt: skip
    for modes in (dense, half):
        assert isinstance(modes, lobex.RotatingModes)
        assert receptance(modes.at(120.0), 900.0) == pytest.approx(receptance(expected.at(120.0), 900.0), rel=1e-9)
    tip = np.concatenate([beam.contact(normal=along, chord=0.02)[0] for along in np.eye(3)], axis=1)
    three = lobex.Modes.from_matrices(*m[:2], tip, 0.01, [1, 2], spin_stiffness=m.spin_stiffness)
    one = three.in_contact(*(CONTACT[name] for name in ("normal", "sliding", "friction")))
    assert one.shape == pytest.approx(expected.shape, rel=1e-9, abs=1e-9)
    assert one.force_shape == pytest.approx(expected.force_shape, rel=1e-9, abs=1e-9)
    whirling = lobex.Modes.from_matrices(*m[:2], seen, 0.01, gyroscopic=m.gyroscopic)
    assert np.all(whirling.spin_stiffness == 0)
    assert whirling.divergence_speed == np.inf


def test_few_modes_at_rest_are_enough_for_a_speed():
    beam = blade(6)
    whole = beam.rotating(0.0, [1, 2, 3]).at(60.0).angular_frequency
    few = [beam.rotating(0.0, [1, 2, 3], basis=p).at(60.0).angular_frequency / whole - 1 for p in (8, 16, 32)]
    # Rayleigh and Ritz: from above.
    assert np.all(np.array(few) > -1e-12)
    assert np.all(np.max(few, axis=1) < [3e-4, 1e-4, 1e-5])


def changed(beam_of, numbers, index, step):
    return [beam_of(*(v * (1 + sign * step * (i == index)) for i, v in enumerate(numbers))) for sign in (1, -1)]


@pytest.mark.slow
def test_derivatives_by_thickness_twist_and_speed_are_those_of_differences():
    def seen(thickness, twist, speed):
        made = blade(1, thickness=lambda share: thickness * (1 - share / 3), twist_degrees=[0.0, twist])
        modes = made.rotating(0.01, [1, 2], **CONTACT).at(speed)
        share = modes.shape * modes.loading + modes.quadrature * modes.force_quadrature
        return modes.angular_frequency[0] + 1e3 * share.sum()

    numbers = (THICKNESS, 25.0, 120.0)
    with jax.enable_x64(True):
        slopes = jax.jit(jax.grad(seen, argnums=(0, 1, 2)))(*numbers)
    for index, (number, slope) in enumerate(zip(numbers, slopes, strict=True)):
        up, down = changed(seen, numbers, index, 1e-5)
        assert float(slope) == pytest.approx((up - down) / (2e-5 * number), rel=1e-6)
