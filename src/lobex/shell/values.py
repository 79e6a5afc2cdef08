"""From the text of a flag to numbers: a range, one value, or several with commas."""

import re
from typing import Annotated, Any

import numpy as np
import tyro
from tyro.constructors import PrimitiveConstructorSpec

from lobex import _checks
from lobex._lengths import metres

_UNIT = re.compile(r"[\d.]\s*(?!e\s*$)([a-zµμ]+)\s*$")
_MOST_VALUES = 1_000_000


def parse_grid(name: str, text: str, unit: str) -> np.ndarray:
    """Read ``low:high:count`` as a grid with both ends, or increasing values with commas, or one value."""
    if not is_range(text):
        return _checks.grid(name, parse_values(name, text, unit), unit)
    wrong = _wrong(name, text)
    try:
        first, last, number = text.split(":")
        low, high, count = float(first), float(last), int(number)
    except ValueError:
        raise ValueError(wrong) from None
    if count < 2:
        raise ValueError(wrong)
    _checks.as_numbers(name, (low, high), unit)
    if count > _MOST_VALUES:
        raise ValueError(f"{name} = {_checks.brief(text)} asks for {count} values; give at most {_MOST_VALUES}")
    return _checks.grid(name, np.linspace(low, high, count), unit)


def parse_values(name: str, text: str, unit: str) -> np.ndarray:
    """Read a range, one number, or several with commas, in any order."""
    if is_range(text):
        return parse_grid(name, text, unit)
    try:
        numbers = _numbers(text)
    except ValueError:
        raise ValueError(_wrong(name, text)) from None
    _checks.as_numbers(name, numbers, unit)
    return np.array(numbers)


def parse_axes(words: tuple[str, ...]) -> dict[str, dict[str, np.ndarray]]:
    """What a verb is told of further axes: nothing, or ``over`` with the grid of each ``NAME=VALUES`` by its name."""
    axes: dict[str, np.ndarray] = {}
    for word in words:
        name, equals, values = word.partition("=")
        if not name or not equals:
            raise ValueError(
                f"over = {_checks.brief(word)} is not NAME=VALUES; give such as modes.damping_ratio=0.01,0.02,0.04"
            )
        if name in axes:
            raise ValueError(f"over names {name!r} twice; give all its values at once")
        axes[name] = parse_grid(f"over[{name!r}]", values, "")
    return {"over": axes} if axes else {}


def in_metres(name: str, text: str) -> str:
    """The text of a range or of values with lengths in metres: they have units, or one of them has that of all, as in
    0.1:6mm:41; without any they are metres.
    """
    parts = text.split(":" if is_range(text) else ",")
    lengths = parts[:2] if is_range(text) else parts
    units = [found[1] if (found := _UNIT.search(part)) else "" for part in lengths]
    said = {unit for unit in units if unit}
    if not said:
        return text
    for part, unit in zip(lengths, units, strict=True):
        if unit:
            metres(name, part)
    of_all = said.pop() if len(said) == 1 else ""
    plain = [repr(metres(name, part if unit else part + of_all)) for part, unit in zip(lengths, units, strict=True)]
    return (":" if is_range(text) else ",").join(plain + parts[len(plain) :])


def is_range(text: str) -> bool:
    """Whether a curve is asked for, and not single points."""
    return ":" in text


def _wrong(name: str, text: str) -> str:
    return (
        f"{name} = {_checks.brief(text)} is not low:high:count with two or more values, nor numbers with commas; "
        "give such as 50:400:351, 85 or 85,112"
    )


def _numbers(text: str) -> tuple[float, ...]:
    return tuple(float(part) for part in text.split(","))


def _read(words: list[str]) -> tuple[float, ...]:
    try:
        return _numbers(words[0])
    except ValueError:
        raise ValueError(f"{_checks.brief(words[0])} is not a number or several with commas") from None


Range = Annotated[str, tyro.conf.arg(metavar="LOW:HIGH:COUNT|VALUE,...")]
Values: Any = PrimitiveConstructorSpec(
    nargs=1,
    metavar="VALUE[,VALUE...]",
    instance_from_str=_read,
    is_instance=lambda value: isinstance(value, tuple),
    str_from_instance=lambda value: [",".join(f"{number:.6g}" for number in value)],
)
