"""Programs are forgotten before there are more than a process may have maps of memory."""

from pathlib import Path

import numpy as np
import pytest

import lobex
from lobex import _programs

MAPS = Path("/proc/self/maps")


def maps():
    return MAPS.read_bytes().count(b"\n")


@pytest.mark.skipif(not MAPS.exists(), reason="maps of memory are told on Linux alone")
@pytest.mark.slow
@pytest.mark.parametrize("verb", [lambda *at: lobex.sweep(*at).multiplier, lobex.multipliers])
def test_a_verb_forgets_programs_that_are_too_many(monkeypatch, verb):
    scalar = lobex.Scalar(-1.0)

    def multiplier(nodes):
        return verb(scalar, [0.16], [0.3], lobex.Duhamel(nodes=nodes))

    begun = maps()
    before = [multiplier(nodes) for nodes in (10, 11)]
    many = maps()
    assert many > begun
    multiplier(10)
    # So few are no reason.
    assert maps() > begun
    monkeypatch.setattr(_programs, "_EVERY", 1)
    monkeypatch.setattr(_programs, "_MOST_MAPS", begun)
    after = multiplier(12), multiplier(10)
    assert maps() < many
    np.testing.assert_array_equal(after[1], before[0])
