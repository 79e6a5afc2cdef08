"""The page: widgets change the state, a thread computes what follows from it, and figures are handed the columns."""

import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import panel as pn

from lobex._warnings import LobexWarning
from lobex.explorer.addresses import query_of
from lobex.explorer.controls import Controls
from lobex.explorer.curves import Slopes, first_look, in_closed_form, limit_of, predicted, slopes_of
from lobex.explorer.drawn_columns import predicted_columns
from lobex.explorer.lobe_figures import LobeFigures, lobe_figures, symbol_of
from lobex.explorer.point import AtPoint, at_point
from lobex.explorer.posting import Posts
from lobex.explorer.recipes import recipe_of
from lobex.explorer.sheets import Sheets
from lobex.explorer.state import STARTS, Measured, Point, State
from lobex.explorer.status_line import BUSY, StatusLine
from lobex.explorer.warming import warmed
from lobex.explorer.worker import Worker
from lobex.plots.frame import speed_axis
from lobex.processes.quantity import CONTACT_STIFFNESS, DEPTH_OF_CUT, Quantity
from lobex.results.band import Band
from lobex.results.limit import Limit

# In the order in which they are done.
_KINDS = ("limit", "point", "advice", "slopes", "address", "warm")
# After the last change of a number, s: while a slider moves the limit alone is drawn.
_AFTER = {"slopes": 0.25, "address": 0.3, "warm": 1.0}
_QUANTITIES = {
    "rub": CONTACT_STIFFNESS,
    "turning": DEPTH_OF_CUT,
    "milling": DEPTH_OF_CUT,
    "blading": CONTACT_STIFFNESS,
}
_SPEED_UNITS = {"rub": "Hz", "turning": "rpm", "milling": "rpm", "blading": "Hz"}
_SIZES = "a new size: programs are compiled …"


class Explorer(pn.viewable.Viewer):
    """Lobes that follow the numbers of a model, on a page or in a notebook.

    Attributes:
        state: all that the screen follows from.
        limit: the limit that is drawn, once there is one, and
        drawn: the state that it is of.
        slopes: how it moves with the numbers; None until they are known.
        panes: in which the diagram stands.
        there: what was found of the point.
        status: what the page says of itself.
        post: has a function called where the page lives, from any thread.
    """

    def __init__(self, state: State, responses: dict[str, Any] | None = None) -> None:
        super().__init__()
        self.state = state
        self.responses = {} if responses is None else responses
        self.limit: Limit | None = None
        self.drawn = state
        self.slopes: Slopes | None = None
        self.there: AtPoint | None = None
        self._left: dict[str, State] = {}
        posts = Posts(lambda: (*self.panes, *self.sheets.panes))
        self.post, self._settle = posts.post, posts.settle
        self._location: Any = pn.state.location if posts.in_browser else None
        self.status = StatusLine(self.post)
        self.worker = Worker(_KINDS, self.status.failed, self.status.tell)
        kinds = pn.widgets.RadioButtonGroup(options=list(STARTS), value=state.kind, margin=(4, 8), width=340)
        kinds.param.watch(lambda event: self._switch(event.new), "value")
        self._kinds = kinds
        self._body = pn.Row(margin=0, sizing_mode="stretch_width")
        title = pn.pane.HTML("<b>lobex explore</b>", margin=(8, 12), styles={"font-size": "17px"})
        head = pn.Row(title, kinds, self.status.state, self.status.message, margin=0, sizing_mode="stretch_width")
        self._whole = pn.Column(head, self._body, margin=0, sizing_mode="stretch_width")
        self._build()

    def __panel__(self) -> Any:
        return self._whole

    @property
    def quantity(self) -> Quantity:
        """What the gain is."""
        return _QUANTITIES[self.state.kind]

    @property
    def speed_unit(self) -> str:
        """In which speeds are shown."""
        return _SPEED_UNITS[self.state.kind]

    @property
    def response(self) -> Any:
        """What was measured, where the structure is."""
        structure = self.state.structure
        return self.responses.get(structure.digest) if isinstance(structure, Measured) else None

    def change(self, to: Callable[[State], State]) -> None:
        """Go to another state, and draw what is known of it at once."""
        try:
            new = to(self.state)
        except ValueError as error:
            self.status.say(str(error))
            return
        if new != self.state:
            self.status.say("")
            self.go_to(new)

    def go_to(self, state: State) -> None:
        """Show a state."""
        old, self.state = self.state, state
        if (old.kind, type(old.structure)) != (state.kind, type(state.structure)):
            self._build()
            return
        if old.view != state.view:
            self._set_ranges()
        if _model(old) != _model(state):
            self._compute()
        elif old.deviation != state.deviation:
            self._draw_slopes()
        if state.point is not None and (old.point, old.periods) != (state.point, state.periods):
            self._march()
        self._keep_address()

    def settle(self, timeout: float = 600.0) -> bool:
        """Wait until nothing is computed any more; whether that is so."""
        settled = self.worker.settle(timeout)
        self._settle()
        return settled

    def close(self) -> None:
        """End the thread."""
        self.worker.close()

    def load(self, state: State) -> None:
        """Show the state of a file, all widgets anew."""
        self.state = state
        self._kinds.param.update(value=state.kind)
        self._build()

    def _switch(self, kind: str) -> None:
        if kind != self.state.kind:
            self._left[self.state.kind] = self.state
            self.load(self._left.get(kind, STARTS[kind]))

    def _build(self) -> None:
        """Make all widgets and figures anew, for the state's process and structure."""
        scale, size = speed_axis(self.speed_unit)[0], self.quantity.scale
        axes = (
            ("speed", self.speed_unit, 1 / scale),
            (symbol_of(self.quantity), self.quantity.display_unit, size),
        )
        self.limit = self.slopes = self.there = None
        self.controls = Controls(self.state, self.change, axes)
        self.figures: LobeFigures = lobe_figures(self.speed_unit, self.quantity)
        self.figures.gain.on_event("tap", self._tapped)
        self.sheets = Sheets(self)
        seen = pn.widgets.Button(label="compute what is seen", width=170, margin=(2, 8))
        seen.on_click(lambda _: self._take_ranges())
        fit = pn.widgets.Button(label="fit the axis to the limit", width=190, margin=(2, 8))
        fit.on_click(lambda _: self._fit())
        drawn = (self.figures.gain, self.figures.frequency, self.figures.readout)
        self.panes = [pn.pane.Bokeh(one, sizing_mode="stretch_width", margin=0) for one in drawn]
        middle = pn.Column(
            *self.panes,
            pn.Row(seen, fit, margin=0),
            sizing_mode="stretch_width",
            min_width=480,
            margin=(0, 8),
        )
        left = pn.Column(self.controls.column, scroll=True, height=880, width=375, margin=0)
        self._body.objects = [left, middle, self.sheets.tabs]
        self._set_ranges()
        self._compute()
        if self.state.point is not None:
            self._march()
        if self.state.heard is not None:
            self.sheets.hear(self.state.heard)
        self._keep_address()

    def _compute(self) -> None:
        """Ask for the limit of the state."""
        state, response = self.state, self.response
        if isinstance(state.structure, Measured) and response is None:
            self.status.say(
                f"give the file {state.structure.file!r} of the measured response again: a link does not hold it"
            )
            return
        ahead = None if self.slopes is None or in_closed_form(state) else predicted(self.slopes, state)
        if ahead is not None:
            self.figures.show_ahead(predicted_columns(ahead, self.speed_unit, self.quantity))
        known = self.slopes is not None and recipe_of(state).sizes == self.slopes.recipe.sizes
        self.status.busy = BUSY if known or self.slopes is None else _SIZES
        if self.status.busy == _SIZES:
            self.status.show(_SIZES)
        self.worker.forget("slopes")
        self.worker.forget("warm")
        self.worker.ask("limit", lambda: self._find_limit(state, response))

    def _find_limit(self, state: State, response: Any) -> Iterator[None]:
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", LobexWarning)
            if not in_closed_form(state):
                look = first_look(state)
                self.post(lambda: self._show_look(state, look))
                yield
            limit = limit_of(state, response)
            doubts = [str(one.message) for one in told if issubclass(one.category, LobexWarning)]
        self.post(lambda: self._show_limit(state, limit, doubts))
        yield

    def _show_look(self, state: State, look: Limit) -> None:
        if state.view == self.state.view:
            self.figures.show_ahead(predicted_columns(look, self.speed_unit, self.quantity))

    def _show_limit(self, state: State, limit: Limit, doubts: list[str]) -> None:
        if state.kind != self.state.kind:
            return
        self.limit, self.drawn = limit, state
        self.figures.show(limit)
        if doubts or self.status.doubting:
            self.status.say("; ".join(dict.fromkeys(doubts)), doubt=True)
        self.sheets.limit_changed()
        if _model(state) != _model(self.state):
            return
        if not isinstance(state.structure, Measured):
            self.worker.ask("slopes", lambda: self._find_slopes(state, limit), _AFTER["slopes"])

    def _find_slopes(self, state: State, limit: Limit) -> Iterator[None]:
        slopes = slopes_of(state, limit)
        self.post(lambda: self._show_slopes(state, slopes))
        yield

    def _show_slopes(self, state: State, slopes: Slopes) -> None:
        if state.kind != self.state.kind:
            return
        self.slopes = slopes
        self._draw_slopes()
        if not in_closed_form(state):
            self.worker.ask("warm", lambda: warmed(state), _AFTER["warm"])

    def _draw_slopes(self) -> None:
        if self.slopes is not None:
            self.figures.show_band(self.band)
            self.sheets.slopes_changed()

    @property
    def band(self) -> Band | None:
        """The band of the limit that is drawn; None where no deviation is given, or none is known yet."""
        if self.slopes is None or not self.state.deviation or self.slopes.table.limit is not self.limit:
            return None
        known = dict(self.slopes.recipe.numbers)
        deviation = {name: value for name, value in self.state.deviation if name in known}
        return self.slopes.table.band(deviation) if deviation else None

    def _tapped(self, event: Any) -> None:
        scale, size = speed_axis(self.speed_unit)[0], self.quantity.scale
        if event.x is None or event.x <= 0:
            return
        point = Point(float(event.x) / scale, max(float(event.y), 0.0) * size)
        self.change(lambda state: replace(state, point=point))

    def _march(self) -> None:
        state = self.state
        assert state.point is not None
        scale, size = speed_axis(self.speed_unit)[0], self.quantity.scale
        self.figures.show_point(state.point.speed * scale, state.point.gain / size)
        self.worker.ask("point", lambda: self._find_point(state))
        self.sheets.point_asked()

    def _find_point(self, state: State) -> Iterator[None]:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", LobexWarning)
            there = at_point(state)
        self.post(lambda: self._show_point(state, there))
        yield

    def _show_point(self, state: State, there: AtPoint) -> None:
        if state.point == self.state.point:
            self.there = there
            self.sheets.point_changed()

    def _set_ranges(self) -> None:
        view, scale, size = self.state.view, speed_axis(self.speed_unit)[0], self.quantity.scale
        speeds = (view.speed_low * scale, view.speed_high * scale)
        self.figures.ranges(speeds, (view.gain_low / size, view.gain_high / size))

    def taken(self) -> tuple[Limit, Slopes | None]:
        """The limit of the state as it is now, and what is known of its slopes, to be taken away."""
        state = self.state
        if self.limit is None or _model(self.drawn) != _model(state):
            self.limit, self.drawn = limit_of(state, self.response), state
        if state.deviation and (self.slopes is None or self.slopes.table.limit is not self.limit):
            self.slopes = slopes_of(state, self.limit)
        return self.limit, self.slopes

    def _take_ranges(self) -> None:
        """Make what is zoomed to the diagram."""
        scale, size = speed_axis(self.speed_unit)[0], self.quantity.scale
        x, y = self.figures.gain.x_range, self.figures.gain.y_range
        self.view_changed(
            speed_low=max(float(x.start), 1e-3) / scale,
            speed_high=float(x.end) / scale,
            gain_low=max(float(y.start), 0.0) * size,
            gain_high=float(y.end) * size,
        )

    def _fit(self) -> None:
        """End the axis of the gain a little above the lowest limits."""
        gain = np.asarray(self.limit.gain if self.limit is not None else [])
        gain = gain[np.isfinite(gain)]
        if gain.size:
            self.view_changed(gain_high=float(f"{min(3 * np.median(gain), 1.1 * gain.max()):.2g}"))

    def view_changed(self, **ends: float) -> None:
        """Show other ends, in the fields too, which change the state."""
        self.change(lambda state: replace(state, view=replace(state.view, **ends)))
        view, scale, size = self.state.view, speed_axis(self.speed_unit)[0], self.quantity.scale
        factors = {"speed_low": scale, "speed_high": scale, "gain_low": 1 / size, "gain_high": 1 / size}
        for name, factor in factors.items():
            self.controls.show(name, getattr(view, name) * factor)

    def _keep_address(self) -> None:
        """The address holds the state, so that it can be kept and sent."""
        if self._location is not None:
            self.worker.ask("address", self._tell_address, _AFTER["address"])

    def _tell_address(self) -> Iterator[None]:
        location: Any = self._location

        def show() -> None:
            location.param.update(search=f"?{query_of(self.state)}")

        self.post(show)
        yield


def _model(state: State) -> tuple[Any, ...]:
    """What of a state its limit follows from."""
    return state.structure, state.numbers, state.view
