"""A thread that does, of each kind, the newest that was asked for."""

import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

Job = Callable[[], Iterator[None]]


class Worker:
    """Jobs by kind, one after the other; a job yields where it may end because a newer one of its kind is there.

    The page's own thread never waits for it, so that a slider is never held up.

    Args:
        kinds: in the order in which they are done.
        failed: told, in the worker's thread, of what a job raises.
        busy: told of whether there is anything to do.
    """

    def __init__(
        self, kinds: tuple[str, ...], failed: Callable[[Exception], None], busy: Callable[[bool], None]
    ) -> None:
        self._kinds, self._failed, self._busy = kinds, failed, busy
        self._waiting: dict[str, tuple[float, Job]] = {}
        self._changed = threading.Condition()
        self._working = self._closed = False
        self._thread: threading.Thread | None = None

    def ask(self, kind: str, job: Job, after: float = 0.0) -> None:
        """Do this once what is being done ends and so many seconds have passed, in place of what waits of its kind."""
        with self._changed:
            if self._closed:
                return
            self._waiting[kind] = time.monotonic() + after, job
            self._changed.notify_all()
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="lobex explorer", daemon=True)
                self._thread.start()

    def forget(self, kind: str) -> None:
        """Do not do what waits of a kind."""
        with self._changed:
            self._waiting.pop(kind, None)

    def settle(self, timeout: float = 600.0) -> bool:
        """Wait until there is nothing to do; whether that is so."""
        with self._changed:
            return self._changed.wait_for(lambda: not self._waiting and not self._working, timeout)

    def close(self) -> None:
        """End once what is being done may end."""
        with self._changed:
            self._closed = True
            self._waiting.clear()
            self._changed.notify_all()

    def _run(self) -> None:
        while (found := self._next()) is not None:
            kind, job = found
            steps: Any = job()
            try:
                for _ in steps:
                    if self._superseded(kind):
                        steps.close()
                        break
            except Exception as error:  # Whatever goes wrong with one screen, the next one is drawn.
                self._failed(error)

    def _next(self) -> tuple[str, Job] | None:
        with self._changed:
            self._working = False
            while not self._closed:
                due = {kind: when - time.monotonic() for kind, (when, _) in self._waiting.items()}
                kind = next((kind for kind in self._kinds if due.get(kind, 1.0) <= 0), None)
                if kind is not None:
                    self._working = True
                    self._busy(True)
                    return kind, self._waiting.pop(kind)[1]
                if not due:
                    self._busy(False)
                    self._changed.notify_all()
                self._changed.wait(min(due.values(), default=None))
            return None

    def _superseded(self, kind: str) -> bool:
        """Whether a job is to end: what comes before it, or a newer one of its kind, is there."""
        before = self._kinds[: self._kinds.index(kind) + 1]
        with self._changed:
            return self._closed or any(other in self._waiting for other in before)
