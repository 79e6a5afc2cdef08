"""Places that delays carry to one another, and forces of one chip: against what is looked up between the nodes."""

from copy import copy
from dataclasses import replace

import jax
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lobex
from lobex.processes.specific_force import CHIP
from lobex.processes.teeth import ALONE, StraightTeeth
from lobex.systems.closed_places import closed_places, shares_of
from lobex.systems.links import Link, due_from_before
from lobex.systems.mesh import mesh_of

TOOL = lobex.Modes.plane(
    x=lobex.Modes.single(frequency=510.0, damping_ratio=0.02, mass=0.5),
    y=lobex.Modes.single(frequency=802.0, damping_ratio=0.018, mass=0.4),
)


METHOD = lobex.Duhamel(nodes=18)


def mill(pitch, immersion):
    return lobex.Milling(TOOL, lobex.Cutter.end_mill(pitch_degrees=pitch), 6e8, 2e8, immersion)


def laid_out(process, **changes):
    """The same with less known before tracing."""
    made = copy(process)
    object.__setattr__(made, "layout", process.layout._replace(**changes))
    return made


@jax.jit
def radii(process):
    with jax.enable_x64(True):
        operator = lobex.Duhamel(nodes=18).operator(process.system(130.0, 2e-3))
        return operator.matrix


def largest(process):
    with jax.enable_x64(True):
        values = np.linalg.eigvals(np.asarray(radii(process)))
    return np.sort(np.abs(values))[::-1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pitch", "immersion"),
    [
        ([70, 110, 70, 110], 0.5),
        ([100, 120, 140], 0.3),
        ([80, 95, 85, 100], 0.5),
    ],
)
def test_node_to_node_is_what_is_looked_up_between_the_nodes(pitch, immersion):
    process = mill(pitch, immersion)
    assert process.layout.places.closed is not None
    closed, apart = largest(process), largest(laid_out(process, places=process.layout.places._replace(closed=None)))
    # About half of the state.
    assert len(closed) < 0.55 * len(apart)
    assert closed[:6] == pytest.approx(apart[:6], rel=1e-9)


HELICAL = lobex.Milling(TOOL, lobex.Cutter.end_mill(0.016, pitch_degrees=[150, 210], helix_degrees=30.0), 6e8, 2e8, 0.4)


@pytest.mark.slow
def test_node_to_node_is_what_is_looked_up_between_the_nodes_with_a_helix_too():
    ((laid, served),) = HELICAL.by_gain(np.array([0.0, 2e-3]))
    assert served.all()
    closed, apart = largest(laid), largest(HELICAL)
    assert len(closed) < len(apart) / 2
    assert closed[:6] == pytest.approx(apart[:6], rel=1e-9)


def test_places_of_a_helix_are_in_one_order_between_two_depths():
    """Edges end where others begin at some depths, beyond which they are in another order."""
    depths = np.linspace(0, 0.02, 201)
    forms = list(HELICAL.by_gain(depths))
    assert len(forms) > 1
    assert np.all(sum(served.astype(int) for _, served in forms) <= 1)
    delays = [150 / 360, 210 / 360]
    with jax.enable_x64(True):
        for form, served in forms:
            for depth in depths[served][[0, -1]]:
                mesh = mesh_of(form.system(100.0, depth))
                assert np.min(mesh.length) > -1e-9
                assert np.sum(mesh.length) == pytest.approx(1, abs=1e-12)
                for link in mesh.links:
                    turns, reader = divmod(link.piece + link.later, mesh.pieces)
                    left = mesh.start[reader] + turns - delays[link.delay]
                    assert left == pytest.approx(mesh.start[link.piece], abs=1e-8)


@pytest.mark.slow
def test_other_methods_know_no_places_that_are_closed():
    """They look up where no force acts as well."""
    process = mill([100, 120, 140], 0.3)
    found = [float(lobex.spectral_radius(process, 130.0, 2e-3, method)) for method in (METHOD, lobex.Chebyshev(24))]
    assert found[1] == pytest.approx(found[0], rel=1e-8)
    stepped = float(lobex.spectral_radius(process, 130.0, 2e-3, lobex.SemiDiscretization(240)))
    assert stepped == pytest.approx(found[0], rel=2e-3)


@settings(max_examples=12)
@given(
    st.lists(st.floats(0.4, 1.0), min_size=2, max_size=5),
    st.floats(0.02, 0.9),
    st.sampled_from(["down", "up"]),
)
@pytest.mark.slow
def test_links_come_from_where_the_tooth_ahead_was(shares, immersion, direction):
    pitch = 360 * np.array(shares) / np.sum(shares)
    process = lobex.Milling(TOOL, lobex.Cutter.end_mill(pitch_degrees=pitch), 6e8, 2e8, immersion, direction)
    with jax.enable_x64(True):
        system = process.system(100.0, 1e-3)
        if system.closed is None:
            return
        mesh, delays = mesh_of(system), np.asarray(shares_of(system))
        start, length = np.asarray(mesh.start), np.asarray(mesh.length)
        acts = [np.asarray(part) for part in system.at(start + length / 2).delayed]
    assert np.all(length > 0)
    assert np.sum(length) == pytest.approx(1, abs=1e-12)
    for link in mesh.links:
        reader = (link.piece + link.later) % mesh.pieces
        turns = (link.piece + link.later) // mesh.pieces
        assert start[reader] + turns - delays[link.delay] == pytest.approx(start[link.piece], abs=1e-8)
        assert length[reader] == pytest.approx(length[link.piece], abs=1e-8)
    met = {((link.piece + link.later) % mesh.pieces, link.delay) for link in mesh.links}
    for delay, coefficient in enumerate(acts):
        assert met >= {(piece, delay) for piece in np.flatnonzero(np.any(coefficient != 0, axis=(1, 2)))}


def test_what_is_due_from_before_a_period():
    # One piece that remembers three periods, and two pieces of which each leaves something to the next.
    assert due_from_before((Link(0, 3, 0),), 1) == ((0, 0), (1, 0), (2, 0))
    assert due_from_before((Link(0, 1, 0), Link(1, 1, 0)), 2) == ((0, 0),)
    # Two kinds are due apart.
    assert due_from_before((Link(0, 2, 0, 0), Link(1, 1, 1, 1)), 2) == ((0, 0), (0, 1))


@pytest.mark.slow
def test_what_is_known_of_one_immersion_is_not_taken_for_another_one():
    """Neither where it is given while tracing nor where a number of a process is exchanged."""
    process, method = mill([100, 120, 140], 0.3), lobex.Duhamel(nodes=16)
    expected = float(lobex.spectral_radius(mill([100, 120, 140], 0.6), 130.0, 2e-3, method))

    @jax.jit
    def given(immersion):
        return lobex.spectral_radius(replace(process, radial_immersion=immersion), 130.0, 2e-3, method)

    leaves, tree = jax.tree.flatten(process)
    exchanged = jax.tree.unflatten(tree, [0.6 if leaf is process.radial_immersion else leaf for leaf in leaves])
    with jax.enable_x64(True):
        assert float(given(0.6)) == pytest.approx(expected, rel=1e-7)
        assert np.isnan(np.asarray(radii(exchanged))).any()


@pytest.mark.slow
def test_a_tooth_just_behind_another_one_finds_nothing_to_cut():
    together = float(lobex.spectral_radius(mill([1e-7, 360 - 1e-7], 0.5), 100.0, 1e-3, METHOD))
    assert together == pytest.approx(float(lobex.spectral_radius(mill([360], 0.5), 100.0, 1e-3, METHOD)), rel=1e-6)


def test_places_that_go_on_for_ever_are_not_closed():
    process = mill([71.3, 108.7, 71.3, 108.7], 1.0)
    with jax.enable_x64(True):
        system = process.system(100.0, 1e-3)
        assert closed_places(system, np.array([0.0, 0.3])) is None
    assert process.layout.places.closed is None


@pytest.mark.parametrize("parts", [ALONE, ("cut", "idle")])
@pytest.mark.parametrize(("directions", "axial"), [(1, None), (2, None), (3, None), (3, 1e8)])
def test_the_force_of_one_chip_is_force_per_chip_times_chip(parts, directions, axial):
    exit_ = np.pi if parts == ALONE else 2.5
    teeth = StraightTeeth(2e-3, 6e8, 2e8, axial, None, np.pi / 2, exit_, 0.1, 4, directions, CHIP, parts)
    with jax.enable_x64(True):
        (piece, *_) = teeth.pieces()
        phase = piece.start + piece.length * np.linspace(0, 1, 7)
        push, chip = teeth.factors(piece.start + piece.length / 2, phase)
        whole = np.asarray(teeth.within(piece.start + piece.length / 2, phase))
    assert teeth.single
    assert np.asarray(push) @ np.asarray(chip) == pytest.approx(whole, rel=1e-13, abs=1e-13 * np.max(np.abs(whole)))


@pytest.mark.slow
@pytest.mark.parametrize("immersion", [0.2, 0.5])
def test_one_tooth_at_a_time_remembers_a_chip_a_node(immersion):
    """Half as much as the force in two directions, and the same multipliers."""
    process = lobex.Milling(TOOL, 4, 6e8, 2e8, immersion)
    both = laid_out(process, parts=("cut", "cut") if immersion == 0.2 else ("cut",))
    chips, forces = largest(process), largest(both)
    assert [len(chips), len(forces)] == [4 + 18, 4 + 2 * 18 * (2 if immersion == 0.2 else 1)]
    assert chips[:6] == pytest.approx(forces[:6], rel=1e-9)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::lobex.SweepWarning")
@pytest.mark.parametrize("discs", [False, True])
def test_gradients_by_pitch_are_those_of_differences_where_places_coincide(discs):
    """One tooth leaves as another one enters, and images of jumps meet others: places that are one till angles move."""
    tool, method = lobex.Modes.single(frequency=510.0, damping_ratio=0.02, mass=0.5), lobex.Duhamel(nodes=18)
    cutter = lobex.Cutter.end_mill(0.016, pitch_degrees=[120.0, 240.0])
    process = lobex.Milling(tool, cutter.in_discs(2, 2e-3) if discs else cutter, 6e8, 2e8, 0.75)
    change = np.array([1.0, -1.0])

    def radius(amount):
        cutter = replace(process.cutter, pitch=process.cutter.pitch + amount * change)
        return lobex.spectral_radius(replace(process, cutter=cutter), 130.0, 2e-3, method)

    with jax.enable_x64(True):
        slope = float(jax.jit(jax.grad(radius))(0.0))
        by_leaf = jax.jit(jax.grad(lambda mill: lobex.spectral_radius(mill, 130.0, 2e-3, method)))(process)
    difference = (float(radius(1e-4)) - float(radius(-1e-4))) / 2e-4
    assert slope == pytest.approx(difference, rel=3e-5)
    assert np.asarray(by_leaf.cutter.pitch) @ change == pytest.approx(difference, rel=3e-5)


# Both are of the same nodes, be they few.
@pytest.mark.filterwarnings("ignore::lobex.SweepWarning")
@pytest.mark.slow
def test_gradient_by_the_immersion_is_that_of_differences_where_one_tooth_leaves_as_another_one_enters():
    tool, method = lobex.Modes.single(frequency=510.0, damping_ratio=0.02, mass=0.5), lobex.Duhamel(nodes=12)
    process = lobex.Milling(tool, lobex.Cutter.end_mill(pitch_degrees=[120.0, 240.0]), 6e8, 2e8, 0.75)
    with jax.enable_x64(True):
        found = jax.jit(jax.grad(lambda mill: lobex.spectral_radius(mill, 130.0, 2e-3, method)))(process)
    ahead, behind = (
        float(lobex.spectral_radius(replace(process, radial_immersion=0.75 + step), 130.0, 2e-3, method))
        for step in (1e-4, -1e-4)
    )
    assert float(found.radial_immersion) == pytest.approx((ahead - behind) / 2e-4, rel=1e-5)


@pytest.mark.slow
def test_gradients_of_an_orbit_by_pitch_are_those_of_differences_where_places_coincide():
    tool, method = (
        lobex.Modes.single(frequency=510.0, damping_ratio=0.02, mass=0.5),
        lobex.Duhamel(nodes=22, tolerance=1e-6),
    )
    cutter = lobex.Cutter.end_mill(pitch_degrees=[120.0, 240.0])
    process = lobex.Milling(tool, cutter, 6e8, 2e8, 0.75, feed_per_tooth=1e-4)
    change = np.array([1.0, -1.0])

    def displaced(mill):
        return 1e6 * lobex.orbit(mill, 130.0, 1e-3, method, phase=[0.3]).displacement[0, 0]

    with jax.enable_x64(True):
        along = jax.tree.map(lambda number: np.zeros_like(number, dtype=float), process)
        object.__setattr__(along.cutter, "pitch", change)
        slope = float(jax.jit(lambda mill: jax.jvp(displaced, (mill,), (along,))[1])(process))
    ahead, behind = (
        displaced(replace(process, cutter=replace(cutter, pitch=cutter.pitch + step * change)))
        for step in (1e-4, -1e-4)
    )
    assert slope == pytest.approx((ahead - behind) / 2e-4, rel=1e-5)
