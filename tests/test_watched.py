"""What is watched of a beam: its tip, its root and the stress there, against statics, and in a march of wear."""

import numpy as np
import pytest

import lobex
from refusals import refused

LENGTH, WIDTH, THICKNESS = 0.2, 0.05, 0.008


def beam(stagger=0.0, **others):
    return lobex.Beam.rectangular(
        elements=3,
        length=LENGTH,
        width=WIDTH,
        thickness=THICKNESS,
        young_modulus=110e9,
        density=4430.0,
        stagger_degrees=stagger,
        **others,
    )


def bent(blade, force):
    """What is watched where constant forces (radial, tangential, axial) pull at the tip: tip (3), root (6), stress."""
    seen = blade.watch(tip=True, root_loads=True, stress_at=[[WIDTH / 2, THICKNESS / 2], [-WIDTH / 2, THICKNESS / 2]])
    _, stiffness, _, _ = blade.matrices()
    return seen.T @ np.linalg.solve(stiffness, seen[:, :3] @ force)


def test_a_root_holds_what_pulls_at_the_tip():
    radial, tangential, axial = 300.0, 20.0, -7.0
    _, root, _ = np.split(bent(beam(25.0), [radial, tangential, axial]), [3, 9])
    forces = [-radial, -tangential, -tangential * LENGTH, -axial, -axial * LENGTH, 0.0]
    assert root == pytest.approx(forces, rel=1e-9, abs=1e-7)


def test_a_root_on_springs_holds_as_a_clamp_does():
    springs = np.array([1e9, 1e9, 1e7, 1e9, 1e7, 1e7])
    force = [300.0, 20.0, -7.0]
    for one, other in ((3, 9), (9, 11)):
        clamped, sprung = (bent(blade, force)[one:other] for blade in (beam(25.0), beam(25.0, root_stiffness=springs)))
        assert sprung == pytest.approx(clamped, rel=1e-6, abs=1e-6)


def test_stress_at_the_root_is_that_of_the_books():
    """Corners of a rectangle under a force across the chord, along it, and along the span."""
    flap, edge = WIDTH * THICKNESS**3 / 12, THICKNESS * WIDTH**3 / 12
    # Without stagger the chord is axial and its normal tangential.
    expected = -10 * LENGTH * THICKNESS / 2 / flap
    assert bent(beam(), [0.0, 10.0, 0.0])[9:] == pytest.approx([expected, expected], rel=1e-9)
    along = 10 * LENGTH * WIDTH / 2 / edge
    assert bent(beam(), [0.0, 0.0, 10.0])[9:] == pytest.approx([-along, along], rel=1e-9)
    assert bent(beam(), [10.0, 0.0, 0.0])[9:] == pytest.approx(np.full(2, 10 / (WIDTH * THICKNESS)), rel=1e-9)
    turned = np.radians(30.0)
    across = [0.0, 10 * np.cos(turned), -10 * np.sin(turned)]
    assert bent(beam(30.0), across)[9:] == pytest.approx([expected, expected], rel=1e-9)


def test_a_march_records_what_is_watched():
    """The tip's displacement along the normal, watched, is that of the contact, of a turning blade too."""
    blade, normal = beam(30.0), np.array([0.9, 0.1, 0.3])
    contact = {"normal": normal, "sliding": (0.0, 3.0, -1.0), "friction": 0.2}
    watched = blade.watch(tip=True, root_loads=True)
    turning = blade.rotating(0.03, [1, 2, 3], watched=watched, **contact)
    alone = blade.rotating(0.03, [1, 2, 3], **contact)
    law, casing = lobex.Linear(1e5), lobex.Casing(amplitude=5e-5)
    with_it = lobex.march_wear(turning, casing, law, [80.0, 90.0], 2, 1024, watched=9)
    without = lobex.march_wear(alone, casing, law, [80.0, 90.0], 2, 1024)
    assert with_it.watched.shape == (2, 9, 1024)
    along = np.einsum("nks,k->ns", with_it.watched[:, :3], normal / np.linalg.norm(normal))
    assert along == pytest.approx(with_it.displacement, rel=1e-6, abs=1e-7 * np.max(np.abs(along)))
    assert with_it.depth == pytest.approx(without.depth, rel=1e-9, abs=1e-16)
    assert np.all(with_it.watched_amplitude[:, 3:8].max(axis=2) > 0)
    ax = with_it.plot_tip_orbit(90.0, directions=("axial", "radial"), revolutions=2)
    (before, end), (last,) = ax.lines, ax.collections
    axial, radial = 1e6 * with_it.watched[1, [2, 0]]
    assert np.array(last.get_segments())[:, 1] == pytest.approx(np.stack([axial, radial], axis=1)[512:])
    # Two revolutions are all there are: nothing is before the first.
    assert np.asarray(before.get_xydata()) == pytest.approx(np.stack([axial, radial], axis=1)[:512])
    assert np.asarray(end.get_xydata())[0] == pytest.approx([axial[-1], radial[-1]])
    assert ax.get_xlabel() == "axial displacement of the tip (µm)"
    (one,) = with_it.plot_tip_orbit(90.0).collections
    # From where the revolution before it ended, along the motion and across.
    assert np.array(one.get_segments())[[0, -1], 0, 1] == pytest.approx(axial[[511, -2]])
    for arguments, words in (
        ((["radial", "radial"],), "give two of radial, tangential, axial"),
        ((("radial", "up"),), "directions = 'up'"),
        ((("radial", "axial"), 3), "revolutions = 3 is more"),
    ):
        with refused(words):
            with_it.plot_tip_orbit(90.0, None, *arguments)
    with refused("march watched 0 outputs"):
        without.plot_tip_orbit(90.0)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: beam().watch(), "watch takes nothing"),
        (lambda: beam().watch(stress_at=[1.0]), "stress_at has shape (1,)"),
        (lambda: beam().modes(0.01, watched=np.ones((3, 2))), "watched has shape (3, 2); give what watch() makes"),
        (
            lambda: lobex.march_wear(beam().modes(0.01, [1]), lobex.Casing(), lobex.Linear(1.0), [50.0], watched=1),
            "watched = 1 leaves no contact",
        ),
    ],
)
def test_what_cannot_be_watched_is_refused(call, words):
    with refused(words):
        call()
