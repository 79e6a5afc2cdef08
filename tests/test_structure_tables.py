"""Structures beyond modes of one model: tables, both ends flexible, damping that couples modes, modes over speed."""

import jax
import numpy as np
import pytest
import scipy.sparse

import lobex
from lobex.limits.closed_form import Regeneration, closed_form
from lobex.limits.receptance import receptance
from lobex.systems.coefficients import Constant
from lobex.systems.system import modal_system
from lobex.systems.terms import Regenerative
from refusals import refused

OMEGA = np.array([310.0, 950.0, 2700.0])
MASS, STIFFNESS = np.diag([2.0, 3.0, 1.0]), 1e6 * np.array([[3.0, -1.0, 0.0], [-1.0, 3.0, -1.0], [0.0, -1.0, 2.0]])
DAMPER = np.diag([0.0, 80.0, 10.0])
SEEN = np.eye(3)[:, :2]


def response(modes):
    """G(jω) of the equations that modes stand for, (ω, r, r)."""
    with jax.enable_x64(True):
        system = modal_system(modes, 1.0, (Regenerative(Constant(np.eye(modes.directions))),))
        drift, inputs, outputs = map(np.asarray, (system.drift(), system.input_matrix(), system.output_matrix()))
    return np.array([outputs @ np.linalg.solve(1j * w * np.eye(len(drift)) - drift, inputs) for w in OMEGA])


def of_matrices(damping, seen=SEEN, force=SEEN):
    return np.array([seen.T @ np.linalg.solve(STIFFNESS - w**2 * MASS + 1j * w * damping, force) for w in OMEGA])


def test_a_mode_has_its_stiffness_or_its_mass():
    by_mass = lobex.Modes.single(frequency=120.0, damping_ratio=0.02, mass=1.7)
    by_stiffness = lobex.Modes.single(frequency=120.0, damping_ratio=0.02, stiffness=1.7 * (240 * np.pi) ** 2)
    for found, given in zip(jax.tree.leaves(by_stiffness), jax.tree.leaves(by_mass), strict=True):
        assert found == pytest.approx(given, rel=1e-15)
    with jax.enable_x64(True):
        slope = jax.grad(lambda k: lobex.Modes.single(frequency=120.0, damping_ratio=0.02, stiffness=k).shape[0, 0])
        assert float(slope(2e6)) == pytest.approx(-0.5 * 240 * np.pi * 2e6**-1.5, rel=1e-12)


def test_a_table_has_modes_in_any_direction():
    frequency, ratio, stiffness = (
        np.array([50.0, 140.0, 300.0]),
        np.array([0.02, 0.03, 0.05]),
        np.array([2e6, 3e6, 9e6]),
    )
    along = np.array([[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 3.0, 4.0]])
    modes = lobex.Modes.from_table(frequency, ratio, stiffness=stiffness, direction=along)
    unit = along / np.linalg.norm(along, axis=1, keepdims=True)
    share = OMEGA[:, None] / (2 * np.pi * frequency)
    expected = np.einsum("wn,na,nb->wab", 1 / (stiffness * (1 - share**2 + 2j * ratio * share)), unit, unit)
    assert response(modes) == pytest.approx(expected, rel=1e-11, abs=1e-12 * np.abs(expected).max())


def test_axes_by_name_are_those_of_a_plane_and_of_space():
    single = {n: lobex.Modes.single(frequency=f, damping_ratio=0.02, mass=m) for n, f, m in
              (("x", 50.0, 1.0), ("y", 70.0, 2.0), ("z", 90.0, 3.0))}  # fmt: skip
    for names, made in (("xy", lobex.Modes.plane), ("xyz", lobex.Modes.space)):
        count = len(names)
        table = lobex.Modes.from_table([50, 70, 90][:count], 0.02, mass=[1.0, 2.0, 3.0][:count], direction=list(names))
        for found, given in zip(
            jax.tree.leaves(table), jax.tree.leaves(made(**{n: single[n] for n in names})), strict=True
        ):
            assert found == pytest.approx(given, rel=1e-15)


def test_receptances_of_tool_and_workpiece_add_up():
    tool = lobex.Modes.from_table([50.0, 90.0], 0.02, mass=1.5, direction=["x", "y"])
    part = lobex.Modes.from_matrices(MASS, STIFFNESS, SEEN, damping=DAMPER)
    both = lobex.Modes.relative(tool=tool, workpiece=part)
    assert response(both) == pytest.approx(response(tool) + response(part), rel=1e-10)
    # Displacements of the workpiece count against those of the tool.
    assert both.shape[2:] == pytest.approx(-part.shape)


@pytest.mark.parametrize("form", [np.asarray, scipy.sparse.csr_array], ids=["dense", "sparse"])
@pytest.mark.parametrize("size", [1.0, 300.0], ids=["vibrating", "with poles that are real"])
def test_damping_that_couples_modes_makes_complex_ones(form, size):
    model = form(MASS), form(STIFFNESS), SEEN
    modes = lobex.Modes.from_matrices(*model, damping=form(size * DAMPER))
    assert (np.max(modes.damping_ratio) > 1) == (size > 1)
    assert response(modes) == pytest.approx(of_matrices(size * DAMPER), rel=1e-9)
    aside = np.array([[0.6], [0.0], [0.8]])
    one = lobex.Modes.from_matrices(form(MASS), form(STIFFNESS), SEEN[:, :1], damping=form(size * DAMPER), force=aside)
    assert response(one) == pytest.approx(of_matrices(size * DAMPER, SEEN[:, :1], aside), rel=1e-9)
    assert receptance(one, OMEGA) == pytest.approx(response(one)[:, 0, 0], rel=1e-9)


def test_the_closed_form_of_complex_modes_has_the_receptance_of_their_matrices():
    tip = np.eye(3)[0]
    modes = lobex.Modes.from_matrices(MASS, STIFFNESS, tip, damping=DAMPER)
    found = closed_form(lobex.Rub(modes))
    assert isinstance(found, Regeneration)
    expected = of_matrices(DAMPER, tip[:, None], tip[:, None])[:, 0, 0]
    assert found.stiffness * receptance(found.receptance, OMEGA) == pytest.approx(expected, rel=1e-9)


def test_few_modes_of_a_damping_that_couples_many_tell_what_they_lose():
    with pytest.warns(lobex.LobexWarning, match=r"couples the mode of .* Hz to others .* 25 % of its force is lost"):
        kept = lobex.Modes.from_matrices(MASS, STIFFNESS, SEEN, damping=DAMPER, keep=[1, 2])
    # Those of the matrices in these two modes.
    own, vectors = np.linalg.eigh(np.diag([2.0, 3.0, 1.0] ** np.array(-0.5)) @ STIFFNESS @ np.diag(
        [2.0, 3.0, 1.0] ** np.array(-0.5)))  # fmt: skip
    basis = (np.array([2.0, 3.0, 1.0]) ** -0.5)[:, None] * vectors[:, :2]
    small = [basis.T @ matrix @ basis for matrix in (MASS, DAMPER, STIFFNESS)]
    expected = [
        SEEN.T @ basis @ np.linalg.solve(small[2] - w**2 * small[0] + 1j * w * small[1], basis.T @ SEEN) for w in OMEGA
    ]
    assert response(kept) == pytest.approx(np.array(expected), rel=1e-9)
    assert own[0] == pytest.approx(small[2][0, 0], rel=1e-9)


def test_poles_and_residues_of_a_modal_test_are_modes():
    pole = np.array([-8.0 + 500.0j, -20.0 + 1200.0j])
    u, v = np.array([[1.0, 0.4 + 0.2j], [0.3j, 1.0]]), np.array([[1.0, 0.5], [-0.2, 1.0 - 0.3j]])
    residue = -1e-3j * np.einsum("na,nb->nab", u, v)
    terms = residue / (1j * OMEGA[:, None] - pole)[..., None, None]
    terms = terms + residue.conj() / (1j * OMEGA[:, None] - pole.conj())[..., None, None]
    assert response(lobex.Modes.from_poles(pole, residue)) == pytest.approx(terms.sum(1), rel=1e-11)
    one = lobex.Modes.from_poles(pole, residue[:, 0, 1])
    assert response(one)[:, 0, 0] == pytest.approx(terms[..., 0, 1].sum(1), rel=1e-11)
    # Displacements that do not follow the force at once leave the velocity a state.
    with pytest.raises(ValueError, match="complex modes of which some are missing"):
        lobex.Turning(one, 1e9, diameter=0.02, process_damping=lobex.ProcessDamping(1e5))


def test_process_damping_of_complex_modes_is_that_of_their_matrices():
    tip, speed, depth = np.eye(3)[0], 60.0, 1e-4
    modes = lobex.Modes.from_matrices(MASS, STIFFNESS, tip, damping=DAMPER)
    damping = lobex.ProcessDamping(1e5)
    turning = lobex.Turning(modes, 1e9, diameter=0.02, process_damping=damping)
    rubbing = DAMPER + 1e5 * depth / (np.pi * 0.02 * speed) * np.outer(tip, tip)
    same = lobex.Modes.from_matrices(MASS, STIFFNESS, tip, damping=rubbing)
    roots = []
    with jax.enable_x64(True):
        for process in (turning, lobex.Turning(same, 1e9)):
            system = process.system(speed, depth)
            held = system.input_matrix() @ system.at(np.zeros(1)).present[0] @ system.output_matrix()
            roots.append(np.sort_complex(np.linalg.eigvals(np.asarray(system.drift() + held))))
    assert roots[0] == pytest.approx(roots[1], rel=1e-10)


def stiffening(speed, sign=1.0):
    """A blade of two modes."""
    omega = np.sqrt(np.array([400.0, 1500.0]) ** 2 + np.array([1.2, 4.0]) * (2 * np.pi * speed) ** 2)
    return lobex.Modes(omega, np.array([0.02, 0.03]), sign * np.array([[1.0], [0.8 + 1e-3 * speed]]))


def test_modes_over_speed_are_those_of_their_table_and_lines_between():
    table = lobex.ModesOverSpeed.from_modes(
        [20.0, 50.0, 80.0], [stiffening(20.0), stiffening(50.0, -1), stiffening(80.0)]
    )
    for found, given in zip(jax.tree.leaves(table.at(50.0)), jax.tree.leaves(stiffening(50.0)), strict=True):
        assert found == pytest.approx(given, rel=1e-14)
    between = table.at(65.0)
    assert between.angular_frequency == pytest.approx(
        (stiffening(50.0).angular_frequency + stiffening(80.0).angular_frequency) / 2, rel=1e-14
    )
    # Whatever the signs of its shapes.
    assert between.shape[:, 0] == pytest.approx([1.0, 0.865], rel=1e-14)
    rub = lobex.Rub(table)
    systems = rub.system(65.0, 1e5), lobex.Rub(between).system(65.0, 1e5)
    for found, given in zip(*map(jax.tree.leaves, systems), strict=True):
        assert found == pytest.approx(given, rel=1e-15)
    with pytest.raises(ValueError, match="speed = 90 Hz is outside the table of modes; give 20 to 80 Hz"):
        lobex.sweep(rub, [30.0, 90.0], [1e4])
    with jax.enable_x64(True):
        slope = jax.grad(lambda speed: table.at(speed).angular_frequency[0])(65.0)
        outside = jax.jit(lambda speed: table.at(speed).shape)(90.0)
    apart = stiffening(80.0).angular_frequency[0] - stiffening(50.0).angular_frequency[0]
    assert float(slope) == pytest.approx(apart / 30, rel=1e-12)
    assert np.isnan(np.asarray(outside)).all()


def test_a_limit_of_milling_is_that_of_the_modes_at_each_speed():
    rows = [lobex.Modes.single(frequency=frequency, damping_ratio=0.03, mass=1.0) for frequency in (563.6, 540.0)]
    table = lobex.ModesOverSpeed.from_modes([80.0, 120.0], rows)
    cut, search = {"tangential": 6.79e8, "normal": 1.7e8, "radial_immersion": 0.5}, {"bounds": (1e-4, 3e-2), "scan": 9}
    limit = lobex.critical_gain(lobex.Milling(table, 4, **cut), [90.0, 110.0], **search)
    assert list(limit.status) == ["found", "found"]
    for speed, gain in zip(limit.speed, limit.gain, strict=True):
        there = lobex.critical_gain(lobex.Milling(table.at(speed), 4, **cut), [speed, speed + 1], **search)
        assert gain == pytest.approx(there.gain[0], rel=1e-10)


ONE = lobex.Modes.single(frequency=50.0, damping_ratio=0.02, mass=1.0)
TWO = lobex.Modes.plane(x=ONE, y=ONE)
MIXED = lobex.Modes.from_poles([-1.0 + 50.0j], [1e-3 - 1e-2j])
ROW = {"frequency": [50.0, 70.0], "damping_ratio": 0.02, "mass": 1.0}


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: lobex.Modes.single(frequency=50.0, damping_ratio=0.02), "mass = None, stiffness = None: give one"),
        (lambda: lobex.Modes.single(frequency=50.0, damping_ratio=0.02, mass=1.0, stiffness=1e6), "give one of them"),
        (lambda: lobex.Modes.single(frequency=50.0, damping_ratio=0.02, stiffness=-1e6), "stiffness = -1e+06 must"),
        (lambda: lobex.Modes.from_table(**{**ROW, "mass": [1.0, 2.0, 3.0]}), "mass has shape (3,); give one number or"),
        (lambda: lobex.Modes.from_table(**ROW, direction=["x", "w"]), "direction = 'w' is unknown"),
        (
            lambda: lobex.Modes.from_table(**ROW, direction=["x", "y", "x"]),
            "direction has 3 axes; give one, or one per",
        ),
        (lambda: lobex.Modes.from_table(**ROW, direction=[[1.0, 0.0]]), "direction has shape (1, 2); give one vector"),
        (lambda: lobex.Modes.from_table(**ROW, direction=[[1.0, 0.0], [0.0, 0.0]]), "a vector of no length"),
        (lambda: lobex.Modes.plane(x=ONE, y=TWO), "y has 2 contact directions; give modes with one"),
        (lambda: lobex.Modes.relative(tool=ONE, workpiece=TWO), "tool has 1 contact directions and workpiece 2"),
        (lambda: lobex.Modes.relative(tool=ONE, workpiece=3.0), "workpiece = 3.0; give lobex.Modes"),
        (lambda: lobex.Modes.from_poles([-1.0 - 5j], [1e-3j]), "pole has parts of another sign"),
        (lambda: lobex.Modes.from_poles([-1.0 + 5j], [np.eye(2)]), "residue has several shapes in one mode"),
        (lambda: lobex.Modes.from_poles([-1.0 + 5j], [1.0, 2.0]), "residue has shape (2,) and pole (1,)"),
        (lambda: lobex.ModesOverSpeed.from_modes([20.0], [ONE]), "modes has 1 entries for 1 speeds"),
        (lambda: lobex.ModesOverSpeed.from_modes([20.0, 30.0], [ONE, TWO]), "modes differ in number or directions"),
        (lambda: lobex.Modes([1.0], [0.1], [[1.0]], quadrature=[1.0]), "quadrature has shape (1,); give that of shape"),
        (
            lambda: lobex.campbell(lobex.ModesOverSpeed.from_modes([20.0, 30.0], [ONE, ONE]), highest_speed=40.0),
            "highest_speed = 40 Hz is beyond the modes; give 30 Hz or less",
        ),
    ],
)
def test_tables_are_refused_in_one_line(call, words):
    with refused(words):
        call()
