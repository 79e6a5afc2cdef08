"""``--store``, ``--processes`` and ``--dask``: where a command's work goes to, and who does it."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from lobex import _checks
from lobex._optional import needed
from lobex.shell.arguments import Storage

# Of one machine.
_MOST_PROCESSES = 256


@contextmanager
def stored(flags: Storage) -> Iterator[dict[str, Any]]:
    """What a verb is told of its store and of who computes its chunks, who are there until the end."""
    if flags.store is None:
        for name in ("processes", "dask"):
            if getattr(flags, name) is not None:
                raise ValueError(f"{name} = {getattr(flags, name)} has no use without --store DIR, which is shared")
        yield {}
        return
    if flags.dask is not None:
        if flags.processes is not None:
            raise ValueError(f"dask = {flags.dask!r} has processes of its own; drop one of --processes and --dask")
        with _client(flags.dask) as executor:
            yield {"store": flags.store, "executor": executor}
        return
    count = 1 if flags.processes is None else _checks.integer("processes", flags.processes, 1, _MOST_PROCESSES)
    if count == 1:
        yield {"store": flags.store}
        return
    from lobex.studies.local_processes import Processes

    # Several may share a GPU, and this one computes little: none takes its memory for itself.
    os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")
    with Processes(count) as executor:
        yield {"store": flags.store, "executor": executor}


def written(study: Any, path: Path, shown: bool) -> None:
    """Write a study over further axes, and say what it is."""
    study.save(path)
    if shown:
        print(f"{study!r}\n  written          {path}")


def _client(address: str) -> Any:
    """A client of the scheduler at an address."""
    distributed = needed("distributed", f"dask = {address!r}", "cluster")
    try:
        # For nothing but the chunks: what xarray writes stays here.
        return distributed.Client(address, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ValueError(f"dask = {address!r} has no scheduler ({error}); give such as tcp://node:8786") from None
