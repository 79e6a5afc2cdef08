"""What lies above a folder, by name: results draw themselves, and drawing knows results.

Every import between folders goes down, from a verb to what it is made of (tests/test_floors.py); the few ways up are
these names, looked up when they are called.
"""

from importlib import import_module
from typing import Any


def by_name(name: str) -> Any:
    """What ``name``, such as "plots.chart_picture.plot_chart", stands for."""
    module, _, attribute = name.rpartition(".")
    return getattr(import_module(f"lobex.{module}"), attribute)
