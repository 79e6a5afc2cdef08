"""Processes of a structure that follows the speed, where the speeds are known: its modes are found once for each."""

from typing import Any, TypeVar

import jax
import numpy as np

from lobex import _checks
from lobex._shapes import ArrayLike, Number

Process = TypeVar("Process")


def follows_speed(node: Any) -> bool:
    """Whether it is a structure that has other modes at another speed."""
    return hasattr(node, "check_speed")


def has_followers(process: Any) -> bool:
    """Whether there is one in a process."""
    return any(map(follows_speed, jax.tree.leaves(process, is_leaf=follows_speed)))


def at_speed(process: Process, speed: Number) -> Process:
    """The process with the modes that its structure has at one speed, Hz: what it knows better itself, or else those of
    all that it is made of.
    """
    own = getattr(process, "at_speed", None)
    return own(speed) if own is not None else _replaced(process, lambda node: node.at(speed))


def tabled(process: Process, speed: ArrayLike) -> Process:
    """The process with a table of modes at the given speeds, of any shape, where each would be an eigenproblem."""
    if _checks.is_traced((process, speed)) or not np.size(speed):
        return process
    speeds = np.unique(np.asarray(speed, dtype=float))
    return _replaced(process, lambda node: node.over(speeds) if hasattr(node, "over") else node)


def _replaced(process: Any, change: Any) -> Any:
    return jax.tree.map(lambda node: change(node) if follows_speed(node) else node, process, is_leaf=follows_speed)
