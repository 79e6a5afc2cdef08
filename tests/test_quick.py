"""The flags with which tests are compiled."""

import jax
import numpy as np

import quick
from lobex import _quickly


def test_only_flags_that_jaxlib_knows_are_given_to_it(monkeypatch):
    monkeypatch.setattr(quick, "QUICK", {"xla_backend_optimization_level": 0, "xla_of_another_version": True})
    assert quick.flags() == "--xla_backend_optimization_level=0"


def test_programs_are_compiled_with_those_alone_that_xla_knows(monkeypatch):
    monkeypatch.setitem(_quickly.QUICK, "xla_of_another_version", True)
    _quickly._options.cache_clear()
    program = _quickly.compiled_quickly(lambda x: 2 * x)
    assert float(program(2.0)) == 4.0
    assert "xla_of_another_version" not in _quickly._options()
    assert "xla_backend_optimization_level" in _quickly._options()
    _quickly._options.cache_clear()


def test_a_program_within_another_is_a_part_of_it():
    program = _quickly.compiled_quickly(lambda x: x**2)
    assert float(jax.jit(jax.grad(program))(3.0)) == 6.0
    assert float(jax.jit(lambda x: x + program(3.0))(1.0)) == 10.0
    np.testing.assert_array_equal(jax.vmap(program)(np.arange(3.0)), [0.0, 1.0, 4.0])
