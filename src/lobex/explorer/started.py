"""The state that a page begins with: of a process, or of the thesis' models."""

from dataclasses import replace
from typing import Any

import numpy as np

from lobex import _checks
from lobex.explorer.state import (
    STARTS,
    Blade,
    BladingNumbers,
    MillingNumbers,
    Mode,
    RubNumbers,
    State,
    Table,
    Tooth,
    TurningNumbers,
    View,
)
from lobex.processes.milling import Milling
from lobex.processes.regenerative import Rub, Turning
from lobex.structures.blading import Blading
from lobex.structures.modes import Modes

# Of the view of a process: lobes of its most flexible mode, and how far above the lowest limit. Below, structures turn
# many times between two passes, which takes operators minutes to compile.
_SLOWEST, _FASTEST, _HEIGHT = 0.24, 1.3, 5.0
_DIGITS = 13


def _as_typed(value: Any) -> float:
    """A number without what a change of its unit added in the last digits."""
    return float(f"{float(value):.{_DIGITS}g}")


def state_of(process: Any, speed: Any = None, gain: Any = None) -> State:
    """The state of a process, whose numbers are then those of the page.

    Args:
        process: ``Rub``, ``Turning`` or ``Milling`` with ``Modes`` that have one shape for displacement and force, or
            ``Rub`` of a ``Blading`` with such modes of a blade.
        speed: lowest and highest speed that is drawn, Hz; by default around the lobes of the most flexible mode.
        gain: lowest and highest gain.

    Raises:
        ValueError: for another process, and for parts of one that a page has no numbers for.
    """
    makers = {Rub: _rub, Turning: _turning, Milling: _milling}
    if type(process) not in makers:
        raise ValueError(f"process = {_checks.brief(process)} is not explored; give lobex.Rub, Turning or Milling")
    _checks.untraced("explore", process=process)
    numbers = makers[type(process)](process)
    modes = process.modes.blade if isinstance(process.modes, Blading) else process.modes
    return State(table_of(modes), numbers, _view(process, modes, numbers, speed, gain))


def table_of(modes: Any) -> Table:
    """The table of modes."""
    if not isinstance(modes, Modes):
        raise ValueError(f"modes = {_checks.brief(modes)} is no table of a page; give lobex.Modes")
    if modes.force_shape is not None or modes.complex:
        raise ValueError("modes has shapes of force apart, or complex ones, which a page's table does not hold")
    shape = np.asarray(modes.shape, dtype=float)
    if shape.shape[1] > 3:
        raise ValueError(f"modes has {shape.shape[1]} contact directions; give up to 3")
    if not np.any(shape, axis=1).all():
        raise ValueError("modes has one that does not move at the contact; leave it out")
    size = np.linalg.norm(shape, axis=1)
    rows = []
    for omega, ratio, length, row in zip(modes.angular_frequency, modes.damping_ratio, size, shape, strict=True):
        x, y, z = np.pad(row / length, (0, 3 - len(row))).tolist()
        alone = len(row) == 1
        typed = map(_as_typed, (omega / (2 * np.pi), ratio, 1 / length**2))
        rows.append(Mode(*typed, *((1.0,) if alone else (x, y, z))))
    return Table(tuple(rows))


def _rub(process: Rub) -> RubNumbers | BladingNumbers:
    _refuse(process, ("casing",))
    stage = process.modes
    if not isinstance(stage, Blading):
        return RubNumbers()
    mistuning = np.zeros(stage.count) if stage.mistuning is None else np.asarray(stage.mistuning, dtype=float)
    spacing = np.full(stage.count, 360 / stage.count) if stage.spacing is None else np.asarray(stage.spacing)
    coupling = np.unique(0.0 if stage.coupling is None else np.asarray(stage.coupling, dtype=float))
    if mistuning.ndim > 1 or len(coupling) > 1:
        raise ValueError("modes of Rub has numbers for each mode of a blade, which a page has no numbers for")
    rows = zip(mistuning.tolist(), spacing.tolist(), strict=True)
    return BladingNumbers(float(coupling[0]), tuple(Blade(*row) for row in rows))


def _turning(process: Turning) -> TurningNumbers:
    _refuse(process, ("speed_variation",))
    usual = TurningNumbers()
    damping = process.process_damping
    return TurningNumbers(
        radial=float(process.radial),
        diameter=usual.diameter if process.diameter is None else float(process.diameter),
        damping_coefficient=0.0 if damping is None else float(damping.coefficient),
    )


def _milling(process: Milling) -> MillingNumbers:
    _refuse(process, ("angles",))
    cutter, usual = process.cutter, MillingNumbers()
    for name in ("discs", "offset", "serration"):
        if getattr(cutter, name) is not None:
            raise ValueError(f"cutter has {name}, which a page has no numbers for")
    damping, varied = process.process_damping, process.speed_variation
    if varied is not None and varied.profile is not None:
        raise ValueError("speed_variation has a profile, which a page has no numbers for; leave it a sine")
    count = cutter.teeth
    pitch = np.full(count, 360 / count) if cutter.pitch is None else np.rad2deg(cutter.pitch)
    helix = np.broadcast_to(0.0 if cutter.helix is None else np.rad2deg(cutter.helix), count)
    runout = np.zeros(count) if cutter.runout is None else np.asarray(cutter.runout)
    rows = zip(*(map(_as_typed, column) for column in (pitch, helix, runout)), strict=True)
    edge = np.zeros(3) if process.edge is None else np.asarray(process.edge, dtype=float)
    of_edge = dict(zip(("tangential_edge", "normal_edge", "axial_edge"), edge.tolist(), strict=True))
    return MillingNumbers(
        tangential=float(process.tangential),
        normal=float(process.normal),
        axial=_number(process.axial, 0.0),
        radial_immersion=_number(process.radial_immersion, 1.0),
        direction=process.direction,
        feed_per_tooth=_number(process.feed_per_tooth, 0.0),
        **of_edge,
        diameter=_number(cutter.diameter, usual.diameter),
        corner_radius=_number(cutter.corner_radius, 0.0),
        lead_degrees=90.0 if cutter.lead is None else _as_typed(np.rad2deg(cutter.lead)),
        damping_coefficient=0.0 if damping is None else float(damping.coefficient),
        damping_friction=0.0 if damping is None else float(damping.friction),
        speed_amplitude=0.0 if varied is None else float(varied.amplitude),
        speed_frequency_ratio=usual.speed_frequency_ratio if varied is None else float(varied.frequency_ratio),
        teeth=tuple(Tooth(*row) for row in rows),
    )


def _number(value: Any, otherwise: float) -> float:
    return otherwise if value is None else float(value)


def _refuse(process: Any, names: tuple[str, ...]) -> None:
    for name in names:
        if getattr(process, name) is not None:
            raise ValueError(f"{name} of {type(process).__name__} is given, which a page has no numbers for")


def _view(process: Any, modes: Any, numbers: Any, speed: Any, gain: Any) -> View:
    """What is asked for or, of what is not, the lobes of the mode that moves most under a force at its frequency."""
    omega, ratio = np.asarray(modes.angular_frequency), np.maximum(np.asarray(modes.damping_ratio), 1e-6)
    stiffness = omega**2 / np.sum(np.asarray(modes.shape) ** 2, axis=1)
    # The least limit of one mode over all speeds, of a straight force.
    least = 2 * stiffness * ratio * (1 + ratio)
    softest = int(np.argmin(least))
    teeth = getattr(process, "passes", 1)
    per_depth = {"rub": 1.0, "blading": 1.0, "turning": getattr(numbers, "radial", 1.0)}.get(numbers.name)
    if per_depth is None:
        per_depth = 0.25 * max(1.0, teeth * numbers.radial_immersion**0.5) * (numbers.tangential + numbers.normal)
    most = float(f"{_HEIGHT * least[softest] / per_depth:.1g}")
    frequency = float(omega[softest] / (2 * np.pi))
    ends = [float(f"{frequency / teeth * share:.2g}") for share in (_SLOWEST, _FASTEST)]
    speeds = ends if speed is None else [float(end) for end in np.ravel(speed)]
    gains = [0.0, most] if gain is None else [float(end) for end in np.ravel(gain)]
    for name, given in (("speed", speeds), ("gain", gains)):
        if len(given) != 2:
            raise ValueError(f"{name} must be two numbers, the lowest and the highest")
    ends_by_name = {"speed_low": speeds[0], "speed_high": speeds[1], "gain_low": gains[0], "gain_high": gains[1]}
    return replace(STARTS[numbers.name].view, **ends_by_name)
