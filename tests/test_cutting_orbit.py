"""What teeth do along an orbit: against closed forms, the structure's own balance, sums over the edges, and a march."""

from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lobex
from lobex.motions.cut_along import cut_along, walls
from lobex.motions.periodic import periodic
from problems import KN, KT, PLANE
from refusals import refused

FEED, RADIUS, IMMERSION = 1e-4, 0.008, 0.5
ENTRY, EXIT = np.pi / 2, np.pi
EVEN = lobex.Milling(PLANE, lobex.Cutter.end_mill(2 * RADIUS, teeth=4), KT, KN, IMMERSION, "down", feed_per_tooth=FEED)
SPEED, DEPTH = 4000 / 60, np.array([5e-4, 1e-3])
PITCH, STEPS, LAG = np.array([2, 4]) * np.pi / 3, np.array([2e-6, -2e-6]), 2 * np.tan(np.pi / 6) / (2 * RADIUS)
FLANK = lobex.ProcessDamping(2e4, 0.3)
UNEVEN = lobex.Milling(
    PLANE,
    lobex.Cutter.end_mill(2 * RADIUS, pitch_degrees=[120, 240], helix_degrees=30, runout=[2e-6, 0]),
    KT,
    KN,
    IMMERSION,
    "down",
    feed_per_tooth=FEED,
    process_damping=FLANK,
)
DEEP, HEIGHT = 1e-3, np.linspace(0, 1, 5)
TIPS = np.array([0.0, PITCH[0]])
"""Where the teeth are at t = 0."""


def between_jumps():
    """Phases by Gauss' rule between the places where tips and ends of edges enter and leave, with weights."""
    ends = np.sort(np.mod([a + b - tip for a in (ENTRY, EXIT) for b in (0, LAG * DEEP) for tip in TIPS], 2 * np.pi))
    ends = np.r_[ends, ends[0] + 2 * np.pi] / (2 * np.pi)
    points, weights = np.polynomial.legendre.leggauss(16)
    length = np.diff(ends)[:, None]
    return (ends[:-1, None] + length * (points + 1) / 2).ravel(), (length * weights / 2).ravel()


GAUSS, WEIGHT = between_jumps()
BEFORE = [GAUSS - pitch / (2 * np.pi) for pitch in PITCH]
PHASE = np.concatenate([GAUSS, *BEFORE])


@jax.jit
@partial(jax.jacfwd, argnums=(0, 1), has_aux=True)
def told(speed, feed):
    """What derivatives are looked at, of even teeth."""
    process = replace(EVEN, feed_per_tooth=feed)
    motion = lobex.orbit(process, speed, DEPTH, lobex.Duhamel(nodes=12), phase=GAUSS)
    slopes = {name: getattr(motion, name) for name in ("surface_location_error", "mean_power")}
    return slopes, {**slopes, "status_code": motion.status_code}


@jax.jit
def along(process, phase, height):
    """The motion and the cut of a process, by the program that an orbit runs at each point."""
    system, wall = process.system(SPEED, DEEP), walls(process, DEEP, height)
    found, path = periodic(system, lobex.Duhamel(nodes=16), jnp.concatenate([phase, wall]))
    motion, left = jnp.split(found.output, [len(phase)])
    return motion, cut_along(process, SPEED, DEEP, system, path, phase, left, height, 16)


def worked(process):
    with jax.enable_x64(True):
        motion, cut = along(process, PHASE, HEIGHT)
    return SimpleNamespace(displacement=np.asarray(motion), **jax.tree.map(np.asarray, cut._asdict()))


@pytest.fixture(scope="module")
def even():
    return worked(EVEN)


@pytest.fixture(scope="module")
def uneven():
    return worked(UNEVEN)


def summed(phase, now, before):
    """Force, torque, and mean thickness of the chips, by a sum over 4000 heights, of the motion now and a pitch ago."""
    omega = PLANE.angular_frequency[0]
    height = DEEP * (np.arange(4000) + 0.5) / 4000
    force, torque, chips = np.zeros((len(phase), 2)), np.zeros(len(phase)), []
    for tip, pitch, step, past in zip(TIPS, PITCH, STEPS, before, strict=True):
        angle = np.mod(2 * np.pi * phase[:, None] + tip - LAG * height, 2 * np.pi)
        cuts = (angle > ENTRY) & (angle < EXIT)
        n, t = np.array([np.sin(angle), np.cos(angle)]), np.array([np.cos(angle), -np.sin(angle)])
        chip = 2 * FEED * pitch / (2 * np.pi) * n[0] + step + np.einsum("apz,pa->pz", n, (now - past)[:, :2])
        rate = FLANK.coefficient / (2 * np.pi * RADIUS * SPEED) * np.einsum("apz,pa->pz", n, omega * now[:, 2:])
        along = KT * chip + FLANK.friction * rate
        force -= np.einsum("apz->pa", cuts * (along * t + (KN * chip + rate) * n)) * DEEP / 4000
        torque += RADIUS * np.sum(cuts * along, axis=1) * DEEP / 4000
        chips.append(np.sum(cuts * chip, axis=1) / np.maximum(np.sum(cuts, axis=1), 1))
    return force, torque, np.array(chips).T


def test_even_teeth_take_the_chip_of_the_feed_whatever_the_motion(even):
    angle = np.mod(np.pi / 2 * (PHASE[:, None] + np.arange(4)), 2 * np.pi)
    cuts = (angle > ENTRY) & (angle < EXIT)
    chip = np.where(cuts, FEED * np.sin(angle), 0.0)
    assert even.chip_thickness == pytest.approx(chip, abs=1e-9 * FEED)
    along = DEEP * np.sum((KT * np.cos(angle) + KN * np.sin(angle)) * chip, axis=1)
    across = DEEP * np.sum((KN * np.cos(angle) - KT * np.sin(angle)) * chip, axis=1)
    force = -np.stack([along, across], axis=1)
    assert even.force == pytest.approx(force, rel=1e-7, abs=1e-7 * np.abs(force).max())
    assert even.torque == pytest.approx(RADIUS * KT * DEEP * chip.sum(axis=1), rel=1e-7)
    # One tooth is in the cut at a time, from the thickest chip on, down to none.
    assert even.highest_torque == pytest.approx(RADIUS * KT * DEEP * FEED, rel=1e-7)
    # Work in a turn over a turn: that of every tooth, K_t b f (cos φ_entry − cos φ_exit) times the radius.
    assert even.mean_torque == pytest.approx(4 * RADIUS * KT * DEEP * FEED / (2 * np.pi), rel=1e-7)
    assert even.pulled == pytest.approx(0, abs=1e-12)


def test_the_wall_is_where_the_tool_is_when_teeth_pass_it(even):
    # Of two independent codes.
    assert even.surface_location_error == pytest.approx(np.full((4, 5), -3.37726288e-06), rel=1e-8)


@pytest.mark.search
def test_derivatives_are_those_of_the_closed_form_and_of_differences():
    with jax.enable_x64(True):
        slopes, found = told(SPEED, FEED)
        low, high = (told(SPEED + side, FEED)[1] for side in (-0.01, 0.01))
    assert not found["status_code"].any()
    for name, (by_speed, by_feed) in slopes.items():
        assert np.asarray(by_feed) == pytest.approx(np.asarray(found[name]) / FEED, rel=1e-9)
        assert np.asarray(by_speed) == pytest.approx(np.asarray(high[name] - low[name]) / 0.02, rel=1e-4)


@pytest.mark.slow
def test_the_force_is_what_the_structure_answers_to_as_it_moves(uneven):
    for axis in range(2):
        omega, ratio = PLANE.angular_frequency[axis], PLANE.damping_ratio[axis]
        mass = 1 / PLANE.shape[axis, axis] ** 2
        for harmonic in range(6):
            turning = WEIGHT * np.exp(-2j * np.pi * harmonic * GAUSS)
            s = 2j * np.pi * harmonic * SPEED
            moved = turning @ uneven.displacement[: len(GAUSS), axis]
            pushed = turning @ uneven.force[: len(GAUSS), axis]
            size = np.abs(uneven.force).max()
            assert mass * (s**2 + 2 * ratio * omega * s + omega**2) * moved == pytest.approx(pushed, abs=1e-6 * size)


@pytest.mark.slow
def test_what_the_spindle_does_not_give_to_the_chip_is_lost_in_damping(uneven):
    """The work of the force on the structure is what its dampers take, and the torque is that of the edges."""
    velocity = PLANE.angular_frequency[0] * uneven.displacement[: len(GAUSS), 2:]
    force = uneven.force[: len(GAUSS)]
    damping = 2 * PLANE.damping_ratio * PLANE.angular_frequency / np.diag(PLANE.shape) ** 2
    lost = WEIGHT @ (velocity**2 @ damping)
    assert WEIGHT @ np.sum(force * velocity, axis=1) == pytest.approx(lost, rel=1e-5)
    assert uneven.mean_torque == pytest.approx(WEIGHT @ uneven.torque[: len(GAUSS)], rel=1e-7)


def test_force_torque_and_chips_are_sums_over_the_edges(uneven):
    now, *before = np.split(uneven.displacement, 3)
    force, torque, chips = summed(GAUSS, now, before)
    assert uneven.force[: len(GAUSS)] == pytest.approx(force, abs=2e-3 * np.abs(force).max())
    assert uneven.torque[: len(GAUSS)] == pytest.approx(torque, abs=2e-3 * torque.max())
    inside = chips > 0.2 * FEED
    assert uneven.chip_thickness[: len(GAUSS)][inside] == pytest.approx(chips[inside], rel=5e-3)
    assert uneven.highest_torque == pytest.approx(torque.max(), rel=5e-3)
    assert uneven.highest_torque >= uneven.torque.max() * (1 - 1e-9)


def test_the_wall_of_a_helix_is_that_of_its_edge_at_every_height(uneven):
    passing = (np.pi + LAG * DEEP * HEIGHT - TIPS[:, None]) / (2 * np.pi)
    with jax.enable_x64(True):
        again = np.asarray(along(UNEVEN, np.resize(passing.ravel(), len(PHASE)), HEIGHT)[0])
    assert uneven.surface_location_error.ravel() == pytest.approx(again[: passing.size, 1], rel=1e-9)


# --- two teeth of which one stands out, on a tool that gives way along the feed

STEP = 2e-5
STEPPED = lobex.Milling(
    lobex.Modes.single(frequency=600.0, damping_ratio=0.03, mass=1.0),
    lobex.Cutter.end_mill(2 * RADIUS, teeth=2, runout=[STEP, 0.0]),
    KT,
    KN,
    IMMERSION,
    "up",
    feed_per_tooth=FEED,
)


@pytest.fixture(scope="module")
def stepped():
    with pytest.warns(lobex.SweepWarning, match="1 of 1 points have a tooth that leaves the cut, which for up to"):
        return lobex.orbit(STEPPED, SPEED, DEEP, lobex.Duhamel(nodes=24), phase=np.arange(360) / 360)


@pytest.mark.slow
def test_a_tooth_that_leaves_the_cut_is_told(stepped):
    assert stepped.status == "tooth leaves the cut"
    assert np.isfinite(stepped.displacement).all()
    # The tooth behind one that stands out enters late.
    assert stepped.pulled[1] > 0.01 > 1e-6 > stepped.pulled[0]
    assert stepped.chip_thickness[:, 1].min() < -0.9 * STEP
    # Nothing is known of the motion across the feed.
    assert np.isnan(stepped.surface_location_error).all()


@pytest.mark.search
def test_a_march_comes_to_the_torque_of_the_orbit(stepped):
    apart = []
    for steps in (360, 720):
        march = lobex.march_delay(STEPPED, SPEED, DEEP, lambda t: 0 * t, 30, steps, state=np.zeros(2))
        last = march.displacement[-steps - 1 : -1, 0]
        angle = 2 * np.pi * np.arange(steps) / steps
        torque = np.zeros(steps)
        for tooth, step in enumerate((STEP, -STEP)):
            angle_of = np.mod(angle + np.pi * tooth, 2 * np.pi)
            chip = (FEED + last - np.roll(last, steps // 2)) * np.sin(angle_of) + step
            torque += RADIUS * KT * DEEP * chip * (angle_of < np.pi / 2)
        torque = torque[:: steps // 360]
        # Not on a jump.
        inside = np.mod(np.arange(360), 90) > 0
        apart.append(np.abs(torque - stepped.torque)[inside].max() / stepped.highest_torque)
    assert apart[1] < 1e-3
    assert apart[0] / apart[1] == pytest.approx(4, rel=0.1)


@pytest.mark.slow
def test_result_of_a_cut_is_drawn_and_told(stepped):
    assert "mean power" in repr(stepped)
    assert f" rpm\n  gain             {1e3 * DEEP:.6g} mm (depth of cut b)\n  displacement" in repr(stepped)
    assert len(stepped.plot_cut().axes) == 3
    assert stepped.plot_wall().get_xlabel().startswith("material left")
    with pytest.raises(ValueError, match="lane = 1 is none of the 1 lanes; give 0 to 0"):
        stepped.plot_cut(lane=1)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"height": [1.5]}, r"height = \[1.5\] must be a list of shares of the depth of cut, from 0 to 1"),
        ({"height": []}, "height = .* must be a list of shares"),
        ({"process": replace(EVEN, feed_per_tooth=None)}, "process has no forcing"),
        ({"process": lobex.Scalar(-1.0), "height": [0.0]}, "height = .* is of a process with teeth"),
    ],
)
def test_bad_input_is_one_line(changed, message):
    given = {"process": EVEN, "speed": SPEED, "gain": 1e-3} | changed
    with refused(match=message):
        lobex.orbit(**given)


def test_edges_ask_for_torque_whatever_the_chip_and_angles_say_where():
    angles, edge = np.deg2rad([30.0, 100.0]), np.array([2e4, 1e4, 0.0])
    cutter = lobex.Cutter.end_mill(2 * RADIUS, teeth=4)
    plain = lobex.Milling(PLANE, cutter, KT, KN, feed_per_tooth=FEED, angles=angles)
    edged = replace(plain, edge=edge)
    phase = np.array([0.1, 0.25, 0.7, 0.95])
    with jax.enable_x64(True):
        torque = [
            np.asarray(process.at_work(SPEED, DEEP, phase, lambda at: jnp.zeros((*jnp.shape(at), 2))).torque)
            for process in (plain, edged)
        ]
    tips = np.mod(np.pi / 2 * (phase[:, None] + np.arange(4)), 2 * np.pi)
    engaged = (tips > angles[0]) & (tips < angles[1])
    assert {0, 1} == set(engaged.sum(axis=1))
    chip = RADIUS * KT * DEEP * FEED * np.sum(engaged * np.sin(tips), axis=1)
    np.testing.assert_allclose(torque[0], chip, rtol=1e-12)
    np.testing.assert_allclose(torque[1] - torque[0], RADIUS * edge[0] * DEEP * engaged.sum(axis=1), rtol=1e-9)
    width = 2 * RADIUS * (np.cos(angles[0]) - np.cos(angles[1])) / 2
    assert edged.removal_rate(SPEED, DEEP) == pytest.approx(width * DEEP * FEED * 4 * SPEED, rel=1e-14)


def test_of_teeth_that_are_not_known_the_motion_alone_is_told():
    cutter = lobex.Cutter.ball(2 * RADIUS, teeth=2)
    ball = lobex.Milling(PLANE, cutter, KT, KN, IMMERSION, feed_per_tooth=FEED)
    varied = replace(EVEN, speed_variation=lobex.SpeedVariation(0.1, 0.5))
    assert not any(process.tells_of_teeth for process in (ball, varied))
    with pytest.raises(ValueError, match="does not tell what its teeth do"):
        lobex.recommend(ball, (50.0, 60.0), (1e-4, 1e-3))
