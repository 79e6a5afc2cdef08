"""States of the explorer: links, models and scripts say the same to the last bit, and nothing else is taken."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lobex
from lobex.explorer.addresses import query_of, state_of_query
from lobex.explorer.recipes import process_of, recipe_of
from lobex.explorer.script import script_of
from lobex.explorer.started import state_of
from lobex.explorer.state import (
    STARTS,
    Blade,
    BladingNumbers,
    Measured,
    MillingNumbers,
    Mode,
    Point,
    Rod,
    RubNumbers,
    Table,
    Tooth,
    TurningNumbers,
    View,
)
from refusals import refused

PLANE = Table((Mode(563.6, 0.0558, 1.4986), Mode(516.21, 0.025, 1.199, 0.0, 1.0)))
UNEVEN = tuple(Tooth(pitch, 30.0, runout) for pitch, runout in ((70.0, 5e-6), (110.0, 0.0), (70.0, 0.0), (110.0, 0.0)))
FULL = replace(
    STARTS["milling"],
    structure=PLANE,
    numbers=MillingNumbers(
        teeth=UNEVEN, damping_coefficient=3e4, damping_friction=0.3, normal_edge=1e4, direction="up"
    ),
    deviation=(("mass", 0.05), ("tangential", 0.1)),
    point=Point(90.0, 1.1e-3),
    heard=545.1,
)
STAGE = replace(
    STARTS["blading"],
    numbers=BladingNumbers(0.0, tuple(Blade(m, s) for m, s in ((0.013, 80.0), (-0.021, 130.0), (0.0, 150.0)))),
    point=Point(55.0, 2e4),
)
STATES = [*STARTS.values(), FULL, STAGE]


@pytest.mark.parametrize("state", STATES, ids=lambda state: state.kind)
def test_a_link_holds_a_state_to_the_last_bit(state):
    assert state_of_query("?" + query_of(state)) == state


NUMBER = st.floats(1e-3, 1e3, allow_subnormal=False)


@settings(max_examples=50)
@given(st.lists(st.tuples(NUMBER, NUMBER, NUMBER), min_size=1, max_size=5), NUMBER, NUMBER, st.none() | NUMBER)
def test_links_hold_any_numbers(rows, radial, low, heard):
    state = replace(
        STARTS["turning"],
        structure=Table(tuple(Mode(*row) for row in rows)),
        numbers=TurningNumbers(radial=radial),
        view=View(low, 2 * low, 7, 0.0, low),
        heard=heard,
    )
    assert state_of_query(query_of(state)) == state


@pytest.mark.parametrize(
    ("query", "words"),
    [
        ("process=lathe", "process = 'lathe' is unknown; choose one of rub, turning, milling, blading"),
        ("process=rub&radial=2e8", "the link says 'radial', which a rub does not have"),
        ("process=turning&radial=two", "radial = 'two' is no number"),
        ("process=turning&radial=nan", "radial = nan has NaN or infinite values"),
        ("process=turning&radial=-2e8", "radial = -2e+08 must be positive"),
        ("process=turning&radial=1&radial=2", "the link says radial twice"),
        ("process=turning&modes=100,0.1", "modes = '100,0.1' is not 6 numbers with commas between"),
        ("process=turning&modes=100,0.1,1,0,1,0", "modes has rows along y or z; turning takes one direction, x"),
        ("process=turning&modes=100,0.1,1,0,0,0", "modes, row 1: it has no direction"),
        ("speeds=1e9", "speeds = '1e9' is no whole number"),
        ("speeds=100000000", "speeds = 100000000 is more than can be computed; give at most 5000"),
        ("elements=999", "elements = 999 is more than can be computed"),
        ("speed_low=400&speed_high=50", "speed_low = 400 must be below speed_high = 50"),
        ("structure=measured", "the link has no file"),
        ("process=milling&structure=rod", "structure = rod is the blade of a rub; give modes for milling"),
        ("structure=measured&file=a.csv&digest=xyz", "digest is no SHA-256 of a file"),
        ("deviation.__class__()=1", "'deviation.__class__()' names no number"),
        ("deviation.mass=-1", "deviation of mass = -1 must be positive"),
        ("process=milling&radial_immersion=50", "radial_immersion = 50; give a share above 0 and up to 1"),
        ("process=blading&blades=0.1,60,3", "blades = '0.1,60,3' is not 2 numbers with commas between"),
        ("process=blading&blades=-1.5,360", "blades, row 1: mistuning = -150 % is 100 % or more"),
        ("process=blading&blades=0,0", "blades, row 1: spacing = 0 must be positive"),
        ("process=blading&blades=" + ";".join(["0,7.2"] * 50), "blades has 50 rows; give 1 to 48"),
        ("process=blading&blades=0,100;0,200", "blades: spacing adds up to 300°; give angles that make 360°"),
        ("process=blading&coupling=-3", "coupling = -3 must not be negative"),
        ("process=milling&direction=__import__('os')", "direction = \"__import__('os')\" is unknown"),
        ("a", "the link holds no list of names and values"),
        ("a=" + 20_000 * "1", "the link has 20002 characters"),
    ],
)
def test_links_that_say_anything_else_are_refused(query, words):
    with refused(words):
        state_of_query(query)


def test_models_are_those_of_the_same_calls():
    rub, mill = process_of(STARTS["rub"]), process_of(FULL)
    known = lobex.Rub(lobex.Rod(elements=5).modes(damping_ratio=0.03))
    np.testing.assert_array_equal(rub.modes.shape, known.modes.shape)
    np.testing.assert_array_equal(rub.modes.angular_frequency, known.modes.angular_frequency)
    cutter = lobex.Cutter.end_mill(0.012, pitch_degrees=[70, 110, 70, 110], helix_degrees=30, runout=[5e-6, 0, 0, 0])
    np.testing.assert_array_equal(mill.cutter.pitch, cutter.pitch)
    np.testing.assert_array_equal(mill.cutter.runout, cutter.runout)
    assert mill.cutter.helix == cutter.helix
    assert (mill.direction, mill.modes.directions, mill.passes) == ("up", 2, 4)
    assert list(mill.edge) == [0.0, 1e4, 0.0]
    assert (mill.process_damping.coefficient, mill.process_damping.friction) == (3e4, 0.3)
    assert mill.modes.frequency == pytest.approx([563.6, 516.21], rel=1e-15)


def test_what_is_zero_is_left_out():
    plain = process_of(STARTS["milling"])
    assert plain.cutter.helix is plain.cutter.runout is plain.cutter.pitch is None
    assert plain.process_damping is plain.speed_variation is plain.axial is plain.edge is None
    assert dict(recipe_of(FULL).numbers)["helix_degrees"] == 30.0


def test_a_stage_is_that_of_the_same_call():
    stage = process_of(STAGE).modes
    assert (stage.count, stage.coupling) == (3, None)
    assert stage.mistuning.tolist() == [0.013, -0.021, 0.0]
    assert stage.spacing.tolist() == [80.0, 130.0, 150.0]
    start = process_of(STARTS["blading"]).modes
    assert (start.count, start.mistuning, start.spacing) == (6, None, None)
    assert float(start.coupling) == 60.0


@pytest.mark.parametrize("state", [STARTS["turning"], FULL, STAGE, STARTS["blading"]], ids=lambda state: state.kind)
def test_a_process_becomes_a_state_with_the_same_process(state):
    process = process_of(state)
    again = state_of(process, (state.view.speed_low, state.view.speed_high), (0.0, state.view.gain_high))
    assert again.view == state.view
    assert again.structure == state.structure
    assert again.numbers == state.numbers


def test_processes_without_numbers_on_a_page_are_refused():
    apart = replace(process_of(STARTS["turning"]).modes, force_shape=np.array([[0.3]]))
    with refused("modes has shapes of force apart, or complex ones"):
        state_of(lobex.Turning(apart, radial=2e8))
    ring = lobex.Ring(nodal_diameter=[2], frequency=[350.0], damping_ratio=0.02, mass=1.5)
    blade = process_of(STARTS["blading"]).modes.blade
    with refused("casing of Rub is given, which a page has no numbers for"):
        state_of(lobex.Rub(blade, casing=ring))
    with refused("numbers for each mode of a blade"):
        state_of(lobex.Rub(lobex.Blading(blade, 3, mistuning=np.full((3, 1), 0.01))))
    with refused("process = 3 is not explored"):
        state_of(3)
    mill = lobex.Milling(PLANE_MODES, teeth=2, tangential=6e8, normal=2e8, angles_degrees=[0, 90])
    with refused("angles of Milling is given"):
        state_of(mill)


PLANE_MODES = process_of(FULL).modes


@pytest.mark.parametrize("kind", ["rub", "turning"])
def test_a_script_finds_the_same_to_the_last_bit(kind, tmp_path, monkeypatch, capsys):
    state = replace(STARTS[kind], view=replace(STARTS[kind].view, speeds=40))
    monkeypatch.chdir(tmp_path)
    exec(compile(script_of(state), "script.py", "exec"), names := {})
    from lobex.explorer.curves import limit_of

    np.testing.assert_array_equal(names["limit"].gain, limit_of(state).gain)
    assert {path.name for path in tmp_path.iterdir()} == {"limit.nc", "limit.csv", "limit.png"}
    np.testing.assert_array_equal(lobex.load("limit.nc").gain, names["limit"].gain)


def test_a_script_holds_a_file_name_as_text_alone():
    name = 'a\'); import os; (\'.csv\n"""'
    state = replace(STARTS["rub"], structure=Measured(name, 64 * "0"))
    assert state_of_query(query_of(state)) == state
    script = compile(script_of(state), "script.py", "exec")
    assert name in [value for value in script.co_consts if isinstance(value, str)]
    assert "os" not in script.co_names


def test_rods_and_tables_have_their_places():
    with refused("structure = measured serves rub and turning"):
        replace(STARTS["milling"], structure=Measured("a.csv", 64 * "0"))
    with refused("modes has 0 rows; give 1 to 40"):
        replace(STARTS["turning"], structure=Table(()))
    with refused("teeth has 0 rows"):
        replace(STARTS["milling"], numbers=MillingNumbers(teeth=()))
    assert replace(STARTS["rub"], structure=Rod(elements=2)).changed("elements", 3).structure == Rod(elements=3)
    assert STARTS["rub"].changed("speeds", 7).view.speeds == 7
    assert isinstance(STARTS["rub"].numbers, RubNumbers)
