"""A map made finer: where it must be, nowhere else, and with what the samples say."""

import numpy as np
import pytest

from lobex._hidden import doubtful_cells
from lobex.grids.finer import doubtful, finer

PIXELS = (840.0, 540.0)
SPEED, GAIN = np.linspace(0.0, 1.0, 21), np.linspace(0.0, 1.0, 16)


def ridge(x, y):
    """Two slanting planes that meet in a valley, zero along two lines that are close together: a tongue."""
    return np.abs(y - 0.3 * x - 0.41) - 0.02 + 0.03 * x


def smooth(x, y):
    """Curved, but little over a cell."""
    return y - 0.3 - 0.2 * np.sin(1.4 * x)


class Counted:
    """A function that knows how often it was asked, and where."""

    def __init__(self, function):
        self.function, self.places = function, np.empty((0, 2))

    def __call__(self, x, y):
        self.places = np.concatenate([self.places, np.column_stack([x, y])])
        return self.function(x, y)


def on_grid(function, x=SPEED, y=GAIN):
    return function(x[:, None], y[None])


def test_cells_around_a_hidden_tongue_are_in_doubt_and_others_are_not():
    growth = on_grid(ridge)
    size = PIXELS[0] / 20
    cells = doubtful(SPEED, GAIN, growth, size)
    middle = (SPEED[1:] + SPEED[:-1]) / 2
    for x in middle[middle < 0.6]:
        valley = 0.3 * x + 0.41
        assert cells[np.searchsorted(SPEED, x) - 1, np.searchsorted(GAIN, valley) - 1]
    far = np.abs(((GAIN[1:] + GAIN[:-1]) / 2)[None] - 0.3 * middle[:, None] - 0.41) > 0.2
    assert not cells[far].any()


def test_a_smooth_map_is_left_alone():
    sample = Counted(smooth)
    speed, gain = np.linspace(0, 1, 61), np.linspace(0, 1, 41)
    made = finer(speed, gain, on_grid(smooth, speed, gain), sample, PIXELS)
    assert len(sample.places) == 0
    assert made[0] is speed


def test_a_fine_map_has_the_samples_where_it_was_in_doubt():
    sample = Counted(ridge)
    speed, gain, growth = finer(SPEED, GAIN, on_grid(ridge), sample, PIXELS)
    assert len(speed) > 8 * 20
    assert set(SPEED) <= set(speed)
    exact = on_grid(ridge, speed, gain)
    # The sign is right everywhere but within about a pixel of the line.
    wrong = (growth < 0) != (exact < 0)
    slope = 1.0
    assert np.max(np.abs(exact[wrong]), initial=0.0) <= slope / 540 * 1.5
    # No point twice, and few far from the line: whole cells around it in the first round, and ever fewer.
    assert len(np.unique(sample.places, axis=0)) == len(sample.places)
    assert len(sample.places) < 0.1 * growth.size
    at = np.searchsorted(speed, sample.places[:, 0]), np.searchsorted(gain, sample.places[:, 1])
    np.testing.assert_array_equal(growth[at], ridge(*sample.places.T))


@pytest.mark.parametrize("failed", [False, True])
def test_flat_growth_and_failed_points_ask_for_nothing(failed):
    random = np.random.default_rng(1)
    growth = np.full((21, 16), np.nan) if failed else 1e-13 * random.standard_normal((21, 16))
    sample = Counted(smooth)
    finer(SPEED, GAIN, growth, sample, PIXELS)
    assert len(sample.places) == 0


def test_two_by_two_points_are_a_map():
    assert not doubtful(SPEED[:2], GAIN[:2], np.array([[-1.0, 1.0], [-1.0, 1.0]]), 500.0).any()


def test_a_cell_with_a_corner_between_samples_is_in_doubt_and_others_are_not():
    place = np.linspace(0, 1, 17)
    # The larger of a hump, above zero from 0.418 to 0.582, and a line, above zero from 0.62 on.
    value = np.maximum(0.02 - 3 * (place - 0.5) ** 2, 3 * (place - 0.62))
    lane = np.repeat([0, 1], 17)
    cells = doubtful_cells(lane, np.tile(place, 2), np.concatenate([value, 1 + place]))
    assert place[9] < 0.582 < 0.62 < place[10]
    assert 9 in cells
    assert set(cells) <= {7, 8, 9, 10}
