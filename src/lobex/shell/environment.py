"""Settings of the shell's own process: a library call never makes them."""

import os
from pathlib import Path


def keep_compilations() -> None:
    """Keep compiled programs between runs, in the user's cache folder, one folder per JAX version.

    ``JAX_COMPILATION_CACHE_DIR`` moves the folder and ``JAX_ENABLE_COMPILATION_CACHE=false`` turns it off.
    """
    import jax

    if "JAX_COMPILATION_CACHE_DIR" in os.environ:
        return
    base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    folder = Path(base).expanduser() / "lobex" / f"jax-{jax.__version__}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return
    if os.access(folder, os.W_OK):
        jax.config.update("jax_compilation_cache_dir", str(folder))
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.1)
