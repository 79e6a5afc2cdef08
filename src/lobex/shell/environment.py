"""Settings of the shell's own process: a library call never makes them."""

import hashlib
import os
import platform
import warnings
from importlib.metadata import version
from pathlib import Path

from lobex.shell.quitting import ended_at_once

# XLA of these versions prints an error for every program that it finds in its cache: two words for how LLVM tunes
# code count there as missing features of the processor. Its errors that matter are exceptions, too.
_NOISY = (0, 10)
_NO_ERRORS = "3"
_PROCESSORS = Path("/proc/cpuinfo")


def prepare_jax() -> None:
    """Import JAX for one quick command, with compiled programs kept between runs.

    They lie in the user's cache folder, in one folder per version of JAX and kind of processor: code made for
    another processor may end in an illegal instruction. ``JAX_COMPILATION_CACHE_DIR`` moves the folder and
    ``JAX_ENABLE_COMPILATION_CACHE=false`` turns it off.
    """
    if tuple(map(int, version("jax").split(".")[:2])) < _NOISY:
        os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", _NO_ERRORS)
    # Another process may be writing what this one reads: JAX then compiles it.
    warnings.filterwarnings("ignore", message="Error (reading|writing) persistent compilation cache entry")
    with ended_at_once():
        import jax

    if "JAX_COMPILATION_CACHE_DIR" in os.environ:
        return
    try:
        folder = cache_folder()
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):
        # A read-only disk, or a user without a home.
        return
    if os.access(folder, os.W_OK):
        # Of the processes that this one starts, too.
        os.environ |= {"JAX_COMPILATION_CACHE_DIR": str(folder), "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0"}
        jax.config.update("jax_compilation_cache_dir", str(folder))
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)


def cache_folder() -> Path:
    """Where the programs for this version of JAX and this processor are kept."""
    base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    versions = f"jax-{version('jax')}-jaxlib-{version('jaxlib')}"
    return Path(base).expanduser() / "lobex" / f"{versions}-{platform.machine() or 'processor'}-{_processor()}"


def _processor() -> str:
    """A short digest of what the processor is and can do."""
    try:
        lines = _PROCESSORS.read_text().partition("\n\n")[0].splitlines()
        told = [line for line in lines if line.startswith(("model name", "flags", "Features", "CPU"))]
    except OSError:
        told = []
    return hashlib.sha256("\n".join(told or [platform.processor()]).encode()).hexdigest()[:10]
