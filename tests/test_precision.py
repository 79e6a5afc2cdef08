"""No global setting is touched, and public calls are in float64 all the same."""

import subprocess
import sys

import jax
import jax.numpy as jnp
import numpy as np

import lobex
from cases import MULTIPLIER_CASES, ROD, point

SETTINGS = """
import sys, lobex
assert "jax" not in sys.modules, "importing lobex must not import jax"
import jax
before = dict(jax.config.values)
for name in lobex.__all__:
    getattr(lobex, name)
chart = lobex.sweep(lobex.Rub(lobex.Rod(2).modes()), [80.0, 90.0], [1e5, 2e5])
assert dict(jax.config.values) == before
assert jax.numpy.ones(1).dtype == "float32" and chart.spectral_radius.dtype == "float64"
"""


def test_importing_and_sweeping_change_no_setting():
    done = subprocess.run([sys.executable, "-c", SETTINGS], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr


def test_the_shell_parses_without_jax():
    code = "import sys, lobex.shell.main; sys.exit('jax' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], timeout=60).returncode == 0


def test_public_calls_are_float64_numpy_with_jax_at_its_defaults():
    assert not jax.config.jax_enable_x64
    case = MULTIPLIER_CASES[16]
    radius = lobex.spectral_radius(*point(case))
    assert isinstance(radius, np.ndarray)
    assert radius.dtype == np.float64
    assert abs(radius / case["spectral_radius"] - 1) < 1e-9
    assert lobex.multipliers(ROD, 85.0, 1e6).dtype == np.complex128
    assert all(np.asarray(leaf).dtype == np.float64 for leaf in jax.tree.leaves(ROD.system(85.0, 1e6)))
    narrow = lobex.spectral_radius(ROD, np.float32(85), jnp.float32(1e6))
    assert narrow == lobex.spectral_radius(ROD, 85.0, 1e6)


def test_traced_calls_follow_their_inputs():
    with jax.enable_x64(False):
        assert jax.jit(lambda k: lobex.spectral_radius(ROD, 85.0, k))(1e6).dtype == jnp.float32
    with jax.enable_x64(True):
        wide = jax.jit(lambda k: lobex.spectral_radius(ROD, 85.0, k))(1e6)
        assert wide.dtype == jnp.float64
    assert abs(float(wide) - float(lobex.spectral_radius(ROD, 85.0, 1e6))) < 1e-12
