"""What the explorer computes and draws of a state: limits, predictions, motions at a point, cuts, columns."""

from dataclasses import replace

import numpy as np
import pytest

import lobex
from lobex.explorer.curves import first_look, in_closed_form, limit_of, predicted, slopes_of
from lobex.explorer.drawn_columns import bar_columns, limit_columns, lobe_columns, series_of, stable_columns
from lobex.explorer.point import at_point
from lobex.explorer.recipes import process_of
from lobex.explorer.state import STARTS, Mode, Point, Table, TurningNumbers
from lobex.explorer.tried_cuts import cuts_of_text, outcomes
from lobex.processes.quantity import CONTACT_STIFFNESS, DEPTH_OF_CUT
from lobex.results.codes import Outcome
from refusals import refused


def small(kind, speeds=64, **view):
    return replace(STARTS[kind], view=replace(STARTS[kind].view, speeds=speeds, **view))


RUB, TURNING = small("rub"), small("turning")


def test_the_limit_is_that_of_the_verbs():
    rub = lobex.Rub(lobex.Rod(elements=5).modes(damping_ratio=0.03))
    known = lobex.exact_limit(rub, np.linspace(50.0, 400.0, 64))
    np.testing.assert_array_equal(limit_of(RUB).gain, known.gain)
    tool = lobex.Modes.single(frequency=146.5, damping_ratio=0.0032, mass=2.573)
    turning = lobex.exact_limit(lobex.Turning(tool, radial=2e8), limit_of(TURNING).speed)
    np.testing.assert_array_equal(limit_of(TURNING).gain, turning.gain)


@pytest.mark.slow
def test_process_damping_of_turning_is_searched_for():
    damped = replace(TURNING, numbers=TurningNumbers(damping_coefficient=3e4))
    assert in_closed_form(TURNING)
    assert not in_closed_form(damped)
    limit, look = limit_of(damped), first_look(damped)
    assert (len(limit.speed), len(look.speed)) == (64, 10)
    known = lobex.critical_gain(process_of(damped), limit.speed, (0.0, damped.view.gain_high))
    np.testing.assert_array_equal(limit.gain, known.gain)


SLOPES = {"turning": None, "rub": None}


def slopes(kind):
    state = RUB if kind == "rub" else TURNING
    if SLOPES[kind] is None:
        SLOPES[kind] = slopes_of(state, limit_of(state))
    return state, SLOPES[kind]


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "name", "share"), [("rub", "area", 1.3), ("turning", "radial", 2.0)])
def test_a_prediction_of_what_only_scales_is_exact(kind, name, share):
    # K is proportional to the cross-section, and the depth of cut to 1/K_r.
    state, found = slopes(kind)
    part = state.numbers if kind == "turning" else state.structure
    moved = state.changed(name, share * getattr(part, name))
    ahead = predicted(found, moved)
    assert ahead.gain == pytest.approx(limit_of(moved).gain, rel=1e-8)
    np.testing.assert_array_equal(ahead.speed, limit_of(moved).speed)


def test_a_prediction_moves_the_lobes_with_the_frequency():
    # Of one mode K goes with m ω² at speeds over ω, to the last digit: the scaling of the whole.
    state, found = slopes("turning")
    (mode,) = state.structure.modes
    moved = replace(state, structure=Table((replace(mode, frequency=1.2 * mode.frequency),)))
    ahead = predicted(found, moved)
    assert ahead.speed == pytest.approx(1.2 * limit_of(state).speed)
    assert ahead.gain == pytest.approx(1.44 * limit_of(state).gain, rel=1e-7)
    known = lobex.exact_limit(process_of(moved), ahead.speed)
    assert ahead.gain == pytest.approx(known.gain, rel=1e-7)


def test_an_error_of_a_prediction_is_of_second_order():
    state, found = slopes("rub")
    misses = []
    for step in (1e-2, 1e-3):
        moved = state.changed("damping_ratio", 0.03 * (1 + step))
        # Beside a cusp the limit has a corner.
        misses.append(np.median(np.abs(predicted(found, moved).gain / limit_of(moved).gain - 1)))
    assert 50 < misses[0] / misses[1] < 200


def test_nothing_is_predicted_of_another_model_or_view():
    state, found = slopes("turning")
    two = replace(state, structure=Table((*state.structure.modes, Mode(300.0, 0.01, 4.0))))
    damped = replace(state, numbers=TurningNumbers(damping_coefficient=1e4))
    wider = state.changed("speed_high", 300.0)
    # Two modes are the same calls, with longer lists.
    assert [predicted(found, other) for other in (damped, wider, two)] == [None, None, None]


def test_columns_are_those_of_the_limit_in_the_units_of_the_axes():
    limit = limit_of(TURNING)
    columns = limit_columns(limit)
    np.testing.assert_array_equal(columns["speed"], 60 * limit.speed)
    np.testing.assert_array_equal(columns["gain"], limit.gain / 1e-3)
    (series,) = series_of(limit)
    assert series.name == "Hopf (complex pair)"
    for name in ("speed", "gain", "frequency"):
        np.testing.assert_array_equal(series.columns[name], columns[name])
    stable = stable_columns(limit)
    # One polygon, under the limit: its area is the integral.
    (x,), (y,) = stable["xs"], stable["ys"]
    area = 0.5 * abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    assert area == pytest.approx(np.trapezoid(columns["gain"], columns["speed"]), rel=1e-12)
    numbers = [int(text) for text in lobe_columns(limit, 2.0)["number"]]
    assert numbers == sorted(numbers, reverse=True)
    assert set(numbers) <= set(limit.lobe.tolist())


def test_waves_around_the_disc_are_series_of_their_own():
    limit = limit_of(small("blading", speeds=120))
    blade = lobex.Modes.single(frequency=400.0, damping_ratio=0.005, mass=0.11)
    known = lobex.exact_limit(lobex.Rub(lobex.Blading(blade, 6, coupling=60.0)), limit.speed)
    np.testing.assert_array_equal(limit.gain, known.gain)
    drawn = {series.name: series for series in series_of(limit)}
    waves = sorted(set(known.nodal_diameter.tolist()))
    assert len(waves) > 2
    assert list(drawn) == [f"nodal diameter {k}" for k in waves]
    assert len({series.colour for series in drawn.values()}) == len(waves)
    for k in waves:
        here = np.isfinite(drawn[f"nodal diameter {k}"].columns["frequency"])
        np.testing.assert_array_equal(here, known.nodal_diameter == k)


def test_coupled_blades_that_differ_are_searched():
    stage = STARTS["blading"]
    mistuned = tuple(replace(blade, mistuning=0.01 * (i % 2)) for i, blade in enumerate(stage.numbers.blades))
    assert in_closed_form(stage)
    assert not in_closed_form(stage.changed("blades", mistuned))
    assert in_closed_form(stage.changed("blades", mistuned).changed("coupling", 0.0))


@pytest.mark.slow
def test_a_march_of_a_stage_grows_as_its_multiplier_says():
    stage = small("blading", speeds=8)
    speed = 100.0
    limit = float(lobex.exact_limit(process_of(stage), speed).gain[0])
    for share, stable in ((0.8, True), (1.3, False)):
        there = at_point(replace(stage, point=Point(speed, share * limit), periods=300))
        assert there.march.displacement.shape[1] == 6
        assert there.deflection == (1e-6, 0.0, 0.0, 0.0, 0.0, 0.0)
        assert (there.radius < 1) is stable
        assert float(there.march.growth) == pytest.approx(there.radius, rel=2e-3)


def test_bars_are_the_sensitivities_at_a_speed():
    _, found = slopes("turning")
    columns, at = bar_columns(found.table, 100.0)
    lane = int(np.argmin(np.abs(found.table.limit.speed - 100.0)))
    assert at == found.table.limit.speed[lane]
    told = dict(zip(columns["name"], columns["size"], strict=True))
    assert told["radial"] == pytest.approx(-1.0)
    assert told["mass, mode 1"] == found.table["mass[0]"][lane]
    assert np.all(np.diff(np.abs(columns["size"])) <= 0)


def test_a_march_at_a_point_grows_as_the_multiplier_says():
    limit = float(lobex.exact_limit(process_of(TURNING), 150.0).gain[0])
    for share, stable in ((0.2, True), (2.0, False)):
        there = at_point(replace(TURNING, point=Point(150.0, share * limit), periods=60))
        assert (there.radius < 1) is stable
        assert float(there.march.growth) == pytest.approx(there.radius, rel=2e-3)
        assert there.orbit is None
        assert len(there.samples()) == 61
    # What chatters does so near its natural frequency.
    frequency, size = there.spectrum()
    assert frequency[np.argmax(size[:, 0])] == pytest.approx(146.5, rel=0.05)


def test_a_spectrum_has_the_amplitude_of_a_sine():
    there = at_point(replace(TURNING, point=Point(150.0, 1e-5), periods=60))
    time = there.march.time
    wave = 3e-6 * np.sin(2 * np.pi * 500.0 * time)
    frequency, size = replace(there, march=replace(there.march, displacement=wave[:, None])).spectrum()
    assert frequency[np.argmax(size[:, 0])] == pytest.approx(500.0, abs=frequency[1])
    assert size.max() == pytest.approx(3e-6, rel=0.2)


def test_a_point_asks_for_one_and_for_equations():
    with refused("point = None; click at a point of the diagram"):
        at_point(TURNING)


@pytest.mark.parametrize(
    "text",
    [
        "6000, 0.1, 0\n9000, 2.5, 1",
        "speed (rpm); depth (mm); chatter\n6000; 0,1; no\n9000; 2,5; yes\n",
        "speed [Hz], depth [um], chatter\n100, 100, 0\n150, 2500, 1",
        '"n [1/min]","ap [mm]","chatter"\n"6000","0,1","0"\n"9000","2,5","1"',
        "Hz\tm\tchattered\n100\t1e-4\tstable\n# said to be loud\n150\t2.5e-3\tchatter\n",
    ],
)
def test_cuts_are_read_from_text(text):
    cuts = cuts_of_text(text, "rpm", DEPTH_OF_CUT)
    assert cuts.speed == pytest.approx([100.0, 150.0])
    assert cuts.gain == pytest.approx([1e-4, 2.5e-3])
    assert cuts.chattered.tolist() == [False, True]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "cuts holds no rows"),
        ("rpm, mm, chatter", "cuts holds a row of names alone"),
        ("6000, 1", "cuts, row 1, has 2 columns; give three: speed, gain and chatter"),
        ("6000, 1, maybe", "cuts, row 1: 'maybe' says nothing of chatter"),
        ("6000, 1, 1\n-5, 1, 1", "cuts, row 2: speed = '-5' is no number above 0"),
        ("6000, nan, 1", "cuts, row 1: gain = 'nan' is no number above 0"),
        (
            "speed [Hz], stiffness [psi], chatter\n100, 1, 1",
            "cuts names 'stiffness [psi]', in a unit that is none of N/m",
        ),
        ("speed [Hz], depth [mm], chatter\n100, 1, 1", "cuts names 'depth [mm]', in a unit that is none of N/m, kN/m"),
        ("speed [km/h]; stiffness; chatter\n100; 1; 1", "cuts names 'speed [km/h]', in a unit that is none of rpm"),
        ("6,000; 1; 1", "cuts has commas that may stand before decimals or between thousands, as in '6,000'"),
        ("6.000; 1,5; 1", "cuts has numbers with a point, '6.000', and with a comma, '1,5'"),
        ("1,1,1\n" * 2002, "cuts holds 2002 rows; give at most 2000"),
    ],
)
def test_texts_that_are_no_cuts_are_refused(text, words):
    with refused(words):
        cuts_of_text(text, "Hz", CONTACT_STIFFNESS)


def test_cuts_are_held_against_the_model():
    limit = float(lobex.exact_limit(process_of(TURNING), 150.0).gain[0]) / 1e-3
    rows = [(share * limit, chattered) for share in (0.9, 1.1) for chattered in (0, 1)]
    cuts = cuts_of_text("\n".join(f"9000, {gain!r}, {chattered}" for gain, chattered in rows), "rpm", DEPTH_OF_CUT)
    assert [Outcome(code) for code in outcomes(cuts, process_of(TURNING))] == [
        Outcome.QUIET_AS_SAID,
        Outcome.CHATTER_BELOW_THE_LIMIT,
        Outcome.QUIET_ABOVE_THE_LIMIT,
        Outcome.CHATTER_AS_SAID,
    ]
