"""What XLA is told of programs, of those of lobex and of all while tests run."""

import jax
import numpy as np
import pytest

import quick
from lobex import _compiled


def test_only_flags_that_jaxlib_knows_are_given_to_it(monkeypatch):
    monkeypatch.setattr(quick, "QUICK", {"xla_backend_optimization_level": 0, "xla_of_another_version": True})
    assert quick.flags() == "--xla_backend_optimization_level=0"


def test_programs_are_compiled_with_those_alone_that_xla_knows(monkeypatch):
    monkeypatch.setenv("XLA_FLAGS", "")
    monkeypatch.setitem(_compiled.QUICK, "xla_of_another_version", True)
    program = _compiled.compiled_quickly(lambda x: 2 * x)
    assert float(program(2.0)) == 4.0
    assert set(_compiled.known(_compiled.QUICK)) == _compiled.QUICK.keys() - {"xla_of_another_version"}


def test_what_the_user_s_flags_say_stands(monkeypatch):
    monkeypatch.setenv("XLA_FLAGS", "--xla_backend_optimization_level=3")
    assert set(_compiled.known(_compiled.SHORT)) == _compiled.SHORT.keys() - {"xla_backend_optimization_level"}


def test_elsewhere_than_on_a_processor_none_are_told(monkeypatch):
    monkeypatch.setenv("XLA_FLAGS", "")
    monkeypatch.setattr(jax, "default_backend", lambda: "gpu")
    assert _compiled.known(_compiled.SHORT) == {}


@pytest.mark.parametrize("told", [_compiled.compiled, _compiled.compiled_quickly])
def test_a_program_within_another_is_a_part_of_it(told):
    program = told(lambda x: x**2)
    assert float(jax.jit(jax.grad(program))(3.0)) == 6.0
    assert float(jax.jit(lambda x: x + program(3.0))(1.0)) == 10.0
    np.testing.assert_array_equal(jax.vmap(program)(np.arange(3.0)), [0.0, 1.0, 4.0])


def test_sizes_are_arguments_by_their_names():
    seen = []

    @_compiled.compiled_for("count")
    def total(x, count):
        seen.append(count)
        return x * count

    assert [float(total(2.0, count)) for count in (3, 3, 4)] == [6.0, 6.0, 8.0]
    assert seen == [3, 4]
