"""Settings of the shell's own process: a library call never makes them."""

import os
import warnings
from pathlib import Path


def prepare_jax() -> None:
    """Import JAX for one quick command, with compiled programs kept between runs.

    They lie in the user's cache folder, in one folder per JAX version; ``JAX_COMPILATION_CACHE_DIR`` moves
    the folder and ``JAX_ENABLE_COMPILATION_CACHE=false`` turns it off. Not before JAX 0.11: version 0.9
    prints a warning of its own for every program that it finds there.
    """
    # JAX has a thread per core already.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Another process may be writing what this one reads: JAX then compiles it.
    warnings.filterwarnings("ignore", message="Error (reading|writing) persistent compilation cache entry")
    import jax

    if "JAX_COMPILATION_CACHE_DIR" in os.environ or jax.__version_info__ < (0, 11):
        return
    base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    folder = Path(base).expanduser() / "lobex" / f"jax-{jax.__version__}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return
    if os.access(folder, os.W_OK):
        jax.config.update("jax_compilation_cache_dir", str(folder))
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
