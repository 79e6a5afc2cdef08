"""Modes of the rod and of anybody's matrices."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

import lobex


def test_thirty_elements_have_the_thesis_frequencies():
    frequency = lobex.Rod(30).modes().frequency[:5]
    assert frequency == pytest.approx([337.8706, 1014.5382, 1693.9877, 2378.0818, 3068.6931], abs=5e-5)


def test_rod_frequencies_in_closed_form():
    # Linear elements of length h: ω² = (6E/ρh²)(1 − cos kh)/(2 + cos kh) at the wave numbers k = (2j−1)π/2L.
    rod = lobex.Rod(12, young_modulus=7e10, density=2700.0, length=0.3, area=2e-4)
    h = 0.3 / 12
    cosine = np.cos((2 * np.arange(1, 13) - 1) * np.pi / 0.6 * h)
    exact = np.sqrt(6 * 7e10 / (2700 * h**2) * (1 - cosine) / (2 + cosine))
    assert rod.modes().angular_frequency == pytest.approx(exact, rel=1e-11)


def test_matrices_agree_with_the_modes():
    rod, ratio = lobex.Rod(6), np.linspace(0.01, 0.06, 6)
    mass, stiffness, damping = rod.matrices(ratio)
    squared, vectors = scipy.linalg.eigh(stiffness, mass)
    modes = rod.modes(ratio)
    assert modes.angular_frequency == pytest.approx(np.sqrt(squared), rel=1e-11)
    assert np.abs(modes.shape[:, 0]) == pytest.approx(np.abs(vectors[-1]), rel=1e-10)
    modal = vectors.T @ damping @ vectors
    assert modal == pytest.approx(np.diag(2 * ratio * np.sqrt(squared)), abs=1e-8 * modal.max())
    for matrix in (mass, stiffness, damping):
        assert matrix == pytest.approx(matrix.T, abs=1e-12 * np.abs(matrix).max())


def test_keep_counts_from_one_and_keeps_order():
    rod = lobex.Rod(5)
    all_modes, kept = rod.modes(0.02), rod.modes([0.01, 0.04], keep=(1, 3))
    assert kept.angular_frequency == pytest.approx(all_modes.angular_frequency[[0, 2]], rel=1e-15)
    assert kept.damping_ratio.tolist() == [0.01, 0.04]
    assert all_modes.select([2]).angular_frequency == pytest.approx(all_modes.angular_frequency[1:2])


@pytest.mark.parametrize("form", [np.asarray, scipy.sparse.csr_array, scipy.sparse.csc_matrix])
@pytest.mark.parametrize("keep", [None, (1, 2, 4)])
def test_modes_from_matrices(form, keep):
    rod = lobex.Rod(20)
    mass, stiffness, _ = rod.matrices()
    tip = np.eye(20)[-1]
    modes = lobex.Modes.from_matrices(form(mass), form(stiffness), tip, 0.02, keep)
    expected = rod.modes(0.02, keep)
    assert modes.angular_frequency == pytest.approx(expected.angular_frequency, rel=1e-9)
    assert np.abs(modes.shape) == pytest.approx(np.abs(expected.shape), rel=1e-7)
    assert modes.damping_ratio == pytest.approx(expected.damping_ratio)


def test_two_contact_directions():
    mass, stiffness = np.diag([2.0, 3.0]), np.diag([2e6, 9e6])
    modes = lobex.Modes.from_matrices(mass, stiffness, np.eye(2), 0.01)
    x = lobex.Modes.single(frequency=1000 / (2 * np.pi), damping_ratio=0.01, mass=2.0)
    y = lobex.Modes.single(frequency=np.sqrt(3e6) / (2 * np.pi), damping_ratio=0.01, mass=3.0)
    both = lobex.Modes.plane(x=x, y=y)
    for found, given in zip(jax.tree.leaves(modes), jax.tree.leaves(both), strict=True):
        assert np.abs(found) == pytest.approx(np.abs(given))


def test_gradients_flow_through_the_eigenproblem():
    with jax.enable_x64(True):

        def first(young_modulus, density):
            modes = lobex.Rod(5, young_modulus=young_modulus, density=density).modes()
            return modes.angular_frequency[0], modes.shape[0, 0] ** 2

        slopes = [jax.jacobian(first, index)(210e7, 4600.0) for index in (0, 1)]
    omega, squared = (float(value) for value in first(210e7, 4600.0))
    by_modulus, by_density = ([float(value) for value in pair] for pair in slopes)
    # ω ~ √(E/ρ), φ² ~ 1/ρ.
    assert by_modulus[0] * 210e7 / omega == pytest.approx(0.5, rel=1e-10)
    assert by_density[0] * 4600 / omega == pytest.approx(-0.5, rel=1e-10)
    assert abs(by_modulus[1] * 210e7 / squared) < 1e-9
    assert by_density[1] * 4600 / squared == pytest.approx(-1, rel=1e-9)


def test_modes_trace_under_jit():
    with jax.enable_x64(True):
        traced = jax.jit(lambda e: lobex.Rod(5, young_modulus=e).modes(jnp.array(0.03)))(210e7)
    assert np.asarray(traced.angular_frequency) == pytest.approx(lobex.Rod(5).modes().angular_frequency, rel=1e-12)


def square(value):
    return np.full((3, 3), 0.0) + np.diag(value)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: lobex.Rod(0), "elements = 0"),
        (lambda: lobex.Rod(2.5), "elements = 2.5"),
        (lambda: lobex.Rod(True), "elements = True"),
        (lambda: lobex.Rod(density=-1.0), "density = -1"),
        (lambda: lobex.Rod(length=np.nan), "length = nan"),
        (lambda: lobex.Rod(area="wide"), "area = 'wide'"),
        (lambda: lobex.Rod(young_modulus=np.inf), "young_modulus = inf"),
        (lambda: lobex.Rod().modes(-0.1), "damping_ratio = -0.1"),
        (lambda: lobex.Rod().modes([0.1, 0.2]), "damping_ratio has shape (2,)"),
        (lambda: lobex.Rod().modes(keep=[0]), "keep = 0"),
        (lambda: lobex.Rod().modes(keep=[6]), "mode 6 of 5"),
        (lambda: lobex.Rod().modes(keep=[1, 1]), "names a mode twice"),
        (lambda: lobex.Rod().modes(keep=3), "keep = 3"),
        (lambda: lobex.Modes.single(frequency=0.0, damping_ratio=0.1, mass=1.0), "frequency = 0"),
        (lambda: lobex.Modes.single(frequency=10.0, damping_ratio=0.1, mass=-1.0), "mass = -1"),
        (lambda: lobex.Modes([1.0, 2.0], [0.1], [[1.0], [1.0]]), "damping_ratio has shape (1,)"),
        (lambda: lobex.Modes([1.0, 2.0], [0.1, 0.1], [1.0, 1.0]), "shape has shape (2,)"),
        (lambda: lobex.Modes([1.0, np.nan], [0.1, 0.1], [[1.0], [1.0]]), "angular_frequency"),
        (lambda: lobex.Modes.from_matrices(square([1, 1, 0]), np.eye(3), np.eye(3)[0], 0.1), "mass is singular"),
        (lambda: lobex.Modes.from_matrices(np.eye(3), square([1, 1, 0]), np.eye(3)[0], 0.1), "stiffness"),
        (lambda: lobex.Modes.from_matrices(np.eye(3), np.eye(2), np.eye(3)[0], 0.1), "stiffness has shape (2, 2)"),
        (lambda: lobex.Modes.from_matrices(np.eye(3), np.ones((3, 2)), np.eye(3)[0], 0.1), "square"),
        (lambda: lobex.Modes.from_matrices(np.triu(np.ones((3, 3))), np.eye(3), np.eye(3)[0], 0.1), "not symmetric"),
        (lambda: lobex.Modes.from_matrices(np.eye(3), np.eye(3), np.eye(2)[0], 0.1), "contact has shape (2,)"),
    ],
)
def test_bad_structures_are_refused_in_one_line(call, words):
    with pytest.raises(ValueError) as error:
        call()
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_singular_sparse_mass_is_refused():
    mass = scipy.sparse.diags_array(np.r_[0.0, np.ones(19)])
    stiffness = scipy.sparse.csr_array(lobex.Rod(20).matrices()[1])
    with pytest.raises(ValueError, match="mass is singular"):
        lobex.Modes.from_matrices(mass, stiffness, np.eye(20)[-1], 0.02, keep=(1, 2))


def test_modes_made_of_lists_are_arrays() -> None:
    listed = lobex.Modes([900.0, 3000.0], [0.01, 0.02], [[1.0], [0.5]])
    made = lobex.Modes(np.array([900.0, 3000.0]), np.array([0.01, 0.02]), np.array([[1.0], [0.5]]))
    radius = [float(lobex.spectral_radius(lobex.Rub(modes), 100.0, 1e5)) for modes in (listed, made)]
    assert radius[0] == radius[1]
