"""The explorer as a user has it: a server of its own process, a real browser, a mouse."""

import http.client
import json
import os
import subprocess
import sys
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest

import browsers
import lobex
from lobex.explorer.addresses import state_of_query
from lobex.explorer.state import STARTS

# Where a browser is installed for the tests, one that is missing is no excuse.
NEEDED = "LOBEX_TESTS_BROWSER" in os.environ
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(bool(browsers.missing()) and not NEEDED, reason=browsers.missing() or "there is a browser"),
]
TOOL = lobex.Modes.single(frequency=146.5, damping_ratio=0.0032, mass=2.573)
SPEEDS = np.linspace(2000 / 60, 12000 / 60, 1000)


def limit_at(radial):
    return lobex.exact_limit(lobex.Turning(TOOL, radial=radial), SPEEDS)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("downloads")


@pytest.fixture(scope="module")
def address():
    with browsers.served("turning") as address:
        yield address


@pytest.fixture(scope="module")
def page(folder, address):
    with browsers.browser(folder) as driver:
        driver.get(address)
        browsers.until(driver, lambda: len(gains(driver)) == 1000, "limit of turning")
        yield driver


def gains(driver):
    """The limit that is drawn, mm."""
    # NaN is no JSON.
    code = "return Array.from(model.data.gain, (value) => isFinite(value) ? value : null)"
    found = browsers.model(driver, "source of limit", code)
    return np.array(found or [], dtype=float)


def handle_of(driver, name):
    """The handle of the slider of a number."""
    (host,) = browsers.found(driver, f".of-{name}")
    return driver.execute_script(browsers.WITHIN, host, ".noUi-handle")


def drag(driver, handle, pixels):
    from selenium.webdriver.common.action_chains import ActionChains

    driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", handle)
    ActionChains(driver).click_and_hold(handle).move_by_offset(pixels, 0).release().perform()


def place_of(driver, x, y):
    """Where the frame of the lobes has a point, in pixels of the window."""
    code = (
        "const view = Bokeh.index.find ? Bokeh.index.find_one(model) : null;"
        "const at = view.el.getBoundingClientRect(), frame = view.frame;"
        "return [at.left + frame.x_scale.compute(more[0]), at.top + frame.y_scale.compute(more[1])]"
    )
    return browsers.model(driver, "lobes", code, x, y)


def mouse_at(driver, x, y, click=False):
    """Move the mouse to a point of the diagram, and click there."""
    from selenium.webdriver.common.actions.action_builder import ActionBuilder

    driver.execute_script("window.scrollTo(0, 0)")
    left, top = place_of(driver, x, y)
    actions = ActionBuilder(driver)
    actions.pointer_action.move_to_location(int(left) - 3, int(top)).move_to_location(int(left), int(top))
    if click:
        actions.pointer_action.click()
    actions.perform()


def test_the_page_begins_with_the_limit_of_the_verb(page):
    np.testing.assert_allclose(gains(page), limit_at(2e8).gain / 1e-3, rtol=1e-12)


def test_a_slider_that_is_dragged_moves_the_curve(page):
    drag(page, handle_of(page, "radial"), 60)
    state = browsers.until(page, lambda: moved(page), "other limit")
    assert state.numbers.radial > 2.5e8
    browsers.until(page, lambda: same(gains(page), limit_at(state.numbers.radial).gain / 1e-3), "limit of the slider")


def moved(driver):
    """The state in the address, once it is another than the first."""
    state = state_of_query(urlsplit(driver.current_url).query)
    return state if state.numbers != STARTS["turning"].numbers else None


def same(found, known):
    return found.shape == known.shape and np.allclose(found, known, rtol=1e-12, equal_nan=True)


def test_the_cursor_reads_the_diagram(page):
    mouse_at(page, 7000.0, 0.5)

    def told():
        text = browsers.model(page, "readout", "return model.text")
        return text if text and "rpm" in text else None

    text = browsers.until(page, told, "text")
    assert "the limit of" in text
    assert "mm</b>, Hopf, chatter at" in text


def test_a_click_marches_the_motion_there(page):
    mouse_at(page, 7000.0, 0.02, click=True)
    code = "return model.data.period.length"
    count = browsers.until(page, lambda: browsers.model(page, "source of samples", code), "march")
    assert count == 101
    point = browsers.until(page, lambda: state_of_query(urlsplit(page.current_url).query).point, "point in the address")
    # To a pixel.
    assert point.speed == pytest.approx(7000 / 60, rel=2e-2)
    assert point.gain == pytest.approx(2e-5, abs=1.2e-5)


@pytest.fixture(scope="module")
def stage(address, folder):
    with browsers.browser(folder) as driver:
        driver.get(f"http://{urlsplit(address).netloc}/?process=blading")
        browsers.until(driver, lambda: len(gains(driver)) == 1000, "limit of blading")
        yield driver


def legend(driver):
    """The names in the legend of the diagram that are shown."""
    code = (
        "const keys = model.above.concat(model.center).find((one) => one.type === 'Legend');"
        "return keys.items.filter((one) => one.visible).map((one) => one.label.value)"
    )
    return browsers.model(driver, "lobes", code)


BLADE = lobex.Modes.single(frequency=400.0, damping_ratio=0.005, mass=0.11)
STAGE_SPEEDS = np.linspace(40.0, 160.0, 1000)


def test_a_stage_of_blades_shows_waves_around_the_disc_by_colour(stage):
    known = lobex.exact_limit(lobex.Rub(lobex.Blading(BLADE, 6, coupling=60.0)), STAGE_SPEEDS)
    np.testing.assert_allclose(gains(stage), known.gain / 1e6, rtol=1e-12)
    waves = [f"nodal diameter {k}" for k in sorted(set(known.nodal_diameter.tolist()))]
    assert [name for name in legend(stage) if name.startswith("nodal")] == waves


def test_the_coupling_of_a_stage_moves_its_lobes(stage):
    drag(stage, handle_of(stage, "coupling"), 40)

    def other():
        state = state_of_query(urlsplit(stage.current_url).query)
        return state if state.numbers.coupling > 70 else None

    state = browsers.until(stage, other, "other coupling")
    known = lobex.exact_limit(lobex.Rub(lobex.Blading(BLADE, 6, coupling=state.numbers.coupling)), STAGE_SPEEDS)
    browsers.until(stage, lambda: same(gains(stage), known.gain / 1e6), "limit of the slider")


def test_a_click_marches_a_stage(stage):
    mouse_at(stage, 100.0, 0.01, click=True)
    code = "return model.data.period.length"
    count = browsers.until(stage, lambda: browsers.model(stage, "source of samples", code), "march")
    assert count == 101
    assert "max|μ| = " in browsers.text_of(stage)
    assert [line["message"] for line in stage.get_log("browser") if line["level"] == "SEVERE"] == []


def sheet(driver, number):
    tabs = browsers.found(driver, ".bk-tab")
    driver.execute_script("arguments[0].click()", tabs[number])


def take(driver, folder, label, name):
    """Click at a button of the sheet of files, and have what is downloaded."""
    sheet(driver, 3)

    def button():
        links = [one for one in browsers.found(driver, "a, button") if label in (one.text or "")]
        return links[0] if links and links[0].is_displayed() else None

    browsers.until(driver, button, f"button {label}").click()
    return browsers.downloaded(folder, name)


def test_the_script_makes_the_screen_again_to_the_last_bit(page, folder, tmp_path):
    script = take(page, folder, "Python script", "lobex-turning.py")
    table = take(page, folder, "NetCDF", "lobex-turning.nc")
    subprocess.run([sys.executable, str(script)], cwd=tmp_path, check=True, capture_output=True, timeout=300)
    shown = browsers.model(page, "source of limit", "return Array.from(model.data.gain)")
    made, taken = lobex.load(tmp_path / "limit.nc"), lobex.load(table)
    np.testing.assert_array_equal(made.gain, taken.gain)
    np.testing.assert_array_equal(made.gain / 1e-3, shown)
    assert {path.name for path in tmp_path.iterdir()} == {"limit.nc", "limit.csv", "limit.png", "march.nc"}


def test_the_address_brings_the_screen_back(page, address, folder):
    known = gains(page)
    with browsers.browser(folder) as other:
        other.get(page.current_url)
        browsers.until(other, lambda: same(gains(other), known), "same limit")


def test_nothing_is_fetched_from_elsewhere(page, address):
    asked = set()
    for line in page.get_log("performance"):
        message = json.loads(line["message"])["message"]
        if message["method"] == "Network.requestWillBeSent":
            asked.add(urlsplit(message["params"]["request"]["url"])[:2])
    assert {host for scheme, host in asked if scheme in ("http", "https", "ws", "wss")} == {urlsplit(address).netloc}
    assert [line["message"] for line in page.get_log("browser") if line["level"] == "SEVERE"] == []


def test_other_origins_do_not_come_in(address):
    host = urlsplit(address).netloc
    for origin, status in (("http://elsewhere.example", 403), (f"http://{host}", 101)):
        assert answered(host, origin) == status


def answered(host, origin):
    """The status that a request for a websocket from an origin is answered with."""
    headers = {
        "Origin": origin,
        "Upgrade": "websocket",
        "Connection": "Upgrade",
        "Sec-WebSocket-Version": "13",
        "Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA==",
        "Sec-WebSocket-Protocol": "bokeh",
    }
    connection = http.client.HTTPConnection(host, timeout=20)
    connection.request("GET", "/ws", headers=headers)
    try:
        return connection.getresponse().status
    finally:
        connection.close()


def test_the_server_listens_to_this_machine_alone(address):
    port = urlsplit(address).port
    listening = [
        line.split()[1]
        for name in ("tcp", "tcp6")
        for line in Path(f"/proc/net/{name}").read_text().splitlines()[1:]
        if line.split()[3] == "0A" and int(line.split()[1].rpartition(":")[2], 16) == port
    ]
    assert listening == [f"0100007F:{port:04X}"]


def test_a_link_that_says_nonsense_is_refused_in_words(page, address):
    where = f"http://{urlsplit(address).netloc}/?process=turning&radial=__import__('os')"
    page.get(where)
    browsers.until(page, lambda: "is no number" in browsers.text_of(page), "refusal", 60)
