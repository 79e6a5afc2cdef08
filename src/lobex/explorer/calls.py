"""A model as calls of lobex: made by them, and written as the Python that makes the same."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

_INDENT, _WIDE = "    ", 112
# What a model is made of; nothing else is called, whatever a file or a link says.
_ALLOWED = (
    "Blading",
    "Cutter.end_mill",
    "CuttingForce",
    "Milling",
    "Modes.from_table",
    "ProcessDamping",
    "Rod",
    "Rub",
    "SpeedVariation",
    "Turning",
)


@dataclass(frozen=True)
class Given:
    """A number, or a list of them, that the model is a function of, by its name."""

    name: str


@dataclass(frozen=True)
class Call:
    """A call of lobex with arguments by name: other calls, given numbers, and constants.

    Attributes:
        function: its name below ``lobex``, such as "Modes.from_table"; with ``of`` that of a method.
        arguments: name and value of each.
        of: the call that makes what the method is one of, where it is one.
    """

    function: str
    arguments: tuple[tuple[str, Any], ...]
    of: "Call | None" = None

    def __call__(self, numbers: Mapping[str, Any]) -> Any:
        """What it makes of the given numbers, which JAX may trace."""
        import lobex

        arguments = {name: _value(value, numbers) for name, value in self.arguments}
        if self.of is not None:
            return getattr(self.of(numbers), self.function)(**arguments)
        if self.function not in _ALLOWED:
            raise ValueError(f"function = {self.function!r} makes no model; give one of {', '.join(_ALLOWED)}")
        made: Any = lobex
        for part in self.function.split("."):
            made = getattr(made, part)
        return made(**arguments)

    def written(self, depth: int = 0) -> str:
        """The same in Python, for a function of ``numbers``."""
        head = f"lobex.{self.function}" if self.of is None else f"{self.of.written(depth)}.{self.function}"
        parts = [f"{name}={_written(value, depth + 1)}" for name, value in self.arguments]
        line = f"{head}({', '.join(parts)})"
        if "\n" not in line and len(line) + len(_INDENT) * depth < _WIDE:
            return line
        inner = "".join(f"{_INDENT * (depth + 1)}{part},\n" for part in parts)
        return f"{head}(\n{inner}{_INDENT * depth})"


def call(function: str, **arguments: Any) -> Call:
    """A ``Call`` without the arguments that are None."""
    return Call(function, tuple((name, value) for name, value in arguments.items() if value is not None))


def _value(value: Any, numbers: Mapping[str, Any]) -> Any:
    if isinstance(value, Given):
        return numbers[value.name]
    return value(numbers) if isinstance(value, Call) else value


def _written(value: Any, depth: int) -> str:
    if isinstance(value, Given):
        return f'numbers["{value.name}"]'
    return value.written(depth) if isinstance(value, Call) else in_python(value)


def in_python(value: Any) -> str:
    """A constant as Python, numbers to the last bit."""
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(in_python, value))}]"
    return repr(value)
