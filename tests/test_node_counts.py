"""How many nodes points begin with, and the few points of each speed that tell of the others."""

import numpy as np
import pytest

import lobex
from cases import MILL
from lobex.grids.node_counts import MANY, node_counts
from lobex.grids.one_size import few_of_each

SPEEDS = np.linspace(2000, 25000, 100) / 60


def begun(points):
    counts = node_counts(MILL, lobex.Duhamel(), SPEEDS, np.full(len(SPEEDS), points), np.min, 1e-8)
    return np.array(counts.sizes), np.array(counts.sizes)[counts.first]


def test_few_points_begin_with_one_size_and_many_with_what_their_speed_asks_for():
    few, one = begun(10)
    many, each = begun(MANY // 50)
    assert len(set(one)) == 1
    assert np.all(np.diff(each) <= 0)
    assert np.all(each <= one)
    # Between the sizes of all there are some, which are nobody's where they serve few.
    assert set(few) < set(many)
    for size in set(many) - set(few):
        assert np.sum(each == size) * (MANY // 50) >= MANY / 10


@pytest.mark.parametrize("few", [1, 4])
def test_a_few_of_each_row_are_evenly_among_them(few):
    rng = np.random.default_rng(few)
    row = rng.permutation(np.repeat(np.arange(30), rng.integers(1, 40, 30)))
    chosen = few_of_each(row, few)
    for number in range(30):
        mine = chosen[row == number]
        if len(mine) < 2 * few:
            assert mine.all()
        else:
            assert few <= mine.sum() < 2 * few
            assert np.diff(np.flatnonzero(mine)).max(initial=0) <= len(mine) // few
