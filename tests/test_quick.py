"""The flags with which tests are compiled."""

import quick


def test_only_flags_that_jaxlib_knows_are_given_to_it(monkeypatch):
    monkeypatch.setattr(quick, "_QUICK", {"xla_backend_optimization_level": "0", "xla_of_another_version": "1"})
    assert quick.flags() == "--xla_backend_optimization_level=0"
