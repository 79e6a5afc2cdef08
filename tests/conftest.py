import os
import tempfile

# Before NumPy and SciPy load it: every worker has a core, and JAX a thread on each.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import matplotlib

matplotlib.use("Agg")

import jax
import matplotlib.pyplot as plt
import pytest


@pytest.fixture(autouse=True, scope="session")
def _cache_of_compilations(tmp_path_factory):
    """Shell commands keep their compiled programs beside the tests' files and not in the user's cache."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield


def pytest_configure(config):
    """The workers of a run share what they compile, in a folder that the run's end removes.

    A folder named by LOBEX_TESTS_COMPILED is taken as it is and kept, for a next run that is to begin sooner.
    """
    if "LOBEX_TESTS_COMPILED" not in os.environ:
        config._compiled = tempfile.TemporaryDirectory(prefix="lobex-compiled-")
        os.environ["LOBEX_TESTS_COMPILED"] = config._compiled.name
    jax.config.update("jax_compilation_cache_dir", os.environ["LOBEX_TESTS_COMPILED"])
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.3)


def pytest_unconfigure(config):
    if hasattr(config, "_compiled"):
        config._compiled.cleanup()


@pytest.fixture(autouse=True)
def _close_figures():
    yield
    plt.close("all")


@pytest.fixture(autouse=True, scope="module")
def _forget_compilations():
    """Every compiled program holds memory maps, and a process that keeps those of all files runs out of them."""
    yield
    jax.clear_caches()
