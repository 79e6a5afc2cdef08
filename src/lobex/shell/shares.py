"""``--store``, ``--processes`` and ``--process``: one command's work, shared by several processes."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from lobex import _checks
from lobex.shell.arguments import Storage

# Of one machine.
_MOST_PROCESSES = 256


@dataclass(frozen=True)
class Share:
    """What a verb is told of its store, and whether this process writes the results."""

    arguments: dict[str, Any]
    writes: bool


@contextmanager
def shared(flags: Storage) -> Iterator[Share]:
    """This process' share; with ``--processes``, the others' are computed by processes of their own until the end."""
    if flags.store is None:
        for name in ("processes", "process"):
            if getattr(flags, name) is not None:
                raise ValueError(f"{name} = {getattr(flags, name)} has no use without --store DIR, which is shared")
        yield Share({}, True)
        return
    from lobex.studies.processes import Children, parse_share, share_of

    if flags.processes is None:
        share = parse_share(flags.process) if flags.process is not None else share_of()
        yield Share({"store": flags.store, "processes": share}, share[0] == 0)
        return
    count = _checks.integer("processes", flags.processes, 1, _MOST_PROCESSES)
    if flags.process is not None:
        raise ValueError(f"process = {flags.process!r} is one of those that --processes starts; drop one of the two")
    with Children(["-m", "lobex.shell.main", *_without_processes(sys.argv[1:]), "--quiet"], count):
        yield Share({"store": flags.store, "processes": (0, count)}, True)


def _without_processes(words: list[str]) -> list[str]:
    kept, skip = [], False
    for word in words:
        if skip:
            skip = False
        elif word == "--processes":
            skip = True
        elif not word.startswith("--processes="):
            kept.append(word)
    return kept
