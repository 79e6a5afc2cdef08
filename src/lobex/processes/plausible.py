"""What is accepted but can hardly be meant: speeds in rpm, damping in per cent, depths in millimetres.

Errors are for what no model can have (``check_speed``, ``check_gain``, ``check_modes``). Overdamped modes, speeds above
every lobe and thick cuts exist, so that these are warnings. A process whose ``speed_unit`` is "1" has no
units, and only its damping is looked at.
"""

from typing import Any

import jax
import numpy as np

from lobex import _checks
from lobex._warnings import warn
from lobex.processes.quantity import has_units

# Above every lobe: the first one of a single mode ends at 1 pass per period of the mode.
FAST = 5.0
# Per period of the fastest mode, more than any machine passes: such speeds are refused. Not of the first one: a machine
# may stand on springs.
TOO_FAST = 60.0
# Depths of cut from here on, m, are those of millimetres; and limits, of which some between lobes are far above what
# is cut.
_THICK, _NO_LIMIT = 0.1, 1.0
# Specific cutting forces of what is cut at all, N/m²: foam to steel, 600 N/mm² being 6e8.
_SOFTEST, _HARDEST = 1e6, 1e11
# And so are the chips and the runout that a tooth has, and the diameter of its cutter and its corner.
_CHIP, _OTHERS = 0.01, {"runout": 0.001, "offset": 0.001, "diameter": 1.0, "corner_radius": 0.5}
_OTHERS |= {"amplitude": 0.005, "wave_length": 0.1, "wear_land": 0.005}
# What material pressed in resists with, N/m³: steel 1e5 N/mm³, and so 1e14.
_SOFTEST_PRESSED = 1e11


def warn_of_implausible(process: Any, speed: Any, gain: Any = None, largest: Any = None) -> None:
    """Warn, at the user's line, of all that is implausible in a call; of nothing where JAX traces a part of it."""
    for message in implausible(process, speed, gain, largest):
        warn(message)


def implausible(process: Any, speed: Any, gain: Any = None, largest: Any = None) -> list[str]:
    """Messages on the numbers of a call that passed its checks: a process, its speeds, Hz, and gains if it has any, of
    which the ``largest`` may be one that is looked up to, as that of bounds is.
    """
    # The modes by themselves as well: a process of one's own may be no pytree.
    if _is_traced((process, getattr(process, "modes", None), speed, gain)):
        return []
    messages = [_overdamped(process)]
    if has_units(process):
        messages.append(_in_other_units(process))
    if has_units(process) and np.size(speed):
        messages += [_in_rpm(process, np.asarray(speed, dtype=float), gain), _in_millimetres(process, gain)]
        cutter = getattr(process, "cutter", None)
        lengths = {name: getattr(cutter, name, None) for name in ("runout", "offset", "diameter", "corner_radius")}
        lengths["feed_per_tooth"] = getattr(process, "feed_per_tooth", None)
        if (wave := getattr(cutter, "serration", None)) is not None:
            lengths |= {"amplitude": wave.amplitude, "wave_length": wave.wave_length}
        messages += [too_long(name, length) for name, length in lengths.items()]
        doubt = getattr(process, "doubt", None)
        most = gain if largest is None else largest
        messages += [doubt(speed, most)] if doubt is not None and most is not None else []
    return [message for message in messages if message is not None]


def warn_of_thick(process: Any, limit: Any) -> None:
    """Warn, at the user's line, where every limit of a depth of cut, m, is more than a tool has."""
    if _is_traced((process, limit)) or not has_units(process) or process.gain.unit != "m":
        return
    found = np.asarray(limit, dtype=float)
    found = found[np.isfinite(found)]
    if found.size and found.min() >= _NO_LIMIT:
        more = " or more" if found.size > 1 else ""
        warn(
            f"the limit is a {process.gain.name} of {float(found.min()):.6g} m{more}, longer than any tool; look at "
            "the units of modes (Hz or rad/s, kg, m) and of cutting forces (N/m²)"
        )


def passes_per_period(process: Any, speed: np.ndarray, fastest: bool = False) -> float | None:
    """The least number of passes at these speeds per period of the first mode, or of the fastest.

    None without modes, or of traced ones.
    """
    modes = getattr(process, "modes", None)
    frequency = getattr(modes, "angular_frequency", None)
    response = getattr(modes, "response", None)
    if any(map(_checks.is_traced, (frequency, response))) or (frequency is None and response is None):
        return None
    if frequency is not None:
        omega = np.asarray(frequency)
        first = float(omega.max() if fastest else omega.min()) / (2 * np.pi)
    else:
        # Of a measurement, the resonance that takes in most power, whatever its sign of time; a magnitude has none.
        lines = np.asarray(getattr(modes, "frequency", None))
        samples = np.asarray(response)
        power = np.abs(lines * np.imag(samples if samples.ndim == 1 else np.trace(samples, axis1=1, axis2=2)))
        if not np.any(power):
            return None
        first = float(lines[np.argmax(power)])
    return float(np.min(speed)) * getattr(process, "passes", 1) / first


def too_long(name: str, length: Any) -> str | None:
    """The message on a feed, a runout or a diameter, m, that can only be in millimetres, if it is one."""
    largest = 0.0 if length is None else float(np.max(np.abs(np.asarray(length))))
    if largest < _OTHERS.get(name, _CHIP):
        return None
    return f"{name} = {largest:.6g} m is more than any tool has; it is in m, 0.0001 for 0.1 mm"


def too_soft(indentation_coefficient: Any) -> str | None:
    """The message on an indentation coefficient, N/m³, that can only be in N/mm³, if it is one."""
    number = float(np.asarray(indentation_coefficient))
    if number >= _SOFTEST_PRESSED:
        return None
    return (
        f"indentation_coefficient = {number:.6g} N/m³ is less than any metal has; it is in N/m³, 1e14 for 100000 N/mm³"
    )


def _is_traced(tree: Any) -> bool:
    return any(map(_checks.is_traced, jax.tree.leaves(tree)))


def _overdamped(process: Any) -> str | None:
    ratio = getattr(getattr(process, "modes", None), "damping_ratio", None)
    if ratio is None or (largest := float(np.max(np.asarray(ratio)))) < 1:
        return None
    return f"damping_ratio = {largest:.6g} lets nothing vibrate; it is a share of critical damping, 0.03 for 3 per cent"


def _in_other_units(process: Any) -> str | None:
    """Of specific cutting forces that no material has."""
    if process.gain.unit != "m":
        return None
    names = ("tangential", "normal", "axial", "radial")
    given = {name: force for name in names if (force := getattr(process, name, None)) is not None}
    forces = {name: abs(float(np.max(np.asarray(force)))) for name, force in given.items() if np.size(force)}
    name = max(forces, key=forces.__getitem__, default="")
    if not name or _SOFTEST <= forces[name] <= _HARDEST:
        return None
    return (
        f"{name} = {forces[name]:.6g} N/m² is {'less' if forces[name] < _SOFTEST else 'more'} than what is cut takes; "
        "specific cutting forces are in N/m², 6e8 for 600 N/mm²"
    )


def _in_rpm(process: Any, speed: np.ndarray, gain: Any) -> str | None:
    passes = passes_per_period(process, speed)
    if passes is None:
        passes = _passes_of_system(process, speed, gain)
    if passes is None or passes <= FAST:
        return None
    return (
        f"every speed, from {float(speed.min()):.6g} Hz, passes more than {FAST:.0f} times per period of the first "
        "mode, above every lobe of it; speeds are revolutions per second, which is rpm/60"
    )


def _passes_of_system(process: Any, speed: np.ndarray, gain: Any) -> float | None:
    """As ``passes_per_period``, for processes of no modes, by the slowest vibration of their system."""
    if hasattr(process, "modes") or gain is None:
        return None
    system = process.system(float(speed.min()), float(np.max(gain)))
    if _is_traced(system) or not np.isfinite(blocks := np.asarray(system.blocks)).all():
        return None
    turning = float(np.min(np.max(np.imag(np.linalg.eigvals(blocks)), axis=-1)))
    return None if turning <= 0 else 2 * np.pi / (turning * float(np.asarray(system.period)))


def _in_millimetres(process: Any, gain: Any) -> str | None:
    if gain is None or process.gain.unit != "m":
        return None
    depths = np.asarray(gain, dtype=float)
    cutting = depths[depths > 0]
    if not cutting.size or cutting.min() < _THICK:
        return None
    return (
        f"{process.gain.name} = {float(cutting.min()):.6g} m{' or more' if cutting.size > 1 else ''} is more than a "
        "tool cuts; depths are in m, 0.002 for 2 mm"
    )
