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
@pytest.mark.parametrize("verb", [lambda *at: lobex.sweep(*at).multiplier, lobex.multipliers])
def test_a_verb_forgets_programs_that_are_too_many(monkeypatch, verb):
    mathieu = lobex.DelayedMathieu(2.5, 1.3, 0.05)

    def multiplier(nodes):
        return verb(mathieu, [0.16], [0.3], lobex.Duhamel(nodes=nodes))

    begun = maps()
    before = [multiplier(nodes) for nodes in (30, 31, 32)]
    many = maps()
    assert many > begun
    multiplier(30)
    # So few are no reason.
    assert maps() > begun
    monkeypatch.setattr(_programs, "_EVERY", 1)
    monkeypatch.setattr(_programs, "_MOST_MAPS", begun)
    after = multiplier(33), multiplier(30)
    assert maps() < many
    np.testing.assert_array_equal(after[1], before[0])
