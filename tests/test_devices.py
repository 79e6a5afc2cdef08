"""Several devices share a sweep, and compute the same bits as one."""

import json
import os
import subprocess
import sys

import pytest

CODE = """
import hashlib, json
import jax
import numpy as np
import lobex
from lobex.grids import evaluation, one_size
from lobex.marches import wear

used = {}


def watch(owner, name, module):
    plain = owner[name]

    def watched(*arguments, **options):
        result = plain(*arguments, **options)
        devices = [str(device) for device in jax.tree.leaves(result)[0].devices()]
        used.setdefault(module.__name__, set()).update(devices)
        return result

    owner[name] = watched


watch(one_size.with_errors, False, one_size)
watch(vars(evaluation), "_over_chunk", evaluation)
watch(vars(wear), "_turn", wear)
tool = lobex.Modes.single(frequency=146.5, damping_ratio=0.0032, mass=2.573)
mill = lobex.Milling(tool, teeth=1, tangential=5.5e8, normal=2e8, radial_immersion=0.5)
chart = lobex.sweep(mill, np.linspace(50, 300, 40), np.linspace(0, 3e-3, 5), lobex.Duhamel(nodes=10))
rub = lobex.sweep(lobex.Rub(lobex.Rod(2).modes(0.03)), np.linspace(100, 300, 40), np.linspace(1e5, 2e6, 5))
limit = lobex.critical_gain(mill, np.linspace(120, 300, 40), (1e-4, 3e-3), lobex.Duhamel(nodes=10), scan=9)
collocation = lobex.sweep(mill, np.linspace(50, 300, 96), np.linspace(0, 3e-3, 20), lobex.Chebyshev(16))
law = lobex.Plastic(stiffness=4.5e6, yield_force=100.0)
march = lobex.march_wear(lobex.Rod(3).modes(0.03), lobex.Casing(), law, np.linspace(60, 190, 64), 2, 320)
parts = (
    chart.multiplier, chart.chatter_frequency, rub.multiplier, limit.gain, collocation.multiplier, march.depth
)
bits = [hashlib.sha256(np.ascontiguousarray(part).tobytes()).hexdigest() for part in parts]
print(json.dumps([len(jax.local_devices()), [len(devices) for devices in used.values()], bits]))
"""


def _run(devices: int) -> tuple[int, list[int], list[str]]:
    flags = {"XLA_FLAGS": f"{os.environ['XLA_FLAGS']} --xla_force_host_platform_device_count={devices}"}
    done = subprocess.run(
        [sys.executable, "-c", CODE], capture_output=True, text=True, env={**os.environ, **flags}, timeout=400
    )
    assert done.returncode == 0, done.stderr
    return tuple(json.loads(done.stdout.splitlines()[-1]))


def test_two_devices_share_the_work_and_change_no_bit():
    if os.environ.get("JAX_PLATFORMS", "cpu") != "cpu":
        pytest.skip("devices are made of the CPU here")
    one, two = _run(1), _run(2)
    assert one[:2] == (1, [1, 1, 1])
    assert two[:2] == (2, [2, 2, 2])
    assert two[2] == one[2]
