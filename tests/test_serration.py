"""Serrated cutters, against brute force over heights and the cutters that waves of some phases come to."""

from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lobex
from lobex._pytree import pytree
from lobex.advice import best_cuts
from lobex.processes.plausible import implausible
from lobex.processes.serrated_cuts import lines_of
from lobex.processes.wave_cells import angles_met, bends, cells_up_to, waves_for
from lobex.systems.coefficients import Framed
from lobex.systems.traits import traits_of
from problems import KN, KT, PLANE
from refusals import refused
from serrated_milling import forces, radius

D, FEED, SPEED, DEPTH = 0.016, 9e-5, 70.0, 5.3e-3
AXES = {"omega": PLANE.angular_frequency, "ratio": PLANE.damping_ratio, "mass": 1 / np.diag(PLANE.shape) ** 2}
RANDOM = {"amplitude": 8.3e-5, "wave_length": 1.7e-3, "phase_degrees": [10.0, 95.0, 230.0]}
RUNOUT = [0.0, 1e-5, -5e-6]
ARC = (1.1, 2.9)
METHOD = lobex.Duhamel(nodes=20)


def serrated(wave, teeth, helix=None, angles=ARC, feed=FEED, **edges):
    serration = None if wave is None else lobex.Serration(**wave)
    cutter = lobex.Cutter.end_mill(D, teeth=teeth, helix_degrees=helix, serration=serration, **edges)
    return lobex.Milling(PLANE, cutter, KT, KN, angles=angles, feed_per_tooth=feed)


def described(process, helix):
    cutter, wave = process.cutter, process.cutter.serration
    even = np.full(cutter.teeth, 2 * np.pi / cutter.teeth)
    return AXES | {
        "teeth": cutter.teeth,
        "pitch": even if cutter.pitch is None else cutter.pitch,
        "amplitude": wave.amplitude,
        "wave_length": wave.wave_length,
        "phase": np.deg2rad(wave.phase_degrees),
        "runout": np.zeros(cutter.teeth) if cutter.runout is None else cutter.runout,
        "twist": 2 * np.tan(np.deg2rad(helix)) / D,
        "feed": process.feed_per_tooth,
        "entry": process.angles[0],
        "exit": process.angles[1],
        "tangential": process.tangential,
        "normal": process.normal,
    }


STEPS = 48


@jax.jit
def _means(process, depth):
    """Over the steps of a period, of what was left by the same tooth and by those ahead."""
    start = jnp.arange(STEPS) / STEPS
    return [term.coefficient.mean(start, start + 1 / STEPS) for term in process.system(SPEED, depth).feedback]


@pytest.mark.slow
def test_mean_forces_on_what_every_tooth_left_are_those_of_brute_force():
    process = serrated(RANDOM, 3, 30.0, runout=RUNOUT)
    with jax.enable_x64(True):
        whole, *others = map(np.asarray, _means(process, DEPTH))
    wanted = forces(described(process, 30.0), STEPS, DEPTH, 1009, 40).sum(axis=0)
    # What a height does as a step ends it does in the next one: of the first harmonics that is little.
    found, wanted = (np.fft.rfft(part, axis=1)[:, :3] / STEPS for part in (np.stack([*others, whole]), wanted))
    assert np.all(np.max(np.abs(wanted), axis=(1, 2, 3)) > 0.1 * np.max(np.abs(wanted)))
    assert np.max(np.abs(found - wanted)) < 5e-4 * np.max(np.abs(wanted))


@pytest.mark.slow
def test_a_random_tool_is_as_brute_force_has_it():
    process = serrated(RANDOM, 3, 30.0, runout=RUNOUT)
    wanted = _extrapolated(described(process, 30.0))
    assert abs(lobex.multipliers(process, SPEED, DEPTH, METHOD)[0]) == pytest.approx(wanted, rel=2e-4)


def _extrapolated(tool):
    coarse, fine = (radius(tool, SPEED, DEPTH, steps, 503, 2000 // steps) for steps in (192, 384))
    return fine + (fine - coarse) / 3


@pytest.mark.slow
def test_a_limit_is_that_of_brute_force_and_marches_beside_it_grow_as_multipliers_say():
    process = serrated({**RANDOM, "phase_degrees": [0.0, 180.0]}, 2)
    limit = lobex.critical_gain(process, [SPEED], (6e-3, 7.5e-3), METHOD, scan=3)
    coarse, fine = (
        radius(described(process, 0.0), SPEED, limit.gain[0], steps, 2003, 4000 // steps) for steps in (384, 768)
    )
    assert fine + (fine - coarse) / 3 == pytest.approx(1, abs=1e-3)
    for depth in (0.98 * limit.gain[0], 1.02 * limit.gain[0]):
        apart = [
            lobex.march_delay(process, SPEED, depth, lambda time: np.full((*time.shape, 2), 1e-6), 40, steps).growth
            - lobex.spectral_radius(process, SPEED, depth, METHOD)
            for steps in (1000, 2000)
        ]
        assert np.abs(apart[1]) < 2e-4
        assert apart[0] / apart[1] == pytest.approx(4, rel=0.2)


@pytest.mark.parametrize("helix", [None, pytest.param(30.0, marks=pytest.mark.slow)])
def test_teeth_of_which_each_stands_back_where_others_cut_are_one_tooth(helix):
    # Of opposite waves far higher than the feed each tooth cuts half of the heights, alone: of whole waves as one tooth
    # would that cuts all of them, but for where the two cross, a share of feed over amplitude.
    opposite = {"amplitude": 2e-3, "wave_length": 5e-4, "phase_degrees": [0.0, 180.0]}
    deviations = []
    for feed in (4e-6, 1e-6):
        process = serrated(opposite, 2, helix, feed=feed)
        with jax.enable_x64(True):
            means = (_means(one, 3e-3)[0] for one in (process, serrated(None, 1, helix)))
            own, alone = (np.mean(part, axis=0) for part in means)
        deviations.append(np.max(np.abs(own - alone)) / np.max(np.abs(alone)))
    assert deviations[0] < 4e-3
    assert deviations[0] / deviations[1] == pytest.approx(4, rel=0.05)


@pytest.mark.slow
def test_waves_of_no_height_and_of_one_phase_are_smooth_edges():
    smooth = serrated(None, 2)
    for wave in ({"amplitude": 0.0, "wave_length": 1e-3}, RANDOM | {"phase_degrees": [70.0, 430.0]}):
        assert serrated(wave, 2, 30.0).cutter.alike == 2
    # What is no more than rounding takes all the way of serrated teeth, over a turn.
    once = abs(lobex.multipliers(smooth, SPEED, DEPTH, lobex.Duhamel(nodes=16))[0])
    nearly = serrated({"amplitude": 1e-13, "wave_length": 1e-3}, 2)
    turn = abs(lobex.multipliers(nearly, SPEED, DEPTH, lobex.Duhamel(nodes=40))[0])
    assert turn == pytest.approx(once**2, rel=1e-8)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:1 of 1 points have an estimated error")
@pytest.mark.parametrize("helix", [None, 30.0])
def test_the_error_that_is_stated_covers_that_of_few_nodes(helix):
    process = serrated(RANDOM, 3, helix, runout=RUNOUT)
    finest = lobex.sweep(process, [SPEED], [DEPTH], method=lobex.Duhamel(nodes=64)).spectral_radius
    for nodes in (13, 20, 33):
        chart = lobex.sweep(process, [SPEED], [DEPTH], method=lobex.Duhamel(nodes=nodes))
        assert np.abs(chart.spectral_radius / finest - 1).max() <= chart.error.max()


@pytest.mark.slow
def test_uneven_pitch_is_as_brute_force_has_it():
    # Straight teeth enter and leave at once: where steps end.
    angles = np.deg2rad([60.0, 165.0])
    process = serrated(RANDOM, None, None, angles, pitch_degrees=[90, 120, 150], runout=RUNOUT)
    wanted = _extrapolated(described(process, 0.0))
    assert abs(lobex.multipliers(process, SPEED, DEPTH, lobex.Duhamel(nodes=12))[0]) == pytest.approx(wanted, rel=2e-4)


@pytest.mark.slow
def test_derivatives_are_those_of_differences():
    def grown(numbers):
        amplitude, feed, depth = numbers
        process = serrated(RANDOM | {"amplitude": amplitude}, 3, 30.0, feed=feed)
        return jnp.log(lobex.spectral_radius(process, SPEED, depth, METHOD))

    at = np.array([8.3e-5, FEED, DEPTH])
    with jax.enable_x64(True):
        rates = np.asarray(jax.jit(jax.grad(grown))(at)) * at
        both = jax.jit(grown)
        apart = [(both(at * (1 + 1e-4 * unit)) - both(at * (1 - 1e-4 * unit))) / 2e-4 for unit in np.eye(3)]
    assert rates == pytest.approx(np.array(apart), rel=1e-3, abs=1e-4)


@pytree()
class Hastier:
    """Serrated milling of a material that is the harder the faster it is cut."""

    milling: lobex.Milling
    gain = lobex.Milling.gain
    speed_unit = "Hz"

    def system(self, speed, gain):
        system, unit = self.milling.system(speed, gain), np.eye(2)
        terms = [replace(term, coefficient=Framed(speed * unit, term.coefficient, unit)) for term in system.terms]
        return replace(system, terms=tuple(terms))


def test_coefficients_are_shared_by_speeds_that_they_do_not_follow():
    process = serrated(RANDOM, 3, 30.0)
    assert not traits_of(process).coefficients_by_speed
    assert traits_of(Hastier(process)).coefficients_by_speed
    # What takes no time is not looked at.
    assert traits_of(serrated(None, 3, 30.0)).coefficients_by_speed


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.* points have an estimated error")
def test_a_chart_has_the_multipliers_of_each_of_its_points():
    process, method = serrated({"amplitude": 8e-5, "wave_length": 1.7e-3}, 2), lobex.Duhamel(nodes=13)
    speeds, depths = np.array([95.0, 104.0, 131.0]), np.array([5e-4, 2.1e-3, 5.3e-3])
    chart = lobex.sweep(process, speeds, depths, method)
    each = np.abs(lobex.multipliers(process, speeds[:, None], depths, method)[..., 0])
    assert chart.spectral_radius == pytest.approx(each, rel=1e-9)


@pytest.mark.slow
def test_heights_are_integrated_to_the_last_digits_between_bends():
    lines = lines_of(serrated(RANDOM, 3, runout=RUNOUT))
    levels = (np.sin(ARC[0]), np.sin(ARC[1]), 1.0)
    with jax.enable_x64(True):
        place = bends(lines, levels)
        many = np.sort(np.hstack([place, np.broadcast_to(np.linspace(0.01, 6.28, 400), (3, 400))]), axis=1)
        for ahead in (1, 3):
            sums = []
            for places, points in ((place, 16), (many, 8)):
                cells = cells_up_to(jnp.asarray(places), 5.0, points)
                met = jnp.cos(3 * angles_met(lines, cells.turned, ahead, *ARC)) @ np.array([1.0, -1.0, 1.0, -1.0])
                sums.append(np.asarray(jnp.sum(cells.weight * met, axis=1)))
            assert sums[0] == pytest.approx(sums[1], abs=1e-8)


@pytest.mark.parametrize("count", [0, 1, 7, 10, 400])
def test_waves_stand_for_all_of_them(count):
    with jax.enable_x64(True):
        wave, often = map(np.asarray, jax.jit(waves_for)(float(count)))
    every = np.arange(count)
    for turn in (0.3, 2.0):
        # Of so many as ten, a smooth function of the place among all of them.
        rate = turn / max(count, 1)
        assert often @ np.cos(rate * wave) == pytest.approx(np.sum(np.cos(rate * every)), rel=1e-11, abs=1e-12)


@pytest.mark.parametrize(
    ("wave", "message"),
    [
        ({"wave_length": 0.0}, "wave_length = 0 must be positive"),
        ({"amplitude": -1e-4}, "amplitude = -0.0001 must not be negative"),
        ({"amplitude": 0.008}, "amplitude = 0.008 m is not below the radius of the cutter; give less than 0.008 m"),
        ({"amplitude": [1e-4] * 2}, r"amplitude has shape \(2,\); give one in m, or one a tooth, \(3,\)"),
        ({"phase_degrees": [0.0, 180.0]}, r"phase_degrees has shape \(2,\); give one angle a tooth, \(3,\)"),
        ({"phase_degrees": [0.0, np.nan, 0.0]}, "phase_degrees = .* has NaN"),
    ],
)
def test_what_is_no_wave_of_a_cutter_is_refused(wave, message):
    with refused(match=message):
        serrated(RANDOM | wave, 3)


@pytest.mark.parametrize(("name", "given"), [("wave_length", 1.7), ("amplitude", 0.0079)])
def test_a_wave_in_millimetres_is_told_of(name, given):
    told = implausible(serrated(RANDOM | {name: given}, 3), [SPEED], [DEPTH])
    assert [f"{name} = {given:.6g} m is more than any tool has" in message for message in told] == [True]
    assert not implausible(serrated(RANDOM, 3), [SPEED], [DEPTH])


def test_what_serrated_cutters_do_not_take_is_refused(monkeypatch):
    with refused("feed_per_tooth = None with a serrated cutter"):
        serrated(RANDOM, 3, feed=None)
    with refused("serration = 3 is none; give a lobex.Serration"):
        lobex.Cutter.end_mill(D, teeth=4, serration=3)
    wave = lobex.Serration(**RANDOM)
    for message, edges in (
        ("corner_radius = 0.001 with a serration; leave it out", {"corner_radius": 1e-3}),
        ("lead = 0.7853.* with a serration; leave it out", {"lead_degrees": 45.0}),
        ("helix = .* with a serration; give one angle of all teeth", {"helix_degrees": [30, 35, 40]}),
        ("offset = 1e-05 with a serration; give a runout of every tooth", {"offset": 1e-5}),
    ):
        with refused(match=message):
            lobex.Cutter.end_mill(D, teeth=3, serration=wave, **edges)
    with refused(match="discs = .* with a serration; leave them out"):
        lobex.Cutter.from_discs(D, [1e-3, 2e-3], teeth=3, serration=wave)
    process = serrated(RANDOM, 3)
    refusing: tuple[dict[str, Any], ...] = (
        {"process_damping": lobex.ProcessDamping(5e4)},
        {"axial": 1e8},
        {"edge": [1e4, 1e4, 0.0]},
    )
    for others in refusing:
        with refused(match=f"{next(iter(others))} = .* with a serrated cutter; leave it out"):
            lobex.Milling(PLANE, process.cutter, KT, KN, 0.5, feed_per_tooth=FEED, **others)
    with refused("process = Milling has serrated teeth, whose forced motion is not known"):
        lobex.orbit(process, SPEED, DEPTH)
    # Before anything is computed: no name of what would search for depths is there any more.
    with monkeypatch.context() as patched, refused("process = Milling has serrated teeth, whose forced motion"):
        patched.delattr(best_cuts, "dominant_over_grid")
        lobex.recommend(process, (50.0, 90.0), (1e-4, 3e-3))
    with refused("process = Milling has serrated teeth, which this solution does not take; give critical_gain"):
        lobex.zero_order_limit(process, [SPEED])
