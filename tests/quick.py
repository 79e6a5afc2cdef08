"""How XLA compiles for tests: a program is called a few times, and takes longer to optimise than to run."""

import mmap
from importlib.util import find_spec
from pathlib import Path

# LLVM as it comes, loops written by the older of XLA's two generators, whose code is shorter, and each program in one
# part, as every core has a worker: a sixth of the time that the defaults take. What is computed is the same, to
# rounding.
_QUICK = {
    "xla_backend_optimization_level": "0",
    "xla_cpu_use_fusion_emitters": "false",
    "xla_cpu_parallel_codegen_split_count": "1",
}


def flags() -> str:
    """``XLA_FLAGS`` for programs that are compiled quickly; a flag that this jaxlib does not know would end JAX."""
    return " ".join(f"--{name}={value}" for name, value in _QUICK.items() if _known(name))


def _known(name: str) -> bool:
    """Whether jaxlib's library has the name of the flag in it."""
    spec = find_spec("jaxlib")
    folder = Path(spec.origin).parent if spec and spec.origin else Path()
    for library in folder.glob("libjax_common.*"):
        with library.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
            if content.find(name.encode()) >= 0:
                return True
    return False
