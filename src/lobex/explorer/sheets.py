"""The sheets beside the diagram: the point, what matters, advice, and files in and out."""

import io
import warnings
from dataclasses import replace
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
import panel as pn

from lobex._warnings import LobexWarning
from lobex.advice.next_try import next_speed
from lobex.explorer.drawn_columns import in_words
from lobex.explorer.files_read import KINDS, UNITS, read_cuts_of, read_model
from lobex.explorer.files_taken import picture, saved
from lobex.explorer.point_figures import bars, point_figures
from lobex.explorer.recipes import process_of
from lobex.explorer.report import report_of
from lobex.explorer.script import script_of
from lobex.explorer.state import Measured
from lobex.explorer.tried_cuts import Cuts, cuts_of_text, outcomes
from lobex.plots.frame import speed_axis
from lobex.results.codes import Outcome
from lobex.results.next_speeds import NextSpeeds
from lobex.results.units import shown_gain, shown_speed

if TYPE_CHECKING:
    from lobex.explorer.page import Explorer

_WIDE = 440
_MODELS = ".toml,.csv,.txt,.frf,.unv,.uff,.npy,.npz,.mat,.xlsx"
_CUTS = {
    "rpm": "rpm, mm, chatter\n12000, 1.0, 0\n14500, 2.5, 1",
    "Hz": "Hz, MN/m, chatter\n120, 0.3, 0\n150, 0.6, 1",
}
# Of a fit, with as many columns as it has directions.
_REPORT = "font-size: 10px; overflow-x: auto; margin: 0"


class Sheets:
    """All sheets of a page.

    Attributes:
        tabs: the sheets.
        note: what is told of a file that was brought in.
        panes: in which their figures stand.
        taken: what is downloaded, by its ending: functions that make bytes.
        bring_in: the fields of a file: itself, what it holds, and the unit of a response.
    """

    def __init__(self, page: "Explorer") -> None:
        self._page = page
        self.cuts: Cuts | None = None
        self.figures = point_figures()
        self.bars = bars(page.quantity)
        self._about = pn.pane.HTML("Click at a point of the diagram.", width=_WIDE, name="about the point")
        measured = isinstance(page.state.structure, Measured)
        self._of_bars = pn.pane.HTML(
            "Known of modes: fit them to the measured response." if measured else "Not known yet.", width=_WIDE
        )
        self.note = pn.pane.HTML("", width=_WIDE)
        self._deviations = pn.Column(margin=0, width=_WIDE)
        self._named: tuple[str, ...] = ()
        drawn = (self.figures.motion, self.figures.spectrum, self.figures.samples, self.bars.figure)
        self.panes = [pn.pane.Bokeh(one, width=_WIDE, margin=0) for one in drawn]
        self._of_point = pn.Column(*self.panes[:3], width=_WIDE, visible=False, margin=0)
        self.panes[3].visible = False
        point = pn.Column(self._about, self._of_point, width=_WIDE)
        matter = pn.Column(self._of_bars, self.panes[3], self._deviations, width=_WIDE)
        self.tabs = pn.Tabs(
            ("Point", point),
            ("What matters", matter),
            ("Advice", self._advice()),
            ("Files", self._files()),
            width=_WIDE + 20,
        )

    def limit_changed(self) -> None:
        """Say of cuts what the new limit says."""
        if self.cuts is not None:
            self._judge()

    def slopes_changed(self) -> None:
        """Draw bars, and a field for the deviation of every number that there is."""
        page = self._page
        assert page.slopes is not None
        at = self.bars.show(page.slopes.table, None if page.state.point is None else page.state.point.speed)
        self.panes[3].visible = True
        where = "At the clicked speed" if page.state.point is not None else "Where the limit is lowest"
        shown = "no limit" if np.isnan(at) else shown_speed(at, page.speed_unit)
        self._of_bars.object = f"{where}, {shown}: percent of limit per percent of each number."
        names = tuple(name for name, _ in page.slopes.recipe.numbers if name in self._moving())
        if names != self._named:
            self._named = names
            fields = [self._deviation(name) for name in names]
            rows = [pn.Row(*fields[i : i + 3], margin=0) for i in range(0, len(fields), 3)]
            self._deviations.objects = [
                pn.pane.HTML("<b>Relative standard deviations</b>, percent, for the band:"),
                *rows,
            ]

    def point_asked(self) -> None:
        """Say that the point is being marched."""
        self._about.object = "marching …"
        self.tabs.active = 0
        if self._page.slopes is not None:
            self.slopes_changed()

    def point_changed(self) -> None:
        """Show what was found at the point."""
        there, page = self._page.there, self._page
        assert there is not None
        self.figures.show(there)
        self._of_point.visible = True
        stable = there.radius < 1
        colour = "#12436d" if stable else "#c8500a"
        lines = [
            f"<b>{shown_speed(there.speed, page.speed_unit)}, {shown_gain(there.gain, page.quantity)}</b>: "
            f'<b style="color:{colour}">{"stable" if stable else "unstable"}</b>, max|μ| = {there.radius:.6g}',
            f"in the march it changes by a factor of {float(there.march.growth):.6g} per period, "
            f"in {there.march.steps_per_period} steps",
        ]
        if there.orbit is not None:
            error = there.location_error
            lines.append(f"periodic motion: {there.orbit.status}")
            if error is not None:
                alike = np.allclose(error, error[0], rtol=1e-9, atol=0)
                shown = ", ".join(f"{1e6 * each:+.3f}" for each in (error[:1] if alike else error)).replace("-", "−")
                lines.append(f"surface location error: <b>{shown} µm</b>" + ("" if alike else " by tooth"))
            else:
                lines.append("a location error takes modes across the feed, too")
        self._about.object = "<br>".join(lines)

    def _moving(self) -> set[str]:
        """The numbers that the limit depends on."""
        page = self._page
        assert page.slopes is not None
        table = page.slopes.table
        size = np.nanmax(np.abs(np.nan_to_num(table.logarithmic)), axis=0)
        return {name.partition("[")[0] for name, most in zip(table.names, size, strict=True) if most > 1e-9}

    def _deviation(self, name: str) -> Any:
        known = dict(self._page.state.deviation)
        made = pn.widgets.FloatInput(
            label=in_words(name),
            value=100 * known.get(name, 0.0),
            start=0.0,
            end=100.0,
            step=1.0,
            width=135,
            margin=(2, 5),
        )

        def moved(event: Any) -> None:
            def to(state: Any) -> Any:
                others = [pair for pair in state.deviation if pair[0] != name]
                value = [(name, event.new / 100)] if event.new else []
                return replace(state, deviation=tuple(sorted(others + value)))

            self._page.change(to)

        made.param.watch(moved, "value")
        return made

    def _advice(self) -> Any:
        page = self._page
        heard = pn.widgets.FloatInput(
            label="chatter frequency that was heard (Hz)", value=page.state.heard, start=0.0, width=250
        )
        self._speeds = pn.pane.HTML("", width=_WIDE, name="next speeds")
        heard.param.watch(lambda event: self.hear(event.new), "value")
        self._text = pn.widgets.TextAreaInput(
            label="cuts: speed, gain, chatter", placeholder=_CUTS[page.speed_unit], height=130, width=_WIDE - 40
        )
        shown = pn.widgets.Button(label="hold them against the limit", width=220)
        shown.on_click(lambda _: self.take_cuts(self._text.value))
        file = pn.widgets.FileInput(accept=".csv,.txt,.xlsx", width=_WIDE - 60)
        file.param.watch(lambda event: event.new and self._cuts_of_file(file.filename, event.new), "value")
        self._score = pn.pane.HTML("", width=_WIDE, name="score")
        title = "<b>{}</b>"
        return pn.Column(
            pn.pane.HTML(title.format("Next speed")),
            heard,
            self._speeds,
            pn.pane.HTML(title.format("Cuts that were made")),
            self._text,
            shown,
            file,
            self._score,
            width=_WIDE,
        )

    def hear(self, frequency: float | None) -> None:
        """Show the speeds to try after a chatter frequency that was heard, Hz."""
        page = self._page
        page.change(lambda state: replace(state, heard=frequency or None))
        if not frequency:
            self._speeds.object = ""
            page.figures.show_next(np.zeros(0))
            return
        state, response = page.state, page.response

        def work() -> Any:
            view, passes = state.view, getattr(process_of(state, response), "passes", 1)
            process = None if isinstance(state.structure, Measured) else process_of(state)
            bounds = None if process is None else (view.gain_low, view.gain_high)
            ends = (view.speed_low, view.speed_high)
            found = next_speed(frequency, passes, speed=ends, process=process, bounds=bounds)
            page.post(lambda: self._show_speeds(found))
            yield

        page.worker.ask("advice", work)

    def _show_speeds(self, found: NextSpeeds) -> None:
        page = self._page
        rows = "".join(
            f"<tr><td>{lobe:.0f}</td><td>{shown_speed(speed, page.speed_unit)}</td><td>"
            f"{shown_gain(limit, page.quantity, 4) if np.isfinite(limit) else escape(str(status))}</td></tr>"
            for lobe, speed, limit, status in zip(found.lobe, found.speed, found.limit, found.status, strict=True)
        )
        self._speeds.object = f"<table><tr><th>waves</th><th>speed</th><th>limit there</th></tr>{rows}</table>"
        page.figures.show_next(found.speed * speed_axis(page.speed_unit)[0])

    def _cuts_of_file(self, name: str, content: bytes) -> None:
        try:
            self.cuts = read_cuts_of(name, content)
        except ValueError as error:
            self._page.status.say(str(error))
            return
        self._page.status.say("")
        self._judge()

    def take_cuts(self, text: str) -> None:
        """Overlay the cuts of a text."""
        page = self._page
        try:
            self.cuts = cuts_of_text(text, page.speed_unit, page.quantity)
        except ValueError as error:
            page.status.say(str(error))
            return
        page.status.say("")
        self._judge()

    def _judge(self) -> None:
        page, cuts = self._page, self.cuts
        assert cuts is not None
        state = page.state
        if isinstance(state.structure, Measured):
            page.status.say("cuts are held against modes; a measured response tells of limits alone")
            return

        def work() -> Any:
            told = outcomes(cuts, process_of(state))
            page.post(lambda: self._show_cuts(told))
            yield

        page.worker.ask("advice", work)

    def _show_cuts(self, told: np.ndarray) -> None:
        page = self._page
        page.figures.show_cuts(self.cuts, told, page.speed_unit, page.quantity)
        counts = [(outcome, int(np.sum(told == outcome))) for outcome in Outcome]
        hits = sum(count for outcome, count in counts if outcome in (Outcome.QUIET_AS_SAID, Outcome.CHATTER_AS_SAID))
        rows = "".join(f"<tr><td>{outcome.words}</td><td>{count}</td></tr>" for outcome, count in counts if count)
        self._score.object = f"<b>{hits} of {len(told)}</b> as the limit says<table>{rows}</table>"

    def _files(self) -> Any:
        kind = pn.widgets.Select(label="it holds", options=list(KINDS), width=180)
        unit = pn.widgets.Select(label="unit, response over force", options=list(UNITS), width=180, visible=False)
        kind.param.watch(lambda event: unit.param.update(visible="response" in event.new), "value")
        model = pn.widgets.FileInput(accept=_MODELS, width=_WIDE - 60)

        def read(_: Any) -> None:
            # What was read is on other sheets: a file that is still here was refused, as it was said to be.
            if model.value:
                self.take_model(model.filename, model.value, kind.value, unit.value)

        for one in (model, kind, unit):
            one.param.watch(read, "value")
        self.bring_in = model, kind, unit
        name = f"lobex-{self._page.state.kind}"
        self.taken = {
            "py": self._script,
            "csv": lambda: saved(self._limit(), ".csv"),
            "nc": lambda: saved(self._limit(), ".nc"),
            "png": lambda: picture(self._plot, "png"),
            "svg": lambda: picture(self._plot, "svg"),
            "html": self._report,
        }
        words = {
            "py": "Python script",
            "csv": "CSV table",
            "nc": "NetCDF",
            "png": "PNG",
            "svg": "SVG",
            "html": "HTML report",
        }
        buttons = [
            pn.widgets.FileDownload(
                callback=lambda made=made: io.BytesIO(made()),
                filename=f"{name}.{ending}",
                label=words[ending],
                width=200,
                margin=(3, 6),
            )
            for ending, made in self.taken.items()
        ]
        rows = [pn.Row(*buttons[i : i + 2], margin=0) for i in range(0, len(buttons), 2)]
        return pn.Column(
            pn.pane.HTML("<b>Take away</b>"),
            *rows,
            pn.pane.HTML("The address of this page holds all numbers: keep it, or send it."),
            pn.pane.HTML("<b>Bring in</b> a file: choose it, or drop it on the field"),
            pn.Row(kind, unit, margin=0),
            model,
            self.note,
            width=_WIDE,
        )

    def take_model(self, name: str, content: bytes, kind: str = KINDS[0], unit: str = UNITS[0]) -> None:
        """Show what a file says: a tool, a modal table, or modes fitted to a measured response."""
        page = self._page
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", LobexWarning)
            try:
                read = read_model(name, content, page.state, kind, unit)
            except ValueError as error:
                page.status.say(str(error))
                return
        if isinstance(read.state.structure, Measured):
            page.responses[read.state.structure.digest] = read.response
        note = read.told
        page.load(read.state)
        # What stands on the page now are other sheets.
        page.sheets.note.object = f'<pre style="{_REPORT}">{escape(note)}</pre>' if note else ""
        page.sheets.tabs.active = 3 if note else 0
        page.status.say("; ".join(str(one.message) for one in told), doubt=True)

    def _limit(self) -> Any:
        return self._page.taken()[0]

    def _plot(self) -> Any:
        limit, _ = self._page.taken()
        return limit.plot() if self._page.band is None else self._page.band.plot()

    def _script(self) -> bytes:
        return script_of(self._page.state, self._page.there).encode()

    def _report(self) -> bytes:
        self._page.taken()
        return report_of(self._page).encode()
