"""Processes of this machine. Nothing here imports JAX: what is set for them is set before it starts."""

import multiprocessing
import os
import re
import signal
import threading
import warnings
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from typing import Any

_DEVICES = "CUDA_VISIBLE_DEVICES"


class Processes(Executor):
    """So many processes of this machine, started afresh and not forked, after which JAX may wait for ever.

    Where one dies, which ends the others too, the next call starts new ones. Each has a GPU of its own where there
    are several. They end with this process, however that ends, and Ctrl-C is this process' alone.
    """

    def __init__(self, count: int) -> None:
        self._max_workers = count
        self._pool = self._afresh()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "Future[Any]":
        """Hand over a call."""
        try:
            return self._pool.submit(fn, *args, **kwargs)
        except BrokenExecutor:
            self._pool.shutdown()
            self._pool = self._afresh()
            return self._pool.submit(fn, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes."""
        self._pool.shutdown(wait, cancel_futures=cancel_futures)

    def __exit__(self, failure: type[BaseException] | None, *_: object) -> None:
        if failure is not None:
            for process in list((self._pool._processes or {}).values()):
                process.terminate()
        self.shutdown()

    def _afresh(self) -> ProcessPoolExecutor:
        devices = [name for name in os.environ.get(_DEVICES, "").split(",") if name] or _graphics_cards()
        spawn = multiprocessing.get_context("spawn")
        return ProcessPoolExecutor(self._max_workers, spawn, _prepare, (devices,))


def _prepare(devices: list[str]) -> None:
    """Of a process, before its first call; its environment is that of the one that starts it."""
    if len(devices) > 1:
        # Such as "SpawnProcess-3", or "SpawnProcess-1:3" of a process that was started itself.
        number = int(re.split("[-:]", multiprocessing.current_process().name)[-1])
        os.environ[_DEVICES] = devices[number % len(devices)]
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # Another process may be writing what this one reads: JAX then compiles it.
    warnings.filterwarnings("ignore", message="Error (reading|writing) persistent compilation cache entry")
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _graphics_cards() -> list[str]:
    """Numbers of the GPUs that NVIDIA's driver shows, without starting any."""
    try:
        return [str(i) for i, _ in enumerate(os.listdir("/proc/driver/nvidia/gpus"))]
    except OSError:
        return []
