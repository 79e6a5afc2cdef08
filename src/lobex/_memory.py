"""How much memory this process may still take, and what would take more."""

import os
from contextlib import suppress
from pathlib import Path

_GROUPS, _PROC = Path("/sys/fs/cgroup"), Path("/proc")


def available_memory() -> int:
    """Bytes: what the machine has left and, in a container or a batch job, what its limit leaves."""
    left = [_left_of_machine(), *_left_of_groups()]
    return max(min(left), 1)


def check_memory(what: str, needed: float, remedy: str) -> None:
    """Refuse what needs more bytes than are left, before any computing; ``what`` begins with the argument's name."""
    left = available_memory()
    if needed > left:
        raise ValueError(f"{what}: they would need {_in_bytes(needed)} and {_in_bytes(left)} are free; {remedy}")


def _in_bytes(number: float) -> str:
    unit = "GB" if number < 1e12 else "TB"
    return f"{number / (1e9 if unit == 'GB' else 1e12):.3g} {unit}"


def _left_of_machine() -> int:
    with suppress(OSError):
        for line in (_PROC / "meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    # Elsewhere than on Linux the pages in use are not told: half of all of them.
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2


def _left_of_groups() -> list[int]:
    """What the limits of the process' control group, version 2 or 1, and of those above it leave."""
    try:
        own = [line.split(":", 2) for line in (_PROC / "self/cgroup").read_text().splitlines()]
    except OSError:
        return []
    left = []
    for _, controllers, path in own:
        if controllers == "":
            base, limit, used = _GROUPS, "memory.max", "memory.current"
        elif "memory" in controllers.split(","):
            base, limit, used = _GROUPS / "memory", "memory.limit_in_bytes", "memory.usage_in_bytes"
        else:
            continue
        folder = base / path.lstrip("/")
        for group in (folder, *folder.parents):
            # No such group here, or "max": no limit.
            with suppress(OSError, ValueError):
                left.append(int((group / limit).read_text()) - int((group / used).read_text()))
            if group == base:
                break
    return left
