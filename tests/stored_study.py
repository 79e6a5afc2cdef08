"""The study that test_study_processes.py and test_cluster.py kill, interrupt and share, for processes of their own."""

import contextlib
import os
import sys
import time
from pathlib import Path

import numpy as np

import lobex
from lobex.studies.local_processes import Processes
from lobex.studies.run import _Work
from lobex.studies.store import Store

COUNT = 20


def study(folder, executor=None, progress=False):
    """The study, to a folder."""
    return lobex.sweep(
        lobex.Rub(lobex.Rod(1).modes(0.03)),
        np.linspace(300, 700, 4),
        np.linspace(1e5, 4e6, 3),
        over={"modes.damping_ratio": np.linspace(0.01, 0.1, COUNT)},
        store=folder,
        executor=executor,
        progress=progress,
    )


def names(folder):
    """The files of a store; the names of chunks carry checksums, so that the same names are the same bits."""
    return sorted(path.name for path in folder.glob("[!.]*")) if folder.exists() else []


def results(folder):
    """The numbers of every chunk that is there, and all that is said of them."""
    store = Store.open(folder)
    names = store.present()
    return {number: store.read(number, names) for number in sorted(names)}


@contextlib.contextmanager
def before_each_chunk(call):
    """Within, ``call(number)`` is made before a chunk is handed over."""
    original = _Work._chunk

    def chunk(self, number):
        call(number)
        return original(self, number)

    _Work._chunk = chunk
    try:
        yield
    finally:
        _Work._chunk = original


def work(folder: str, processes: int, gate: str, told: str | None = None) -> None:
    """The study, by so many processes or by this one; what it says goes to the file ``told``.

    Chunks are begun up to the number in the file ``gate``: what a test then kills or interrupts is still at work,
    however busy the machine is.
    """
    if told is not None:
        os.dup2(os.open(told, os.O_WRONLY), 2)

    def wait(number: int) -> None:
        while number >= int(Path(gate).read_text()):
            time.sleep(0.005)

    pool = Processes(processes) if processes else contextlib.nullcontext()
    with before_each_chunk(wait), pool as executor:
        study(folder, executor, progress=True)


if __name__ == "__main__":
    work(sys.argv[1], int(sys.argv[2]), sys.argv[3])
