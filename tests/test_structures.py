"""Modes of the rod and of anybody's matrices."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

import lobex
from receptance_of_modes import of_modes
from refusals import refused


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
    with refused(words):
        call()


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


# --- matrices as finite-element programs write them


def beam(elements, lumped=False):
    """A free Euler-Bernoulli beam, translation and rotation node by node: (mass, stiffness), N, kg, m."""
    length, modulus, density, width = 0.3 / elements, 210e9, 7800.0, 0.02
    bending, mass_per_length = modulus * width**4 / 12, density * width**2
    a, b, c, d = 12.0, 6 * length, 4 * length**2, 2 * length**2
    element = np.array([[a, b, -a, b], [b, c, -b, d], [-a, -b, a, -b], [b, d, -b, c]]) * bending / length**3
    a, b, c, d, e, f = 156.0, 22 * length, 54.0, 13 * length, 4 * length**2, 3 * length**2
    inertia = np.array([[a, b, c, -d], [b, e, d, -f], [c, d, a, -b], [-d, -f, -b, e]]) * mass_per_length * length / 420
    if lumped:
        inertia = np.diag([0.5, 0.0, 0.5, 0.0]) * mass_per_length * length
    mass, stiffness = np.zeros((2, 2 * elements + 2, 2 * elements + 2))
    for first in range(0, 2 * elements, 2):
        part = slice(first, first + 4)
        mass[part, part] += inertia
        stiffness[part, part] += element
    return mass, stiffness


def reference(mass, stiffness):
    """ω and mass-normalised vectors by scipy, from K⁻¹M: the first ones keep all their digits."""
    inverse, vectors = scipy.linalg.eigh(mass, stiffness)
    return inverse[::-1] ** -0.5, vectors[:, ::-1] / np.sqrt(inverse[::-1])


MASS, STIFFNESS = beam(10)
TIP = np.eye(22)[-2]
CLAMPED = np.arange(2, 22)
OWN, VECTORS = reference(*(matrix[2:, 2:] for matrix in (MASS, STIFFNESS)))
FORMS = pytest.mark.parametrize("form", [np.asarray, scipy.sparse.csr_array], ids=["dense", "sparse"])


def test_the_reference_is_the_cantilever_of_the_books():
    bar = 1.8751040687119611**2 / 0.3**2 * np.sqrt(210e9 * 0.02**2 / 12 / 7800)
    assert OWN[0] == pytest.approx(bar, rel=1e-6)


@FORMS
@pytest.mark.parametrize("keep", [None, (1, 2, 4)])
@pytest.mark.parametrize("penalty", ["Abaqus", 1e8, 1e12, 1e17])
def test_a_penalty_fixes_degrees_of_freedom_and_costs_the_others_nothing(form, keep, penalty):
    stiffness = STIFFNESS.copy()
    stiffness[[0, 1], [0, 1]] = 1e36 if penalty == "Abaqus" else penalty * STIFFNESS.max()
    modes = lobex.Modes.from_matrices(form(MASS), form(stiffness), TIP, 0.02, keep)
    kept = np.arange(4) if keep is None else np.array(keep) - 1
    # A penalty of 1e8 gives way by its own share.
    assert modes.angular_frequency[: len(kept)] == pytest.approx(OWN[kept], rel=2e-8 if penalty == 1e8 else 1e-9)
    assert np.abs(modes.shape[: len(kept), 0]) == pytest.approx(np.abs(VECTORS[-2, kept]), rel=1e-7)
    if penalty == "Abaqus" and keep is None:
        assert modes.count == 20


@FORMS
@pytest.mark.parametrize("triangle", ["lower", "upper"])
def test_one_triangle_is_taken_by_symmetry_when_told(form, triangle):
    part = np.tril if triangle == "lower" else np.triu
    stiffness = STIFFNESS + np.diag(np.r_[1e36, 1e36, np.zeros(20)])
    stored = [form(part(matrix)) for matrix in (MASS, stiffness, 1e-5 * STIFFNESS + 2 * MASS)]
    options = {"contact": TIP, "keep": (1, 2)}
    modes = lobex.Modes.from_matrices(*stored[:2], **options, damping=stored[2], triangle=triangle)
    assert modes.angular_frequency == pytest.approx(OWN[:2], rel=1e-9)
    assert modes.damping_ratio == pytest.approx(1 / OWN[:2] + 0.5e-5 * OWN[:2], rel=1e-9)
    for given in ((stored[0], stiffness), (MASS, stored[1])):
        with pytest.raises(ValueError, match=f"only its {triangle} triangle is stored: give triangle='{triangle}'"):
            lobex.Modes.from_matrices(*given, **options, damping_ratio=0.01)
    other = "upper" if triangle == "lower" else "lower"
    with pytest.raises(ValueError, match="mass is not symmetric"):
        lobex.Modes.from_matrices(*stored[:2], **options, damping_ratio=0.01, triangle=other)


@FORMS
@pytest.mark.parametrize("keep", [None, (1, 3)])
def test_rotations_without_mass_follow_statically(form, keep):
    mass, stiffness = (matrix[2:, 2:] for matrix in beam(10, lumped=True))
    moving, massless = np.arange(0, 20, 2), np.arange(1, 20, 2)
    follow = -np.linalg.solve(stiffness[np.ix_(massless, massless)], stiffness[np.ix_(massless, moving)])
    condensed = stiffness[np.ix_(moving, moving)] + stiffness[np.ix_(moving, massless)] @ follow
    own, vectors = reference(mass[np.ix_(moving, moving)], condensed)
    kept = np.arange(10) if keep is None else np.array(keep) - 1
    seen = np.eye(20)[:, [-2, -1]]
    with pytest.raises(ValueError, match="10 of 20 degrees of freedom have none; give condense=True for static"):
        lobex.Modes.from_matrices(form(mass), form(stiffness), seen, 0.02, keep)
    modes = lobex.Modes.from_matrices(form(mass), form(stiffness), seen, 0.02, keep, condense=True)
    assert modes.angular_frequency == pytest.approx(own[kept], rel=1e-9)
    expected = np.stack([vectors[-1], (follow @ vectors)[-1]], axis=1)[kept]
    assert modes.shape * np.sign(modes.shape[:, :1]) == pytest.approx(expected * np.sign(expected[:, :1]), rel=1e-7)


@FORMS
def test_proportional_damping_becomes_modal(form):
    ratio = np.linspace(0.01, 0.06, 6)
    mass, stiffness, damping = lobex.Rod(6).matrices(ratio)
    tip = np.eye(6)[-1]
    modes = lobex.Modes.from_matrices(form(mass), form(stiffness), tip, damping=form(damping))
    assert modes.damping_ratio == pytest.approx(ratio, rel=1e-9)
    kept = lobex.Modes.from_matrices(form(mass), form(stiffness), tip, damping=form(damping), keep=[2, 5])
    assert kept.damping_ratio == pytest.approx(ratio[[1, 4]], rel=1e-9)
    # A mode without damping, beside one with.
    own, vectors = reference(mass, stiffness)
    one = np.outer(mass @ vectors[:, 3], mass @ vectors[:, 3])
    modes = lobex.Modes.from_matrices(form(mass), form(stiffness), tip, damping=form(one))
    assert modes.damping_ratio == pytest.approx(np.eye(6)[3] / (2 * own), abs=1e-15)


@pytest.mark.parametrize("size", [0.1, 1.0], ids=["vibrating", "overdamped"])
def test_two_directions_alike_have_the_receptance_of_their_matrices(size):
    """Of poles that are alike any vectors are, and an eigensolver's are not those of one direction each."""
    stiffness, damping = 1e4 * np.array([[3.0, -1.0], [-1.0, 2.0]]), size * 100 * np.array([[9.0, -4.0], [-4.0, 7.0]])
    turn = np.kron([[np.cos(0.6), np.sin(0.6)], [-np.sin(0.6), np.cos(0.6)]], np.eye(2))
    mass, stiffness, damping = (turn @ np.kron(np.eye(2), one) @ turn.T for one in (np.eye(2), stiffness, damping))
    contact = turn[:, [1, 3]]
    modes = lobex.Modes.from_matrices(mass, stiffness, contact, damping=damping)
    for s in (10 + 50j, 300j):
        expected = contact.T @ np.linalg.solve(s**2 * mass + s * damping + stiffness, contact)
        assert of_modes(modes, s) == pytest.approx(expected, rel=1e-11, abs=1e-18)


def test_a_force_in_another_direction_than_the_displacement():
    force = np.eye(22)[[-2, -1]].T @ [0.6, 0.8]
    fixed = [MASS, STIFFNESS + np.diag(np.r_[1e36, 1e36, np.zeros(20)])]
    modes = lobex.Modes.from_matrices(*fixed, TIP, 0.02, (1, 2, 3), force=force)
    expected = VECTORS[-2, :3] * (0.6 * VECTORS[-2, :3] + 0.8 * VECTORS[-1, :3])
    assert (modes.shape * modes.force_shape)[:, 0] == pytest.approx(expected, rel=1e-7)


def test_gradients_flow_past_a_penalty():
    stiffness = np.tril(STIFFNESS) + np.diag(np.r_[1e36, 1e36, np.zeros(20)])
    with jax.enable_x64(True):

        def first(share):
            matrices = MASS, share * jnp.asarray(stiffness)
            options = {"keep": (1, 2), "damping": 1e-5 * matrices[1], "triangle": "lower"}
            modes = lobex.Modes.from_matrices(*matrices, TIP, **options)
            return modes.angular_frequency[0], modes.damping_ratio[0]

        slopes = jax.jit(jax.jacfwd(first))(1.0)
    # ω ~ √K, and ξ = βω/2 with βK for a damping matrix.
    assert [float(slope) for slope in slopes] == pytest.approx([OWN[0] / 2, 0.25e-5 * OWN[0]], rel=1e-9)


def test_free_structures_are_refused():
    for mass, stiffness in ((MASS, STIFFNESS), (MASS[:-1, :-1], STIFFNESS[:-1, :-1])):
        contact = np.eye(len(mass))[-2]
        for form in (np.asarray, scipy.sparse.csr_array):
            with pytest.raises(ValueError, match=r"stiffness is singular.*; clamp rigid-body motion"):
                lobex.Modes.from_matrices(form(mass), form(stiffness), contact, 0.02, keep=[1, 2])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, "give either damping_ratio or damping"),
        ({"damping_ratio": 0.1, "damping": np.eye(3)}, "give either damping_ratio or damping"),
        ({"damping": np.eye(2)}, "damping has shape (2, 2) and mass (3, 3)"),
        ({"damping": np.triu(np.ones((3, 3)))}, "damping is not symmetric, by up to 1; only its upper triangle"),
        ({"damping": -np.eye(3)}, "damping (in the modes)"),
        ({"damping_ratio": 0.1, "force": np.eye(3)}, "force has shape (3, 3); give that of contact, (3,)"),
        ({"damping_ratio": 0.1, "triangle": "left"}, "triangle = 'left'"),
        ({"damping_ratio": 0.1, "mass": np.diag([1.0, 1.0, -1.0])}, "mass is singular or indefinite"),
        ({"damping_ratio": 0.1, "mass": np.diag([1.0, 1.0, -1.0]), "condense": True}, "mass is singular or indefinite"),
        ({"damping_ratio": 0.1, "mass": 5.0}, "mass has shape ()"),
        ({"damping_ratio": 0.1, "stiffness": np.diag([1.0, 1.0, -1.0])}, "stiffness is singular or indefinite"),
    ],
)
def test_matrices_are_refused_in_one_line(options, words):
    sound = {"mass": np.eye(3), "stiffness": np.diag([1.0, 2.0, 3.0]), "contact": np.eye(3)[0]}
    with refused(words):
        lobex.Modes.from_matrices(**{**sound, **options})
