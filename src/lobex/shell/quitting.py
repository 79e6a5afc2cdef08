"""Ctrl-C before there is anything to lose."""

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NoReturn


@contextmanager
def ended_at_once() -> Iterator[None]:
    """Ctrl-C ends the process here and now: there is nothing to tidy, and an import cut short may not say so."""
    before: Any = signal.getsignal(signal.SIGINT)
    if before is not signal.default_int_handler or threading.current_thread() is not threading.main_thread():
        # Ctrl-C is another's: of a process in the background, or of whoever calls from a thread.
        yield
        return
    signal.signal(signal.SIGINT, _end)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _end(*_: Any) -> NoReturn:
    os.write(2, b"lobex: interrupted; nothing was written\n")
    os._exit(130)
