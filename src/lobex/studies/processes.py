"""Which share of a study is this process', and a study in several processes of this machine.

Chunks need nothing of each other: processes share a folder and never speak.
"""

import os
import signal
import subprocess
import sys
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

from lobex import _checks

# What launchers tell their processes: number of the process, number of processes.
_LAUNCHERS = (
    ("SLURM_PROCID", "SLURM_NTASKS"),
    ("OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"),
    ("PMI_RANK", "PMI_SIZE"),
)
_DEVICES = "CUDA_VISIBLE_DEVICES"


def share_of(processes: Any = None, environment: Mapping[str, str] = os.environ) -> tuple[int, int]:
    """This process' number, from 0, and how many there are: as given, else as Slurm or MPI tell, else (0, 1)."""
    if processes is not None:
        if not isinstance(processes, Sequence) or isinstance(processes, str) or len(processes) != 2:
            raise ValueError(f"processes = {processes!r} must be two whole numbers, such as (0, 2) for the first of 2")
        count = _checks.integer("processes[1]", processes[1], 1)
        number = _checks.integer("processes[0]", processes[0], 0)
        if number >= count:
            raise ValueError(f"processes = ({number}, {count}): give a number from 0 to {count - 1}")
        return number, count
    for rank, size in _LAUNCHERS:
        try:
            number, count = int(environment[rank]), int(environment[size])
        except (KeyError, ValueError):
            continue
        if 0 <= number < count:
            return number, count
    return 0, 1


def parse_share(text: str) -> tuple[int, int]:
    """Read ``number/count``, as in 0/2."""
    try:
        number, count = (int(part) for part in text.split("/"))
    except ValueError:
        raise ValueError(f"process = {text!r} is not number/count; give such as 0/2 for the first of two") from None
    return share_of((number, count))


class Children:
    """Processes 1 to n − 1 of n beside this one, which is process 0: ``python command --process k/n``.

    Each, this one too, has a GPU of its own if there are several. They are waited for; what one that dies leaves
    undone, the others do. When this one fails or is interrupted, the others end with their chunks.
    """

    def __init__(self, command: Sequence[str], count: int) -> None:
        self.command, self.count = command, count
        self.running: list[subprocess.Popen[bytes]] = []

    def __enter__(self) -> "Children":
        devices = [name for name in os.environ.get(_DEVICES, "").split(",") if name] or _graphics_cards()
        for k in range(1, self.count):
            own = {_DEVICES: devices[k % len(devices)]} if len(devices) > 1 else {}
            arguments = [sys.executable, *self.command, "--process", f"{k}/{self.count}"]
            # A terminal's Ctrl-C is this process' alone, which ends them when its own chunk is done.
            self.running.append(subprocess.Popen(arguments, env={**os.environ, **own}, process_group=0))
        if len(devices) > 1:
            os.environ[_DEVICES] = devices[0]
        return self

    def __exit__(self, failure: type[BaseException] | None, *_: object) -> None:
        if failure is not None:
            for child in self.running:
                child.send_signal(signal.SIGINT)
        codes = [child.wait() for child in self.running]
        for k, code in enumerate(codes, 1):
            if code and failure is None:
                warnings.warn(
                    f"process {k} of {self.count} ended with exit code {code}; the others did its share",
                    RuntimeWarning,
                    stacklevel=2,
                )


def _graphics_cards() -> list[str]:
    """Numbers of the GPUs that NVIDIA's driver shows, without starting any."""
    try:
        return [str(i) for i, _ in enumerate(os.listdir("/proc/driver/nvidia/gpus"))]
    except OSError:
        return []
