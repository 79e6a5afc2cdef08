"""The figures by name. Their modules import neither JAX nor Matplotlib before they compute or draw."""

import difflib
from collections.abc import Sequence
from importlib import import_module

from lobex.gallery.reproduction import Reproduction

_NUMBERS = (
    *("1.2", "1.3", "1.4", "2.5", "2.6", "3.1", "3.2"),
    *("4.1", "4.2", "4.3", "4.4", "4.5", "4.6", "4.7", "4.8", "4.9", "4.10", "4.11", "4.12", "4.13"),
)
NAMES = tuple(f"fig-{number}" for number in _NUMBERS)


def figure(name: str) -> Reproduction:
    """The figure of that name, such as "fig-4.3". Raises ValueError for an unknown one, with the nearest."""
    if name not in NAMES:
        near = difflib.get_close_matches(name, NAMES, n=1, cutoff=0.4)
        hint = f"did you mean {near[0]}? " if near else ""
        raise ValueError(f"name = {name!r} is no figure of the gallery; {hint}lobex reproduce --list tells them all")
    module = import_module(f"lobex.gallery.{name.replace('-', '_').replace('.', '_')}")
    return module.FIGURE


def figures(names: Sequence[str] = ()) -> list[Reproduction]:
    """The figures of those names, each once and in the given order; all of them if none is named."""
    return [figure(name) for name in dict.fromkeys(names or NAMES)]
