"""``--store``, ``--processes``: where a command's work goes to, and who does it."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from lobex import _checks
from lobex.shell.arguments import Storage

# Of one machine.
_MOST_PROCESSES = 256


@contextmanager
def stored(flags: Storage) -> Iterator[dict[str, Any]]:
    """What a verb is told of its store and of who computes its chunks, who are there until the end."""
    if flags.store is None:
        if flags.processes is not None:
            raise ValueError(f"processes = {flags.processes} has no use without --store DIR, which is shared")
        yield {}
        return
    count = 1 if flags.processes is None else _checks.integer("processes", flags.processes, 1, _MOST_PROCESSES)
    if count == 1:
        yield {"store": flags.store}
        return
    from lobex.studies.local_processes import Processes

    # This process computes little: the GPU's memory is for the others.
    os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")
    with Processes(count) as executor:
        yield {"store": flags.store, "executor": executor}
