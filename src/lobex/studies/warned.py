"""What the chunks of a study warn of, said once."""

import re
import threading
import warnings
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from contextvars import ContextVar
from functools import partial
from typing import Any

from lobex._warnings import LobexWarning

Warned = tuple[type[Warning], str]

_NUMBER = re.compile(r"[-+]?\d[\d.]*(?:e[-+]?\d+)?(?:, …)?")

_told: ContextVar[list[Warned] | None] = ContextVar("told", default=None)
_lock = threading.Lock()
_scope = ExitStack()
_listening = 0


@contextmanager
def heard() -> Iterator[list[Warned]]:
    """Hold back what is warned of within, in this thread and in those that work for it.

    Python's own ``catch_warnings`` is of the whole process: the first of several threads enters it, the last leaves.
    """
    global _listening
    told: list[Warned] = []
    token = _told.set(told)
    with _lock:
        _listening += 1
        if _listening == 1:
            _scope.enter_context(warnings.catch_warnings())
            warnings.simplefilter("always", LobexWarning)
            warnings.showwarning = partial(_note, warnings.showwarning)
    try:
        yield told
    finally:
        _told.reset(token)
        with _lock:
            _listening -= 1
            if not _listening:
                _scope.close()


def _note(show: Any, message: Warning | str, category: type[Warning], *others: Any, **named: Any) -> None:
    told = _told.get()
    if told is None:
        show(message, category, *others, **named)
    else:
        told.append((category, str(message)))


class Collected:
    """Warnings that differ in their numbers alone count as one."""

    def __init__(self) -> None:
        self.first: dict[Warned, str] = {}
        self.count: dict[Warned, int] = {}

    def add(self, warned: Iterable[Warned]) -> None:
        """Of a chunk."""
        for category, text in warned:
            kind = category, _NUMBER.sub("#", text)
            self.first.setdefault(kind, text)
            self.count[kind] = self.count.get(kind, 0) + 1

    def say(self, chunks: int, stacklevel: int) -> None:
        """Warn now, of each kind once, with its first text."""
        for (category, kind), text in self.first.items():
            count = self.count[category, kind]
            more = f" (the first of {count} such warnings in {chunks} chunks)" if count > 1 else ""
            warnings.warn(text + more, category, stacklevel=stacklevel + 1)
