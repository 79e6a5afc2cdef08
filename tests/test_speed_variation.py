"""Varying spindle speeds against collocation over the angle, in which every delay is constant."""

from dataclasses import replace

import jax
import numpy as np
import pytest

import lobex
from milling_collocation import specific_force
from turning_angle import Spindle, largest, period_map

TANGENTIAL, NORMAL = 6e8, 2e8
TOOL = lobex.Modes.plane(
    x=lobex.Modes.single(frequency=563.6, damping_ratio=0.0558, mass=1.4986),
    y=lobex.Modes.single(frequency=516.21, damping_ratio=0.025, mass=1.199),
)
NUMBERS = TOOL.angular_frequency, TOOL.damping_ratio, TOOL.shape
SPEED, DEPTH = 4000 / 60, 1.5e-3
FINE = lobex.Duhamel(nodes=28)
# Five and three passes to one and two variations, and one of two harmonics that begins at its fastest.
SINE = lobex.SpeedVariation(0.12, 0.4)
THIRDS = lobex.SpeedVariation(0.2, 4 / 3)
ANGLES = 2 * np.pi * np.arange(9) / 9
PROFILE = lobex.SpeedVariation(0.15, 0.4, np.cos(ANGLES) + 0.5 * np.sin(2 * ANGLES))
SPINDLES = {
    "sine": (SINE, Spindle(SPEED, 0.4, sine=(0.12,)), 5),
    "two variations": (THIRDS, Spindle(SPEED, 4 / 3, sine=(0.2,)), 3),
    "profile": (PROFILE, Spindle(SPEED, 0.4, cosine=(0.15, 0.0), sine=(0.0, 0.075)), 5),
}


def mill(variation, **others):
    """Two teeth of which one or none is in the cut, up to half a turn."""
    cutter = lobex.Cutter.end_mill(0.02, teeth=2)
    numbers = {"tangential": TANGENTIAL, "normal": NORMAL, "radial_immersion": 0.5, "direction": "down"}
    return lobex.Milling(TOOL, cutter, **numbers, speed_variation=variation, **others)


def at_angle(numbers):
    """A force of the tooth that is in the cut, which is from a quarter to half a turn."""

    def force(turn):
        place = np.mod(turn, 0.5)
        return DEPTH * specific_force(2 * np.pi * place, *numbers, 2) if place > 0.25 else np.zeros((2, 2))

    return force


def independent(spindle, passes, **others):
    parts = np.concatenate([np.linspace(0.0, 0.5, 4), np.linspace(0.5, 1.0, 5)[1:]])
    return period_map(NUMBERS, spindle, at_angle((TANGENTIAL, NORMAL)), parts, passes, 2, **others)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["two variations", "profile"])
def test_multipliers_are_those_of_collocation_over_the_angle(kind):
    variation, spindle, passes = SPINDLES[kind]
    found = complex(lobex.sweep(mill(variation), [SPEED], [DEPTH]).multiplier[0, 0])
    wanted = largest(independent(spindle, passes)[0])
    assert abs(complex(found.real, abs(found.imag)) - wanted) < 1e-11 * abs(wanted)


@pytest.mark.slow
def test_flanks_and_the_feed_see_the_speed_and_the_time_that_there_is():
    _, spindle, passes = SPINDLES["sine"]
    flank, feed = lobex.ProcessDamping(2e4, 0.3), 1e-4
    process = mill(SINE, process_damping=flank, feed_per_tooth=feed)
    per_speed = 2e4 / (np.pi * 0.02 * SPEED)
    damping = at_angle((0.3 * per_speed, per_speed))
    matrix, pushed = independent(spindle, passes, damping=damping, fed=feed * 2 * SPEED)
    motion = lobex.orbit(process, SPEED, DEPTH, lobex.Duhamel(nodes=20), phase=[0.0, 1.0])
    assert motion.spectral_radius == pytest.approx(abs(largest(matrix)), rel=1e-11)
    periodic = np.linalg.solve(np.eye(len(pushed)) - matrix, pushed)
    displacement = periodic[:2] @ np.asarray(TOOL.shape)
    peak = np.max(np.abs([motion.lowest, motion.highest]), axis=0)[:2]
    assert np.all(np.abs(motion.displacement[:, :2] - displacement) < 1e-10 * peak)


@pytest.mark.slow
def test_turning_with_a_profile_and_a_flank():
    mode = lobex.Modes.single(frequency=450.0, damping_ratio=0.0316, mass=0.8106)
    flank = lobex.ProcessDamping(1e4)
    process = lobex.Turning(mode, 1.5e9, diameter=0.035, process_damping=flank, speed_variation=PROFILE)
    speed, depth = 50.0, 2e-4
    spindle = Spindle(speed, 0.4, cosine=(0.15, 0.0), sine=(0.0, 0.075))
    numbers = mode.angular_frequency, mode.damping_ratio, mode.shape
    force, rubbing = np.array([[1.5e9 * depth]]), np.array([[1e4 * depth / (np.pi * 0.035 * speed)]])
    parts = np.linspace(0, 1, 15)
    matrix, _ = period_map(numbers, spindle, lambda _: force, parts, 5, 1, damping=lambda _: rubbing)
    # Five revolutions come in two variations.
    found = complex(lobex.sweep(process, [speed], [depth]).multiplier[0, 0]) ** 2
    wanted = largest(matrix)
    assert abs(complex(found.real, abs(found.imag)) - wanted) < 1e-9 * abs(wanted)


CUTTERS = {
    "uneven pitch": lobex.Cutter.end_mill(pitch_degrees=[150, 210]),
    "helix": lobex.Cutter.end_mill(0.016, teeth=2, helix_degrees=30),
    "a helix a tooth": lobex.Cutter.end_mill(0.016, teeth=2, helix_degrees=[30, 35]),
}


@pytest.mark.parametrize(
    "kind", [*(pytest.param(k, marks=pytest.mark.slow) for k in list(CUTTERS)[:2]), *list(CUTTERS)[2:]]
)
def test_forces_and_delays_are_those_of_the_angle(kind):
    cutter = CUTTERS[kind]
    numbers = (TOOL, cutter, TANGENTIAL, NORMAL, 0.5)
    varied = lobex.Milling(*numbers, speed_variation=SINE)
    spindle, repeats = SPINDLES["sine"][1], varied.layout.repeats
    steady, system = (process.system(SPEED, DEPTH) for process in (lobex.Milling(*numbers), varied))
    assert repeats / (cutter.alike * SPEED) == pytest.approx(system.period, rel=1e-14)
    phase = (np.arange(40) + 0.37) / 40
    turns = spindle.turns(phase * system.period)
    with jax.enable_x64(True):
        forces = [one.at(place).present for one, place in ((system, phase), (steady, turns * cutter.alike))]
        ago = np.array(system.lags(phase)) * system.period
        share = np.array(steady.lags(turns * cutter.alike)) / cutter.alike
    assert np.allclose(*forces, rtol=1e-9, atol=1e-3)
    assert np.allclose(spindle.turns(phase * system.period - ago), turns - share, rtol=0, atol=1e-12)


@pytest.mark.search
@pytest.mark.parametrize("kind", list(CUTTERS)[:2])
def test_a_spindle_that_keeps_its_speed_leaves_every_cutter_as_it_was(kind):
    cutter = CUTTERS[kind]
    numbers = (TOOL, cutter, TANGENTIAL, NORMAL, 0.5)
    still = lobex.Milling(*numbers, speed_variation=lobex.SpeedVariation(0.0, 1.0))
    assert still.layout.repeats == cutter.alike
    wanted = lobex.sweep(lobex.Milling(*numbers), [SPEED], [DEPTH]).spectral_radius ** cutter.alike
    found = lobex.sweep(still, [SPEED], [DEPTH]).spectral_radius
    assert found == pytest.approx(wanted, rel=1e-9)


# Both are of the same nodes, be they few.
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::lobex.SweepWarning")
def test_derivatives_by_the_amplitude_are_those_of_differences():
    mode = lobex.Modes.single(frequency=450.0, damping_ratio=0.0316, mass=0.8106)

    def radius(amplitude):
        process = lobex.Turning(mode, 1.5e9, speed_variation=replace(SINE, amplitude=amplitude))
        return lobex.spectral_radius(process, 50.0, 2e-4, FINE)

    step = 1e-5
    wanted = (radius(0.12 + step) - radius(0.12 - step)) / (2 * step)
    with jax.enable_x64(True):
        assert jax.jit(jax.grad(radius))(0.12) == pytest.approx(float(wanted), rel=1e-6)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: lobex.SpeedVariation(1.0, 0.1), "amplitude = 1 takes the speed to 0 of its mean"),
        (lambda: lobex.SpeedVariation(-0.1, 0.1), "amplitude = -0.1"),
        (lambda: lobex.SpeedVariation(0.1, 0.0), "frequency_ratio = 0"),
        (lambda: lobex.SpeedVariation(0.1, 1e-6), "frequency_ratio = 1e-06 is of no spindle"),
        (lambda: lobex.SpeedVariation(0.1, 100.0), "frequency_ratio = 100 is of no spindle"),
        (lambda: lobex.SpeedVariation(0.1, 0.1, [1.0, 2.0, 3.0]), "profile has the mean 2"),
        (lambda: lobex.SpeedVariation(0.1, 0.1, [1.0, -1.0]), "an odd number of samples"),
        (lambda: mill(lobex.SpeedVariation(0.1, np.pi)), "frequency_ratio = 3.1415"),
        (lambda: mill(0.1), "speed_variation = 0.1; give lobex.SpeedVariation"),
        (lambda: lobex.Turning(TOOL, 1e9, speed_variation=(0.1, 0.2)), "give lobex.SpeedVariation"),
    ],
)
def test_bad_input_is_told_in_one_line(call, message):
    with pytest.raises(ValueError, match=message) as error:
        call()
    assert len(str(error.value).splitlines()) == 1
