"""The widgets of a state: a slider with a field for every number, and tables of modes and teeth."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import panel as pn
from bokeh.models.widgets.tables import NumberFormatter

from lobex.explorer.state import (
    DIRECTIONS,
    MOST_BLADES,
    MOST_ELEMENTS,
    MOST_SPEEDS,
    MOST_TEETH,
    Blade,
    BladingNumbers,
    Knob,
    Measured,
    MillingNumbers,
    Mode,
    Rod,
    RubNumbers,
    State,
    Table,
    Tooth,
    knobs_of,
)

Change = Callable[[Callable[[State], State]], None]

WIDE = 330
_DIGITS = 12
# Of which fields have room for; the numbers keep theirs.
_SHOWN = "0[.][0000]"
_STEPS = 500
# Columns of tables, with the size of the unit that they are shown in.
_OF_MODES = {"frequency": ("f (Hz)", 1.0), "damping_ratio": ("ξ (%)", 1e-2), "mass": ("m (kg)", 1.0)}
_OF_AXES = {axis: (axis, 1.0) for axis in ("x", "y", "z")}
_OF_BLADES = {"mistuning": ("mistuning (%)", 1e-2), "spacing": ("spacing (°)", 1.0)}
_OF_TEETH = {"pitch": ("pitch (°)", 1.0), "helix": ("helix (°)", 1.0), "runout": ("runout (µm)", 1e-6)}
_STRUCTURES = {"thesis' rod": Rod, "modal table": Table}


def rounded(value: float) -> float:
    """A number as it was meant: what a unit's factor adds in the last digits goes."""
    return float(f"{value:.{_DIGITS}g}")


def slider(name: str, knob: Knob, value: float, moved: Callable[[float], None]) -> Any:
    """A slider with a field, of the CSS class "of-" and its name; ``moved`` is told of the number in SI, at every step
    of the way.
    """
    low, high = (rounded(end / knob.scale) for end in (knob.low, knob.high))
    shown = rounded(value / knob.scale)
    made = pn.widgets.EditableFloatSlider(
        label=_label(knob.label, knob.unit),
        start=min(low, shown),
        end=max(high, shown),
        step=rounded((high - low) / _STEPS),
        value=shown,
        format=_SHOWN,
        width=WIDE - 20,
        margin=(1, 8),
        css_classes=[f"of-{name.replace('_', '-')}"],
    )
    made.param.watch(lambda event: moved(rounded(event.new * knob.scale)), "value")
    return made


class Controls:
    """All widgets that change a state, for the structure and the process that it has.

    Args:
        state: that they begin with.
        change: is given functions from the old state to the new one.
        axes: name, unit and its size, of the speed and of the gain.

    Attributes:
        column: all of them.
        sliders: by the name of the number.
        modes, teeth, blades: the tables; None where there is none.
    """

    def __init__(
        self, state: State, change: Change, axes: tuple[tuple[str, str, float], tuple[str, str, float]]
    ) -> None:
        self._change, self._axes, self._quiet = self._unless_quiet(change), axes, False
        self.sliders: dict[str, Any] = {}
        self.modes: Any = None
        self.teeth: Any = None
        self.blades: Any = None
        self._of_mode = pn.Column(margin=0)
        cards = [self._structure(state)]
        if isinstance(state.numbers, MillingNumbers):
            cards += [self._cutter(state.numbers), *self._cut(state.numbers)]
        elif isinstance(state.numbers, BladingNumbers):
            cards.append(self._stage(state.numbers))
        elif knobs_of(state.numbers):
            cards.append(_card("Cut", self._sliders(state.numbers)))
        self.column = pn.Column(*cards, self._view(state), width=WIDE + 20, margin=0)

    def show(self, name: str, value: float) -> None:
        """Show another number in a field, which is not a change of it."""
        self._quiet = True
        try:
            self.sliders[name].value = rounded(value)
        finally:
            self._quiet = False

    def _unless_quiet(self, change: Change) -> Change:
        return lambda to: None if self._quiet else change(to)

    def _set(self, name: str) -> Callable[[Any], None]:
        return lambda value: self._change(lambda state: state.changed(name, value))

    def _sliders(self, part: Any, names: tuple[str, ...] | None = None) -> list[Any]:
        found = []
        for name, knob in knobs_of(part).items():
            if names is None or name in names:
                self.sliders[name] = slider(name, knob, getattr(part, name), self._set(name))
                found.append(self.sliders[name])
        return found

    def _structure(self, state: State) -> Any:
        structure, parts = state.structure, []
        if isinstance(state.numbers, RubNumbers) and not isinstance(structure, Measured):
            chosen = pn.widgets.RadioButtonGroup(
                options=list(_STRUCTURES), value="thesis' rod" if isinstance(structure, Rod) else "modal table"
            )
            chosen.param.watch(lambda event: self._change(lambda old: _with_structure(old, event.new)), "value")
            parts.append(chosen)
        if isinstance(structure, Measured):
            parts.append(pn.pane.Markdown(f"Measured response: `{structure.file}`", margin=(0, 8)))
        elif isinstance(structure, Rod):
            count = _whole("elements", structure.elements, 1, MOST_ELEMENTS, self._set("elements"))
            parts += [*self._sliders(structure), count]
        else:
            parts += self._table_of_modes(structure, state.numbers)
        names_blade = isinstance(state.numbers, RubNumbers | BladingNumbers)
        return _card("Blade" if names_blade else "Modes", parts)

    def _table_of_modes(self, structure: Table, numbers: Any) -> list[Any]:
        axes = 0
        if isinstance(numbers, MillingNumbers):
            # Along the axis only where something acts that way.
            axes = 3 if numbers.axial or structure.directions == 3 else 2
        columns = _OF_MODES | dict(list(_OF_AXES.items())[:axes])

        def rows() -> tuple[Mode, ...]:
            return tuple(Mode(**row) for row in _read(self.modes.value, columns))

        def set_rows(modes: tuple[Mode, ...]) -> None:
            self._change(lambda state: replace(state, structure=Table(modes)))

        self.modes = _table(structure.modes, columns, lambda: set_rows(rows()))
        number = pn.widgets.Select(label="sliders of mode", options=_numbers(structure.modes), width=120, margin=(2, 8))
        number.visible = len(structure.modes) > 1

        def slide(_: Any = None) -> None:
            index = number.value - 1
            mode = rows()[index]

            def moved(name: str) -> Callable[[float], None]:
                def to(value: float) -> None:
                    table = self.modes.value.copy()
                    label, size = columns[name]
                    table.loc[index, label] = rounded(value / size)
                    self.modes.value = table
                    set_rows(rows())

                return to

            made = {name: slider(name, knob, getattr(mode, name), moved(name)) for name, knob in knobs_of(mode).items()}
            self.sliders |= made
            self._of_mode.objects = list(made.values())

        def resize(change: Callable[[tuple[Mode, ...]], tuple[Mode, ...]]) -> None:
            modes = change(rows())
            self.modes.value = _frame(modes, columns)
            number.options, number.visible = _numbers(modes), len(modes) > 1
            set_rows(modes)

        number.param.watch(slide, "value")
        slide()
        more = _button("add a mode", lambda: resize(lambda modes: (*modes, modes[-1])))
        fewer = _button("remove the last", lambda: resize(lambda modes: modes[:-1] if len(modes) > 1 else modes))
        return [self.modes, pn.Row(more, fewer, margin=0), number, self._of_mode]

    def _stage(self, numbers: BladingNumbers) -> Any:
        def set_blades(blades: tuple[Blade, ...]) -> None:
            self._change(lambda state: state.changed("blades", blades))

        def spread(count: int) -> None:
            blades = (Blade(spacing=360 / count),) * count
            self.blades.value = _frame(blades, _OF_BLADES)
            set_blades(blades)

        self.blades = _table(
            numbers.blades,
            _OF_BLADES,
            lambda: set_blades(tuple(Blade(**row) for row in _read(self.blades.value, _OF_BLADES))),
        )
        count = _whole("blades, alike and evenly spaced", len(numbers.blades), 1, MOST_BLADES, spread, 220)
        return _card("Stage", [count, self.blades, *self._sliders(numbers)])

    def _cutter(self, numbers: MillingNumbers) -> Any:
        def set_teeth(teeth: tuple[Tooth, ...]) -> None:
            self._change(lambda state: state.changed("teeth", teeth))

        def spread(count: int) -> None:
            first = Tooth(**_read(self.teeth.value, _OF_TEETH)[0])
            teeth = (replace(first, pitch=360 / count, runout=0.0),) * count
            self.teeth.value = _frame(teeth, _OF_TEETH)
            set_teeth(teeth)

        self.teeth = _table(
            numbers.teeth,
            _OF_TEETH,
            lambda: set_teeth(tuple(Tooth(**row) for row in _read(self.teeth.value, _OF_TEETH))),
        )
        count = _whole("teeth at equal angles", len(numbers.teeth), 1, MOST_TEETH, spread)
        shape = self._sliders(numbers, ("diameter", "corner_radius", "lead_degrees"))
        return _card("Cutter", [count, self.teeth, *shape])

    def _cut(self, numbers: MillingNumbers) -> list[Any]:
        way = pn.widgets.RadioButtonGroup(options=list(DIRECTIONS), value=numbers.direction, margin=(4, 8))
        way.param.watch(lambda event: self._set("direction")(event.new), "value")
        ratio = pn.widgets.FloatInput(
            label="speed variations per revolution", value=numbers.speed_frequency_ratio, step=0.05, width=WIDE - 20
        )
        ratio.param.watch(lambda event: self._set("speed_frequency_ratio")(event.new), "value")
        forces = ("tangential", "normal", "axial", "tangential_edge", "normal_edge", "axial_edge")
        rest = ("damping_coefficient", "damping_friction", "speed_amplitude")
        return [
            _card("Cut", [way, *self._sliders(numbers, ("radial_immersion", "feed_per_tooth"))]),
            _card("Forces", self._sliders(numbers, forces[:2])),
            _card("Axial and edge forces", self._sliders(numbers, forces[2:]), True),
            _card("Process damping and speed variation", [*self._sliders(numbers, rest), ratio], True),
        ]

    def _view(self, state: State) -> Any:
        view, found = state.view, []
        for what, (shown, unit, size) in zip(("speed", "gain"), self._axes, strict=True):
            ends = []
            for end in ("low", "high"):
                name = f"{what}_{end}"
                field = pn.widgets.FloatInput(
                    label=_label(f"{end}est {shown}", unit),
                    value=rounded(getattr(view, name) / size),
                    width=150,
                    margin=(2, 8),
                )
                field.param.watch(lambda event, n=name, s=size: self._set(n)(rounded(event.new * s)), "value")
                self.sliders[name] = field
                ends.append(field)
            found.append(pn.Row(*ends, margin=0))
        found.append(_whole("speeds", view.speeds, 2, MOST_SPEEDS, self._set("speeds")))
        if not isinstance(state.numbers, RubNumbers):
            found.append(_whole("gains of a scan", view.scan, 5, 513, self._set("scan")))
        return _card("Diagram", found)


def _with_structure(state: State, name: str) -> State:
    """The same blade in another form: the rod's modes as a table."""
    if _STRUCTURES[name] is type(state.structure):
        return state
    if name == "thesis' rod":
        return replace(state, structure=Rod())
    from lobex.explorer.recipes import process_of
    from lobex.explorer.started import table_of

    return replace(state, structure=table_of(process_of(state).modes), deviation=())


def _label(name: str, unit: str) -> str:
    return name if unit == "1" else f"{name} ({unit})"


def _card(title: str, parts: list[Any], collapsed: bool = False) -> Any:
    return pn.Card(*parts, title=title, collapsed=collapsed, width=WIDE + 12, margin=(4, 4))


def _button(name: str, clicked: Callable[[], None]) -> Any:
    made = pn.widgets.Button(label=name, width=140, margin=(4, 8))
    made.on_click(lambda _: clicked())
    return made


def _whole(name: str, value: int, low: int, high: int, moved: Callable[[int], None], width: int = 150) -> Any:
    made = pn.widgets.IntInput(label=name, value=value, start=low, end=high, width=width, margin=(2, 8, 6, 8))
    made.param.watch(lambda event: moved(int(event.new)), "value")
    return made


def _numbers(rows: tuple[Any, ...]) -> list[int]:
    return list(range(1, len(rows) + 1))


def _table(rows: tuple[Any, ...], columns: Mapping[str, tuple[str, float]], edited: Callable[[], None]) -> Any:
    """A table whose cells are edited."""
    made = pn.widgets.Tabulator(
        _frame(rows, columns),
        show_index=False,
        sortable=False,
        layout="fit_columns",
        theme="simple",
        width=WIDE - 10,
        height=min(38 + 33 * len(rows), 260),
        editors={label: {"type": "number"} for label, _ in columns.values()},
        formatters={label: NumberFormatter(format=_SHOWN, text_align="right") for label, _ in columns.values()},
        sizing_mode="fixed",
        margin=(2, 8),
    )
    made.on_edit(lambda _: edited())
    return made


def _frame(rows: tuple[Any, ...], columns: Mapping[str, tuple[str, float]]) -> pd.DataFrame:
    return pd.DataFrame(
        {label: [rounded(getattr(r, name) / size) for r in rows] for name, (label, size) in columns.items()}
    )


def _read(frame: pd.DataFrame, columns: Mapping[str, tuple[str, float]]) -> list[dict[str, float]]:
    """Numbers of each row by their names; what is no number is NaN, which a state refuses."""
    numbers = {
        name: np.asarray(pd.to_numeric(frame[label], errors="coerce")) * size for name, (label, size) in columns.items()
    }
    count = len(frame)
    return [{name: rounded(float(column[i])) for name, column in numbers.items()} for i in range(count)]
