"""Milling with one delay a tooth: numbers of independent codes, and the laws of even pitch and of cyclic order."""

import numpy as np
import pytest

import lobex
from lobex.systems.mesh import mesh_of
from problems import KN, KT, PLANE, pitched

METHOD = lobex.Duhamel(nodes=20)


@pytest.mark.parametrize("direction", ["down", "up"])
def test_even_pitch_is_milling_taken_as_often_as_it_has_teeth(direction):
    even = lobex.Milling(PLANE, 4, KT, KN, 0.3, direction)
    once = lobex.multipliers(even, 70.0, 1e-3, lobex.Duhamel(nodes=14))
    whole = lobex.multipliers(pitched([90.0] * 4, 0.3, direction), 70.0, 1e-3, METHOD)
    assert abs(whole[0]) == pytest.approx(abs(once[0]) ** 4, rel=1e-8)


def test_the_order_of_the_teeth_matters_and_where_it_begins_does_not():
    def leading(degrees):
        return abs(lobex.multipliers(pitched(degrees), 60.0, 2e-3, METHOD)[0])

    first = leading([70, 100, 85, 105])
    assert leading([85, 105, 70, 100]) == pytest.approx(first, rel=1e-8)
    assert leading([105, 85, 100, 70]) != pytest.approx(first, rel=1e-4)


def test_pieces_end_where_a_tooth_enters_or_leaves_and_where_their_delays_carry_that_into_the_cut():
    process = pitched([70, 110, 70, 110])
    mesh = mesh_of(process.system(50.0, 1e-3))
    assert mesh.pieces == len(process.layout.places.kept) < 8 + 32
    # The longest delay is 110° of pieces that are 30° on average.
    assert mesh.history < mesh.pieces
    assert float(np.sum(mesh.length)) == pytest.approx(1.0)


def test_mean_forces_are_those_of_quadrature():
    with np.errstate(all="raise"):
        term = pitched([80, 100, 75, 105], 0.8, "up").system(50.0, 1e-3).terms[1]
    start, stop = np.array([0.1, 0.63, 0.97]), np.array([0.13, 0.7, 1.05])
    phase = start[:, None] + (stop - start)[:, None] * (np.arange(4000) + 0.5) / 4000
    values = np.asarray(term.coefficient.at(phase.ravel())).reshape(3, 4000, 2, 2)
    assert np.asarray(term.coefficient.mean(start, stop)) == pytest.approx(
        np.mean(values, axis=1), rel=2e-3, abs=1e-3 * KT * 1e-3
    )


def test_mean_forces_of_feed_and_runout_are_those_of_quadrature():
    process = lobex.VariablePitch(
        PLANE, np.deg2rad([80, 100, 75, 105]), KT, KN, 0.8, "up", feed_per_tooth=1e-4, runout=[0, 1e-5, 0, 0]
    )
    system = process.system(50.0, 1e-3)
    # They cut what the teeth cut, and multipliers do not know of them.
    assert len(system.forcing) == 8
    assert mesh_of(system).pieces == mesh_of(pitched([80, 100, 75, 105], 0.8, "up").system(50.0, 1e-3)).pieces
    start, stop = np.array([0.1, 0.63, 0.97]), np.array([0.13, 0.7, 1.05])
    phase = start[:, None] + (stop - start)[:, None] * (np.arange(4000) + 0.5) / 4000
    values = sum(np.asarray(term.coefficient.at(phase.ravel())) for term in system.forcing)
    wanted = np.mean(values.reshape(3, 4000, 2), axis=1)
    assert np.asarray(system.mean_forcing(start, stop)) == pytest.approx(wanted, rel=2e-3, abs=1e-3 * KT * 1e-7)


@pytest.mark.parametrize("runout", [[1e-5], [[1e-5, 0.0]], [np.inf] * 4])
def test_runout_is_a_number_a_tooth(runout):
    with pytest.raises(ValueError, match="runout"):
        lobex.VariablePitch(PLANE, np.deg2rad([90.0] * 4), KT, KN, 0.5, runout=runout)


@pytest.mark.parametrize(
    ("degrees", "message"),
    [
        ([90.0, 90.0, 90.0], "pitch sums to 4.71239 rad"),
        ([[90.0], [270.0]], "give one angle a tooth"),
        ([-90.0, 450.0], "must be positive"),
        ([90.0, np.nan], "NaN"),
    ],
)
def test_angles_that_make_no_turn_are_refused(degrees, message):
    with pytest.raises(ValueError, match=message):
        pitched(degrees)


def test_degrees_are_recognised():
    with pytest.raises(ValueError, match=r"numpy\.deg2rad"):
        lobex.VariablePitch(PLANE, [90.0] * 4, KT, KN, 0.5)
