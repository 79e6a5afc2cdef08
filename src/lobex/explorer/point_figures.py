"""What is drawn of a point, in Bokeh: motion, spectrum, once-per-period samples; and the bars of the sensitivities."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from bokeh.core.properties import value
from bokeh.models import ColumnDataSource, FactorRange, LegendItem, Range1d, Span
from bokeh.plotting import figure
from jaxtyping import Float

from lobex.explorer.drawn_columns import bar_columns
from lobex.explorer.lobe_figures import GREY, legend_of, plain, symbol_of
from lobex.explorer.point import AtPoint
from lobex.plots.limit_picture import COLOUR
from lobex.processes.quantity import Quantity
from lobex.results.codes import Kind
from lobex.results.sensitivities import Sensitivities

# Of a march, parts of which the lowest and the highest sample are drawn.
_PARTS = 2000
_AXES = ("x", "y", "z")
_COLOURS = (COLOUR[Kind.HOPF], COLOUR[Kind.FLIP], COLOUR[Kind.FOLD])
# Of a spectrum, what is drawn: up to so many times the frequency that holds most of it.
_REACH = 4.0
_MICRO = 1e6


@dataclass(eq=False)
class PointFigures:
    """Motion, spectrum and samples of a point, their sources by name, and the entries of their legends."""

    motion: Any
    spectrum: Any
    samples: Any
    sources: dict[str, Any]
    keys: list[LegendItem]

    def show(self, there: AtPoint) -> None:
        """Draw what was found; of many blades those that move most."""
        march, shown = there.march, loudest(there.march.displacement)
        directions = march.displacement.shape[-1]
        for number, key in enumerate(self.keys):
            place = number % len(_AXES)
            # A single direction needs no name.
            key.visible = directions > 1 and place < len(shown)
            if key.visible:
                key.label = value(_AXES[place] if directions <= len(_AXES) else f"blade {shown[place] + 1}")
        time, moved = thinned(march.time * 1e3, march.displacement[:, shown] * _MICRO)
        self.sources["motion"].data = _by_axis("time", time, moved)
        frequency, size = there.spectrum()
        size = size[:, shown]
        peak = frequency[np.argmax(np.max(size, axis=1))] if len(size) else 0.0
        seen = frequency <= max(_REACH * peak, frequency[-1] / 50)
        self.sources["spectrum"].data = _by_axis("frequency", frequency[seen], size[seen] * _MICRO)
        samples = there.samples()[:, shown] * _MICRO
        self.sources["samples"].data = _by_axis("period", np.arange(len(samples)).astype(float), samples)


def point_figures() -> PointFigures:
    """The three figures, empty."""
    names = {"motion": "time", "spectrum": "frequency", "samples": "period"}
    sources: dict[str, Any] = {
        name: ColumnDataSource(data=_by_axis(axis, np.zeros(0), np.zeros((0, 1))), name=f"source of {name}")
        for name, axis in names.items()
    }
    labels = {
        "motion": ("time (ms)", "displacement (µm)"),
        "spectrum": ("frequency (Hz)", "amplitude (µm)"),
        "samples": ("period", "once per period (µm)"),
    }
    made, keys = {}, {name: [] for name in names}
    for name, (x, y) in labels.items():
        one: Any = figure(
            name=name,
            height=200,
            sizing_mode="stretch_width",
            tools="pan,box_zoom,wheel_zoom,reset",
            x_axis_label=x,
            y_axis_label=y,
            min_border_left=70,
        )
        for axis, colour in zip(_AXES, _COLOURS, strict=True):
            if name == "samples":
                one.scatter(names[name], axis, source=sources[name], size=4, color=colour)
            else:
                line = one.line(names[name], axis, source=sources[name], color=colour, line_width=1)
                keys[name].append(LegendItem(label=axis, renderers=[line]))
        if keys[name]:
            one.add_layout(legend_of(keys[name]), "above")
        plain(one)
        made[name] = one
    return PointFigures(**made, sources=sources, keys=[*keys["motion"], *keys["spectrum"]])


@dataclass(eq=False)
class Bars:
    """The sensitivities at one speed: the figure and its source."""

    figure: Any
    source: ColumnDataSource

    def show(self, table: Sensitivities, speed: float | None) -> float:
        """Draw the largest at a speed, Hz, or where the limit is lowest; returns that speed."""
        columns, at = bar_columns(table, speed)
        names = columns["name"]
        self.figure.y_range.factors = names[::-1]
        self.figure.height = 90 + 24 * max(len(names), 1)
        sizes = np.asarray(columns["size"], float)
        colours = [COLOUR[Kind.HOPF] if size >= 0 else COLOUR[Kind.FLIP] for size in sizes]
        self.source.data = {
            "name": names,
            "size": sizes,
            "text": columns["text"],
            "colour": colours,
            "align": ["left" if size >= 0 else "right" for size in sizes],
            "offset": [5 if size >= 0 else -5 for size in sizes],
        }
        most = 1.8 * max(float(np.max(np.abs(sizes), initial=0.0)), 0.1)
        self.figure.x_range.update(
            start=-most if (sizes < 0).any() else -0.05 * most, end=most if (sizes > 0).any() else 0.05 * most
        )
        return at


def bars(quantity: Quantity) -> Bars:
    """The figure of the bars, empty."""
    names = ("name", "size", "text", "colour", "align", "offset")
    source = ColumnDataSource({name: [] for name in names}, name="source of bars")
    one: Any = figure(
        name="bars",
        height=200,
        sizing_mode="stretch_width",
        tools="",
        y_range=FactorRange(),
        x_range=Range1d(start=-1, end=1),
        x_axis_label=f"d ln {symbol_of(quantity)} / d ln p",
    )
    one.hbar("name", right="size", height=0.7, color="colour", source=source)
    beside: dict[str, Any] = {"text_baseline": "middle", "text_font_size": "9pt", "text_color": GREY}
    one.text("size", "name", "text", source=source, text_align="align", x_offset="offset", **beside)
    one.add_layout(Span(location=0, dimension="height", line_color=GREY, line_width=0.8))
    plain(one)
    one.ygrid.grid_line_color = None
    return Bars(one, source)


def loudest(moved: Float[np.ndarray, "n r"]) -> list[int]:
    """All of up to three contacts, and of more those three that move most, in their order."""
    with np.errstate(over="ignore", invalid="ignore"):
        size = np.sum(np.nan_to_num(moved) ** 2, axis=0)
    return sorted(np.argsort(-size, kind="stable")[: len(_AXES)].tolist())


def thinned(
    time: Float[np.ndarray, " n"], moved: Float[np.ndarray, "n r"]
) -> tuple[Float[np.ndarray, " m"], Float[np.ndarray, "m r"]]:
    """Of a long motion the lowest and the highest sample of each of many parts, so that no peak is lost."""
    count = len(time) // _PARTS
    if count < 3:
        return time, moved
    whole = moved[: count * _PARTS].reshape(_PARTS, count, -1)
    low, high = np.min(whole, axis=1), np.max(whole, axis=1)
    ends = time[: count * _PARTS].reshape(_PARTS, count)
    return ends[:, [0, count // 2]].ravel(), np.stack([low, high], axis=1).reshape(2 * _PARTS, -1)


def _by_axis(name: str, place: np.ndarray, moved: np.ndarray) -> dict[str, Any]:
    """A column for each axis; NaN of those along which nothing moves."""
    none = np.full(len(place), np.nan)
    columns = {axis: moved[:, i] if i < moved.shape[1] else none for i, axis in enumerate(_AXES)}
    return {name: place, **columns}
