"""What a result says of the model that it came from: plain text and numbers, in JSON."""

import dataclasses
import functools
from typing import Any, Protocol, runtime_checkable

import numpy as np

from lobex.results.codes import Code


def describe(value: Any) -> Any:
    """A frozen dataclass of numbers as nested dictionaries, lists and numbers; a function by its name."""
    if dataclasses.is_dataclass(value):
        fields = {f.name: describe(getattr(value, f.name)) for f in dataclasses.fields(value)}
        return {"type": type(value).__name__, **fields}
    if isinstance(value, str | bool | int | float | None):
        return value
    if isinstance(value, tuple | list):
        return [describe(v) for v in value]
    if isinstance(value, dict):
        return [describe(v) for v in value.values()]
    if isinstance(value, functools.partial):
        name = getattr(value.func, "__name__", type(value.func).__name__)
        return {"type": f"function {name}", "numbers": describe(value.args)}
    numbers = np.asarray(value)
    if np.iscomplexobj(numbers):
        return {"type": "Complex", "real": np.real(numbers).tolist(), "imag": np.imag(numbers).tolist()}
    return numbers.tolist()


def in_words(description: Any) -> str:
    """A description as one line, such as ``Chebyshev(nodes=40, aligned=True, full=False)``."""
    if isinstance(description, dict):
        inner = ", ".join(f"{k}={in_words(v)}" for k, v in description.items() if k != "type")
        return f"{description['type']}({inner})"
    if isinstance(description, list):
        return f"[{', '.join(in_words(v) for v in description)}]"
    return f"{description:.6g}" if isinstance(description, float) else repr(description)


def doubts(error: np.ndarray, codes: type[Code], status_code: np.ndarray, parts: str) -> list[str]:
    """Lines on the largest estimated error, if one was estimated, and on how many ``parts`` are not simply good."""
    lines = [f"  estimated error  at most {np.nanmax(error):.1e}"] if np.any(error > 0) else []
    told = [code for code in codes if code.words != "good"]
    return lines + [f"  {code.words:<16} {np.sum(status_code == code)} {parts}" for code in told]


@runtime_checkable
class Timed(Protocol):
    """What a result says of the time that it took, s."""

    @property
    def seconds(self) -> float:
        """All of it."""
        ...

    @property
    def compiling(self) -> float:
        """The part in which programs were made."""
        ...


def wall_time(result: Timed, parts: int, part: str) -> str:
    """Such as "6.17 s: compiling 5.77 s, computing 0.40 s (46.6 µs a point)", for the ``parts`` computed."""
    if np.isnan(result.seconds):
        return "not known"
    computing = result.seconds - result.compiling
    each = computing / max(parts, 1)
    # Points are many and quick: their times are always compared in µs.
    units = ((1e-6, "µs"),) if part == "point" else ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"))
    scale, unit = next((pair for pair in units if each >= pair[0]), units[-1])
    split = f"compiling {result.compiling:.2f} s, computing {computing:.2f} s ({each / scale:.3g} {unit} a {part})"
    return f"{result.seconds:.2f} s: {split}"
