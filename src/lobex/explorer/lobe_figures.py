"""The limit and its chatter frequencies, in Bokeh: redrawn by handing their sources new columns."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from bokeh.core.properties import value
from bokeh.models import ColumnDataSource, CrosshairTool, CustomJS, Div, Legend, LegendItem, Range1d, Span
from bokeh.plotting import figure
from matplotlib.colors import to_hex

from lobex.explorer.drawn_columns import (
    DEVIATIONS,
    Columns,
    band_columns,
    limit_columns,
    lobe_columns,
    series_of,
    stable_columns,
)
from lobex.explorer.tried_cuts import Cuts
from lobex.plots.advice_pictures import OUTCOMES
from lobex.plots.frame import speed_axis
from lobex.plots.limit_picture import BAND, COLOUR, LABELLED, NAME, STABLE
from lobex.processes.quantity import Quantity
from lobex.results.band import Band
from lobex.results.codes import Kind, Status
from lobex.results.limit import Limit

GREY, RED, GREEN, PURPLE = "#555555", "#c8102e", "#0b7a75", "#7a4b94"
IDLE = "Move over the diagram to read it; click to march the motion there. Numbers are those of the lobes."
_MARKER = {"o": "circle", "X": "x", "d": "diamond"}
_TOOLS = "pan,box_zoom,wheel_zoom,reset"
# Of limits that are drawn alike, by their colour: one that changes is sent back in a form that notebooks do not take.
_SERIES = {colour: f"series {number}" for number, colour in enumerate(dict.fromkeys((*COLOUR.values(), *LABELLED)))}
_LINE: Columns = {"speed": np.zeros(0), "gain": np.zeros(0)}
# In the browser: what is under the cursor, between the speeds computed.
_READ = """
const s = source.data, n = s.speed.length, x = cb_obj.x, y = cb_obj.y;
if (n < 2 || x == null || x < s.speed[0] || x > s.speed[n - 1]) { div.text = idle; return; }
let i = 1;
while (i < n - 1 && s.speed[i] < x) i++;
const share = (x - s.speed[i - 1]) / (s.speed[i] - s.speed[i - 1]);
const near = share < 0.5 ? i - 1 : i;
let limit = s.gain[i - 1] + share * (s.gain[i] - s.gain[i - 1]);
if (!isFinite(limit)) limit = s.gain[near];
const digits = (v) => Number(v.toPrecision(5)).toString();
let text = `<b>${digits(x)} ${speed_unit}</b>, ${symbol} = <b>${digits(Math.max(y, 0))} ${unit}</b>: `;
if (isFinite(limit)) {
  text += `${y > limit ? "above" : "below"} the limit of <b>${digits(limit)} ${unit}</b>, ${kinds[s.kind[near]]}`;
  text += `, chatter at <b>${digits(s.frequency[near])} Hz</b>, lobe ${s.lobe[near]}`;
  const named = series.find((one) => one.visible && isFinite(one.data_source.data.frequency[near]));
  if (named && named.name && !kinds.some((kind) => kind && named.name.startsWith(kind))) text += `, ${named.name}`;
} else text += statuses[s.status[near]];
div.text = text;
"""


@dataclass(eq=False)
class LobeFigures:
    """The limit above, the chatter frequencies below, on one axis of speed.

    Attributes:
        gain, frequency: the two figures.
        readout: a line on what is under the cursor.
        sources: by name: "limit", "ahead" (what is predicted), "stable", "lobes", "band", "point", "next", one of
            cuts for each outcome, and "series 0" and on for limits that are drawn alike.
        keys: entries of the legend, by name.
        below: what is drawn of each series in the lower figure.
    """

    gain: Any
    frequency: Any
    readout: Div
    sources: dict[str, Any]
    keys: dict[str, LegendItem]
    below: dict[str, Any]

    def show(self, limit: Limit, band: Band | None = None) -> None:
        """Draw a limit, and take away what was predicted of it."""
        self.sources["limit"].data = limit_columns(limit)
        drawn = {_SERIES[series.colour]: series for series in series_of(limit)}
        for key in _SERIES.values():
            if key in drawn:
                self.sources[key].data = drawn[key].columns
                self._name(key, drawn[key].name)
            if key in drawn or self.keys[key].visible:
                self._draw(key, key in drawn)
        self.sources["stable"].data = stable_columns(limit)
        self.sources["lobes"].data = lobe_columns(limit, self.gain.y_range.end)
        self.show_ahead(None)
        self.show_band(band)

    def _draw(self, name: str, there: bool) -> None:
        """Whether something is drawn, and told of in the legend."""
        self.keys[name].visible = there
        for one in self._renderers(name):
            one.visible = there

    def _renderers(self, name: str) -> list[Any]:
        return [*self.keys[name].renderers, *([self.below[name]] if name in self.below else [])]

    def _name(self, key: str, name: str) -> None:
        """What a series is called, in the legend and to the cursor."""
        self.keys[key].label = value(name)
        for one in self._renderers(key):
            one.name = name

    def show_ahead(self, columns: Columns | None) -> None:
        """Draw what a limit is thought to be while it is sought; None takes it away."""
        if columns is not None or self.keys["ahead"].visible:
            self._draw("ahead", columns is not None)
            self.sources["ahead"].data = dict(_LINE if columns is None else columns)

    def show_band(self, band: Band | None) -> None:
        """Draw the band of the limit that is drawn; None for none."""
        if band is not None or self.keys["band"].visible:
            self.sources["band"].data = band_columns(band)
            self._draw("band", band is not None)

    def show_point(self, speed: float, gain: float) -> None:
        """Mark a point, in the units of the axes."""
        self.sources["point"].data = {"speed": [speed], "gain": [gain]}

    def show_next(self, speeds: np.ndarray) -> None:
        """Mark speeds, in the unit of the axis."""
        self.sources["next"].data = {"speed": speeds}
        self._draw("next", bool(len(speeds)))

    def show_cuts(self, cuts: Cuts | None, told: np.ndarray, speed_unit: str, quantity: Quantity) -> None:
        """Draw cuts by what the model says of them."""
        scale, _ = speed_axis(speed_unit)
        for outcome in OUTCOMES:
            here = told == outcome
            found = _LINE
            if cuts is not None:
                found = {"speed": cuts.speed[here] * scale, "gain": cuts.gain[here] / quantity.scale}
            self.sources[outcome.name].data = dict(found)
            self._draw(outcome.name, bool(here.any()))

    def ranges(self, speed: tuple[float, float], gain: tuple[float, float]) -> None:
        """Set the ends of the axes, in their units."""
        for axis, (low, high) in ((self.gain.x_range, speed), (self.gain.y_range, gain)):
            axis.update(start=low, end=high, reset_start=low, reset_end=high)


def symbol_of(quantity: Quantity) -> str:
    """ "K_e" as "Kₑ": the figures' texts have no formulas."""
    return quantity.symbol.replace("_e", "ₑ")


def lobe_figures(speed_unit: str, quantity: Quantity) -> LobeFigures:
    """The two figures, empty."""
    sources = _sources()
    unit = "" if quantity.display_unit == "1" else f" ({quantity.display_unit})"
    shared: dict[str, Any] = {"sizing_mode": "stretch_width", "tools": _TOOLS, "min_border_left": 70}
    upper = figure(
        name="lobes",
        height=430,
        x_range=Range1d(start=0, end=1),
        y_range=Range1d(start=0, end=1),
        y_axis_label=f"{quantity.name} {symbol_of(quantity)}{unit}",
        **shared,
    )
    lower = figure(
        name="frequencies",
        height=200,
        x_range=upper.x_range,
        x_axis_label=speed_axis(speed_unit)[1],
        y_axis_label="chatter frequency (Hz)",
        **shared,
    )
    keys = _draw_limit(upper, sources) | _draw_marks(upper, sources)
    below = {
        name: lower.scatter("speed", "frequency", source=sources[name], size=3.2, color=colour)
        for colour, name in _SERIES.items()
    }
    for name, key in keys.items():
        if name != "stable":
            key.visible = False
            for one in [*key.renderers, *([below[name]] if name in below else [])]:
                one.visible = False
    spans: Any = [Span(dimension=way, line_color=GREY, line_width=0.6) for way in ("width", "height")]
    for one in (upper, lower):
        one.add_tools(CrosshairTool(overlay=spans))
        plain(one)
    upper.xaxis.visible = False
    upper.add_layout(legend_of(list(keys.values())), "above")
    readout = Div(text=IDLE, name="readout", styles={"font-size": "13px", "min-height": "22px"})
    told = {
        "source": sources["limit"],
        "div": readout,
        "idle": IDLE,
        "speed_unit": speed_unit,
        "unit": quantity.display_unit,
        "symbol": symbol_of(quantity),
        "kinds": ["", *(NAME[kind].partition(" (")[0] for kind in (Kind.HOPF, Kind.FLIP, Kind.FOLD))],
        "series": [keys[name].renderers[0] for name in _SERIES.values()],
        "statuses": [status.words for status in Status],
    }
    upper.js_on_event("mousemove", CustomJS(args=told, code=_READ))
    return LobeFigures(upper, lower, readout, sources, keys, below)


def plain(one: Any) -> None:
    """The frame that all figures share."""
    one.toolbar.logo = None
    one.toolbar.autohide = True
    one.xgrid.grid_line_color = None
    one.ygrid.grid_line_color = "#e6e6e6"
    one.outline_line_color = "#999999"
    for axis in (one.xaxis, one.yaxis):
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_text_font_size = "10pt"
        axis.major_label_text_font_size = "9pt"


def legend_of(keys: list[LegendItem]) -> Legend:
    """In rows above the frame."""
    made: Any = Legend
    return made(
        items=keys,
        orientation="horizontal",
        location="center",
        ncols=4,
        border_line_color=None,
        background_fill_alpha=0.0,
        label_text_font_size="9pt",
        glyph_height=14,
        glyph_width=18,
        spacing=6,
        padding=2,
        margin=2,
    )


def _sources() -> dict[str, Any]:
    names = ["frequency", "kind", "status", "lobe"]
    empty: dict[str, Any] = {
        "limit": _LINE | {name: np.zeros(0) for name in names},
        "ahead": _LINE,
        "stable": {"xs": [], "ys": []},
        "lobes": _LINE | {"number": [], "offset": []},
        "band": {"xs": [], "ys": []},
        "point": _LINE,
        "next": {"speed": np.zeros(0)},
        **{name: _LINE | {"frequency": np.zeros(0)} for name in _SERIES.values()},
        **{outcome.name: _LINE for outcome in OUTCOMES},
    }
    return {name: ColumnDataSource(dict(columns), name=f"source of {name}") for name, columns in empty.items()}


def _draw_limit(upper: Any, sources: dict[str, Any]) -> dict[str, LegendItem]:
    limit, keys = sources["limit"], {}
    stable = upper.patches("xs", "ys", source=sources["stable"], fill_color=STABLE, line_color=None)
    keys["stable"] = LegendItem(label="stable", renderers=[stable])
    band = upper.patches("xs", "ys", source=sources["band"], fill_color=BAND, fill_alpha=0.6, line_color=None)
    keys["band"] = LegendItem(label=f"± {DEVIATIONS:g} standard deviations", renderers=[band])
    upper.line("speed", "gain", source=limit, color=GREY, line_width=0.8)
    for colour, name in _SERIES.items():
        line = upper.line("speed", "gain", source=sources[name], color=colour, line_width=2.2)
        # A single speed makes no line.
        dots = upper.scatter("speed", "gain", source=sources[name], color=colour, size=1.6)
        keys[name] = LegendItem(label=name, renderers=[line, dots])
    ahead = upper.line("speed", "gain", source=sources["ahead"], color=PURPLE, line_dash="dashed", line_width=1.8)
    keys["ahead"] = LegendItem(label="predicted", renderers=[ahead])
    text = {"text_align": "center", "text_baseline": "middle", "text_font_size": "9pt", "text_color": GREY}
    upper.text("speed", "gain", "number", source=sources["lobes"], y_offset="offset", **text)
    return keys


def _draw_marks(upper: Any, sources: dict[str, Any]) -> dict[str, LegendItem]:
    spans = upper.vspan("speed", source=sources["next"], line_color=GREEN, line_dash="dotted", line_width=2)
    keys = {"next": LegendItem(label="next speeds", renderers=[spans])}
    for outcome, (named, marker) in OUTCOMES.items():
        cross, colour = marker == "X", to_hex(named)
        cuts = upper.scatter(
            "speed",
            "gain",
            source=sources[outcome.name],
            marker=_MARKER[marker],
            size=10,
            fill_color=colour,
            line_width=2.6 if cross else 1,
            line_color=colour if cross else "white",
        )
        keys[outcome.name] = LegendItem(label=f"cut: {outcome.words}", renderers=[cuts])
    upper.scatter("speed", "gain", source=sources["point"], marker="cross", size=18, line_width=2.5, color=RED)
    return keys
