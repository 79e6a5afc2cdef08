"""The Python that makes a screen again, to the last bit."""

from lobex.explorer.addresses import query_of
from lobex.explorer.calls import in_python
from lobex.explorer.curves import in_closed_form, slopes_in_closed_form
from lobex.explorer.point import AtPoint
from lobex.explorer.recipes import MEASURED, recipe_of
from lobex.explorer.state import Measured, State

_DEFLECTED = "lambda time: np.zeros((*time.shape, 1)) + np.array({value})"


def script_of(state: State, there: AtPoint | None = None) -> str:
    """A script that finds the limit of a state, with its band, and the motion at its point, and writes them to files.

    Args:
        state: of the screen.
        there: what is shown of its point; the script marches with as many steps.
    """
    recipe = recipe_of(state)
    table = ["numbers = {", *(f'    "{name}": {in_python(value)},' for name, value in recipe.numbers), "}"]
    parts = [
        f'"""The stability limit of {state.kind}, as lobex explore showed it: writes limit.nc, .csv and .png.\n\n'
        f'The screen is /?{query_of(state)}\n"""',
        "import numpy as np\n\nimport lobex",
        "\n".join(table),
    ]
    if isinstance(state.structure, Measured):
        parts.append(_measurement(state.structure))
    parts += [
        f"\ndef process_of(numbers):\n    return {recipe.call.written(1)}\n",
        "process = process_of(numbers)",
        _limit(state),
    ]
    if there is not None:
        parts.append(_point(there))
    return "\n".join(f"{part}\n" for part in parts)


def _measurement(structure: Measured) -> str:
    """Reads the file of the response, which must be the one of the screen."""
    name = in_python(structure.file)
    unit = f", unit={in_python(structure.unit)}" if structure.unit else ""
    return "\n".join(
        [
            "import hashlib",
            "from pathlib import Path",
            "",
            f"file = Path({name})",
            f'if hashlib.sha256(file.read_bytes()).hexdigest() != "{structure.digest}":',
            '    raise SystemExit(f"{file} is not the file of the screen")',
            f'numbers["{MEASURED}"] = lobex.read_frf(file{unit}).receptance()',
        ]
    )


def _limit(state: State) -> str:
    view = state.view
    bounds = f", bounds=({view.gain_low!r}, {view.gain_high!r}), scan={view.scan}"
    lines = [f"speed = np.linspace({view.speed_low!r}, {view.speed_high!r}, {view.speeds})  # Hz"]
    if in_closed_form(state):
        found = "lobex.exact_limit(process, speed)"
    else:
        found = f"lobex.critical_gain(process, speed{bounds})"
    lines += [f"limit = {found}", "print(limit)"]
    picture = "limit"
    known = dict(recipe_of(state).numbers)
    deviation = ", ".join(f'"{name}": {value!r}' for name, value in state.deviation if name in known)
    if deviation:
        searched = "" if slopes_in_closed_form(state) else bounds
        lines += [
            f"table = lobex.sensitivities(process_of, speed{searched}, at=numbers)",
            "print(table)",
            f"band = table.band({{{deviation}}})",
            "print(band)",
            'table.save("sensitivities.nc")',
        ]
        picture = "band"
    lines += ['limit.save("limit.nc")', 'limit.save("limit.csv")', f'{picture}.plot().savefig("limit.png")']
    return "\n".join(lines)


def _point(there: AtPoint) -> str:
    """The march of the point, and its orbit."""
    march = there.march
    history = _DEFLECTED.format(value=in_python(there.deflection))
    steps = march.steps_per_period
    periods = (len(march.phase) - 1) // steps
    lines = [
        f"point = {there.speed!r}, {there.gain!r}  # Hz, {march.quantity.unit}",
        f"history = {history}",
        f"march = lobex.march_delay(process, *point, history, periods={periods}, steps_per_period={steps})",
        "print(march)",
        'march.save("march.nc")',
    ]
    if there.orbit is not None:
        lines += ["orbit = lobex.orbit(process, *point)", "print(orbit)", 'orbit.save("orbit.nc")']
    return "\n".join(lines)
