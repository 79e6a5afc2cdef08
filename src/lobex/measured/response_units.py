"""Units of measured responses and of frequencies, as files and people write them."""

import re
from typing import NamedTuple

import numpy as np

from lobex import _checks
from lobex.limits.measurement import MEASURED

_LENGTH = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9}
_LENGTH |= {"in": 0.0254, "ft": 0.3048, "mil": 2.54e-5}
_FORCE = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "lbf": 4.4482216152605, "lb": 4.4482216152605, "kgf": 9.80665}
# Powers of length, time and force, and the size in SI, of every word. The g of accelerometers is no gram.
_WORDS: dict[str, tuple[np.ndarray, float]] = {
    **{word: (np.array([1, 0, 0]), size) for word, size in _LENGTH.items()},
    **{word: (np.array([0, 0, 1]), size) for word, size in _FORCE.items()},
    **{word: (np.array([0, 1, 0]), 1.0) for word in ("s", "sec")},
    **{word: (np.array([1, -2, 0]), 9.80665) for word in ("g", "gn", "G")},
    "kg": (np.array([-1, 2, 1]), 1.0),
}
_FACTOR = re.compile(r"([A-Za-zµμ]+|1)(?:\^?([+-]?\d+))?")
_FREQUENCY = {"hz": 1.0, "khz": 1e3, "rad/s": 1 / (2 * np.pi), "rad/sec": 1 / (2 * np.pi), "rpm": 1 / 60, "1/s": 1.0}
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")


class ResponseUnit(NamedTuple):
    """What was measured over force, and in which unit.

    Attributes:
        measured: one of ``MEASURED``.
        scale: its size in m/N, m/(N s) or m/(N s²).
        text: as it was written.
    """

    measured: str
    scale: float
    text: str


def response_unit(text: str) -> ResponseUnit | None:
    """The unit that is meant by such as "m/N", "mm/s/N", "g/lbf" or "m/(N s^2)"; None where it is of no response."""
    plain = text.translate(_SUPERSCRIPTS).replace("**", "^").strip().strip("[]")
    plain = re.sub(r"\bN(?=s\b|s\d|s\^)", "N ", re.sub(r"[·*⋅.]", " ", plain))
    found = _product(plain)
    if found is None:
        return None
    (length, time, force), scale = found
    if (length, force) != (1, -1) or -time not in range(len(MEASURED)):
        return None
    plain = text.strip().strip("[]")
    inner = plain[1:-1]
    alone = plain.startswith("(") and plain.endswith(")") and not set("()") & set(inner)
    return ResponseUnit(MEASURED[-time], scale, inner if alone else plain)


def _product(text: str) -> tuple[tuple[int, int, int], float] | None:
    """Powers of length, time and force of a product, and its size in SI; all that follows a stroke is below it."""
    powers, scale, sign = np.zeros(3, int), 1.0, 1
    for part in re.findall(r"/|\([^()]*\)|[^\s/()]+", text):
        if part == "/":
            sign = -1
            continue
        one = _product(part[1:-1]) if part.startswith("(") else _factor(part)
        if one is None:
            return None
        powers, scale = powers + sign * np.array(one[0]), scale * one[1] ** sign
    return tuple(powers.tolist()), float(scale)


def _factor(text: str) -> tuple[tuple[int, int, int], float] | None:
    found = _FACTOR.fullmatch(text)
    if found is None or (found[1] != "1" and found[1] not in _WORDS):
        return None
    own, size = (np.zeros(3, int), 1.0) if found[1] == "1" else _WORDS[found[1]]
    power = int(found[2] or 1)
    return tuple((power * own).tolist()), size**power


def frequency_scale(text: str) -> float | None:
    """The size in Hz of a unit of frequency, None of what is none."""
    return _FREQUENCY.get(text.strip().lower().replace(" ", ""))


def check_response_unit(text: str) -> ResponseUnit:
    """As ``response_unit``, of an argument that a user gave.

    Raises:
        ValueError: for what is no unit of a response over a force.
    """
    found = response_unit(text) if isinstance(text, str) else None
    if found is None:
        raise ValueError(
            f"unit = {_checks.brief(text)} is no unit of a response over a force; give such as 'm/N', 'mm/s/N', "
            "'m/s^2/N' or 'g/N'"
        )
    return found


def check_frequency_unit(text: str) -> float:
    """As ``frequency_scale``, of an argument that a user gave.

    Raises:
        ValueError: for what is no unit of a frequency.
    """
    found = frequency_scale(text) if isinstance(text, str) else None
    if found is None:
        raise ValueError(f"frequency_unit = {_checks.brief(text)} is unknown; give 'Hz', 'kHz', 'rad/s' or 'rpm'")
    return found


def with_measured(unit: ResponseUnit, measured: str) -> str:
    """The unit of the same length and force, of what else was measured."""
    (length,) = [word for word in re.findall(r"[A-Za-zµμ]+", unit.text) if word in _LENGTH][:1] or ["m"]
    (force,) = [word for word in re.findall(r"[A-Za-zµμ]+", unit.text) if word in _FORCE][:1] or ["N"]
    return length + ("", "/s", "/s^2")[MEASURED.index(measured)] + "/" + force
