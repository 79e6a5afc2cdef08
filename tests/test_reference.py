"""Against numbers of independent codes."""

import numpy as np
import pytest

import lobex
from cases import LIMIT_CASES, MULTIPLIER_CASES, label, point

MILLING_34 = [c for c in MULTIPLIER_CASES if c.get("tool") == "thesis-3.4"]
ROD_LIMITS = [c for c in LIMIT_CASES if c["problem"] == "rod-rub"]


def order_of(steps: np.ndarray, errors: np.ndarray) -> float:
    """Convergence order as the slope of log error over log step size."""
    return -np.polyfit(np.log(steps), np.log(errors), 1)[0]


@pytest.mark.parametrize("case", MULTIPLIER_CASES, ids=label)
def test_chebyshev_with_64_nodes_meets_every_case(case):
    process, speed, gain = point(case)
    radius = lobex.spectral_radius(process, speed, gain, lobex.Chebyshev(nodes=64))
    assert radius == pytest.approx(case["spectral_radius"], rel=1e-8)


@pytest.mark.parametrize("case", MILLING_34, ids=label)
def test_aligned_pieces_need_24_nodes_where_one_interval_fails_with_40(case):
    process, speed, gain = point(case)
    aligned = lobex.spectral_radius(process, speed, gain, lobex.Chebyshev(nodes=24))
    assert aligned == pytest.approx(case["spectral_radius"], rel=1e-8)
    single = lobex.spectral_radius(process, speed, gain, lobex.Chebyshev(nodes=40, aligned=False))
    # The thesis' Fig. 3.2 is drawn with this error.
    assert 1e-3 < abs(single / case["spectral_radius"] - 1) < 3e-2


SHALLOW = next(c for c in MULTIPLIER_CASES if c.get("radial_immersion") == 0.05 and c["direction"] == "down")
SMOOTH = [c for c in MULTIPLIER_CASES if c["problem"] in ("rod-rub", "delayed-mathieu")]


@pytest.mark.parametrize("order", [0, 1])
@pytest.mark.parametrize("case", SMOOTH, ids=label)
def test_semi_discretization_is_second_order_on_smooth_coefficients(case, order):
    process, speed, gain = point(case)
    steps = np.array([160, 226, 320])
    methods = [lobex.SemiDiscretization(steps=int(k), order=order) for k in steps]
    radii = [lobex.spectral_radius(process, speed, gain, method) for method in methods]
    errors = np.abs(np.array(radii) / case["spectral_radius"] - 1)
    assert order_of(steps, errors) == pytest.approx(2, abs=0.15)


@pytest.mark.parametrize("case", [c for c in SMOOTH if c["problem"] == "rod-rub"][:4], ids=label)
def test_semi_discretization_of_order_two_gains_an_order_on_constant_coefficients(case):
    process, speed, gain = point(case)
    steps = np.array([160, 226, 320])
    methods = [lobex.SemiDiscretization(steps=int(k), order=2) for k in steps]
    radii = [lobex.spectral_radius(process, speed, gain, method) for method in methods]
    errors = np.abs(np.array(radii) / case["spectral_radius"] - 1)
    assert order_of(steps, errors) > 2.5


@pytest.mark.parametrize("order", [0, 1])
@pytest.mark.parametrize("case", [c for c in MULTIPLIER_CASES if "1dof" in c["problem"]], ids=label)
def test_semi_discretization_is_second_order_over_the_jumps_of_milling(case, order):
    # Averaged coefficients keep the order; where the jump falls within a step moves the constant a little. Of the
    # shallowest cut the two leading error terms nearly cancel, and the order shows at finer steps.
    process, speed, gain = point(case)
    steps = np.array([320, 450, 640]) if case is SHALLOW else np.array([80, 91, 104, 120, 142])
    radii = [lobex.spectral_radius(process, speed, gain, lobex.SemiDiscretization(int(k), order)) for k in steps]
    exact = lobex.spectral_radius(process, speed, gain, lobex.Chebyshev(64))
    assert order_of(steps, np.abs(np.array(radii) / exact - 1)) == pytest.approx(2, abs=0.15)


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
