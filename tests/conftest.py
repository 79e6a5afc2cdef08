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


@pytest.fixture(autouse=True)
def _close_figures():
    yield
    plt.close("all")


@pytest.fixture(autouse=True, scope="module")
def _forget_compilations():
    """Every compiled program holds memory maps, and a process that keeps those of all files runs out of them."""
    yield
    jax.clear_caches()
