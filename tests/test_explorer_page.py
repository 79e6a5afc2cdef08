"""The page without a browser: widgets change the state, the figures follow, and numbers compile nothing."""

import asyncio
import html
import threading
from dataclasses import replace

import jax
import numpy as np
import pytest

import lobex
from lobex.explorer.files_read import KINDS, MOST_BYTES, read_model
from lobex.explorer.page import Explorer
from lobex.explorer.serving import free_port
from lobex.explorer.state import STARTS, Mode, Point, Rod, Table
from lobex.explorer.worker import Worker
from refusals import refused

SPEEDS = 64


def page_of(kind, **view):
    state = STARTS[kind]
    explorer = Explorer(replace(state, view=replace(state.view, **{"speeds": SPEEDS, **view})))
    assert explorer.settle(500)
    return explorer


@pytest.fixture(scope="module")
def turning():
    page = page_of("turning")
    yield page
    page.close()


def drawn(page):
    return page.figures.sources["limit"].data


def compiled(change):
    """Programs compiled while ``change`` is made."""
    found = []

    def listen(event, duration, **about):
        if event == "/jax/core/compile/backend_compile_duration":
            found.append(about.get("fun_name"))

    jax.monitoring.register_event_duration_secs_listener(listen)
    change()
    jax.monitoring.unregister_event_duration_listener(listen)
    return found


def test_a_slider_moves_the_curve_to_the_right_numbers(turning):
    turning.controls.sliders["radial"].value = 400.0
    assert turning.settle()
    tool = lobex.Modes.single(frequency=146.5, damping_ratio=0.0032, mass=2.573)
    known = lobex.exact_limit(lobex.Turning(tool, radial=4e8), np.linspace(2000, 12000, SPEEDS) / 60)
    assert drawn(turning)["gain"] == pytest.approx(known.gain / 1e-3, rel=1e-12)
    assert drawn(turning)["frequency"] == pytest.approx(known.chatter_frequency, rel=1e-12)
    # The slopes came after it.
    assert turning.slopes.table.limit is turning.limit
    assert "radial" in turning.sheets.bars.source.data["name"]


def test_no_number_compiles_anything(turning):
    def move():
        for name, share in (("radial", 1.3), ("frequency", 1.1), ("damping_ratio", 2.0), ("mass", 0.7)):
            turning.controls.sliders[name].value *= share
            assert turning.settle()
        turning.view_changed(speed_high=300.0)
        assert turning.settle()

    assert compiled(move) == []


def test_the_table_is_what_the_sliders_say(turning):
    turning.controls.sliders["frequency"].value = 200.0
    assert turning.controls.modes.value["f (Hz)"].tolist() == [200.0]
    assert turning.state.structure.modes[0].frequency == 200.0
    assert turning.settle()


def test_what_is_refused_is_said_and_changes_nothing(turning):
    before = turning.state
    turning.controls.sliders["radial"].value = -1.0
    assert turning.state == before
    assert "radial = -1e+06 must be positive" in turning.status.message.object
    turning.controls.sliders["radial"].value = before.numbers.radial / 1e6


@pytest.mark.slow
def test_a_band_is_that_of_the_limit(turning):
    turning.change(lambda state: replace(state, deviation=(("damping_ratio", 0.1),)))
    assert turning.settle()
    known = turning.limit.band({"modes.damping_ratio": 0.1}).interval(2.0)
    (edge,) = turning.figures.sources["band"].data["ys"]
    assert edge == pytest.approx(np.r_[known[0], known[1][::-1]] / 1e-3, rel=1e-9)
    assert turning.figures.keys["band"].visible
    turning.change(lambda state: replace(state, deviation=()))
    assert not turning.figures.keys["band"].visible


def test_a_click_marches(turning):
    turning.change(lambda state: replace(state, point=Point(120.0, 1e-5)))
    assert turning.settle()
    assert turning.there.speed == 120.0
    assert "stable</b>, max|μ| = " in turning.sheets._about.object
    assert turning.figures.sources["point"].data == {"speed": [7200.0], "gain": [0.01]}
    assert len(turning.sheets.figures.sources["samples"].data["x"]) == turning.state.periods + 1


def test_what_was_heard_gives_speeds(turning):
    turning.sheets.hear(150.0)
    assert turning.settle()
    speed = turning.figures.sources["next"].data["speed"]
    low, high = (60 * end for end in (turning.state.view.speed_low, turning.state.view.speed_high))
    assert sorted(speed) == pytest.approx([9000 / k for k in range(4, 0, -1) if low <= 9000 / k <= high])
    assert turning.state.heard == 150.0
    turning.sheets.hear(None)


def test_cuts_are_overlaid_by_outcome(turning):
    turning.sheets.take_cuts("rpm, mm, chatter\n7000, 0.001, 0\n7000, 0.001, 1\n")
    assert turning.settle()
    assert turning.sheets._score.object.startswith("<b>1 of 2</b>")
    assert turning.figures.sources["CHATTER_BELOW_THE_LIMIT"].data["speed"] == pytest.approx([7000.0])
    turning.sheets.take_cuts("1, 2")
    assert "has 2 columns" in turning.status.message.object


@pytest.mark.parametrize(
    ("ending", "begins"), [("csv", b"speed"), ("nc", b"\x89HDF"), ("png", b"\x89PNG"), ("svg", b"<?xml")]
)
def test_what_is_taken_away_is_the_screen(turning, ending, begins, tmp_path):
    content = turning.sheets.taken[ending]()
    assert content.startswith(begins)
    if ending == "nc":
        (tmp_path / "a.nc").write_bytes(content)
        np.testing.assert_array_equal(lobex.load(tmp_path / "a.nc").gain, turning.limit.gain)


def test_a_report_holds_all_that_it_shows(turning):
    from html.parser import HTMLParser

    fetched = []

    class Reader(HTMLParser):
        def handle_starttag(self, tag, attrs):
            if tag == "script":
                fetched.append(tag)
            fetched.extend(value for name, value in attrs if name in ("src", "href", "data") and "#" not in value)

    # The motion at a point is the third picture.
    turning.change(lambda state: replace(state, point=Point(120.0, 1e-5)))
    assert turning.settle()
    text = turning.sheets.taken["html"]().decode()
    Reader().feed(text)
    assert fetched == []
    assert text.count("<svg") == 3
    assert "def process_of(numbers):" in text


@pytest.mark.slow
def test_other_processes_have_pages_of_their_own(turning):
    turning.load(replace(STARTS["rub"], view=replace(STARTS["rub"].view, speeds=SPEEDS)))
    assert turning.settle()
    assert (turning.speed_unit, turning.quantity.symbol) == ("Hz", "K_e")
    assert isinstance(turning.state.structure, Rod)
    known = turning.limit.gain
    # The rod's modes as a table vibrate as the rod does.
    turning.controls.column.objects[0].objects[0].value = "modal table"
    assert turning.settle()
    assert isinstance(turning.state.structure, Table)
    assert len(turning.state.structure.modes) == 5
    assert turning.limit.gain == pytest.approx(known, rel=1e-9)


@pytest.mark.slow
def test_a_stage_of_blades_is_drawn_by_its_waves(turning):
    turning.load(replace(STARTS["blading"], view=replace(STARTS["blading"].view, speeds=SPEEDS)))
    assert turning.settle()
    assert (turning.speed_unit, turning.quantity.symbol) == ("Hz", "K_e")
    blade = lobex.Modes.single(frequency=400.0, damping_ratio=0.005, mass=0.11)

    def shown():
        keys = turning.figures.keys
        return [keys[name].label.value for name in keys if name.startswith("series") and keys[name].visible]

    waves = sorted(set(turning.limit.nodal_diameter.tolist()))
    assert shown() == [f"nodal diameter {k}" for k in waves]
    turning.controls.sliders["coupling"].value = 0.0
    assert turning.settle()
    known = lobex.exact_limit(lobex.Rub(lobex.Blading(blade, 6)), turning.limit.speed)
    assert drawn(turning)["gain"] == pytest.approx(known.gain / 1e6, rel=1e-12)
    shares = [0.013, -0.021, 0.004, 0.017, -0.009, -0.004]
    rows = tuple(replace(row, mistuning=share) for row, share in zip(turning.state.numbers.blades, shares, strict=True))
    turning.change(lambda state: state.changed("blades", rows))
    assert turning.settle()
    known = lobex.exact_limit(lobex.Rub(lobex.Blading(blade, 6, mistuning=shares)), turning.limit.speed)
    assert drawn(turning)["gain"] == pytest.approx(known.gain / 1e6, rel=1e-12)
    # Twice the mass is twice the limit, at frequencies that stay.
    assert turning.slopes.table.limit is turning.limit
    assert turning.slopes.table["mass[0]"] == pytest.approx(1.0, rel=1e-6)
    # Angles that make no turn are said, and change nothing.
    turning.change(lambda state: state.changed("blades", (replace(rows[0], spacing=61.0), *rows[1:])))
    assert "spacing adds up to 361°" in html.unescape(turning.status.message.object)
    assert turning.state.numbers.blades == rows


def test_files_are_limited_and_their_names_lead_nowhere():
    with refused(f"give a file of up to {MOST_BYTES}"):
        read_model("a.toml", bytes(MOST_BYTES + 1), STARTS["turning"])
    with refused("'passwd.toml' is no TOML"):
        read_model("../../etc/passwd.toml", b"\xff\x00", STARTS["turning"])
    tool = (
        b"[[modes]]\naxis = 'x'\nfrequency = 300.0\ndamping_ratio = 0.02\nmass = 1.5\n"
        b"[force]\ntangential = 6e8\nnormal = 2e8\n"
    )
    state, told, _ = read_model("tool.toml", tool, STARTS["turning"])
    assert told == ""
    assert state.structure == Table((Mode(300.0, 0.02, 1.5),))
    assert state.numbers.radial == 2e8
    with refused("has no [cutter]; milling takes one"):
        read_model("tool.toml", tool, STARTS["milling"])


@pytest.mark.parametrize("kind", KINDS[1:3])
def test_of_several_responses_a_process_of_one_direction_says_what_to_keep(kind):
    columns = b"Frequency [Hz],Re xx [m/N],Im xx [m/N],Re yy [m/N],Im yy [m/N]\n"
    rows = b"".join(b"%d,1e-6,-2e-7,1e-6,-2e-7\n" % frequency for frequency in range(100, 120))
    with refused("path = 'tap.csv' holds several responses, x to x, y to y, of which this process takes one; keep"):
        read_model("tap.csv", columns + rows, STARTS["turning"], kind)


def test_a_worker_does_the_newest_of_each_kind_in_order():
    done, failed, begun, held = [], [], threading.Event(), threading.Event()
    worker = Worker(("first", "second"), failed.append, lambda busy: None)

    def job(name, wait=False):
        def steps():
            if wait:
                begun.set()
                held.wait(10)
            done.append(name)
            yield
            done.append(f"{name} ends")

        return steps

    def broken():
        raise KeyError("no number")
        yield

    worker.ask("first", job("held", wait=True))
    assert begun.wait(10)
    for name in ("old", "new"):
        worker.ask("second", job(f"second {name}"))
        worker.ask("first", job(name))
    held.set()
    assert worker.settle(10)
    # What was superseded ended at its first step, and the one between was never begun.
    assert done == ["held", "new", "new ends", "second new", "second new ends"]
    worker.ask("first", lambda: broken())
    assert worker.settle(10)
    assert [type(error) for error in failed] == [KeyError]
    worker.close()
    worker.ask("first", job("late"))
    assert "late" not in done


@pytest.mark.parametrize(("port", "words"), [(-1, "port = -1 is none"), (70000, "port = 70000 is none")])
def test_ports_that_are_none_are_refused(port, words):
    with refused(words):
        free_port(port)


def test_a_port_that_is_taken_is_refused():
    import socket

    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with refused("cannot be listened at"):
            free_port(taken.getsockname()[1])
    assert free_port(0) > 1023


def test_a_notebook_is_changed_in_its_own_thread():
    async def cell():
        page = Explorer(replace(STARTS["turning"], view=replace(STARTS["turning"].view, speeds=SPEEDS)))
        show, threads = page.figures.show, []
        page.figures.show = lambda *shown: (threads.append(threading.current_thread()), show(*shown))
        while page.limit is None:
            await asyncio.sleep(0.02)
        first = page.limit.gain
        page.controls.sliders["radial"].value = 400.0
        # Once a cell has waited, it sees what was found meanwhile.
        assert page.settle()
        page.close()
        return first / page.limit.gain, threads

    ratio, threads = asyncio.run(asyncio.wait_for(cell(), 300))
    assert ratio == pytest.approx(2.0, rel=1e-12)
    assert set(threads) == {threading.current_thread()}


@pytest.mark.slow
def test_milling_is_predicted_looked_at_and_polished():
    page = page_of("milling", speeds=48, scan=9)
    shown = []
    source = page.figures.sources["ahead"]
    source.on_change("data", lambda attr, old, new: shown.append(len(new["speed"])))

    def move():
        page.controls.sliders["tangential"].value = 600.0
        # Before anything is computed.
        assert shown == [48]
        assert page.settle()
        page.controls.sliders["radial_immersion"].value = 52.0
        assert page.settle()

    assert compiled(move) == []
    # Predicted, a first look, and taken away; twice.
    assert shown == [48, 8, 0, 48, 8, 0]
    known = lobex.critical_gain(
        lobex.Milling(
            lobex.Modes.single(frequency=146.5, damping_ratio=0.0032, mass=2.573),
            teeth=1,
            tangential=6e8,
            normal=2e8,
            radial_immersion=0.52,
        ),
        np.linspace(5000 / 60, 25000 / 60, 48),
        (0.0, 5e-3),
        scan=9,
    )
    there = np.isfinite(known.gain)
    assert there.sum() > 10
    np.testing.assert_array_equal(there, np.isfinite(drawn(page)["gain"]))
    assert drawn(page)["gain"][there] == pytest.approx(known.gain[there] / 1e-3, rel=1e-8)
    page.close()


def response_of(modes):
    """The receptance of modes as a table, from 50 to 250 Hz."""
    frequency = np.arange(50.0, 250.0, 0.5)
    omega, own = 2 * np.pi * frequency[:, None], modes.angular_frequency
    value = np.sum(modes.shape[:, 0] ** 2 / (own**2 - omega**2 + 2j * modes.damping_ratio * own * omega), axis=1)
    rows = [f"{f!r},{v.real!r},{v.imag!r}" for f, v in zip(frequency.tolist(), value.tolist(), strict=True)]
    return "\n".join(["Frequency [Hz],Real xx [m/N],Imag xx [m/N]", *rows]).encode()


@pytest.mark.slow
def test_a_measured_response_is_fitted_or_taken_as_it_is(turning, tmp_path, monkeypatch):
    tool = lobex.Modes.single(frequency=146.5, damping_ratio=0.02, mass=2.573)
    content = response_of(tool)
    known = lobex.Turning(tool, radial=2e8)
    turning.load(replace(STARTS["turning"], view=replace(STARTS["turning"].view, speeds=SPEEDS)))
    turning.sheets.take_model("tap.csv", content, KINDS[1])
    assert turning.settle()
    (mode,) = turning.state.structure.modes
    assert (mode.frequency, mode.damping_ratio, mode.mass) == pytest.approx((146.5, 0.02, 2.573), rel=1e-6)
    assert "ModalFit" in turning.sheets.note.object
    turning.sheets.take_model("tap.csv", content, KINDS[2])
    assert turning.settle()
    exact = lobex.exact_limit(known, turning.limit.speed)
    there = np.isfinite(turning.limit.gain)
    assert there.sum() > 30
    assert turning.limit.gain[there] == pytest.approx(exact.gain[there], rel=1e-4)
    # The script reads the file that lies beside it.
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tap.csv").write_bytes(content)
    exec(compile(turning.sheets.taken["py"](), "script.py", "exec"), names := {})
    np.testing.assert_array_equal(names["limit"].gain, turning.limit.gain)
    # A link tells of the file, and does not hold it.
    again = Explorer(turning.state)
    assert "give the file 'tap.csv' of the measured response again" in html.unescape(again.status.message.object)


@pytest.mark.slow
def test_a_file_that_was_refused_is_read_again_once_its_unit_is_said(turning):
    turning.load(replace(STARTS["turning"], view=replace(STARTS["turning"].view, speeds=SPEEDS)))
    content = response_of(lobex.Modes.single(frequency=146.5, damping_ratio=0.02, mass=2.573))
    model, kind, unit = turning.sheets.bring_in
    kind.value = KINDS[1]
    model.param.update(filename="../tap test.csv", value=content.replace(b" [m/N]", b""))
    assert "'tap test.csv' does not say what was measured" in html.unescape(turning.status.message.object)
    assert turning.state.structure == STARTS["turning"].structure
    unit.value = "m/N"
    assert turning.settle()
    (mode,) = turning.state.structure.modes
    assert mode.frequency == pytest.approx(146.5, rel=1e-6)
    # It has the name that the user gave it.
    assert "ModalFit of tap_test.csv" in turning.sheets.note.object


@pytest.mark.slow
def test_a_list_of_cuts_is_read_from_a_file(turning):
    turning.load(replace(STARTS["turning"], view=replace(STARTS["turning"].view, speeds=SPEEDS)))
    turning.sheets._cuts_of_file("cuts.csv", b"speed [rpm],depth [mm],chatter\n7000,0.001,no\n")
    assert turning.settle()
    assert turning.sheets._score.object.startswith("<b>1 of 1</b>")
    turning.sheets._cuts_of_file("cuts.csv", b"speed,depth,chatter\n7000,0.001,no\n")
    assert "unit" in turning.status.message.object


def test_the_shell_refuses_what_it_cannot_show(shell):
    assert "process = 'lathe' is unknown" in shell.refuses("explore", "lathe")
    assert "port = 99999 is none" in shell.refuses("explore", "--port", "99999", "--no-show")
    assert "'tool.toml' is no file" in shell.refuses("explore", "turning", "--tool", "tool.toml")
    assert "tool = 'tool.toml' is of turning or milling" in shell.refuses("explore", "blading", "--tool", "tool.toml")
    assert "drop one of the two" in shell.refuses("explore", "turning", "--tool", "a.toml", "--frf", "a.csv")


def test_a_process_of_ones_own_is_explored():
    tool = lobex.Modes.single(frequency=300.0, damping_ratio=0.02, mass=2.0)
    explorer = lobex.explore(lobex.Turning(tool, radial=5e8), speed=(50, 200), gain=(0, 1e-3))
    assert (explorer.state.view.speed_low, explorer.state.view.gain_high) == (50.0, 1e-3)
    assert explorer.state.structure == Table((Mode(300.0, 0.02, 2.0),))
    explorer.close()
    with refused("process = 'lathe' is unknown"):
        lobex.explore("lathe")
