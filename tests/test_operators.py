"""The operators against the thesis' own formulas, written out, and their parts against scipy."""

import jax
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import expm

import lobex
from cases import MILL, MULTIPLIER_TOOLS, ROD, milling
from lobex.operators.chebyshev import chebyshev_points, differentiation_matrix, quadrature_weights
from lobex.operators.exponential import exponential, scaled_exponential

TOOL = MULTIPLIER_TOOLS["Insperger-Stepan"]


def nonzero(values, threshold=1e-7):
    """Values above the threshold, in an order that rounding does not change."""
    kept = values[np.abs(values) > threshold]
    return kept[np.lexsort((kept.imag.round(9), np.abs(kept).round(9)))]


def written_out_collocation(system, nodes):
    """(3.10)-(3.15) as the thesis states them, Kronecker products and all, on the whole state."""
    tau = float(system.period)
    drift, inputs, outputs = (np.asarray(m()) for m in (system.drift, system.input_matrix, system.output_matrix))
    d = len(drift)
    x = np.cos(np.pi * np.arange(nodes) / (nodes - 1))
    c = np.r_[2.0, np.ones(nodes - 2), 2.0] * (-1.0) ** np.arange(nodes)
    difference = x[:, None] - x + np.eye(nodes)
    derivative = np.outer(c, 1 / c) / difference
    derivative -= np.diag(derivative.sum(axis=1))
    phase = (x[:-1] + 1) / 2
    current, delayed = (np.asarray(m) for m in jax.tree.leaves(system.at(phase)))
    left = np.kron(derivative * 2 / tau, np.eye(d))
    right = np.zeros_like(left)
    left[-d:] = 0
    left[-d:, -d:] = np.eye(d)
    right[-d:, :d] = np.eye(d)
    for j in range(nodes - 1):
        here = np.s_[j * d : (j + 1) * d]
        left[here, here] -= drift + inputs @ current[j] @ outputs
        right[here, here] = inputs @ delayed[j] @ outputs
    return np.linalg.solve(left, right)


@pytest.mark.parametrize(
    ("process", "speed", "gain"),
    [(ROD, 112.0, 1.35e6), (MILL, 50.0, 1e-3), (milling(TOOL, 0.3, "up", 2), 83.0, 5e-4)],
)
def test_single_interval_is_the_thesis_operator(process, speed, gain):
    with jax.enable_x64(True):
        written = nonzero(np.linalg.eigvals(written_out_collocation(process.system(speed, gain), 32)))
    for full in (False, True):
        found = lobex.multipliers(process, speed, gain, lobex.Chebyshev(32, aligned=False, full=full))
        assert nonzero(found) == pytest.approx(written, rel=1e-6, abs=1e-10)
        assert found[0] == pytest.approx(written[-1], rel=1e-10) or found[0] == pytest.approx(
            written[-1].conj(), rel=1e-10
        )


def written_out_semi_discretization(process, speed, gain, k):
    """(3.19)-(3.23) of 1-DoF milling as Appendix A means them, from the entry of the tooth, K_s by quadrature."""
    with jax.enable_x64(True):
        cutting = process.system(speed, gain).terms[0].coefficient
        start, leave = float(cutting.entry), float(cutting.exit)
    omega, ratio = process.modes.angular_frequency[0], process.modes.damping_ratio[0]
    squared, step = process.modes.shape[0, 0] ** 2, 1 / speed / k

    def force(phi):
        turned = phi % (2 * np.pi)
        inside = start <= turned <= leave
        return inside * (process.tangential * np.cos(turned) + process.normal * np.sin(turned)) * np.sin(turned)

    total = np.eye(k + 2)
    for i in range(k):
        edges = start + 2 * np.pi * np.array([i, i + 1]) / k
        jumps = [p for p in (leave, start + 2 * np.pi) if edges[0] < p < edges[1]]
        mean = quad(force, *edges, points=jumps or None, epsabs=0, epsrel=1e-12)[0] / np.diff(edges)[0]
        push = gain * squared * mean
        a = np.array([[0.0, 1.0], [-(omega**2) - push, -2 * ratio * omega]])
        p = expm(a * step)
        r = (p - np.eye(2)) @ np.linalg.inv(a) @ np.array([0.0, push])
        one = np.diag(np.ones(k + 1), -1)
        one[:2], one[2] = 0, 0
        one[2, 0] = 1
        one[:2, :2] = p
        one[:2, k] = one[:2, k + 1] = r / 2
        total = one @ total
    return np.linalg.eigvals(total)


def test_semi_discretization_is_the_thesis_operator():
    k, speed, gain = 24, 50.0, 2e-3
    written = nonzero(written_out_semi_discretization(MILL, speed, gain, k), 1e-4)
    for full in (False, True):
        found = lobex.multipliers(MILL, speed, gain, lobex.SemiDiscretization(k, full=full))
        assert nonzero(found, 1e-4) == pytest.approx(written, rel=1e-8, abs=1e-11)


METHODS = [
    lobex.Chebyshev(18),
    lobex.Chebyshev(18, aligned=False),
    lobex.SemiDiscretization(16),
    lobex.SemiDiscretization(16, order=1),
    lobex.SemiDiscretization(16, order=2),
]
PROCESSES = [
    (lobex.Rub(lobex.Rod(3).modes()), 200.0, 8e5),
    (milling(TOOL, 0.2, "down", 2), 90.0, 6e-4),
    (lobex.Scalar(-0.5), 1.0, -1.0),
]


@pytest.mark.parametrize(("process", "speed", "gain"), PROCESSES)
@pytest.mark.parametrize("method", METHODS, ids=repr)
def test_reduced_and_full_forms_share_their_nonzero_multipliers(process, speed, gain, method):
    whole = type(method)(**{**vars(method), "full": True})
    reduced, full = (lobex.multipliers(process, speed, gain, m) for m in (method, whole))
    with jax.enable_x64(True):
        system = process.system(speed, gain)
        assert [len(reduced), len(full)] == [m.size(system) for m in (method, whole)]
    assert len(full) >= len(reduced)
    leading = reduced[np.abs(reduced) > 1e-2]
    assert len(leading) > 0
    for mu in leading:
        assert np.min(np.abs(full - mu)) < 1e-11 * max(1, abs(reduced[0]))


@pytest.mark.parametrize("method", [lobex.Chebyshev(30), lobex.SemiDiscretization(48)], ids=repr)
def test_the_chatter_frequency_is_that_of_the_output_in_both_forms(method):
    process, speed, gain = PROCESSES[1]
    whole = type(method)(**{**vars(method), "full": True})
    charts = [lobex.sweep(process, [speed], [gain], m) for m in (method, whole)]
    assert charts[0].chatter_frequency == pytest.approx(charts[1].chatter_frequency, rel=1e-9)


def test_reduced_rod_operator_has_50_rows_and_the_full_one_390():
    assert lobex.monodromy(ROD, 85.0, 1e6).shape == (50, 50)
    assert lobex.monodromy(ROD, 85.0, 1e6, lobex.Chebyshev(40)).shape == (48, 48)
    assert lobex.monodromy(ROD, 85.0, 1e6, lobex.Chebyshev(40, full=True)).shape == (400 - 10, 400 - 10)


@pytest.mark.parametrize("teeth", [1, 2, 3, 4, 5, 8])
@pytest.mark.parametrize("immersion", [0.05, 0.25, 0.5, 0.75, 0.9, 1.0])
@pytest.mark.parametrize("direction", ["up", "down"])
def test_milling_pieces_and_means_agree_with_the_screen_function(teeth, immersion, direction):
    tool = {**TOOL, "teeth": teeth}
    process = milling(tool, immersion, direction, 2)
    with jax.enable_x64(True):
        cutting = process.system(100.0, 1e-3).terms[0].coefficient
        pieces = cutting.pieces()
        assert sum(float(p.length) for p in pieces) == pytest.approx(1)
        total = np.zeros((2, 2))
        x, w = np.polynomial.legendre.leggauss(40)
        scale = 1e-3 * tool["tangential_N_per_m2"]
        for piece in pieces:
            start, length = float(piece.start), float(piece.length)
            inside = start + length * np.concatenate([[0.011, 0.3, 0.77, 0.987], (x + 1) / 2])
            anywhere, within = (np.asarray(values) for values in _looked_up(cutting, inside))
            assert within[:4] == pytest.approx(anywhere[:4], abs=1e-9 * scale)
            if piece.idle is True:
                assert not anywhere.any()
            total += length / 2 * np.einsum("k,kab->ab", w, within[4:])
        start = float(pieces[0].start)
        edges = start + np.arange(8) / 7
        mean, *parts = np.asarray(_averaged(cutting, np.r_[start, edges[:-1]], np.r_[start + 1, edges[1:]]))
        assert mean == pytest.approx(total, abs=1e-10 * scale)
        assert np.mean(parts, axis=0) == pytest.approx(total, abs=1e-10 * scale)


@jax.jit
def _looked_up(cutting, inside):
    return cutting.at(inside), cutting.within(inside[1], inside)


@jax.jit
def _averaged(cutting, start, stop):
    return cutting.mean(start, stop)


@pytest.mark.parametrize("nodes", [2, 3, 8, 40])
def test_differentiation_and_quadrature_are_exact_on_polynomials(nodes):
    x, derivative, weights = chebyshev_points(nodes), differentiation_matrix(nodes), quadrature_weights(nodes)
    for degree in range(min(nodes, 12)):
        slope = degree * x ** max(degree - 1, 0)
        assert derivative @ x**degree == pytest.approx(slope, abs=1e-10)
        assert weights @ x**degree == pytest.approx(1 / (degree + 1), abs=1e-13)


@pytest.mark.parametrize("size", [1, 2, 3, 9])
def test_exponentials_against_scipy(size):
    rng = np.random.default_rng(size)
    matrices, exact, scale = [], [], []
    for norm in np.repeat([1e-9, 0.3, 3.0, 50.0, 700.0], 5):
        matrix = rng.standard_normal((size, size))
        matrix -= np.max(np.linalg.eigvals(matrix).real) * np.eye(size)
        matrix *= norm / np.abs(matrix).sum(axis=0).max() if size > 1 else norm
        matrices.append(matrix)
        exact.append(expm(matrix))
        scale.append(np.abs(exact[-1]).max() * max(norm, 1))
    with jax.enable_x64(True):
        for function in (exponential, scaled_exponential):
            error = np.abs(np.asarray(jax.jit(jax.vmap(function))(np.array(matrices))) - exact)
            assert np.all(error.max(axis=(1, 2)) <= 1e-13 * np.array(scale))


def test_exponential_of_critical_damping_and_its_derivative():
    with jax.enable_x64(True):

        def corner(ratio):
            return exponential(np.array([[0.0, 1.0], [-1.0, 0.0]]) - 2 * ratio * np.array([[0.0, 0.0], [0.0, 1.0]]))

        for ratio in (0.999999, 1.0, 1.000001):
            exact = expm(np.array([[0.0, 1.0], [-1.0, -2 * ratio]]))
            assert np.asarray(corner(ratio)) == pytest.approx(exact, abs=1e-14)
        slope = jax.jacobian(corner)(1.0)
        step = 1e-5
        assert np.asarray(slope) == pytest.approx(
            np.asarray(corner(1 + step) - corner(1 - step)) / (2 * step), abs=1e-9
        )


def test_exponential_beyond_its_bound_is_nan_and_not_a_number():
    assert np.isnan(scaled_exponential(np.diag([-2e4, 1.0, 1.0]))).all()
