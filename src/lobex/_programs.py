"""Compiled programs are forgotten before they are too many.

JAX keeps all of them, each in some maps of memory of its own. Linux lets a process have 65,530, and at one more XLA
ends it with a segmentation fault: the chart of one cutter of uneven pitch takes two thousand.
"""

from contextlib import suppress
from pathlib import Path

import jax

_MAPS = Path("/proc/self/maps")
_MOST_MAPS = 45_000
# To count the maps takes milliseconds: not more often than after so many programs.
_EVERY = 100


def forget_if_many() -> None:
    """Let JAX forget all programs, those of others included, if this process holds too many."""
    # Elsewhere than on Linux nothing is told, and nothing known of such a limit.
    with suppress(OSError):
        if _MAPS.read_bytes().count(b"\n") > _MOST_MAPS:
            jax.clear_caches()


class Programs:
    """Those made since the maps were last counted."""

    def __init__(self) -> None:
        self._made = 0

    def count(self) -> None:
        """One more was made."""
        self._made += 1

    def spare(self) -> None:
        """As ``forget_if_many``, now and then."""
        if self._made < _EVERY:
            return
        self._made = 0
        forget_if_many()
