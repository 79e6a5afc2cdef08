"""Ctrl-C between chunks."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


class Interruption:
    """Whether an interruption was asked for, ``asked``, and once more, ``twice``.

    Attributes:
        wake: called at the first, for whoever waits.
    """

    def __init__(self) -> None:
        self.asked = self.twice = False
        self.wake: Callable[[], object] = bool

    def __call__(self, number: int, frame: Any) -> None:
        """The signal's handler: the second time at once."""
        if self.asked:
            self.twice = True
            raise KeyboardInterrupt
        self.asked = True
        self.wake()


@contextmanager
def postponed() -> Iterator[Interruption]:
    """Within, the first Ctrl-C is only noted: what is being computed is finished and kept. The second ends it."""
    interruption = Interruption()
    if threading.current_thread() is not threading.main_thread():
        # Signals are the main thread's.
        yield interruption
        return
    before = signal.signal(signal.SIGINT, interruption)
    try:
        yield interruption
    finally:
        signal.signal(signal.SIGINT, before)
