"""What a result says of the model that it came from: plain text and numbers, in JSON."""

import dataclasses
from typing import Any

import numpy as np


def describe(value: Any) -> Any:
    """A frozen dataclass of numbers as nested dictionaries, lists and numbers."""
    if dataclasses.is_dataclass(value):
        fields = {f.name: describe(getattr(value, f.name)) for f in dataclasses.fields(value)}
        return {"type": type(value).__name__, **fields}
    if isinstance(value, str | bool | int | float | None):
        return value
    if isinstance(value, tuple | list):
        return [describe(v) for v in value]
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
