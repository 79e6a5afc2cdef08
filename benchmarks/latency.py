"""How soon the explorer's curve follows a slider: LATENCY.md.

python benchmarks/latency.py    measure, and write the page; with Chromium and selenium in the browser, too
"""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import jax
import numpy as np

from lobex.explorer.curves import first_look, limit_of, predicted, slopes_of
from lobex.explorer.drawn_columns import limit_columns, predicted_columns, stable_columns
from lobex.explorer.state import STARTS, State
from lobex.explorer.warming import warmed
from machine import machine

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))

import browsers  # noqa: E402

CHANGES, SEARCHES = 200, 30
# Which number moves, and between which values.
MOVED = {
    "rub": ("young_modulus", 1.9e9, 2.3e9),
    "turning": ("radial", 1.5e8, 2.5e8),
    "milling": ("tangential", 5e8, 6e8),
}
# In the browser: a slider's value is set, and the time is taken until the frame that follows the new columns.
_STEP = """
const done = arguments[arguments.length - 1], [name, from, to, count] = arguments;
const every = Array.from(Bokeh.documents[0]._all_models.values());
const within = (model) => model.type.endsWith("Slider") ? model
  : (model.children || []).map(within).find((found) => found);
const slider = within(every.find((model) => (model.css_classes || []).includes(name)));
const source = Bokeh.documents[0].get_model_by_name("source of limit");
const times = [];
let begun = 0;
const next = () => {
  if (times.length >= count) return done(times);
  begun = performance.now();
  slider.value = from + (to - from) * Math.random();
};
source.properties.data.change.connect(() => requestAnimationFrame(() => {
  times.push(performance.now() - begun);
  setTimeout(next, 30);
}));
next();
"""


def states(kind: str, count: int) -> Iterator[State]:
    """States with another number each."""
    name, low, high = MOVED[kind]
    for value in np.random.default_rng(1).uniform(low, high, count):
        yield STARTS[kind].changed(name, float(value))


def timed(work: Callable[[State], object], kind: str, count: int) -> tuple[np.ndarray, int]:
    """Milliseconds of each change once it is warm, and the programs that were compiled meanwhile."""
    for state in states(kind, 3):
        work(state)
    times = []
    with compiled() as programs:
        for state in states(kind, count):
            begun = time.perf_counter()
            work(state)
            times.append(1e3 * (time.perf_counter() - begun))
    return np.array(times), len(programs)


@contextmanager
def compiled() -> Iterator[list[str]]:
    """The programs that JAX compiles."""
    found: list[str] = []

    def listen(event: str, duration: float, **about: object) -> None:
        if event == "/jax/core/compile/backend_compile_duration":
            found.append(str(about.get("fun_name")))

    jax.monitoring.register_event_duration_secs_listener(listen)
    try:
        yield found
    finally:
        jax.monitoring.unregister_event_duration_listener(listen)


def drawn(state: State) -> object:
    """All columns of the limit of a state."""
    limit = limit_of(state)
    return limit_columns(limit), stable_columns(limit)


def in_process() -> Iterator[tuple[str, np.ndarray, int]]:
    """What is computed of a change, in words, with its times."""
    for kind in ("rub", "turning"):
        yield f"{kind}, 1,000 speeds in closed form: number to columns", *timed(drawn, kind, CHANGES)
    start = STARTS["milling"]
    slopes = slopes_of(start, limit_of(start))
    # What a page compiles while it is left alone.
    for _ in warmed(start):
        pass

    def ahead(state: State) -> object:
        found = predicted(slopes, state)
        assert found is not None
        return predicted_columns(found, "rpm", slopes.table.limit.quantity)

    count = start.view.speeds
    yield f"milling, {count} speeds, predicted", *timed(ahead, "milling", CHANGES)
    yield "milling, first look, a sixth of the speeds", *timed(first_look, "milling", SEARCHES)
    yield f"milling, {count} speeds, polished", *timed(drawn, "milling", SEARCHES)


def in_the_browser() -> Iterator[tuple[str, np.ndarray, str]]:
    """From a slider's value to the frame that shows the new limit."""
    for kind, name in (("rub", "of-young-modulus"), ("turning", "of-radial")):
        size = 1e9 if kind == "rub" else 1e6
        low, high = (end / size for end in MOVED[kind][1:])
        with browsers.served(kind) as address, browsers.browser() as driver:
            driver.get(address)
            ready = "return model.data.gain.length"
            browsers.until(driver, lambda: browsers.model(driver, "source of limit", ready), "limit")  # noqa: B023
            driver.set_script_timeout(600)
            driver.execute_async_script(_STEP, name, low, high, 10)
            times = driver.execute_async_script(_STEP, name, low, high, 100)
        yield f"{kind}, in Chromium: slider to the frame that shows it", np.array(times), ""


def page() -> str:
    """The page."""
    rows = []
    parts = [*in_process(), *([] if browsers.missing() else in_the_browser())]
    for words, times, programs in parts:
        median, most = np.percentile(times, [50, 95])
        rows.append(f"| {words} | {median:.1f} | {most:.1f} | {len(times)} | {programs} |")
        print(rows[-1], flush=True)
    return "\n".join(
        [
            "# How soon the explorer's curve follows a slider",
            "",
            "Made by `python benchmarks/latency.py`: changes of one number at random, in milliseconds, once all is "
            "compiled. In the browser the way through the websocket and Bokeh's drawing are in it, in a Chromium that "
            "has neither window nor graphics card.",
            "",
            "| what follows | median | 95th percentile | changes | programs compiled |",
            "|---|---|---|---|---|",
            *rows,
            "",
            f"Machine: {machine()}.",
            "",
        ]
    )


if __name__ == "__main__":
    (HERE / "LATENCY.md").write_text(page())
