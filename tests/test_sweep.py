"""The sweep: the iteration against the dense solver, failures, memory, and that it never hangs."""

import subprocess
import sys
from dataclasses import replace
from importlib import import_module

import jax
import numpy as np
import pytest

import lobex
from cases import LIMIT_CASES, MILL, MULTIPLIER_TOOLS, ROD, milling, rub
from lobex.floquet import dense, power
from lobex.floquet.subspace import dominant_pair
from lobex.grids.dominant import Dominant

GRIDS = [
    (ROD, np.linspace(50, 400, 12), np.linspace(4.5e4, 4.5e6, 11), lobex.Chebyshev(40)),
    (ROD, np.linspace(60, 300, 4), np.linspace(0, 4.5e6, 5), lobex.SemiDiscretization(60, order=1)),
    (rub(8), np.linspace(500, 8000, 9), np.linspace(0, 13.5e6, 6), lobex.Chebyshev(24)),
    (MILL, np.linspace(2000, 25000, 11) / 60, np.linspace(0, 5e-3, 9), lobex.Chebyshev(32)),
    (
        milling(MULTIPLIER_TOOLS["Insperger-Stepan"], 0.05, "down", 2),
        np.linspace(5e3, 25e3, 7) / 60,
        np.linspace(0, 5e-3, 6),
        lobex.Chebyshev(24),
    ),
    (lobex.Scalar(-0.3), np.linspace(0.2, 2, 5), np.linspace(-2, 2, 8), lobex.Chebyshev(20)),
]


@pytest.mark.parametrize(("process", "speeds", "gains", "method"), GRIDS)
@pytest.mark.filterwarnings("ignore::lobex.SweepWarning")
def test_sweep_agrees_with_the_dense_solver(process, speeds, gains, method):
    chart = lobex.sweep(process, speeds, gains, method)
    exact = lobex.spectral_radius(process, speeds[:, None], gains, method)
    assert chart.spectral_radius == pytest.approx(exact, rel=1e-9, abs=1e-12)
    assert np.abs(chart.multiplier) == pytest.approx(exact, rel=1e-9, abs=1e-12)
    assert np.all(chart.multiplier.imag >= 0)
    assert chart.failed == 0


def test_chunks_of_any_shape_give_the_same_map(monkeypatch):
    speeds, gains = np.linspace(60, 400, 7), np.linspace(0, 4e6, 9)
    whole = lobex.sweep(ROD, speeds, gains, lobex.Duhamel())
    module = sys.modules["lobex.grids.refinement"]
    monkeypatch.setattr(module, "_CALL", 1)
    for bytes_ in (1.0, 8 * 36**2 * 100):
        monkeypatch.setattr(module, "_CHUNK_BYTES", bytes_)
        parts = lobex.sweep(ROD, speeds, gains, lobex.Duhamel())
        assert parts.spectral_radius == pytest.approx(whole.spectral_radius, rel=1e-10)
        assert parts.chatter_frequency == pytest.approx(whole.chatter_frequency, rel=1e-9)


# Each as one program, as a sweep has it.
FEW = jax.jit(lambda matrix, squarings, periods: dominant_pair(matrix, 8, squarings, periods), static_argnums=2)
PAIR, TRIPLE, LEFT = (jax.jit(one) for one in (power.pair_by_squaring, power.triple_by_squaring, dense.left_vector))


def test_powers_report_their_own_failure():
    # Twelve multipliers of one modulus: no plane holds the dominant space.
    angles = np.linspace(0.1, 3.0, 6)
    blocks = [[[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]] for a in angles]
    rng = np.random.default_rng(1)
    basis = rng.standard_normal((20, 20))
    matrix = np.zeros((20, 20))
    for i, block in enumerate(blocks):
        matrix[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = block
    matrix = basis @ matrix @ np.linalg.inv(basis)
    with jax.enable_x64(True):
        pair = PAIR(matrix, 8)
        assert float(power.residual(matrix, pair)) > 1e-6
        assert abs(complex(dense.pair_by_eigensolver(matrix)[0])) == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("second", [-1.29, 1.29, 0.9])
def test_powers_meet_a_known_spectrum(second):
    rng = np.random.default_rng(3)
    basis = rng.standard_normal((30, 30))
    values = np.r_[1.3, second, np.linspace(0.5, 0, 28)]
    inverse = np.linalg.inv(basis)
    matrix = basis @ np.diag(values) @ inverse
    with jax.enable_x64(True):
        (value, right, left), residual = TRIPLE(matrix, 10)
    # The basis' condition, a few hundred, times rounding.
    assert complex(value) == pytest.approx(1.3, rel=1e-10)
    assert float(residual) < 1e-10
    assert matrix @ np.asarray(right) == pytest.approx(1.3 * np.asarray(right), abs=1e-9)
    assert np.asarray(left) @ matrix == pytest.approx(1.3 * np.asarray(left), abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.4, 1.0, 2.0, 3.0])
def test_no_point_waits_for_the_dense_solver_however_long_the_delay_is(share):
    delayed = lobex.LinearDelay.second_order(
        1.0, 0.1, lambda t, speed, gain: speed + jax.numpy.cos(t), [(lambda t, speed, gain: gain, share * 2 * np.pi)],
        period=2 * np.pi,
    )  # fmt: skip
    chart = lobex.sweep(delayed, [1.5, 3.4, 5.7], [-2.0, -0.3, 1.4])
    assert set(chart.status.ravel()) == {"good"}
    exact = [[lobex.multipliers(delayed, s, g, lobex.Duhamel(nodes=40))[0] for g in chart.gain] for s in chart.speed]
    assert np.abs(chart.multiplier) == pytest.approx(np.abs(np.array(exact)), rel=1e-8)


@pytest.mark.parametrize(("angle", "periods"), [(0.0, 1), (2.0, 1), (2.0, 3)])
def test_a_few_vectors_find_the_dominant_multiplier_of_a_large_operator(angle, periods):
    """Eight multipliers of a structure, some of a delay of so many periods behind them, and the eight alone."""
    rng, size = np.random.default_rng(3), 60 if periods == 1 else 150
    of_delay = 0.05 * 0.5 ** np.arange(size - 8)
    values = np.r_[1.3, -1.28, 1.2, 1.1, 0.9, -0.9, 0.7, 0.5, of_delay ** (1 / periods)]
    basis = rng.standard_normal((size, size))
    close = 1e-14 * np.linalg.cond(basis)
    for count in (size, 8):
        matrix = np.diag(np.where(np.arange(size) < count, values, 0.0))
        if angle:
            matrix[:2, :2] = 1.3 * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        matrix = basis @ matrix @ np.linalg.inv(basis)
        with jax.enable_x64(True):
            value, right, left = map(power.as_complex, FEW(matrix, 9, periods))
        assert complex(value) == pytest.approx(1.3 * np.exp(1j * angle), rel=close)
        assert matrix @ np.asarray(right) == pytest.approx(complex(value) * np.asarray(right), abs=10 * close)
        # A left vector tells how far to trust the value, and takes two digits for it.
        lefts = np.asarray(left) / np.linalg.norm(left)
        assert lefts @ matrix == pytest.approx(complex(value) * lefts, abs=1e-3)
        assert complex(np.asarray(left) @ np.asarray(right)) == pytest.approx(1)


def test_powers_meet_a_known_pair():
    rng = np.random.default_rng(5)
    basis = rng.standard_normal((20, 20))
    matrix = np.diag(np.linspace(0.9, 0, 20))
    matrix[:2, :2] = 1.1 * np.array([[np.cos(2.0), -np.sin(2.0)], [np.sin(2.0), np.cos(2.0)]])
    matrix = basis @ matrix @ np.linalg.inv(basis)
    with jax.enable_x64(True):
        (value, _, left), residual = TRIPLE(matrix, 10)
    assert complex(value) == pytest.approx(1.1 * np.exp(2j), rel=1e-11)
    assert float(residual) < 1e-10
    assert np.asarray(left) @ matrix == pytest.approx(complex(value) * np.asarray(left), abs=1e-9)


@pytest.mark.parametrize("second", [0.4, 1.29])
@pytest.mark.parametrize("angle", [0.0, 2.0])
def test_left_vectors_belong_to_the_pair(angle, second):
    # Beside a dominant pair or a dominant real number with another of nearly its modulus.
    basis = np.random.default_rng(7).standard_normal((20, 20))
    matrix = np.diag(np.r_[1.3, second, -0.3, np.linspace(0.2, 0, 17)])
    if angle:
        turn = 1.3 * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        matrix[:2, :2] = turn
    matrix = basis @ matrix @ np.linalg.inv(basis)
    with jax.enable_x64(True):
        value, right, left = map(power.as_complex, PAIR(matrix, 9))
        other = LEFT(matrix, value, right)
    values, vectors = np.linalg.eig(matrix.T)
    expected = vectors[:, np.argmin(np.abs(values - complex(value)))]
    expected = expected / (expected @ np.asarray(right))
    scale = np.abs(expected).max()
    assert complex(value) == pytest.approx(1.3 * np.exp(1j * angle), rel=1e-10)
    assert np.asarray(left) == pytest.approx(expected, abs=1e-4 * scale)
    assert np.asarray(other) == pytest.approx(expected, abs=1e-6 * scale)


@pytest.mark.parametrize(
    "method", [lobex.Auto(), lobex.Duhamel(nodes=40), lobex.Chebyshev(40), lobex.Duhamel(tolerance=1e-4)]
)
def test_errors_above_the_tolerance_are_warned_of_whatever_computed_them(method, monkeypatch):
    def computed(process, speeds, gains, method, progress):
        error = np.array([[0.0, 1e-7, np.inf], [1e-9, 1e-3, np.nan]])
        again = np.array([[True, True, False], [False, False, False]])
        return Dominant(np.full((2, 3), 0.5 + 0j), np.zeros((2, 3)), error, np.zeros((2, 3), dtype=int), again)

    monkeypatch.setattr(import_module("lobex.grids.sweep"), "dominant_over_grid", computed)
    above = "2 of 6 .* above the tolerance 0.0001" if method == lobex.Duhamel(tolerance=1e-4) else "3 of 6 .* 1e-08"
    with pytest.warns(lobex.SweepWarning, match=above):
        chart = lobex.sweep(ROD, [100.0, 200.0], [1e5, 1e6, 2e6], method)
    least = "settled again" if method == lobex.Duhamel(tolerance=1e-4) else "above tolerance"
    assert chart.status.tolist() == [
        ["settled again", least, "above tolerance"],
        ["good", "above tolerance", "good"],
    ]


def test_a_scan_that_leaves_stability_open_is_warned_of(monkeypatch):
    def computed(process, speeds, gains, method, progress, of_growth, quickly):
        # One that is surely stable in spite of its error, and two that may not be.
        error = np.array([[0.0, 1e-3, 1.0, np.inf, 1e-9]])
        shape = error.shape
        return Dominant(np.full(shape, 0.5 + 0j), np.zeros(shape), error, np.full(shape, 12), error > 1)

    monkeypatch.setattr(import_module("lobex.limits.scan"), "dominant_over_grid", computed)
    with pytest.warns(lobex.SweepWarning, match="2 of 5 samples of the scan have an estimated error"):
        limit = lobex.critical_gain(ROD, 100.0, (1e5, 1e6), lobex.Duhamel(), scan=5)
    assert limit.status == ["none in range"]


@pytest.mark.parametrize("case", [c for c in LIMIT_CASES if c["problem"] == "rod-rub"][:3])
def test_critical_gain_of_the_map_brackets_the_limit(case):
    gains = np.linspace(4.5e4, 4.5e6, 200)
    chart = lobex.sweep(rub(5, case["damping_ratio"]), [case["speed_Hz"]], gains)
    limit = case["critical_contact_stiffness_N_per_m"]
    assert chart.critical_gain()[0] == pytest.approx(limit, abs=0.1 * (gains[1] - gains[0]))


def test_no_limit_in_the_range_is_nan():
    below = lobex.sweep(ROD, [85.0], [1e5, 2e5])
    above = lobex.sweep(ROD, [85.0], [2e6, 3e6])
    assert np.isnan(below.critical_gain()).all()
    assert np.isnan(above.critical_gain()).all()


class _Broken(lobex.Rub):
    """A rub that fails above 100 Hz, as a model outside its range would."""

    def system(self, speed, gain):
        system = super().system(speed, gain)
        return replace(system, blocks=jax.numpy.where(speed > 100, jax.numpy.nan, system.blocks))


def test_failed_points_are_nan_and_counted_in_one_warning():
    cls = lobex._pytree.pytree()(_Broken)
    with pytest.warns(lobex.SweepWarning, match="4 of 6 points failed"):
        chart = lobex.sweep(cls(ROD.modes), [80.0, 120.0, 160.0], [1e5, 1e6])
    assert chart.failed == 4
    assert chart.status.tolist() == [["good"] * 2, ["failed"] * 2, ["failed"] * 2]
    assert np.isfinite(chart.spectral_radius[0]).all()
    assert np.isnan(chart.spectral_radius[1:]).all()
    assert np.isnan(chart.chatter_frequency[1:]).all()
    assert chart.spectral_radius[0] == pytest.approx(lobex.spectral_radius(ROD, 80.0, [1e5, 1e6]))
    with pytest.raises(ValueError, match="its structure has values that are not finite at speed = 1"):
        lobex.sweep(cls(ROD.modes), [120.0, 160.0], [1e5, 1e6])


def test_the_method_is_chosen_by_the_process():
    rub_chart = lobex.sweep(ROD, [100.0, 200.0], [1e5, 1e6])
    mill_chart = lobex.sweep(MILL, [100.0, 200.0], [1e-4, 1e-3])
    assert rub_chart.method["type"] == "CharacteristicRoots"
    assert mill_chart.method["type"] == "Duhamel"
    by_operator = lobex.sweep(ROD, [100.0, 200.0], [1e5, 1e6], lobex.Duhamel())
    assert rub_chart.multiplier == pytest.approx(by_operator.multiplier, rel=1e-8)
    assert rub_chart.chatter_frequency == pytest.approx(by_operator.chatter_frequency, rel=1e-7)
    assert np.all(rub_chart.error < 1e-12)


def test_oddities_are_warned_of():
    with pytest.warns(lobex.SweepWarning, match="more nodes"):
        lobex.sweep(ROD, [4.0, 5.0], [1e5, 2e5], lobex.Chebyshev(16))
    with pytest.warns(lobex.LobexWarning, match="rpm/60"):
        lobex.sweep(rub(2), [3000.0, 4000.0], [1e5, 2e5])


@pytest.mark.parametrize(
    "process",
    [
        rub(2),
        lobex.Rub(lobex.Modes([1e30, 3e30], [0.03, 0.03], [[1.0], [1.0]])),
        rub(2, damping_ratio=1e60),
        MILL,
        lobex.DelayedMathieu(delta=3.0, epsilon=1e60),
    ],
)
@pytest.mark.filterwarnings("ignore::lobex.LobexWarning")
def test_what_moves_too_fast_for_double_precision_is_refused(process):
    for call in (
        lambda: lobex.sweep(process, [100.0, 200.0], [1e5, 1e60]),
        lambda: lobex.critical_gain(process, [100.0, 200.0], (1e5, 1e60)),
    ):
        with pytest.raises(ValueError, match=r"up to gain = 1e\+60 the model moves through \S+ rad per period"):
            call()


LARGE = r"""
import re, numpy as np, lobex
tool = lobex.Modes.single(frequency=146.5, damping_ratio=0.0032, mass=2.573)
mill = lobex.Milling(tool, teeth=1, tangential=5.5e8, normal=2e8, radial_immersion=0.5)
chart = lobex.sweep(mill, np.linspace(4e3, 25e3, 500) / 60, np.linspace(0, 5e-3, 200), lobex.Chebyshev(20))
assert chart.failed == 0 and np.isfinite(chart.spectral_radius).all()
print(int(re.search(r"VmHWM:\s*(\d+)", open("/proc/self/status").read()).group(1)) / 1e6)
"""


@pytest.mark.timeout(400)
def test_a_hundred_thousand_points_end_within_memory():
    # jax 0.10.0 to 0.11.0 hangs here for ever: the time-out is the assertion.
    done = subprocess.run([sys.executable, "-c", LARGE], capture_output=True, text=True, timeout=360)
    assert done.returncode == 0, done.stderr
    assert float(done.stdout) < 2.0


MANY_SOLVES = """
import numpy as np, lobex
radius = lobex.spectral_radius(lobex.Rub(lobex.Rod(3).modes()), np.linspace(80, 400, 2000)[:, None], [1e5, 1e6],
                               lobex.Chebyshev(20))
assert np.isfinite(radius).all()
"""


@pytest.mark.timeout(300)
def test_one_large_batch_of_dense_solvers_ends():
    done = subprocess.run([sys.executable, "-c", MANY_SOLVES], capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stderr
