"""The study that test_study_processes.py kills, interrupts and shares, for processes of their own."""

import os
import sys
import time
from pathlib import Path

import numpy as np

import lobex
from lobex.studies.store import Store

COUNT = 20


def work(folder: str, share: str, gate: str, told: str | None = None) -> None:
    """The share of ``folder``, "0/2", say; what it says goes to the file ``told``.

    Chunks are written as far as the number in the file ``gate`` allows: what a test then kills or interrupts is still
    at work, however busy the machine is.
    """
    if told is not None:
        os.dup2(os.open(told, os.O_WRONLY), 2)
    write = Store.write

    def write_if_allowed(store: Store, number: int, dataset: object) -> object:
        while len(store.present()) >= int(Path(gate).read_text()):
            time.sleep(0.005)
        return write(store, number, dataset)

    Store.write = write_if_allowed
    lobex.sweep(
        lobex.Rub(lobex.Rod(1).modes(0.03)),
        np.linspace(300, 700, 4),
        np.linspace(1e5, 4e6, 3),
        over={"modes.damping_ratio": np.linspace(0.01, 0.1, COUNT)},
        store=folder,
        processes=tuple(map(int, share.split("/"))),
        progress=True,
    )


if __name__ == "__main__":
    work(*sys.argv[1:])
