"""How XLA compiles for tests: a program is called a few times, and takes longer to optimise than to run."""

import mmap
from importlib.util import find_spec
from pathlib import Path

from lobex._compiled import QUICK


def flags() -> str:
    """``XLA_FLAGS`` for programs that are compiled quickly; a flag that this jaxlib does not know would end JAX."""
    return " ".join(f"--{name}={str(value).lower()}" for name, value in QUICK.items() if _known(name))


def _known(name: str) -> bool:
    """Whether jaxlib's library has the name of the flag in it."""
    spec = find_spec("jaxlib")
    folder = Path(spec.origin).parent if spec and spec.origin else Path()
    for library in folder.glob("libjax_common.*"):
        with library.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
            if content.find(name.encode()) >= 0:
                return True
    return False
