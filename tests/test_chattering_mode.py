"""Which mode chatters, and with how many waves, of limits that no closed form found: as closed forms say it."""

import numpy as np
import pytest

import lobex
from lobex.limits.chattering_mode import labels_of_process

SPEEDS = np.linspace(40.0, 260.0, 45)
TWO = lobex.Modes.from_table([310.0, 720.0], 0.01, mass=[0.1, 0.02])


@pytest.mark.slow
@pytest.mark.parametrize("others", [{}, {"coupling": 40.0}])
def test_waves_around_a_disc_are_those_whose_characteristic_equation_holds(others):
    stage = lobex.Rub(lobex.Blading(TWO, 7, **others))
    limit = lobex.exact_limit(stage, SPEEDS)
    found = labels_of_process(stage, SPEEDS, limit.gain * (1 + 1e-7), limit.chatter_frequency)
    assert len(np.unique(limit.nodal_diameter)) > 3
    np.testing.assert_array_equal(found.mode, limit.mode)
    np.testing.assert_array_equal(found.nodal_diameter, limit.nodal_diameter)


@pytest.mark.slow
def test_mistuned_blades_that_are_coupled_are_labelled_as_nearly_as_they_are_without_the_coupling():
    mistuning = 0.01 * np.array([1.0, -2.0, 0.5, 1.5, -1.0])
    limit = lobex.exact_limit(lobex.Rub(lobex.Blading(TWO, 5, mistuning)), SPEEDS)
    coupled = lobex.Rub(lobex.Blading(TWO, 5, mistuning, coupling=1e-3))
    assert set(limit.mode) == {1, 2}
    for found in (
        labels_of_process(coupled, SPEEDS, limit.gain, limit.chatter_frequency),
        lobex.exact_limit(coupled, SPEEDS[::9]),
    ):
        np.testing.assert_array_equal(found.mode, limit.mode[:: 45 // len(found.mode)])
        assert set(found.nodal_diameter) == {-1}


def test_a_tool_with_hardly_any_process_damping_is_labelled_as_without():
    plain = lobex.Turning(TWO, radial=1e9)
    limit = lobex.exact_limit(plain, SPEEDS)
    damped = lobex.Turning(TWO, radial=1e9, diameter=0.05, process_damping=lobex.ProcessDamping(1e-6))
    found = labels_of_process(damped, SPEEDS, limit.gain, limit.chatter_frequency)
    assert set(limit.mode) == {1, 2}
    np.testing.assert_array_equal(found.mode, limit.mode)
    assert set(found.nodal_diameter) == {-1}


def test_the_direction_of_a_milling_cutter_that_chatters_is_the_one_at_whose_frequency_it_does():
    x, y = (lobex.Modes.single(frequency=frequency, damping_ratio=0.02, mass=0.04) for frequency in (400.0, 1100.0))
    milling = lobex.Milling(lobex.Modes.plane(x=x, y=y), teeth=3, tangential=6e8, normal=2e8, radial_immersion=0.5)
    found = labels_of_process(milling, np.full(4, 60.0), np.full(4, 1e-3), np.array([420.0, 1150.0, np.nan, 380.0]))
    np.testing.assert_array_equal(found.mode, [1, 2, 0, 1])


def test_an_equation_that_does_not_say_its_modes_has_no_labels():
    several = lobex.LinearDelay(np.diag([-0.1, -0.2, -0.3]), delayed=[(np.ones((3, 3)), None)])
    found = labels_of_process(several, np.ones(2), np.full(2, 0.1), np.full(2, 0.2))
    assert set(found.mode) == {0}


@pytest.mark.slow
def test_waves_around_a_disc_in_a_casing_that_gives_way_are_those_of_the_exact_limit():
    ring = lobex.Ring(nodal_diameter=2, frequency=520.0, damping_ratio=0.02, mass=2.0)
    stage = lobex.Rub(lobex.Blading(TWO, 5), casing=ring)
    speeds = SPEEDS[::9]
    limit = lobex.exact_limit(stage, speeds)
    found = labels_of_process(stage, speeds, limit.gain, limit.chatter_frequency)
    assert len(np.unique(limit.nodal_diameter)) > 1
    np.testing.assert_array_equal(found.mode, limit.mode)
    np.testing.assert_array_equal(found.nodal_diameter, limit.nodal_diameter)
