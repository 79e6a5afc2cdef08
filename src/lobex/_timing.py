"""How long a verb takes, and how much of that JAX spends on making programs: tracing, lowering and compiling."""

import functools
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar, copy_context
from typing import Any

import jax

from lobex._programs import Programs

_MAKING = (
    "/jax/core/compile/jaxpr_trace_duration",
    "/jax/core/compile/jaxpr_to_mlir_module_duration",
    "/jax/core/compile/backend_compile_duration",
)


class Stopwatch:
    """What a verb has spent so far.

    Several threads may compile side by side, and one program may be traced within another: what counts is the time
    in which any of that goes on.
    """

    def __init__(self) -> None:
        self._begun = time.perf_counter()
        self._spans: list[tuple[float, float]] = []

    @property
    def seconds(self) -> float:
        """Wall time, s."""
        return time.perf_counter() - self._begun

    @property
    def compiling(self) -> float:
        """The part of it in which programs were made, s."""
        total, reached = 0.0, self._begun
        for begin, end in sorted(self._spans):
            total += max(end - max(begin, reached), 0.0)
            reached = max(reached, end)
        return total

    def add(self, begin: float, end: float) -> None:
        """A program was made between two times."""
        self._spans.append((begin, end))


_running: ContextVar[tuple[Stopwatch, ...]] = ContextVar("running", default=())
_lock = threading.Lock()
_programs = Programs()


@contextmanager
def timed() -> Iterator[Stopwatch]:
    """A stopwatch for what is done within, in this thread and in calls that are ``carried`` to others."""
    spare_programs()
    watch = Stopwatch()
    token = _running.set((*_running.get(), watch))
    try:
        yield watch
    finally:
        _running.reset(token)


def spare_programs() -> None:
    """To be called where a verb begins: too many programs are forgotten."""
    with _lock:
        _listen()
        if not _running.get():
            _programs.spare()


def carried(function: Callable[..., Any]) -> Callable[..., Any]:
    """``function`` for the threads of a pool: what they compile counts for the verb that they work for."""
    context = copy_context()

    @functools.wraps(function)
    def call(*arguments: Any) -> Any:
        return context.copy().run(function, *arguments)

    return call


@functools.cache
def _listen() -> None:
    """Once in a process: JAX has no way to take a listener off again."""
    jax.monitoring.register_event_duration_secs_listener(_note)


def _note(event: str, duration_secs: float, **_: Any) -> None:
    if event == _MAKING[-1]:
        _programs.count()
    if event in _MAKING:
        end = time.perf_counter()
        for watch in _running.get():
            watch.add(end - duration_secs, end)
