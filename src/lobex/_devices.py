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


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def workers() -> int:
    """Parts that are worth having at once: one for each core that this process may use, and each local device."""
    return max(cores(), len(jax.local_devices()))


def threads() -> int:
    """Threads that take parts: for all of them at once, or for as many cores as ``NPROC`` grants, which XLA reads too.

    What the parts are does not depend on it: a worker of one core computes the same bits as one of many.
    """
    granted = os.environ.get("NPROC", "")
    return max(int(granted), len(jax.local_devices())) if granted.isdecimal() and int(granted) else workers()
