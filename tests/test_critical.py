"""Critical gains by scan and Newton's method: reference limits, statuses, derivatives, files, pictures."""

import jax
import numpy as np
import pytest

import lobex
import lobex._pytree
from cases import LIMIT_CASES, LIMIT_TOOLS, ROD, assert_same_fields, milling, rub
from refusals import refused

BOUNDS = (4.5e4, 4.5e6)
FINE = lobex.Chebyshev(56)


@pytest.mark.parametrize("ratio", [0.03, 0.0177])
def test_rod_limits(ratio):
    cases = [c for c in LIMIT_CASES if c["problem"] == "rod-rub" and c["damping_ratio"] == ratio]
    limit = lobex.critical_gain(rub(5, ratio), [c["speed_Hz"] for c in cases], BOUNDS, FINE)
    expected = np.array([c["critical_contact_stiffness_N_per_m"] for c in cases])
    assert limit.gain == pytest.approx(expected, rel=1e-8)
    assert limit.chatter_frequency == pytest.approx([c["chatter_frequency_Hz"] for c in cases], rel=1e-7)
    assert set(limit.kind) == {"hopf"}
    assert set(limit.status) == {"found"}
    assert limit.intervals[:, 0] == pytest.approx(np.column_stack([np.full(9, BOUNDS[0]), expected]), rel=1e-8)
    assert np.all(limit.error < 1e-8 * expected)
    assert limit.lobe.tolist() == [6, 5, 4, 4, 3, 2, 1, 1, 0]


@pytest.mark.parametrize(
    "method", [pytest.param(lobex.Chebyshev(48), marks=pytest.mark.slow), lobex.Duhamel()], ids=["Chebyshev", "Duhamel"]
)
@pytest.mark.parametrize(
    "case", [c for c in LIMIT_CASES if c["problem"] == "milling-1dof"], ids=lambda c: c["speed_rpm"]
)
def test_milling_limits_with_kinds_and_re_entrance(case, method):
    process = milling(LIMIT_TOOLS[case["tool"]], case["radial_immersion"], case["direction"])
    limit = lobex.critical_gain(process, case["speed_rpm"] / 60, (0, 6e-3), method)
    depths = np.atleast_1d(case["critical_depth_m"])
    assert limit.gain[0] == pytest.approx(depths[0], rel=1e-7)
    if "kind" in case:
        assert limit.kind[0] == case["kind"]
    edges = limit.intervals[0][np.isfinite(limit.intervals[0])]
    assert edges[: len(depths) + 1] == pytest.approx([0.0, *depths], rel=1e-7)


def test_no_limit_is_nan_with_its_reason():
    below = lobex.critical_gain(ROD, [85.0, 112.0], (1e4, 2e4), scan=9)
    assert np.isnan(below.gain).all()
    assert set(below.status) == {"none in range"}
    assert below.intervals[:, 0].tolist() == [[1e4, 2e4]] * 2
    above = lobex.critical_gain(ROD, [85.0, 112.0], (2e6, 3e6), scan=9)
    assert np.isnan(above.gain).all()
    assert set(above.status) == {"unstable at the lower bound"}
    assert set(above.kind) == {""}
    assert np.isnan(above.intervals).all()


@lobex._pytree.pytree()
class _Gap(lobex.Rub):
    """A rub that fails between two gains, as a model outside its range would."""

    def system(self, speed, gain):
        system = super().system(speed, gain)
        bad = (gain > 2.5e5) & (gain < 4e5)
        return jax.tree.map(lambda leaf: jax.numpy.where(bad, jax.numpy.nan, leaf), system)


def test_a_limit_above_points_that_failed_is_not_claimed():
    # 200 Hz has its limit at 3.3e5, within the gap; 85 Hz at 9.2e5, above it; both may have missed a lower one.
    limit = lobex.critical_gain(_Gap(ROD.modes), [85.0, 200.0], (1e5, 2e6), lobex.Chebyshev(40), scan=20)
    assert set(limit.status) == {"not converged"}
    assert np.isnan(limit.gain).all()
    assert np.isnan(limit.intervals).all()


@pytest.fixture(scope="module")
def lobes():
    return lobex.critical_gain(ROD, np.linspace(60, 400, 35), (4.5e4, 2e6), scan=33)


def test_a_limit_is_where_the_radius_is_one(lobes):
    found = np.isfinite(lobes.gain)
    assert found.sum() > 25
    radius = lobex.spectral_radius(ROD, lobes.speed[found], lobes.gain[found])
    assert radius == pytest.approx(1, abs=1e-9)
    below = lobex.spectral_radius(ROD, lobes.speed[found], 0.999 * lobes.gain[found])
    assert np.all(below < 1)
    assert set(lobes.status[~found]) == {"none in range"}


def test_limits_print_save_and_load(lobes, tmp_path):
    assert "smallest limit" in repr(lobes)
    assert "none in range" in repr(lobes)
    lobes.save(tmp_path / "limit.nc")
    again = lobex.load(tmp_path / "limit.nc")
    assert_same_fields(again, lobes)


def test_the_picture_has_both_axes_kinds_and_lobe_numbers(lobes):
    upper, lower = lobes.plot().axes
    assert upper.get_ylabel() == "contact stiffness $K_{e}$ (MN/m)"
    assert lower.get_ylabel() == "chatter frequency (Hz)"
    assert lower.get_xlabel() == "rotational frequency (Hz)"
    assert [t.get_text() for t in upper.get_legend().get_texts()] == ["stable", "Hopf (complex pair)"]
    assert {t.get_text() for t in upper.texts} >= {"1", "2", "3"}


def test_derivatives_by_the_implicit_function_theorem():
    # Along E → αE, f → √α f the limit scales by α; and against a central difference of separate searches.
    def limit(young_modulus, ratio, speed):
        process = lobex.Rub(lobex.Rod(2, young_modulus=young_modulus).modes(ratio))
        return lobex.critical_gain(process, speed, (1e5, 2e6), lobex.Chebyshev(32), scan=9).gain[0]

    at = np.array([210e7, 0.03, 140.0])
    with jax.enable_x64(True):
        value, slopes = jax.jit(jax.value_and_grad(limit, argnums=(0, 1, 2)))(*at)
    assert float(value) == pytest.approx(float(limit(*at)), rel=1e-11)
    logarithmic = np.array(slopes) * at / float(value)
    assert logarithmic[0] + logarithmic[2] / 2 == pytest.approx(1, rel=1e-8)
    direction = np.array([0.3, 1.0, -0.5]) * 1e-4
    difference = (limit(*(at * (1 + direction))) - limit(*(at * (1 - direction)))) / 2
    assert logarithmic @ direction * float(value) == pytest.approx(float(difference), rel=1e-6)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: lobex.critical_gain(ROD, 85.0, (2e6, 1e5)), "must be increasing"),
        (lambda: lobex.critical_gain(ROD, 85.0, (1e5, 1e5)), "must be increasing"),
        (lambda: lobex.critical_gain(ROD, 85.0, 1e5), "bounds = 100000.0"),
        (lambda: lobex.critical_gain(ROD, 85.0, (-1.0, 1e5)), "gain = [-1, 100000]"),
        (lambda: lobex.critical_gain(ROD, 85.0, (0.0, np.inf)), "NaN or infinite"),
        (lambda: lobex.critical_gain(ROD, 0.0, BOUNDS), "speed = 0"),
        (lambda: lobex.critical_gain(ROD, [], BOUNDS), "speed has shape (0,)"),
        (lambda: lobex.critical_gain(ROD, 85.0, BOUNDS, scan=2), "scan = 2"),
    ],
)
def test_bad_input_is_refused_in_one_line(call, words):
    with refused(words):
        call()
