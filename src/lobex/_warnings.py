"""What lobex warns of, where the warnings point, and holding them back."""

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

Warned = tuple[type[Warning], str]

_heard: ContextVar[list[Warned] | None] = ContextVar("heard", default=None)


class LobexWarning(UserWarning):
    """Whatever lobex warns of; by itself, input that is accepted but can hardly be meant, such as rpm for Hz."""


class SweepWarning(LobexWarning):
    """Points of a sweep that failed and are NaN, or that are coarsely resolved."""


def warn(message: str, category: type[Warning] = LobexWarning) -> None:
    """Warn of the line that called lobex, from however deep within lobex."""
    told = _heard.get()
    if told is not None:
        told.append((category, message))
        return
    level, frame = 2, sys._getframe(1)
    # By the module's name and not its file: a dataclass' constructor has no file of its own.
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "lobex":
        level, frame = level + 1, frame.f_back
    warnings.warn(message, category, stacklevel=level)


@contextmanager
def heard() -> Iterator[list[Warned]]:
    """Hold back what lobex warns of within, in this thread and in calls that are ``carried`` to others.

    Python's own ``catch_warnings`` is of the whole process: the first of several threads enters it, the last leaves.
    """
    told: list[Warned] = []
    token = _heard.set(told)
    try:
        yield told
    finally:
        _heard.reset(token)
