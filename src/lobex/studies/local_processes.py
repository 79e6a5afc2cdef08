"""Processes of this machine. Nothing here imports JAX: what is set for them is set before it starts."""

import multiprocessing
import os
import re
import signal
import sys
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
        self._pool: ProcessPoolExecutor | None = None

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "Future[Any]":
        """Hand over a call."""
        self._pool = self._pool or self._started()
        try:
            return self._pool.submit(fn, *args, **kwargs)
        except BrokenExecutor:
            self._pool.shutdown()
            self._pool = self._started()
            return self._pool.submit(fn, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes."""
        if self._pool is not None:
            self._pool.shutdown(wait, cancel_futures=cancel_futures)

    def __exit__(self, failure: type[BaseException] | None, *_: object) -> None:
        if failure is not None and self._pool is not None:
            for process in list((self._pool._processes or {}).values()):
                process.terminate()
        self.shutdown()

    def _started(self) -> ProcessPoolExecutor:
        devices = [name for name in os.environ.get(_DEVICES, "").split(",") if name] or _graphics_cards()
        spawn = multiprocessing.get_context("spawn")
        return ProcessPoolExecutor(self._max_workers, spawn, _prepare, (devices, _compiled()))


def _prepare(devices: list[str], settings: dict[str, str]) -> None:
    """Of a process, before its first call."""
    os.environ.update(settings)
    # JAX has a thread per core already.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Several may share a GPU: none takes its memory for itself.
    os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")
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


def _compiled() -> dict[str, str]:
    """Where this process keeps compiled programs, as the environment says it."""
    if "jax" not in sys.modules:
        return {}
    config = sys.modules["jax"].config
    if not config.jax_compilation_cache_dir:
        return {}
    return {
        "JAX_COMPILATION_CACHE_DIR": str(config.jax_compilation_cache_dir),
        "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": str(config.jax_persistent_cache_min_compile_time_secs),
    }


def _graphics_cards() -> list[str]:
    """Numbers of the GPUs that NVIDIA's driver shows, without starting any."""
    try:
        return [str(i) for i, _ in enumerate(os.listdir("/proc/driver/nvidia/gpus"))]
    except OSError:
        return []
