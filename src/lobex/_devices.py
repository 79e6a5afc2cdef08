"""Work on every local device: worker threads take them in turn."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

import jax


@contextmanager
def on_device(number: int) -> Iterator[None]:
    """Float64, which belongs to a thread as the device does, on the local device whose turn part ``number`` is.

    Where there is one device, such as the CPU with all its cores, nothing is chosen.
    """
    devices = jax.local_devices()
    with jax.enable_x64(True):
        if len(devices) == 1:
            yield
            return
        with jax.default_device(devices[number % len(devices)]):
            yield


def workers() -> int:
    """Threads that take parts: one for each core that this process may use, and each local device."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(cores, len(jax.local_devices()))
