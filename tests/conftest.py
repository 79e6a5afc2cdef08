import gc
import os
import signal
import tempfile

# Before NumPy and SciPy load it: every worker has a core, and JAX a thread on each.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Before JAX loads: 0.9 writes a line of its own for every program that it finds in the cache.
os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")

import quick

# Empty flags, as make test-all has them, compile as for users.
os.environ.setdefault("XLA_FLAGS", quick.flags())

import matplotlib

matplotlib.use("Agg")

import hypothesis
import jax
import matplotlib.pyplot as plt
import pytest

from commands import Shell
from compiled import Counter
from lobex._programs import forget_if_many

# Files that take longest begin first, so that the workers end together.
LONGEST = (
    *("links", "problems", "explorer_page", "study_processes", "docs", "notebooks", "gallery", "critical"),
    *("exact_limits", "transformations", "shell", "gradients", "duhamel", "growth_beside", "readme", "cluster"),
    *("blading", "real_wear", "sweep", "stage_in_casing", "sensitivity", "march_delay", "properties", "cutter"),
    *("multi_frequency", "operators", "random_models", "closed_form", "chatter", "study", "explorer_curves"),
    *("modal_fit", "devices", "boundary", "critical_constant", "linear_delay", "band", "programs", "orbit"),
    *("outputs_apart", "general_error", "exact_limit_verb", "characteristic_roots", "duhamel_search"),
    *("force_shapes", "speed_variation", "reference", "precision", "store", "exact", "turning_simulation"),
    *("cutter_shapes", "distributed", "undamped", "design", "plausible", "several_contacts", "chart"),
    *("blade_limits", "frf_file", "wear", "cutting_orbit", "explorer_browser", "random_tools", "orbit_map"),
    *("advice",),
)
# How long an example takes is the machine's affair, and what else it does.
hypothesis.settings.register_profile("lobex", deadline=None)
hypothesis.settings.load_profile("lobex")
# New objects, and rounds of the younger ones, after which Python looks for rubbish; 700, 10 and 10 by default.
COLLECTED = (50_000, 20, 100)


def pytest_configure(config):
    """The workers of a run and the processes that tests start share what they compile.

    It lies in a folder that the run's end removes. A folder named by LOBEX_TESTS_COMPILED is taken as it is and
    kept, for a next run that is to begin sooner.
    """
    if "LOBEX_TESTS_COMPILED" not in os.environ:
        config._compiled = tempfile.TemporaryDirectory(prefix="lobex-compiled-", ignore_cleanup_errors=True)
        os.environ["LOBEX_TESTS_COMPILED"] = config._compiled.name
    os.environ["JAX_COMPILATION_CACHE_DIR"] = os.environ["LOBEX_TESTS_COMPILED"]
    os.environ["JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"] = "0"
    jax.config.update("jax_compilation_cache_dir", os.environ["LOBEX_TESTS_COMPILED"])
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    config.pluginmanager.register(Counter())
    # What JAX traced is kept, and grows: looking through all of it for rubbish, time and again, costs a tenth.
    gc.set_threshold(*COLLECTED)
    # A run in the background ignores Ctrl-C, and with it every process that a test starts and interrupts.
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_finish():
    # What was imported stays: there is nothing to look for in it.
    gc.freeze()


def pytest_unconfigure(config):
    # Ending, pytest and Python look for rubbish several times, which takes seconds with all that JAX keeps.
    gc.freeze()
    if hasattr(config, "_compiled"):
        config._compiled.cleanup()


def pytest_collection_modifyitems(items):
    rank = {f"test_{name}.py": number for number, name in enumerate(LONGEST)}
    items.sort(key=lambda item: rank.get(item.path.name, len(rank)))


@pytest.fixture
def shell(tmp_path, monkeypatch, capsys):
    return Shell(tmp_path, monkeypatch, capsys)


@pytest.fixture(autouse=True)
def _close_figures():
    yield
    plt.close("all")


@pytest.fixture(autouse=True, scope="module")
def _few_memory_maps():
    """A process that keeps the compiled programs of all files can run out of memory maps."""
    yield
    forget_if_many()
