"""Speeds added to a limit where it bends, ends or jumps, on curves known at every speed."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import lobex
from lobex.limits.adaptive import limit_curve, merged
from lobex.processes.quantity import DEPTH_OF_CUT
from lobex.results.codes import Kind, Status
from lobex.results.limit import Limit

CUSP, LENS, END = 1.33, (2.01, 2.09), 3.7
SPEED = np.linspace(1, 4, 21)


def curve(speed):
    """Falling, a cusp, rising, a lens that cuts a piece out from below, and no limit beyond the end."""
    gain = 1.0 + np.abs(speed - CUSP) + 0.1 * np.sin(3 * speed)
    gain = np.where((speed > LENS[0]) & (speed < LENS[1]), 0.4, gain)
    return np.where(speed > END, np.nan, gain)


def search(speed, calls=None, curve=curve):
    """The limits of a curve; above the lens the process is stable again."""
    gain = curve(speed)
    found, inside = np.isfinite(gain), gain == 0.4
    intervals = np.full((len(speed), 1 + inside.any(), 2), np.nan)
    intervals[:, 0] = np.column_stack([np.zeros(len(speed)), np.where(found, gain, 9.0)])
    if inside.any():
        intervals[inside, 1] = (0.6, 1.5)
    if calls is not None:
        calls.append(speed)
    status = np.where(found, Status.FOUND, Status.NONE_IN_RANGE).astype(np.int8)
    return Limit(
        speed=speed,
        gain=gain,
        chatter_frequency=np.where(found, 100.0, np.nan),
        kind_code=np.where(found, Kind.HOPF, Kind.NONE).astype(np.int8),
        status_code=status,
        intervals=intervals,
        mode=np.zeros(len(speed), dtype=int),
        nodal_diameter=np.full(len(speed), -1),
        error=1e-9 * gain,
        bounds=(0.0, 9.0),
        quantity=DEPTH_OF_CUT,
        speed_unit="rpm",
        process={"type": "Milling"},
        method={"type": "Duhamel"},
        seconds=1.0,
        compiling=0.0,
    )


def interpolation_error(limit, margin):
    """Largest error of the line through the limits, off the jumps by more than ``margin``."""
    dense = np.linspace(SPEED[0], END - margin, 20001)
    away = np.min(np.abs(dense[:, None] - np.array(LENS)), axis=1) > margin
    line = np.interp(dense, limit.speed, limit.gain)
    return np.max(np.abs(line - curve(dense))[away & np.isfinite(line)])


def test_the_line_through_the_limits_comes_close_where_it_was_far_off():
    rough, fine = limit_curve(search, SPEED, 0), limit_curve(search, SPEED, 120)
    # One of the first speeds sees the lens.
    assert interpolation_error(rough, 0.005) > 0.5
    assert interpolation_error(fine, 0.005) < 5e-3
    assert len(fine.speed) <= len(SPEED) + 120


@pytest.mark.parametrize("place", [CUSP, *LENS, END])
def test_cusp_lens_edges_and_end_are_pinned_to_a_thousandth_of_the_width(place):
    fine = limit_curve(search, SPEED, 120)
    right = np.searchsorted(fine.speed, place)
    assert fine.speed[right] - fine.speed[right - 1] < 4 * np.ptp(SPEED) / 1000


def test_results_are_sorted_keep_the_speeds_given_and_belong_together():
    fine = limit_curve(search, SPEED, 27)
    assert len(fine.speed) == len(SPEED) + 27
    assert np.all(np.diff(fine.speed) > 0)
    assert set(SPEED) <= set(fine.speed)
    np.testing.assert_array_equal(fine.gain, curve(fine.speed))
    np.testing.assert_array_equal(
        fine.intervals[fine.gain == 0.4, 1], np.tile((0.6, 1.5), (np.sum(fine.gain == 0.4), 1))
    )
    assert np.isnan(fine.intervals[fine.gain != 0.4, 1:]).all()
    assert fine.status[-1] == "none in range"


def test_a_straight_curve_and_few_speeds_get_none():
    calls = []
    limit_curve(partial(search, calls=calls, curve=lambda speed: 5 - speed), SPEED[:9], 50)
    limit_curve(partial(search, calls=calls), SPEED[:2], 50)
    assert [len(part) for part in calls] == [9, 2]


def test_printing_is_in_the_units_of_the_picture():
    text = repr(search(SPEED))
    assert "21 speeds, 60 to 240 rpm" in text
    assert "bounds           0 to 9000 mm" in text
    assert "b = 400 mm at 123 rpm, hopf at 100 Hz" in text
    assert "smallest limit   none\n" in repr(search(np.array([3.8, 3.9])))


def test_times_add_up():
    assert merged(search(SPEED), search(np.array([1.01]))).seconds == 2.0


def test_the_closed_form_of_a_tool_with_two_modes():
    modes = lobex.Modes(2 * np.pi * np.array([150.0, 190.0]), np.array([0.02, 0.02]), np.array([[0.6], [0.5]]))
    closed = partial(lobex.exact_limit, lobex.Turning(modes, radial=2e8))
    dense = np.linspace(60, 200, 4001)
    exact = closed(dense).gain
    rough, fine = (limit_curve(closed, np.linspace(60, 200, 41), budget) for budget in (0, 160))
    curve = np.column_stack([(dense - dense[0]) / np.ptp(dense), exact / np.ptp(exact)])
    along = np.diff(curve, axis=0)

    def off(limit):
        """Largest distance of the line from the curve, of the picture's width and height."""
        line = np.column_stack([curve[::10, 0], np.interp(dense[::10], limit.speed, limit.gain) / np.ptp(exact)])
        to_line = line[:, None] - curve[:-1]
        share = np.clip(np.sum(to_line * along, axis=2) / np.sum(along**2, axis=1), 0, 1)
        return np.max(np.min(np.linalg.norm(to_line - share[:, :, None] * along, axis=2), axis=1))

    assert off(rough) > 0.01
    assert off(fine) < 1.5e-3


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((SPEED[::-1], 5), "not strictly increasing"),
        ((SPEED, -1), "budget = -1"),
        ((SPEED, 2**31), "budget = 2147483648"),
    ],
)
def test_bad_input(arguments, words):
    with pytest.raises(ValueError, match=words):
        limit_curve(search, *arguments)


def test_no_curve_ends_where_the_process_becomes_stable_at_any_gain():
    def above(speed):
        limit = search(speed, curve=lambda speed: np.where(speed > END, 1.0, np.nan))
        always = np.where(speed < CUSP, Status.STABLE_AT_ANY_GAIN, limit.status_code).astype(np.int8)
        return replace(limit, status_code=always)

    fine = limit_curve(above, SPEED, 20)
    added = np.setdiff1d(fine.speed, SPEED)
    assert added.size
    assert np.all(added > SPEED[np.searchsorted(SPEED, END) - 1])
