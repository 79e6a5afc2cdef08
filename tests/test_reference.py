"""Against numbers of independent codes."""

import numpy as np
import pytest

import lobex
from cases import LIMIT_CASES, MULTIPLIER_CASES, label, point

MILLING_34 = [c for c in MULTIPLIER_CASES if c.get("tool") == "thesis-3.4"]
ROD_LIMITS = [c for c in LIMIT_CASES if c["problem"] == "rod-rub"]


@pytest.mark.parametrize("case", MILLING_34, ids=label)
def test_aligned_pieces_need_24_nodes_where_one_interval_fails_with_40(case):
    process, speed, gain = point(case)
    aligned = lobex.spectral_radius(process, speed, gain, lobex.Chebyshev(nodes=24))
    assert aligned == pytest.approx(case["spectral_radius"], rel=1e-8)
    single = lobex.spectral_radius(process, speed, gain, lobex.Chebyshev(nodes=40, aligned=False))
    # The thesis' Fig. 3.2 is drawn with this error.
    assert 1e-3 < abs(single / case["spectral_radius"] - 1) < 3e-2


@pytest.mark.parametrize("case", ROD_LIMITS, ids=label)
def test_rod_limits_have_unit_radius_and_their_chatter_frequency(case):
    process, speed, _ = point(case)
    gain = case["critical_contact_stiffness_N_per_m"]
    method = lobex.Chebyshev(nodes=64)
    chart = lobex.sweep(process, [speed], [gain], method)
    assert chart.spectral_radius[0, 0] == pytest.approx(1, abs=1e-8)
    assert chart.chatter_frequency[0, 0] == pytest.approx(case["chatter_frequency_Hz"], rel=1e-7)


MILLING_LIMITS = [c for c in LIMIT_CASES if c["problem"] == "milling-1dof"]


@pytest.mark.parametrize("case", MILLING_LIMITS, ids=label)
def test_milling_limits_have_unit_radius_and_their_kind(case):
    process, speed, _ = point({**case, "depth_m": 0.0})
    for depth in np.atleast_1d(case["critical_depth_m"]):
        chart = lobex.sweep(process, [speed], [depth], lobex.Chebyshev(nodes=64))
        assert chart.spectral_radius[0, 0] == pytest.approx(1, abs=1e-7)
        if case.get("kind") == "flip":
            assert chart.multiplier[0, 0] == pytest.approx(-1, abs=1e-7)
        if case.get("kind") == "hopf":
            assert chart.multiplier[0, 0].imag > 1e-2
