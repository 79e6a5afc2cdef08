"""Packages that not everybody installs: imported where they are used, and asked for by the name of their extra."""

from importlib import import_module
from typing import Any


def needed(package: str, what: str, extra: str) -> Any:
    """The package that ``what`` takes, or a line that says how to install it.

    Raises:
        ValueError: where it is not installed.
    """
    try:
        return import_module(package)
    except ImportError:
        raise ValueError(
            f"{what} takes the package {package}, which is not installed; run pip install 'lobex[{extra}]'"
        ) from None
