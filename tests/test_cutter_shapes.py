"""Cutters of any profile, against forces summed point by point and multipliers without a delay."""

import json
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lobex
from lobex.processes import profiled_teeth
from lobex.processes.edge_points import missed_by
from lobex.processes.plausible import implausible
from lobex.processes.process import fine_enough
from lobex.results.description import describe
from lobex.results.rebuild import rebuild
from problems import KN, KT, PLANE
from refusals import refused

KA, D = 1.2e8, 0.016
FINE = lobex.Duhamel(nodes=20)
TABLE = {"frequency": np.array([500.0, 560.0, 900.0]), "damping_ratio": [0.03, 0.02, 0.01], "mass": [1.2, 1.0, 4.0]}
SPACE = lobex.Modes.from_table(**TABLE, direction=["x", "y", "z"])
PHASE, PART = np.array([0.03, 0.21, 0.55, 0.83]), 0.17
WITHIN = PHASE[0] + PART * (np.arange(60) + 0.5) / 60


@jax.jit
def looked_up(system, phase):
    """H, its means over parts of the period that begin there, and what pushes."""
    pushed = sum(term.coefficient.at(phase)[..., 0] for term in system.forcing)
    return -system.at(phase).present, -system.mean(phase, phase + PART).present, pushed


def forces_of(process, depth, phase):
    with jax.enable_x64(True):
        return [np.asarray(part) for part in looked_up(process.system(50.0, depth), phase)]


def point_by_point(phase, teeth, depth, helix, corner, lead, window, points=4000):
    """Of d = K_t t + K_n n + K_a a, Σ ∫ d nᵀ and Σ ∫ d, (k, 3, 3) and (k, 3), by midpoints of a profile."""
    bottom = min(depth, corner * (1 - np.cos(lead)))
    share = (np.arange(points) + 0.5) / points
    angle = np.arccos(1 - bottom / corner) * share if corner else np.zeros(0)
    line = (depth - bottom) / np.sin(lead)
    kappa = np.r_[angle, np.full(points, lead)]
    width = np.r_[
        np.full(angle.size, corner * (angle[-1] + angle[0]) / points if corner else 0), np.full(points, line / points)
    ]
    height = np.r_[corner * (1 - np.cos(angle)), bottom + (depth - bottom) * share]
    phi = 2 * np.pi / teeth * (phase[:, None, None] + np.arange(teeth)[:, None]) - 2 * np.tan(helix) / D * height
    phi = np.mod(phi, 2 * np.pi)
    sine, cosine, zero = np.sin(phi), np.cos(phi), np.zeros_like(phi)
    n = np.stack([sine * np.sin(kappa), cosine * np.sin(kappa), zero - np.cos(kappa)])
    a = np.stack([sine * np.cos(kappa), cosine * np.cos(kappa), zero + np.sin(kappa)])
    force = KT * np.stack([cosine, -sine, zero]) + KN * n + KA * a
    cut = width * ((phi > window[0]) & (phi < window[1]))
    return np.einsum("aktz,bktz,ktz->kab", force, n, cut, optimize=True), np.einsum("aktz,ktz->ka", force, cut)


PROFILES = {
    "cylinder": (lobex.Cutter.end_mill(D, teeth=2, helix_degrees=30.0), 5e-3, 0.0, np.pi / 2),
    "ball": (lobex.Cutter.ball(D, teeth=2, helix_degrees=30.0), 5e-3, D / 2, np.pi / 2),
    "ball, deeper than its radius": (lobex.Cutter.ball(D, teeth=2, helix_degrees=30.0), 0.012, D / 2, np.pi / 2),
    "bull nose": (lobex.Cutter.bull_nose(D, 2e-3, teeth=2, helix_degrees=45.0), 9e-3, 2e-3, np.pi / 2),
    "straight ball": (lobex.Cutter.ball(D, teeth=2), 5e-3, D / 2, np.pi / 2),
    "straight inserts": (lobex.Cutter.inserts(D, 45.0, teeth=2), 2e-3, 0.0, np.pi / 4),
    "tapered": (
        lobex.Cutter.tapered(D, 10.0, teeth=2, corner_radius=3e-3, helix_degrees=30.0),
        6e-3,
        3e-3,
        np.radians(80),
    ),
}


def milling(cutter, modes=SPACE, **given):
    given = {"axial": KA, "radial_immersion": 0.6, "direction": "down"} | given
    return lobex.Milling(modes, cutter, KT, KN, **given)


@pytest.mark.parametrize("name", PROFILES)
def test_forces_of_a_profile_are_those_of_its_points(name):
    cutter, depth, corner, lead = PROFILES[name]
    process = milling(cutter, edge=[KT, KN, KA])
    helix = 0.0 if cutter.helix is None else float(cutter.helix)
    wanted, edge = point_by_point(PHASE, 2, depth, helix, corner, lead, list(map(float, process.engagement)))
    found, mean, pushed = forces_of(process, depth, np.r_[PHASE, WITHIN])
    # Of so many points, of which one more or less is in the cut.
    assert found[:4] == pytest.approx(wanted, abs=2e-3 * np.abs(wanted).max())
    assert pushed[:4] == pytest.approx(-edge, abs=2e-3 * np.abs(edge).max())
    assert mean[0] == pytest.approx(found[4:].mean(0), abs=3e-3 * np.abs(found).max())


def missed(value, force, period, steps=400):
    """How far μ is from an eigenvalue of the period's map of ż = A z − E (1 − 1/μ) H(t) C z, relative to it.

    The delay, which is the period, is in 1/μ, and there is nothing else of it: Runge and Kutta's method is enough.
    """
    omega, none = np.diag(2 * np.pi * TABLE["frequency"]), np.zeros((3, 3))
    drift = np.block([[none, np.eye(3)], [-(omega**2), -2 * np.diag(TABLE["damping_ratio"]) @ omega]])
    acting = np.array(
        [
            drift - (1 - 1 / value) * np.block([[none, none], [part / np.array(TABLE["mass"])[:, None], none]])
            for part in force
        ]
    )
    state, step = np.eye(6, dtype=complex), period / steps
    for first, middle, last in zip(acting[:-2:2], acting[1::2], acting[2::2], strict=True):
        slopes = [first @ state]
        for matrix, share in ((middle, 0.5), (middle, 0.5), (last, 1.0)):
            slopes.append(matrix @ (state + share * step * slopes[-1]))
        state = state + step / 6 * (slopes[0] + 2 * slopes[1] + 2 * slopes[2] + slopes[3])
    return np.min(np.abs(np.linalg.eigvals(state) - value)) / abs(value)


@pytest.mark.parametrize("name", ["ball", "bull nose"])
def test_multipliers_of_a_profile_solve_the_equation_in_which_the_delay_is_no_more(name):
    cutter, depth, corner, lead = PROFILES[name]
    process, speed = milling(cutter), 80.0
    value = lobex.multipliers(process, speed, depth, FINE)[0]
    window = list(map(float, process.engagement))
    force = point_by_point(np.arange(801) / 800, 2, depth, float(cutter.helix), corner, lead, window, points=300)[0]
    assert missed(value, force, 1 / (2 * speed)) < 3e-4
    # Which another multiplier does not.
    assert missed(1.01 * value, force, 1 / (2 * speed)) > 1e-3


@pytest.mark.search
def test_a_ball_with_even_pitch_moves_as_the_free_structure_under_its_nominal_force():
    """What a tooth meets is left by one that moved alike: a Fourier series of the force, through the receptance."""
    cutter, depth, corner, lead = PROFILES["ball"]
    feed, edge, speed, depth = 1e-4, 3e-5, 80.0, 1e-3
    # The same shares for the edge as for the chip, of a thickness of its own.
    process = milling(cutter, feed_per_tooth=feed, edge=[edge * KT, edge * KN, edge * KA])
    motion = lobex.orbit(process, speed, depth)
    count = 512
    window = list(map(float, process.engagement))
    matrix, column = point_by_point(np.arange(count) / count, 2, depth, float(cutter.helix), corner, lead, window, 2000)
    force = np.fft.rfft(-feed * matrix[:, :, 0] - edge * column, axis=0) / count
    omega = 2 * np.pi * 2 * speed * np.arange(len(force))[:, None]
    own, ratio, mass = 2 * np.pi * TABLE["frequency"], np.array(TABLE["damping_ratio"]), np.array(TABLE["mass"])
    seen = force / mass / (own**2 - omega**2 + 2j * ratio * own * omega)
    waves = np.exp(2j * np.pi * np.arange(len(force)) * np.asarray(motion.phase)[:, None])
    expected = np.real(waves @ (seen * np.where(np.arange(len(force)) > 0, 2, 1)[:, None]))
    assert motion.displacement.reshape(expected.shape) == pytest.approx(expected, abs=2e-3 * np.abs(expected).max())


@pytest.mark.search
@pytest.mark.parametrize("seed", range(12))
def test_multipliers_of_random_profiles_solve_it_too(seed):
    rng = np.random.default_rng(seed)
    helix, taper = rng.uniform(5, 55), rng.choice([0.0, rng.uniform(1, 40)])
    corner, depth = rng.uniform(0.05, 0.49) * D, rng.uniform(0.5e-3, 12e-3)
    cutter = lobex.Cutter.tapered(D, taper, teeth=2, corner_radius=corner, helix_degrees=helix)
    window = np.sort(rng.uniform(0, 180, 2))
    process, speed = milling(cutter, radial_immersion=None, angles_degrees=window), rng.uniform(60, 150)
    value = lobex.multipliers(process, speed, depth, FINE)[0]
    lead = np.radians(90 - taper)
    force = point_by_point(
        np.arange(1601) / 1600, 2, depth, np.radians(helix), corner, lead, np.radians(window), points=400
    )[0]
    assert missed(value, force, 1 / (2 * speed), steps=800) < 1e-3


@pytest.mark.search
def test_a_ball_in_space_comes_to_its_digits_with_few_nodes():
    process = milling(PROFILES["ball"][0])
    values = [abs(lobex.multipliers(process, 91.6, 4.7e-3, lobex.Duhamel(nodes=nodes))[0]) for nodes in (16, 24, 40)]
    assert values[0] == pytest.approx(values[2], rel=2e-9)
    assert values[1] == pytest.approx(values[2], rel=2e-10)


@pytest.mark.slow
def test_corners_that_vanish_leave_a_cylinder_to_first_order():
    cylinder = lobex.multipliers(milling(PROFILES["cylinder"][0]), 80.0, 5e-3, FINE)[0]
    corners = [lobex.Cutter.bull_nose(D, radius, teeth=2, helix_degrees=30.0) for radius in (1e-5, 2e-5)]
    apart = [abs(lobex.multipliers(milling(cutter), 80.0, 5e-3, FINE)[0] - cylinder) for cutter in corners]
    assert apart[1] / apart[0] == pytest.approx(2, rel=0.02)


def test_a_ball_has_derivatives_by_depth_and_corner():
    def force(numbers):
        cutter = replace(lobex.Cutter(2, D, helix=0.5), corner_radius=numbers[1])
        return milling(cutter, PLANE).system(80.0, numbers[0]).at(PHASE[:2]).present

    at = np.array([3e-3, 6e-3])
    with jax.enable_x64(True):
        value, slope = jax.jit(force), jax.jit(jax.jacfwd(force))
        slopes = np.asarray(slope(at))
        for index, step in enumerate(np.diag(1e-5 * at)):
            difference = np.asarray(value(at + step) - value(at - step)) / (2 * np.sum(step))
            assert slopes[..., index] == pytest.approx(difference, abs=1e-6 * np.abs(difference).max())
        assert np.all(np.isfinite(np.asarray(slope(np.array([0.0, 6e-3])))))


def stacked(count, helix=0.0, depth=6e-3, taper=10.0):
    """A tapered cutter as discs, with the lag of the middle of each."""
    thick = np.full(count, depth / count)
    lag = np.degrees(2 * np.tan(np.radians(helix)) / D * (np.cumsum(thick) - thick / 2))
    lead = np.full(count, 90 - taper)
    return lobex.Cutter.from_discs(D, thick, lag_degrees=lag, lead_degrees=lead, teeth=2)


@pytest.mark.slow
@pytest.mark.parametrize("direction", ["up", "down"])
def test_discs_of_a_ball_meet_a_wall_each_at_angles_of_its_own(direction):
    wall, depth, start = 0.4 * D / 2, 6e-3, np.arange(64) / 64
    # The heights of ``point_by_point``, of which those above the corner have no width.
    height = D / 2 * (1 - np.cos(np.arccos(1 - depth / (D / 2)) * (np.arange(1000) + 0.5) / 1000))
    radius = np.sqrt((D / 2) ** 2 - (D / 2 - height) ** 2)
    arc = np.r_[np.arccos(np.clip(wall / radius, -1, 1)), np.zeros(1000)]
    window = (0 * arc, arc) if direction == "up" else (np.pi - arc, np.pi + 0 * arc)
    wanted = point_by_point(start, 2, depth, np.pi / 6, D / 2, np.pi / 2, window, points=1000)[0]
    ball = lobex.Cutter.ball(D, teeth=2, helix_degrees=30.0)
    apart = []
    for count in (8, 32):
        process = milling(ball.in_discs(count, depth), direction=direction, radial_immersion=0.3)
        apart.append(np.linalg.norm(forces_of(process, depth, start)[0] - wanted) / np.linalg.norm(wanted))
    assert apart[1] < min(0.4 * apart[0], 0.03)


@pytest.mark.slow
def test_discs_come_to_the_profile_by_the_square_of_their_thickness():
    smooth = lobex.Cutter.tapered(D, 10.0, teeth=2, helix_degrees=30.0)
    start = np.arange(64) / 64
    means = [forces_of(milling(cutter), 6e-3, start)[1] for cutter in (smooth, stacked(6, 30.0), stacked(12, 30.0))]
    tapered = lobex.Cutter.tapered(D, 10.0, teeth=2)
    one, same = (forces_of(milling(cutter), 5e-3, start)[0] for cutter in (stacked(1), tapered))
    first, second = (np.linalg.norm(mean - means[0]) for mean in means[1:])
    assert first / second == pytest.approx(4, rel=0.25)
    # A single disc is as thick as it takes.
    assert one == pytest.approx(same, rel=1e-12, abs=1e-12 * np.abs(same).max())


def test_an_axis_that_is_off_is_a_runout_of_every_tooth():
    offset, angle = 2e-5, 25.0
    off = lobex.Cutter.end_mill(D, teeth=3, offset=offset, offset_degrees=angle)
    runout = offset * np.cos(2 * np.pi / 3 * np.arange(3) - np.radians(angle))
    found, wanted = (
        forces_of(milling(cutter, PLANE), 2e-3, PHASE)[2]
        for cutter in (off, lobex.Cutter.end_mill(D, teeth=3, runout=runout))
    )
    assert off.alike == 1
    assert found == pytest.approx(wanted, rel=1e-11)


def test_entry_and_exit_angles_stand_in_the_place_of_an_immersion():
    by_immersion = milling(4, PLANE, radial_immersion=0.25, direction="up")
    by_angles = milling(4, PLANE, radial_immersion=None, angles_degrees=[0.0, 60.0])
    assert by_angles.layout == by_immersion.layout
    system, same = (process.system(50.0, 1e-3) for process in (by_angles, by_immersion))
    for found, given in zip(jax.tree.leaves(system), jax.tree.leaves(same), strict=True):
        assert found == pytest.approx(given, rel=1e-15, abs=1e-15)
    with jax.enable_x64(True):
        slope = jax.jit(jax.grad(_mean_force))(1.2)
        difference = (_mean_force(1.2 + 1e-5) - _mean_force(1.2 - 1e-5)) / 2e-5
    assert float(slope) == pytest.approx(float(difference), rel=1e-7)


@jax.jit
def _mean_force(exit_):
    process = milling(4, PLANE, radial_immersion=None, angles=jnp.stack([jnp.zeros(()), exit_]))
    return process.system(80.0, 1e-3).mean(jnp.zeros(1), jnp.ones(1)).present[0, 0, 1]


@pytest.mark.parametrize(
    "cutter",
    [
        lobex.Cutter.inserts(D, 45.0, pitch_degrees=[100, 260], offset=1e-5),
        lobex.Cutter.from_discs(D, [1e-3, 2e-3], lag_degrees=[0, 5], teeth=2),
        PROFILES["tapered"][0],
    ],
    ids=["uneven inserts", "discs", "tapered"],
)
def test_a_description_is_enough_to_make_a_process_again(cutter):
    process = milling(cutter, radial_immersion=None, angles_degrees=[20.0, 100.0], edge=[1e4, 2e4, 0.0])
    again = rebuild(json.loads(json.dumps(describe(process))))
    for found, given in zip(jax.tree.leaves(again), jax.tree.leaves(process), strict=True):
        assert found == pytest.approx(given, rel=1e-15)
    assert again.layout == process.layout


def answered(process, speed, depth, waves, phase):
    """Σ H e^{−i waves τ} of the points of all edges, (k, 2, 2), τ in turns."""
    with jax.enable_x64(True):
        terms = process.system(speed, depth).feedback
        parts = [(np.asarray(term.coefficient.at(phase)), np.asarray(term.delay.shares(phase, 1.0))) for term in terms]
    return sum(force * np.exp(-1j * waves * share)[:, None, None] for force, share in parts)


def by_heights(helix, teeth, depth, window, waves, phase, count=200):
    """The same by Gauss' rule of many heights over what of each edge is in the cut."""
    points, weights = np.polynomial.legendre.leggauss(count)
    twist, total = 2 * np.tan(np.radians(helix)) / D, 0.0
    for tooth in range(teeth):
        tip = np.mod(2 * np.pi * (phase + tooth / teeth), 2 * np.pi)
        for turn in (tip, tip + 2 * np.pi):
            low, high = (np.clip((turn - angle) / twist[tooth], 0.0, depth) for angle in window[::-1])
            z = low + np.multiply.outer(points + 1, high - low) / 2
            phi = turn - twist[tooth] * z
            share = 1 / teeth - (twist[(tooth + 1) % teeth] - twist[tooth]) * z / (2 * np.pi)
            n = np.stack([np.sin(phi), np.cos(phi)])
            d = KT * np.stack([np.cos(phi), -np.sin(phi)]) + KN * n
            weight = weights[:, None] * (high - low) / 2 * np.exp(-1j * waves * share)
            total = total + np.einsum("zk,azk,bzk->kab", weight, d, n)
    return total


def edges_of(helix, **given):
    cutter = lobex.Cutter.end_mill(D, teeth=len(helix), helix_degrees=helix)
    return lobex.Milling(PLANE, cutter, KT, KN, 0.4, **given)


@pytest.mark.parametrize(("helix", "speed", "depth"), [([15.0, 48.0, 33.0], 60.0, 1.2e-2), ([38.0, 42.0], 140.0, 3e-3)])
def test_points_of_an_edge_are_as_many_as_the_tolerance_asks_for(helix, speed, depth):
    process, phase = edges_of(helix), (np.arange(8) + 0.37) / 8
    waves, window = float(np.max(PLANE.angular_frequency)) / speed, tuple(map(float, process.engagement))
    wanted = by_heights(np.array(helix), len(helix), depth, window, waves, phase)
    counts, left = [], []
    for tolerance in (1e-2, 1e-5, 1e-8):
        fine = fine_enough(process, np.array([speed, 300.0]), np.array([1e-3, depth]), tolerance)
        counts.append(fine.heights)
        left.append(np.abs(answered(fine, speed, depth, waves, phase) - wanted).max() / np.abs(wanted).max())
        assert left[-1] < tolerance
    assert counts[0] < counts[2] < 32
    # And no more than that: those of another tolerance are too few.
    assert left[0] > 1e-8


def test_points_of_an_edge_are_those_given_where_there_is_a_number():
    plain, given = milling(PROFILES["ball"][0]), edges_of([30.0, 45.0], heights=5)
    uneven = edges_of([30.0, 45.0])
    assert fine_enough(plain, 80.0, 5e-3, 1e-8) is plain
    assert fine_enough(given, 80.0, 5e-3, 1e-8) is given
    assert fine_enough(uneven, 80.0, np.zeros(0), 1e-8) is uneven
    with jax.enable_x64(True):
        shape = jax.eval_shape(lambda depth: fine_enough(uneven, 80.0, depth, 1e-8).system(80.0, depth), 5e-3)
    assert len(shape.feedback) == 2 * uneven.points
    # A tip to which a slow wave is a hundred turns.
    assert str(edges_of([10.0, 60.0]).doubt(0.1, 2e-2)).startswith(
        "of edges with a helix angle each 64 points may leave"
    )


def test_a_corner_has_points_for_any_tolerance(monkeypatch):
    # As steep as it may be in the cut once alone.
    system = milling(lobex.Cutter.ball(D, teeth=2, helix_degrees=77.0), PLANE).system(80.0, D / 2)
    with jax.enable_x64(True):
        # Two functions, each of which is compiled for itself.
        found = np.asarray(jax.jit(lambda phase: system.at(phase).present)(PHASE))
        monkeypatch.setattr(profiled_teeth, "_POINTS", 60)
        wanted = np.asarray(jax.jit(lambda phase: system.at(phase).present)(PHASE))
    assert np.all(np.isfinite(wanted))
    assert found == pytest.approx(wanted, abs=1e-12 * np.abs(wanted).max())


def test_points_of_an_edge_that_may_be_too_few_are_told():
    cutter = lobex.Cutter.end_mill(0.02, teeth=2, helix_degrees=[30.0, 45.0])
    process = lobex.Milling(PLANE, cutter, 6e8, 2e8, 0.5, heights=3)
    assert process.doubt(250.0, 1e-3) is None
    # Limits are sought up to the higher of their bounds.
    assert any("heights = 3" in message for message in implausible(process, [40.0], 1e-4, 6e-3))
    assert not any("heights = 3" in message for message in implausible(process, [250.0], 1e-4, 1e-3))
    told = str(process.doubt(np.array([40.0, 250.0]), np.array([1e-3, 6e-3])))
    count = int(told.partition("give ")[2].partition(",")[0])
    assert told.startswith("heights = 3 may leave")
    assert count > 3
    assert replace(process, heights=count).doubt(40.0, 6e-3) is None
    # What is said of them is what Gauss' rule of a wave leaves.
    for count, radians in ((3, 1.0), (5, 2.0)):
        points, weights = np.polynomial.legendre.leggauss(count)
        left = abs(weights @ np.cos(radians * points) / 2 - np.sin(radians) / radians)
        assert 0.5 < left / missed_by(radians, count) <= 1


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: lobex.Cutter.bull_nose(D, 0.009, teeth=2),
            "corner_radius = 0.009 m is above the radius of the cutter",
        ),
        (lambda: lobex.Cutter.bull_nose(D, -1e-3, teeth=2), "corner_radius = -0.001 must be positive"),
        (
            lambda: lobex.Cutter.end_mill(teeth=2, corner_radius=1e-3),
            "diameter = None with a corner; give the diameter",
        ),
        (lambda: lobex.Cutter.inserts(D, 0.0, teeth=2), r"lead_degrees = 0; give an angle above 0 and up to 90"),
        (lambda: lobex.Cutter.inserts(D, 91.0, teeth=2), r"lead_degrees = 91; give an angle above 0 and up to 90"),
        (lambda: lobex.Cutter.tapered(D, 90.0, teeth=2), r"taper_degrees = 90.0; give an angle from 0 to below 90"),
        (lambda: lobex.Cutter(2, D, lead=45.0), "lead = 45 rad; give an angle above 0 and up to π/2"),
        (
            lambda: lobex.Cutter.ball(D, teeth=2, helix_degrees=[30.0, 40.0]),
            "helix has an angle a tooth; give one helix",
        ),
        (lambda: lobex.Cutter.end_mill(D, teeth=2, offset_degrees=30.0), "offset = None with an angle of it"),
        (lambda: lobex.Cutter.from_discs(D, [1e-3, -1e-3], teeth=2), "thickness = .* must be positive"),
        (lambda: lobex.Cutter.from_discs(D, [1e-3] * 2, lag_degrees=[1.0], teeth=2), r"lag_degrees has shape \(1,\)"),
        (
            lambda: lobex.Cutter.from_discs(D, [1e-3], lead_degrees=[0.0], teeth=2),
            "lead_degrees = .*; give angles above",
        ),
        (lambda: lobex.Cutter.ball(D, teeth=2).in_discs(0, 1e-3), "count = 0 must be a whole number of at least 1"),
        (lambda: stacked(2).in_discs(2, 1e-3), "discs are made of a cutter with a diameter and one helix angle"),
        (lambda: lobex.Cutter.from_discs(D, [1e-3], radius=[0.0], teeth=2), "radius = .* must be positive"),
        (lambda: lobex.Cutter.from_discs(D, [1e-3], helix_degrees=30.0, teeth=2), "edges have a helix, a corner or a"),
        (lambda: milling(4, radial_immersion=None), "radial_immersion = None, angles = None: give one of them"),
        (
            lambda: lobex.Cutter.end_mill(D, pitch_degrees=["a", 90]),
            r"pitch_degrees = \['a', 90\] is no list of numbers",
        ),
        (lambda: lobex.Cutter.end_mill(D, teeth=2, runout=[[1e-5], 2]), "runout = .* is no list of numbers"),
        (
            lambda: milling(4, radial_immersion=None, angles_degrees=["a", 60]),
            r"angles_degrees = \['a', 60\] is no list of numbers",
        ),
        (lambda: lobex.Cutter.from_discs(D, ["a"], teeth=2), r"thickness = \['a'\] is no list of numbers"),
        (
            lambda: lobex.Cutter.end_mill(D, teeth=2, helix_degrees=[0, 30]),
            r"helix_degrees = \[0, 30\]; give angles above 0 of all teeth, or 0 of all",
        ),
        (lambda: milling(4, angles_degrees=[0.0, 60.0]), "radial_immersion = 0.6, angles = .*: give one of them"),
        (
            lambda: milling(4, radial_immersion=None, angles_degrees=[60.0, 30.0]),
            "angles are 60 and 30 degrees; give the",
        ),
        (lambda: milling(4, radial_immersion=None, angles_degrees=[60.0, 190.0]), "angles are 60 and 190 degrees"),
        (lambda: milling(4, radial_immersion=None, angles_degrees=[60.0]), r"angles has shape \(1,\); give 2 numbers"),
    ],
)
def test_what_is_no_profile_is_refused_in_one_line(call, message):
    with refused(match=message):
        call()
