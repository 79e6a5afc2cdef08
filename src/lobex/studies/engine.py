"""Who computes the chunks of a study: this process, any executor, or the workers of a dask cluster."""

import os
import sys
import uuid
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor, wait
from contextlib import suppress
from functools import partial
from multiprocessing.reduction import ForkingPickler
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any

from lobex import _checks
from lobex._devices import cores
from lobex.studies.interruption import Interruption
from lobex.studies.local_processes import Processes

if TYPE_CHECKING:
    from distributed import Client

Call = Callable[[], Any]

# Calls that are handed over before the first is back: some for every worker of a large cluster.
_AHEAD = 1024
# So many times in a row workers may die with nothing done in between.
_DEATHS = 3


class Engine:
    """Calls without arguments, handed to an executor. ``executor=None`` is this process."""

    lost: tuple[type[Exception], ...] = (BrokenExecutor,)
    """What a call ends with whose worker died."""
    gone: tuple[type[Exception], ...] = (CancelledError,)
    """What a call ends with when there is nobody left to hand it over again."""

    def __init__(self, executor: Executor | None) -> None:
        self.executor = executor or _Here()
        # What is computed at once is not handed over ahead.
        self.ahead = 1 if executor is None else _AHEAD
        # Whether it is open that calls can be sent: the first tells of all, which are of a kind.
        self.unproved = isinstance(executor, ProcessPoolExecutor | Processes)
        self.threads = max(cores() // getattr(executor, "_max_workers", 1), 1) if self.unproved else None
        context: Any = getattr(executor, "_mp_context", None)
        if context is not None and context.get_start_method() == "fork":
            raise ValueError(
                f"executor = {self} forks, after which JAX may wait for ever; give it "
                "mp_context=multiprocessing.get_context('spawn')"
            )

    def __str__(self) -> str:
        return type(self.executor).__name__

    def submit(self, name: str, call: Call) -> Any:
        """The call's future."""
        if self.unproved:
            self._prove(call)
        granting = call if self.threads is None else partial(granted, self.threads, os.getpid(), call)
        try:
            return self.executor.submit(granting)
        except RuntimeError as error:
            raise ValueError(
                f"executor = {self} takes no more work ({_line(error)}); run the same with a new one"
            ) from error

    def cancel(self, futures: list[Any], patient: bool) -> None:
        """Take back what has not begun, and wait for what has."""
        begun = [future for future in futures if not future.cancel()]
        if patient:
            wait(begun)

    def _prove(self, call: Call) -> None:
        try:
            ForkingPickler.dumps(call)
        except Exception as error:
            raise ValueError(
                f"executor = {self} cannot send the model to another process ({_line(error)}); define its functions in "
                "a module, or give a dask Client, which sends them"
            ) from error
        self.unproved = False


class _OnCluster(Engine):
    """Calls by the names that dask shows on its dashboard, with as many threads as their worker was started with."""

    def __init__(self, client: "Client") -> None:
        self.client, self.ahead = client, _AHEAD
        distributed = sys.modules["distributed"]
        self.lost = (BrokenExecutor, distributed.KilledWorker)
        self.gone = (CancelledError, distributed.comm.CommClosedError)
        if client.asynchronous:
            raise ValueError("executor is an asynchronous dask Client; give one that is not")

    def __str__(self) -> str:
        return "dask Client"

    def submit(self, name: str, call: Call) -> Any:
        if self.client.status != "running":
            raise ValueError(f"executor = {self} has lost its scheduler; run the same with a new one")
        # A name that was there before, such as that of a call whose workers died, would be the same call.
        key = f"{name}-{uuid.uuid4().hex[:8]}"
        return self.client.submit(partial(granted, None, os.getpid(), call), key=key)

    def cancel(self, futures: list[Any], patient: bool) -> None:
        if futures and self.client.status == "running":
            with suppress(*self.gone):
                self.client.cancel(futures)


class _Here(Executor):
    """Calls are made when they are handed over."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "Future[Any]":
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


def engine_of(executor: Any) -> Engine:
    """The engine for what a user gives as ``executor``."""
    if executor is None or isinstance(executor, Executor):
        return Engine(executor)
    distributed = sys.modules.get("distributed")
    if distributed is not None and isinstance(executor, distributed.Client):
        return _OnCluster(executor)
    raise ValueError(
        f"executor = {_checks.brief(executor)} is none; give a concurrent.futures.Executor or a dask.distributed.Client"
    )


def granted(threads: int | None, client: int, call: Call) -> Any:
    """``call()`` in a worker, where XLA, if it has not begun, and lobex take no more threads than granted: ``threads``,
    or as many as the dask worker has.
    """
    if os.getpid() != client:
        if threads is None:
            threads = sys.modules["distributed"].get_worker().state.nthreads
        os.environ.setdefault("NPROC", str(threads))
    return call()


def ended(
    engine: Engine, label: str, numbers: Iterable[int], call_of: Callable[[int], Call], interruption: Interruption
) -> Iterator[tuple[int, Any]]:
    """Number and result of every ``call_of(number)``, in the order in which they end.

    A call whose worker died is handed over again. After an interruption no more are, and what has begun is waited for.

    Raises:
        ValueError: where workers die again and again, and where the executor went away.
    """
    back: SimpleQueue[int | None] = SimpleQueue()
    interruption.wake = lambda: back.put(None)
    waiting, again = iter(numbers), deque[int]()
    futures: dict[int, Any] = {}
    # A death ends all calls under way: of a call that was in each of them, how many in a row.
    deaths = Counter[int]()
    try:
        while not interruption.asked:
            while len(futures) < engine.ahead and not interruption.asked:
                number = again.popleft() if again else next(waiting, None)
                if number is None:
                    break
                futures[number] = engine.submit(f"{label}-{number}", call_of(number))
                futures[number].add_done_callback(lambda _, number=number: back.put(number))
            if not futures:
                return
            number = back.get()
            if number is None:
                continue
            try:
                result = futures.pop(number).result()
            except engine.lost as error:
                deaths[number] += 1
                if deaths[number] > _DEATHS:
                    raise ValueError(
                        f"executor = {engine} lost its workers {deaths[number]} times in a row, the last time at "
                        f"{label} {number} ({_line(error)}); give them more memory, or fewer at once"
                    ) from error
                again.append(number)
                continue
            except engine.gone as error:
                raise ValueError(
                    f"executor = {engine} gave its work up ({_line(error)}); run the same with a new one"
                ) from error
            deaths.clear()
            yield number, result
    finally:
        engine.cancel(list(futures.values()), not interruption.twice)


def _line(error: BaseException) -> str:
    return " ".join(str(error).split())
