"""Cutters of any pitch and helix: the laws of even pitch, of cyclic order and of constant coefficients, and errors."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lobex
from lobex.systems.coefficients import Constant
from lobex.systems.forced import as_feedback
from lobex.systems.mesh import mesh_of
from lobex.systems.terms import Regenerative
from problems import KN, KT, PLANE, pitched
from refusals import refused

METHOD = lobex.Duhamel(nodes=20)
EACH = lobex.Duhamel(nodes=10)
"""Nodes of the pieces of a helical tooth's period, of which there are four."""

MODE = lobex.Modes.single(frequency=500.0, damping_ratio=0.03, mass=1.2)


@jax.jit
def _looked_up(system, phase):
    return system.at(phase)


@jax.jit
def _averaged(system, start, stop):
    return system.mean(start, stop)


@jax.jit
def _pushing(system, phase):
    return sum(term.coefficient.at(phase) for term in system.forcing)


@pytest.mark.parametrize("direction", [pytest.param("down", marks=pytest.mark.slow), "up"])
def test_even_pitch_is_milling_taken_as_often_as_it_has_teeth(direction):
    even = lobex.Milling(PLANE, 4, KT, KN, 0.3, direction)
    once = lobex.multipliers(even, 70.0, 1e-3, lobex.Duhamel(nodes=14))
    # Runout makes the period a revolution, with a delay a tooth, and has no part in multipliers.
    cutter = lobex.Cutter.end_mill(teeth=4, runout=[1e-5, 0, 0, 0])
    uneven = lobex.Milling(PLANE, cutter, KT, KN, 0.3, direction)
    assert (even.cutter.alike, uneven.cutter.alike, len(uneven.system(70.0, 1e-3).delays)) == (4, 1, 4)
    whole = lobex.multipliers(uneven, 70.0, 1e-3, METHOD)
    assert abs(whole[0]) == pytest.approx(abs(once[0]) ** 4, rel=1e-8)


@pytest.mark.slow
def test_the_order_of_the_teeth_matters_and_where_it_begins_does_not():
    def leading(degrees):
        return abs(lobex.multipliers(pitched(degrees), 60.0, 2e-3, METHOD)[0])

    first = leading([70, 100, 85, 105])
    assert leading([85, 105, 70, 100]) == pytest.approx(first, rel=1e-8)
    assert leading([105, 85, 100, 70]) != pytest.approx(first, rel=1e-4)


def test_cutters_of_much_the_same_pitch_share_their_programs():
    near, far = pitched([88, 91, 89, 92], 0.2), pitched([82, 97, 83, 98], 0.2)
    assert jax.tree.structure(near) == jax.tree.structure(far)
    for process in (near, far):
        shortest, longest = process.layout.shortest, process.layout.longest
        assert shortest < process.cutter.shares.min() < process.cutter.shares.max() < longest
        assert longest / shortest < 1.5
    # Of an even pitch there is one delay, a period, to the digit.
    even = lobex.Milling(PLANE, 4, KT, KN, 0.2)
    assert (even.layout.shortest, even.layout.longest) == (1.0, 1.0)


def test_pieces_end_where_a_tooth_enters_or_leaves_and_where_their_delays_carry_that_into_the_cut():
    process = pitched([82, 98, 84, 96])
    mesh = mesh_of(process.system(50.0, 1e-3))
    assert mesh.pieces == len(process.layout.places.kept) < 8 + 32
    assert mesh.history < mesh.pieces
    assert float(np.sum(mesh.length)) == pytest.approx(1.0)
    # Those that repeat after half a turn have half as many, of a period that is half as long.
    halved = pitched([70, 110, 70, 110]).system(50.0, 1e-3)
    assert mesh_of(halved).pieces < mesh.pieces
    assert float(halved.period) == pytest.approx(0.5 / 50)
    assert len(halved.delays) == 2


@pytest.mark.slow
def test_mean_forces_are_those_of_quadrature():
    with np.errstate(all="raise"):
        term = pitched([80, 100, 75, 105], 0.8, "up").system(50.0, 1e-3).terms[1]
    start, stop = np.array([0.1, 0.63, 0.97]), np.array([0.13, 0.7, 1.05])
    phase = start[:, None] + (stop - start)[:, None] * (np.arange(4000) + 0.5) / 4000
    values = np.asarray(term.coefficient.at(phase.ravel())).reshape(3, 4000, 2, 2)
    assert np.asarray(term.coefficient.mean(start, stop)) == pytest.approx(
        np.mean(values, axis=1), rel=2e-3, abs=1e-3 * KT * 1e-3
    )


def test_mean_forces_of_feed_and_runout_are_those_of_quadrature():
    cutter = lobex.Cutter.end_mill(pitch_degrees=[80, 100, 75, 105], runout=[0, 1e-5, 0, 0])
    process = lobex.Milling(PLANE, cutter, KT, KN, 0.8, "up", feed_per_tooth=1e-4)
    system = process.system(50.0, 1e-3)
    # They cut what the teeth cut, and multipliers do not know of them.
    assert len(system.forcing) == 8
    assert mesh_of(system).pieces == mesh_of(pitched([80, 100, 75, 105], 0.8, "up").system(50.0, 1e-3)).pieces
    start, stop = np.array([0.1, 0.63, 0.97]), np.array([0.13, 0.7, 1.05])
    phase = start[:, None] + (stop - start)[:, None] * (np.arange(4000) + 0.5) / 4000
    values = sum(np.asarray(term.coefficient.at(phase.ravel())) for term in system.forcing)
    wanted = np.mean(values.reshape(3, 4000, 2), axis=1)
    assert np.asarray(system.mean_forcing(start, stop)) == pytest.approx(wanted, rel=2e-3, abs=1e-3 * KT * 1e-7)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"pitch_degrees": [90.0, 90.0, 90.0]}, "pitch_degrees sum to 270; give angles that make one turn, 360"),
        ({"pitch_degrees": []}, r"pitch_degrees has shape \(0,\); give one angle a tooth"),
        (
            {"teeth": 4, "helix_degrees": []},
            r"helix_degrees = \[\] has no angle; give one of all teeth, or one a tooth",
        ),
        ({"pitch_degrees": [[90.0], [270.0]]}, r"pitch_degrees has shape \(2, 1\); give one angle a tooth"),
        ({"pitch_degrees": [-90.0, 450.0]}, "pitch_degrees = .* must be positive"),
        ({"pitch_degrees": [90.0, np.nan]}, "pitch_degrees = .* has NaN"),
        ({"teeth": 2, "pitch_degrees": [180.0, 180.0]}, "teeth = 2, pitch_degrees = .* give the number"),
        ({}, "teeth = None, pitch_degrees = None: give the number"),
        ({"teeth": 0}, "teeth = 0 must be a whole number of at least 1"),
        ({"teeth": 2, "diameter": -0.02}, "diameter = -0.02 must be positive"),
        ({"teeth": 2, "diameter": 0.02, "helix_degrees": 90.0}, "helix_degrees = 90.0; give angles from 0 to below 90"),
        ({"teeth": 2, "diameter": 0.02, "helix_degrees": [30.0, -5.0]}, "helix_degrees = .* from 0 to below 90"),
        (
            {"teeth": 2, "diameter": 0.02, "helix_degrees": [30.0, 0.0]},
            r"helix_degrees = \[30.0, 0.0\]; give angles above 0 of all teeth",
        ),
        ({"teeth": 2, "diameter": 0.02, "helix_degrees": [30.0] * 3}, "helix has shape .* one a tooth"),
        ({"teeth": 2, "helix_degrees": 30.0}, "diameter = None with a helix; give the diameter"),
        ({"teeth": 4, "runout": [1e-5]}, r"runout has shape \(1,\); give one number in m a tooth"),
        ({"teeth": 4, "runout": [np.inf] * 4}, "runout = .* infinite"),
    ],
)
def test_what_is_no_cutter_is_refused_in_one_line(given, message):
    with refused(match=message):
        lobex.Cutter.end_mill(**given)


def test_degrees_are_recognised_where_radians_are_meant():
    with pytest.raises(ValueError, match=r"pitch sums to 360 rad.*Cutter\.end_mill"):
        lobex.Cutter(4, pitch=[90.0] * 4)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"cutter": "end mill"}, "cutter = 'end mill' is none; give a lobex.Cutter, or the number of teeth"),
        ({"cutter": 4, "teeth": 4}, "cutter = 4, teeth = 4: give one of them"),
        ({}, "cutter = None, teeth = None: give one of them"),
        ({"teeth": 4, "feed_per_tooth": 0.0}, "feed_per_tooth = 0 must be positive"),
    ],
)
def test_milling_takes_a_cutter_or_a_number_of_teeth(given, message):
    with pytest.raises(ValueError, match=message):
        lobex.Milling(PLANE, tangential=KT, normal=KN, radial_immersion=0.5, **given)


# --- helix

SMALL = {"diameter": 0.016, "teeth": 4}


def helical(degrees, direction="up", immersion=0.25, modes=PLANE):
    return lobex.Milling(modes, lobex.Cutter.end_mill(**SMALL, helix_degrees=degrees), KT, KN, immersion, direction)


@pytest.mark.slow
def test_a_helix_at_its_pitch_depth_has_the_constant_coefficients_of_the_mean():
    process, speed, depth = helical(45.0), 90.0, np.pi * SMALL["diameter"] / 4
    with jax.enable_x64(True):
        system, even = (each.system(speed, depth) for each in (process, helical(None)))
        forces = np.asarray(_looked_up(system, np.arange(9) / 9).present)
        # The mean of a straight cutter, of which each tooth is in turn where the edge is at some height.
        mean = np.asarray(_averaged(even, np.zeros(1), np.ones(1)).present)
    assert forces == pytest.approx(np.broadcast_to(mean, forces.shape), rel=1e-12)
    with jax.enable_x64(True):
        constant = replace(system, terms=(Regenerative(Constant(-forces[0])),))
        pairs = (EACH, system), (lobex.Duhamel(nodes=24), constant)
        matrices = [jax.jit(lambda one, by=method: by.operator(one).matrix)(each) for method, each in pairs]
        values = [np.abs(np.linalg.eigvals(matrix)).max() for matrix in matrices]
    assert values[0] == pytest.approx(values[1], rel=1e-9)


@pytest.mark.parametrize("depth", [1e-3, 0.03])
def test_mean_forces_of_a_helix_are_those_of_its_heights(depth):
    process = helical(45.0, "down", 0.6)
    phase, height = 0.137 + np.arange(3) / 3, depth * (np.arange(20000) + 0.5) / 20000
    angle = (2 * np.pi / 4 * (phase[:, None] + np.arange(4)))[..., None] - 2 / SMALL["diameter"] * height
    angle = np.mod(angle, 2 * np.pi)
    sine, cosine = np.sin(angle), np.cos(angle)
    cutting = (angle > np.arccos(2 * 0.6 - 1)) & (angle < np.pi)
    wanted = [(cutting * (KT * cosine + KN * sine) * sine).mean(-1).sum(1) * depth]
    wanted += [(cutting * (KN * cosine - KT * sine) * cosine).mean(-1).sum(1) * depth]
    with jax.enable_x64(True):
        system = process.system(50.0, depth)
        mean = np.asarray(_averaged(system, phase[:1], phase[:1] + 0.3).present[0])
        phases = np.concatenate([phase, phase[0] + 0.3 * (np.arange(2000) + 0.5) / 2000])
        forces, every = np.split(np.asarray(_looked_up(system, phases).present), [3])
        forces = -forces
    assert np.stack([forces[:, 0, 0], forces[:, 1, 1]]) == pytest.approx(np.stack(wanted), rel=2e-3)
    assert mean == pytest.approx(every.mean(0), rel=1e-5)


@pytest.mark.slow
def test_symmetric_structures_cut_up_as_they_cut_down_with_a_helix():
    both = lobex.Modes.plane(x=MODE, y=MODE)
    up, down = (helical(30.0, direction, modes=both) for direction in ("up", "down"))
    values = [abs(lobex.multipliers(mill, 90.0, 6e-3, EACH)[0]) for mill in (up, down)]
    assert values[0] == pytest.approx(values[1], rel=1e-9)


@pytest.mark.slow
def test_derivatives_by_depth_helix_and_immersion_are_those_of_differences():
    def radius(numbers):
        depth, helix, immersion = numbers
        cutter = lobex.Cutter(4, SMALL["diameter"], helix=helix)
        return lobex.spectral_radius(lobex.Milling(PLANE, cutter, KT, KN, immersion, "up"), 90.0, depth, EACH)

    at = np.array([6e-3, 0.5, 0.25])
    with jax.enable_x64(True):
        slopes = np.asarray(jax.jit(jax.grad(radius))(at))
        value = jax.jit(radius)
        for slope, step in zip(slopes, np.diag(1e-5 * at), strict=True):
            difference = float(value(at + step) - value(at - step)) / (2 * np.sum(step))
            assert slope == pytest.approx(difference, rel=1e-6)


def test_a_small_helix_comes_to_a_straight_cutter_by_its_square():
    straight = lobex.multipliers(helical(None), 90.0, 3e-3, EACH)[0]
    apart = [abs(lobex.multipliers(helical(a), 90.0, 3e-3, EACH)[0] - straight) for a in (1.0, 2.0)]
    assert apart[1] / apart[0] == pytest.approx(4, rel=0.1)


@pytest.fixture(scope="module")
def two_teeth():
    def made(helix):
        tool = lobex.Modes.single(frequency=922.0, damping_ratio=0.011, mass=0.03993)
        cutter = lobex.Cutter.end_mill(0.02, teeth=2, helix_degrees=helix)
        return lobex.Milling(tool, cutter, 6e8, 2e8, 0.1, "up", feed_per_tooth=1e-4, heights=4)

    return made


@pytest.mark.slow
def test_edges_of_different_helix_meet_what_was_left_longer_ago_at_one_height_than_at_another(two_teeth):
    # Of two independent codes, at 15000 rpm and 3 mm.
    value = lobex.multipliers(two_teeth([30.0, 35.0]), 250.0, 3e-3, EACH)[0]
    assert [value.real, abs(value.imag)] == pytest.approx([0.03001599, 1.36216502], abs=5e-8)
    # Edges of the same helix, over a revolution instead of a tooth's pass.
    each = lobex.multipliers(two_teeth([30.0, 30.0]), 250.0, 3e-3, EACH)[0]
    one = lobex.multipliers(two_teeth(30.0), 250.0, 3e-3, EACH)[0]
    assert abs(each) == pytest.approx(abs(one) ** 2, rel=1e-8)


def test_feed_along_edges_of_different_helix_is_that_of_their_pitch_at_every_height(two_teeth):
    phase = np.arange(40) / 40
    with jax.enable_x64(True):
        each, one = (two_teeth(helix).system(250.0, 3e-3) for helix in ([30.0, 30.0], 30.0))
        forces = [_pushing(system, place) for system, place in ((each, phase), (one, 2 * phase))]
    assert np.asarray(forces[0]) == pytest.approx(np.asarray(forces[1]), rel=1e-8)


def test_an_edge_that_is_in_the_cut_twice_at_a_time_has_no_number_where_helix_angles_differ(two_teeth):
    with jax.enable_x64(True):
        forces = _looked_up(two_teeth([30.0, 35.0]).system(250.0, 0.1), np.arange(4) / 4).present
    assert np.isnan(np.asarray(forces)).all()


# --- process damping


def damped(coefficient, friction=0.3, **others):
    tool = lobex.Modes.single(frequency=500.0, damping_ratio=0.03, mass=1.0)
    across = replace(tool, shape=np.array([[0.0, 1.0]]))
    cutter = lobex.Cutter.end_mill(0.02, teeth=4)
    damping = lobex.ProcessDamping(coefficient, friction)
    return lobex.Milling(across, cutter, 1.5e9, 6e8, 0.5, "down", process_damping=damping, **others)


@pytest.mark.slow
def test_process_damping_of_milling_is_that_of_independent_codes_and_none_without_it():
    method = lobex.Duhamel(nodes=40)
    value = lobex.multipliers(damped(1e5), 2000 / 60, 1.5e-3, method)[0]
    assert [value.real, abs(value.imag)] == pytest.approx([0.6646433069, 0.8914549727], abs=1e-9)
    none = lobex.multipliers(damped(0.0, 0.0), 2000 / 60, 1.5e-3, method)[0]
    plain = lobex.multipliers(replace(damped(0.0), process_damping=None), 2000 / 60, 1.5e-3, method)[0]
    assert abs(none) == pytest.approx(abs(plain), rel=1e-8)


UNEVEN = {
    "plain": {},
    "fed": {"feed_per_tooth": 1e-4},
    "damped": {"process_damping": lobex.ProcessDamping(5e4, 0.3)},
    "both": {"feed_per_tooth": 1e-4, "process_damping": lobex.ProcessDamping(5e4, 0.3)},
}


def uneven(**given):
    cutter = lobex.Cutter.end_mill(0.02, pitch_degrees=[70, 110, 70, 110])
    return lobex.Milling(PLANE, cutter, 6.79e8, 1.73824e8, 0.5, "down", **given)


@pytest.mark.parametrize("given", UNEVEN.values(), ids=UNEVEN)
def test_pieces_end_at_the_same_places_whatever_else_acts_and_traced_or_not(given):
    process = uneven(**given)

    def starts(speed):
        return jnp.sort(jnp.mod(mesh_of(as_feedback(process.system(speed, 1e-3))).start, 1.0))

    with jax.enable_x64(True):
        for found in (starts(20.0), jax.jit(starts)(20.0)):
            # With the middles of the two widest.
            assert 180 * np.asarray(found) == pytest.approx([0, 20, 40, 65, 90, 110, 135, 160], abs=1e-9)


def test_process_damping_at_uneven_pitch_is_that_of_independent_codes():
    value = lobex.multipliers(uneven(**UNEVEN["damped"]), 1200 / 60, 1e-3, lobex.Duhamel(nodes=24))[0]
    assert abs(value) ** 2 == pytest.approx(0.07441786272, rel=1e-8)


def test_process_damping_of_turning_is_that_of_independent_codes():
    tool = lobex.Modes.single(frequency=450.0, damping_ratio=0.0316, mass=0.8106)
    damping = lobex.ProcessDamping(611000.0)
    turning = lobex.Turning(tool, 1.5e9, diameter=0.035, process_damping=damping)
    value = lobex.sweep(turning, [500 / 60], [2e-3]).multiplier[0, 0]
    assert [value.real, abs(value.imag)] == pytest.approx([0.160736030252, 0.597011995902], rel=1e-9)


def test_damping_of_a_wear_land_is_the_force_of_what_the_flat_presses_in():
    indentation, land, speed = 1.5e14, 8e-5, 3.0
    worn = lobex.ProcessDamping.from_wear_land(indentation, land, friction=0.3)
    assert (worn.coefficient, worn.friction) == (pytest.approx(4.8e5, rel=1e-15), 0.3)
    # A flat at the height of the edge, over the wave that this cut a little earlier: of waves ever longer.
    for waves in (1e3, 1e2):

        def height(time, waves=waves):
            return np.sin(waves * time)

        points, weights = np.polynomial.legendre.leggauss(20)
        behind = land / 2 * (points + 1)
        volume = land / 2 * weights @ (height(0.0) - height(-behind / speed))
        assert indentation * volume == pytest.approx(worn.coefficient / speed * waves, rel=(waves * land / speed) ** 2)


def test_derivatives_by_the_wear_land_are_differences():
    tool = lobex.Modes.single(frequency=450.0, damping_ratio=0.0316, mass=0.8106)

    def radius(land):
        worn = lobex.ProcessDamping.from_wear_land(1.5e14, land)
        return lobex.spectral_radius(lobex.Turning(tool, 1.5e9, diameter=0.035, process_damping=worn), 100.0, 2e-3)

    with jax.enable_x64(True):
        slope = float(jax.grad(radius)(8e-5))
    ends = [radius(land) for land in (8e-5 - 1e-8, 8e-5 + 1e-8)]
    assert slope == pytest.approx((ends[1] - ends[0]) / 2e-8, rel=1e-6)


@pytest.mark.parametrize(
    ("given", "message"),
    [((1.5e5, 8e-5), "1e14 for 100000 N/mm³"), ((1.5e14, 0.08), "wear_land = 0.08 m is more than any tool has")],
)
def test_a_wear_land_in_other_units_is_told(given, message):
    with pytest.warns(lobex.LobexWarning, match=message):
        lobex.ProcessDamping.from_wear_land(*given)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: lobex.Milling(MODE, 4, KT, KN, 0.5, process_damping=lobex.ProcessDamping(1e5)),
            "diameter = None with process damping; give that at which is cut, in m",
        ),
        (lambda: lobex.Turning(MODE, 1e9, process_damping=lobex.ProcessDamping(1e5)), "diameter = None with process"),
        (lambda: lobex.Turning(MODE, 1e9, diameter=0.02, process_damping=1e5), r"give lobex.ProcessDamping\(coeff"),
        (lambda: lobex.Turning(MODE, 1e9, diameter=-0.02), "diameter = -0.02 must be positive"),
        (lambda: lobex.ProcessDamping(-1e5), "coefficient = -100000 must not be negative"),
        (lambda: lobex.ProcessDamping.from_wear_land(1e14, -1e-4), "wear_land = -0.0001 must not be negative"),
        (lambda: lobex.ProcessDamping.from_wear_land(0.0, 1e-4), "indentation_coefficient = 0 must be positive"),
    ],
)
def test_process_damping_asks_for_a_diameter_and_numbers_that_there_are(call, message):
    with refused(match=message):
        call()


def test_an_uneven_helical_tool_that_takes_more_than_there_is_is_refused_before_computing(monkeypatch):
    cutter = lobex.Cutter.end_mill(0.02, pitch_degrees=[81, 97, 86, 96], helix_degrees=30)
    process = lobex.Milling(PLANE, cutter, KT, KN, 0.5)
    monkeypatch.setattr("lobex._memory.available_memory", lambda: 10**8)
    with refused(match=r"nodes = 36 in each of the \d+ pieces of a period: they would need .* give fewer by lobex.Duh"):
        lobex.spectral_radius(process, 50.0, 2e-3, lobex.Duhamel(nodes=36))
