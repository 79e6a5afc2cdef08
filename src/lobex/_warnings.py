"""What lobex warns of, and where the warnings point."""

import sys
import warnings


class LobexWarning(UserWarning):
    """Whatever lobex warns of; by itself, input that is accepted but can hardly be meant, such as rpm for Hz."""


class SweepWarning(LobexWarning):
    """Points of a sweep that failed and are NaN, or that are coarsely resolved."""


def warn(message: str, category: type[Warning] = LobexWarning) -> None:
    """Warn of the line that called lobex, from however deep within lobex."""
    level, frame = 2, sys._getframe(1)
    # By the module's name and not its file: a dataclass' constructor has no file of its own.
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "lobex":
        level, frame = level + 1, frame.f_back
    warnings.warn(message, category, stacklevel=level)
