"""The process of a state, as a function of its numbers."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from lobex.explorer.calls import Call, Given, call
from lobex.explorer.state import (
    BladingNumbers,
    Measured,
    MillingNumbers,
    Mode,
    Rod,
    RubNumbers,
    State,
    Table,
    TurningNumbers,
)

MEASURED = "frf"
"""The name under which a measured response is given."""


@dataclass(frozen=True)
class Recipe:
    """A process as a call, and the numbers that it is given.

    Attributes:
        call: which makes it of the numbers.
        numbers: a number or a tuple of them by name.
        measured: of a measured response, the file that it is in; "" of others.
    """

    call: Call
    numbers: tuple[tuple[str, Any], ...]
    measured: str = ""

    @property
    def sizes(self) -> tuple[Any, ...]:
        """What is not a number in it: of models that agree in this JAX compiles for the first alone."""
        return self.call, tuple((name, np.shape(value)) for name, value in self.numbers)

    @property
    def arrays(self) -> dict[str, Any]:
        """The numbers as ``lobex.sensitivities`` takes them."""
        return {name: np.asarray(value, dtype=np.float64) for name, value in self.numbers}

    def process(self, response: Any = None) -> Any:
        """The process itself; ``response`` is the ``lobex.Receptance`` that was measured."""
        return self.call({**dict(self.numbers), MEASURED: response})


class _Numbers:
    """Collects numbers by name, and stands for them in calls."""

    def __init__(self) -> None:
        self.found: dict[str, Any] = {}

    def __call__(self, name: str, value: Any) -> Given:
        self.found[name] = value
        return Given(name)

    def where(self, name: str, value: float) -> Given | None:
        """None of what is zero, and so is left out."""
        return self(name, value) if value else None


def recipe_of(state: State) -> Recipe:
    """How to make the process of a state."""
    given = _Numbers()
    modes = _structure(state.structure, given)
    numbers = state.numbers
    if isinstance(numbers, RubNumbers):
        made = call("Rub", modes=modes)
    elif isinstance(numbers, BladingNumbers):
        made = call("Rub", modes=_blading(modes, numbers, given))
    elif isinstance(numbers, TurningNumbers):
        made = _turning(modes, numbers, given)
    else:
        made = _milling(modes, numbers, given)
    measured = state.structure.file if isinstance(state.structure, Measured) else ""
    return Recipe(made, tuple(given.found.items()), measured)


def process_of(state: State, response: Any = None) -> Any:
    """The process of a state."""
    return recipe_of(state).process(response)


def _structure(structure: Rod | Table | Measured, given: _Numbers) -> Call | Given:
    if isinstance(structure, Measured):
        return Given(MEASURED)
    if isinstance(structure, Rod):
        names = ("young_modulus", "density", "length", "area")
        rod = call(
            "Rod", elements=structure.elements, **{name: given(name, getattr(structure, name)) for name in names}
        )
        ratio = given("damping_ratio", structure.damping_ratio)
        return Call("modes", (("damping_ratio", ratio),), rod)
    table = {name: given(name, tuple(getattr(mode, name) for mode in structure.modes)) for name in Mode.columns}
    axes = ("x", "y", "z")[: structure.directions]
    direction = None
    if len(axes) > 1:
        direction = tuple(tuple(getattr(mode, axis) for axis in axes) for mode in structure.modes)
    return call("Modes.from_table", **table, direction=direction)


def _blading(modes: Any, numbers: BladingNumbers, given: _Numbers) -> Call:
    mistuning, spacing = (tuple(getattr(blade, name) for blade in numbers.blades) for name in ("mistuning", "spacing"))
    return call(
        "Blading",
        blade=modes,
        count=len(numbers.blades),
        mistuning=given("mistuning", mistuning) if any(mistuning) else None,
        spacing=None if numbers.even else given("spacing", spacing),
        coupling=given.where("coupling", numbers.coupling),
    )


def _turning(modes: Any, numbers: TurningNumbers, given: _Numbers) -> Call:
    radial = given("radial", numbers.radial)
    if not numbers.damping_coefficient:
        return call("Turning", modes=modes, radial=radial)
    return call(
        "Turning",
        modes=modes,
        radial=radial,
        diameter=given("diameter", numbers.diameter),
        process_damping=_damping(numbers.damping_coefficient, 0.0, given),
    )


def _milling(modes: Any, numbers: MillingNumbers, given: _Numbers) -> Call:
    varied = None
    if numbers.speed_amplitude:
        varied = call(
            "SpeedVariation",
            amplitude=given("speed_amplitude", numbers.speed_amplitude),
            frequency_ratio=numbers.speed_frequency_ratio,
        )
    damping = None
    if numbers.damping_coefficient:
        damping = _damping(numbers.damping_coefficient, numbers.damping_friction, given)
    edges = {
        name: given.where(name, getattr(numbers, name)) for name in ("tangential_edge", "normal_edge", "axial_edge")
    }
    force = call(
        "CuttingForce",
        tangential=given("tangential", numbers.tangential),
        normal=given("normal", numbers.normal),
        axial=given.where("axial", numbers.axial),
        **edges,
    )
    return call(
        "Milling",
        modes=modes,
        cutter=_cutter(numbers, given),
        force=force,
        radial_immersion=given("radial_immersion", numbers.radial_immersion),
        direction=numbers.direction,
        feed_per_tooth=given.where("feed_per_tooth", numbers.feed_per_tooth),
        process_damping=damping,
        speed_variation=varied,
    )


def _damping(coefficient: float, friction: float, given: _Numbers) -> Call:
    return call(
        "ProcessDamping",
        coefficient=given("damping_coefficient", coefficient),
        friction=given.where("damping_friction", friction),
    )


def _cutter(numbers: MillingNumbers, given: _Numbers) -> Call:
    """Of what all teeth have alike, one number."""
    pitch, helix, runout = (
        tuple(getattr(tooth, name) for tooth in numbers.teeth) for name in ("pitch", "helix", "runout")
    )
    even, straight = len(set(pitch)) == 1, not any(helix)
    lead = numbers.lead_degrees
    return call(
        "Cutter.end_mill",
        diameter=given("diameter", numbers.diameter),
        teeth=len(pitch) if even else None,
        pitch_degrees=None if even else given("pitch_degrees", pitch),
        helix_degrees=None if straight else given("helix_degrees", helix[0] if len(set(helix)) == 1 else helix),
        runout=given("runout", runout) if any(runout) else None,
        corner_radius=given.where("corner_radius", numbers.corner_radius),
        lead_degrees=None if lead == 90 else given("lead_degrees", lead),
    )
