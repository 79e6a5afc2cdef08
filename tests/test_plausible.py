"""Numbers that can hardly be meant: every verb says so, once, at the line that called it, and no other line does."""

import warnings
from dataclasses import replace
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lobex
from lobex._pytree import pytree
from lobex.processes.plausible import implausible
from lobex.processes.process import check_speed
from lobex.results.rebuild import rebuild
from lobex.shell import arguments
from lobex.shell.lobes_command import run_lobes

# In silence: 100 rev/s of a tool at 146.5 Hz, whose limit there is 1.19 mm.
TOOL = lobex.Modes.single(frequency=146.5, damping_ratio=0.03, mass=2.573)
TURN = lobex.Turning(TOOL, radial=2e8)
PER_CENT = lobex.Turning(replace(TOOL, damping_ratio=np.array([3.0])), radial=2e8)
METHOD = lobex.Chebyshev(24)
LAW = lobex.Linear(2e8)
CASING = lobex.Casing(amplitude=1e-6)
HARD = lobex.Linear(1e4)


def still(time):
    return 0 * time + 1e-6


def verbs(turn, speed, depth):
    """Every verb, at one speed and a depth, both of an ordinary size in the units that are meant."""
    rub = lobex.Rub(turn.modes)
    return {
        "monodromy": lambda: lobex.monodromy(turn, speed, depth, METHOD),
        "multipliers": lambda: lobex.multipliers(turn, speed, depth, METHOD),
        "spectral_radius": lambda: lobex.spectral_radius(turn, speed, depth, METHOD),
        "sweep": lambda: lobex.sweep(turn, [speed, 1.1 * speed], [depth, 2 * depth]),
        "study": lambda: lobex.sweep(turn, [speed, 1.1 * speed], [depth], over={"radial": [1e8, 2e8]}),
        "critical_gain": lambda: lobex.critical_gain(turn, speed, (depth, 100 * depth)),
        "exact_limit": lambda: lobex.exact_limit(turn, [speed]),
        "sensitivities": lambda: lobex.sensitivities(turn, [speed]),
        "boundary": lambda: lobex.boundary(turn, [speed, 1.01 * speed], [depth, 2 * depth], METHOD),
        "march_delay": lambda: lobex.march_delay(turn, speed, depth, still, 2, 128),
        "simulate_turning": lambda: lobex.simulate_turning(turn.modes, LAW, speed, depth, 1e-4, 2, 128),
        "march_wear": lambda: lobex.march_wear(rub.modes, CASING, HARD, [speed], 2, 64, samples_per_revolution=16),
    }


NAMES = list(verbs(TURN, 100.0, 1e-4))


def said_by(call):
    """The messages of one call, each with a file and a line."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        call()
    return [w for w in caught if w.category is lobex.LobexWarning]


@pytest.mark.parametrize("name", NAMES)
def test_ordinary_numbers_are_met_in_silence(name):
    assert said_by(verbs(TURN, 100.0, 1e-4)[name]) == []


@pytest.mark.parametrize("name", NAMES)
def test_every_verb_says_each_thing_once_at_the_callers_line(name):
    said = said_by(verbs(PER_CENT, 6000.0, 0.5)[name])
    expected = ["damping_ratio = 3 lets nothing vibrate", "every speed, from 6000 Hz, passes"]
    if name in ("exact_limit", "sensitivities"):
        expected.append("the limit is a depth of cut of ")
    elif name != "march_wear":
        expected.append("depth of cut = 0.5 m")
    assert len(said) == len(expected)
    for warning, words in zip(said, expected, strict=True):
        assert str(warning.message).startswith(words)
        assert warning.filename == __file__


def test_lobes_as_curves_look_at_the_damping():
    with pytest.warns(lobex.LobexWarning, match="damping_ratio = 3"):
        lobex.exact_lobes(PER_CENT, 2)


def test_a_study_looks_at_all_of_its_speeds_together_and_at_every_model():
    speeds = np.linspace(100, 2000, 5)
    assert said_by(lambda: lobex.sweep(TURN, speeds, [1e-4], over={"radial": [1e8, 2e8]})) == []
    over = {"modes.damping_ratio": [0.03, 2.0, 3.0]}
    (warning,) = said_by(lambda: lobex.critical_gain(TURN, [100.0], (1e-5, 1e-4), over=over))
    assert str(warning.message).startswith("damping_ratio = 2")
    assert "the first of 2 such warnings" in str(warning.message)


@pytest.mark.slow
def test_under_tracing_nothing_is_looked_at():
    with jax.enable_x64(True):
        jitted = jax.jit(lambda speed: lobex.spectral_radius(TURN, speed, 1e-4, METHOD))
        slope = jax.grad(lambda speed: lobex.exact_limit(TURN, speed).gain[0])
        assert said_by(lambda: (jitted(jnp.asarray(6000.0)), slope(jnp.asarray(6000.0)))) == []


def test_a_machine_on_springs_is_warned_of_by_its_first_mode_and_refused_by_its_fastest():
    springs = lobex.Rub(lobex.Modes(2 * np.pi * np.array([2.0, 300.0]), [0.1, 0.03], [[0.1], [0.6]]))
    check_speed(springs, 150.0)
    (message,) = implausible(springs, 150.0)
    assert "above every lobe of it" in message
    with pytest.raises(ValueError, match=r"60 times per period of the fastest mode.*rpm/60"):
        check_speed(springs, 60.4 * 300)


@pytest.mark.parametrize(("name", "value"), [("feed_per_tooth", 0.1), ("runout", [0.01, 0.0]), ("diameter", 20.0)])
def test_feed_runout_and_diameter_in_millimetres_are_told(name, value):
    def cutter(**lengths):
        lengths = {"feed_per_tooth": 1e-4, "runout": [1e-5, 0.0], "diameter": 0.02, **lengths}
        tool = lobex.Cutter(2, lengths["diameter"], runout=lengths["runout"])
        return lobex.Milling(TURN.modes, tool, 6e8, 2e8, 0.5, feed_per_tooth=lengths["feed_per_tooth"])

    assert implausible(cutter(), 100.0) == []
    (message,) = implausible(cutter(**{name: value}), 100.0)
    assert message.startswith(f"{name} = {np.max(value):g} m is more than any tool has")


@pytest.mark.parametrize(("force", "side"), [(600.0, "less"), (6e5, "less"), (6e14, "more")])
def test_cutting_forces_in_other_units_are_told(force, side):
    said = (
        f" = {force:.6g} N/m² is {side} than what is cut takes; specific cutting forces are in N/m², 6e8 for 600 N/mm²"
    )
    turning = lobex.Turning(TOOL, radial=force)
    milling = lobex.Milling(TOOL, 2, tangential=force, normal=force / 3, radial_immersion=0.5)
    assert implausible(turning, 100.0) == [f"radial{said}"]
    assert implausible(milling, 100.0) == [f"tangential{said}"]
    assert implausible(replace(turning, speed_unit="1"), 100.0) == []


def test_a_limit_longer_than_any_tool_is_told():
    """Of a tool whose mass is in g, and of one whose limit is ordinary at one of the speeds."""
    grams = lobex.Modes.single(frequency=146.5, damping_ratio=0.03, mass=2573.0 * 1e3)
    (warning,) = said_by(lambda: lobex.exact_limit(lobex.Turning(grams, radial=2e8), [100.0, 120.0]))
    assert str(warning.message).startswith("the limit is a depth of cut of ")
    (warning,) = said_by(lambda: lobex.zero_order_limit(lobex.Milling(grams, 2, 6e8, 2e8, 0.5), [100.0]))
    assert "longer than any tool; look at the units of modes" in str(warning.message)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("length", 500.0, "length = 500 m is more than a blade has; it is in m, 0.5 for 500 mm"),
        ("young_modulus", 210.0, "young_modulus = 210 Pa is less than a blade has; it is in Pa, 210e9 for 210 GPa"),
        ("density", 7.85, "density = 7.85 kg/m³ is less than a blade has; it is in kg/m³, 7850 for 7.85 g/cm³"),
    ],
)
def test_blades_in_other_units_are_told(name, value, words):
    numbers = {"length": 0.5, "young_modulus": 210e9, "density": 7850.0, name: value}
    beam = {"width": 0.05, "thickness": 0.004, "elements": 2}
    for make in (lambda: lobex.Rod(**numbers), lambda: lobex.Beam.rectangular(**numbers, **beam)):
        (warning,) = said_by(make)
        assert str(warning.message) == words
        assert warning.filename == __file__


def test_a_hub_in_millimetres_and_friction_in_per_cent_are_told():
    beam = {"length": 0.2, "width": 0.05, "thickness": 0.004, "young_modulus": 110e9, "density": 4430.0, "elements": 1}
    (warning,) = said_by(lambda: lobex.Beam.rectangular(**beam, hub_radius=120.0))
    assert str(warning.message) == "hub_radius = 120 m is more than a blade has; it is in m, 0.5 for 500 mm"
    tip, surface = lobex.Modes([100.0, 300.0], [0.01, 0.02], np.eye(2)), {"normal": (1, 0), "sliding": (0, 1)}
    for call in (
        lambda: tip.in_contact(**surface, friction=15.0),
        lambda: lobex.Beam.rectangular(**beam).modes(0.01, [1], sliding=(0, 1, 0), friction=15.0),
    ):
        (warning,) = said_by(call)
        assert str(warning.message) == "friction = 15 is more than any surfaces have; give a coefficient, 0.15 for 15 %"
        assert warning.filename == __file__


def test_a_feed_of_turning_in_millimetres_is_told():
    with pytest.warns(lobex.LobexWarning, match="feed = 0.1 m is more than any tool has"):
        lobex.simulate_turning(TURN.modes, LAW, 100.0, 1e-3, 0.1, 2, 128)


# --- what is read from a map


def test_a_limit_within_the_first_cell_is_nan_and_the_finer_grid_is_named():
    with pytest.warns(lobex.LobexWarning, match="depths are in m"):
        chart = lobex.sweep(TURN, [100.0, 110.0], np.linspace(0, 2, 5))
    with pytest.warns(lobex.LobexWarning, match=r"at 2 of 2 speeds .* sweep a finer one .* np.linspace\(0, 0.5, 65\)"):
        assert np.isnan(chart.critical_gain()).all()
    # As asked, until the limit can be read.
    fine = lobex.sweep(TURN, [100.0, 110.0], np.linspace(0, 0.5 / 64, 65))
    exact = lobex.exact_limit(TURN, fine.speed).gain
    assert fine.critical_gain() == pytest.approx(exact, abs=0.5 / 64**2)


def test_the_shell_says_so_and_reads_no_limit_from_the_first_cell(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    flags = arguments.Turning(rpm="6000:6600:2", gain="0:2:5", output=arguments.Output("map"))
    said = [str(w.message) for w in said_by(lambda: run_lobes(arguments.Lobes(flags)))]
    assert [words for words in said if "depths are in m, 0.002 for 2 mm" in words]
    assert [words for words in said if "np.linspace(0, 0.5, 65)" in words]
    printed = capsys.readouterr().out
    assert (
        "smallest limit   b is at most 500 mm, such as at 6000 rpm: at 2 of 2 speeds it is below the second" in printed
    )
    assert "no limit found" not in printed


def test_the_smallest_limit_of_a_map_is_sought_in_the_first_cell_too(tmp_path, monkeypatch, capsys):
    """That at 6000 rpm lies in the first cell, and can be read at 8400 rpm alone."""
    monkeypatch.chdir(tmp_path)
    speeds = np.array([6000.0, 8400.0]) / 60
    slow, fast = lobex.exact_limit(lobex.Turning(TOOL, radial=2e8), speeds).gain
    step = (slow + fast) / 2
    assert slow < step < fast
    flags = arguments.Turning(rpm="6000,8400", gain=f"0:{3 * step}:4", output=arguments.Output("map"))
    with pytest.warns(lobex.LobexWarning, match="at 1 of 2 speeds the limit lies within the first cell"):
        run_lobes(arguments.Lobes(flags))
    printed = capsys.readouterr().out
    assert f"smallest limit   b is at most {1e3 * step:.6g} mm, such as at 6000 rpm: at 1 of 2 speeds" in printed


# --- processes without units

SCALED = lobex.Rub(lobex.Modes([1.0], [0.03], [[1.0]]), speed_unit="1")
"""Natural frequency 1 rad per unit of time, stiffness 1: its speed is Ω/2πω."""


def test_a_process_without_units_is_met_in_silence_and_keeps_that_in_its_files(tmp_path):
    assert said_by(lambda: lobex.sweep(SCALED, [1.0, 1.27], [0.1, 0.2])) == []
    assert said_by(lambda: lobex.spectral_radius(SCALED, 12.0, 0.2, METHOD)) == []
    with pytest.warns(lobex.LobexWarning, match="rpm/60"):
        lobex.exact_limit(replace(SCALED, speed_unit="Hz"), [1.27])
    limit = lobex.exact_limit(SCALED, [0.1, 1.27])
    assert limit.speed_unit == limit.quantity.unit == limit.quantity.display_unit == "1"
    assert "Hz" not in repr(limit)
    limit.save(tmp_path / "limit.nc")
    loaded = lobex.load(tmp_path / "limit.nc")
    again = rebuild(loaded.process)
    assert again.speed_unit == "1"
    assert lobex.exact_limit(again, [0.1, 1.27]).gain.tolist() == limit.gain.tolist()
    upper, lower = limit.plot().axes
    assert (upper.get_ylabel(), lower.get_ylabel()) == ("contact stiffness $K_{e}$", "chatter frequency")
    assert lower.get_xlabel() == "speed 1/τ"


def test_a_study_of_a_process_without_units_says_nothing():
    assert said_by(lambda: lobex.sweep(SCALED, [1.0, 1.27], [0.1], over={"modes.damping_ratio": [0.01, 0.02]})) == []


def test_the_test_equations_have_no_units():
    # δ is small: the first mode turns slowly beside the delay of 2π.
    mathieu = lobex.DelayedMathieu(delta=0.01, epsilon=0.1, damping=0.1)
    assert said_by(lambda: lobex.spectral_radius(mathieu, 1 / (2 * np.pi), 0.01, METHOD)) == []
    assert mathieu.speed_unit == lobex.Scalar(-1.0).speed_unit == "1"


@pytree()
class Own:
    """A user's own process, which has no modes."""

    natural: float

    gain: ClassVar = lobex.Rub.gain
    speed_unit: ClassVar[str] = "Hz"

    def system(self, speed, gain):
        system = SCALED.system(speed, gain)
        return replace(system, blocks=self.natural * system.blocks)


def test_a_process_of_ones_own_is_looked_at_by_its_system_and_may_say_that_it_has_no_units():
    with pytest.warns(lobex.LobexWarning, match="rpm/60"):
        lobex.spectral_radius(Own(1.0), 1.27, 0.1, METHOD)

    @pytree()
    class Unitless(Own):
        speed_unit: ClassVar[str] = "1"

    assert said_by(lambda: lobex.spectral_radius(Unitless(1.0), 1.27, 0.1, METHOD)) == []


@pytest.mark.parametrize(
    "make", [lambda unit: replace(SCALED, speed_unit=unit), lambda unit: replace(TURN, speed_unit=unit)]
)
def test_other_units_of_speed_are_refused(make):
    with pytest.raises(ValueError, match="speed_unit = 'rad/s' is unknown; choose one of 'Hz', 'rpm', '1'"):
        make("rad/s")
