"""Random rubs through the default of every verb, against a root count of the tests' own and the closed form.

One to eight modes, damping from 1e-4 to 0.2, frequencies near each other and far, 0.1 to 300 waves of the fastest mode
per delay, gains from 0.01 to 1e6 times the least limit, grids of up to 3 × 40 points.
"""

import warnings

import jax
import numpy as np
import pytest

import lobex
from lobex.characteristic.lanes import placed
from lobex.characteristic.method import contacts
from lobex.characteristic.strips import Strips, roots_over
from root_count import Feedback, least_limit, polished, roots_beyond

# The count is taken this far to the right of the root: closer, the samples of the oracle become too many.
_BESIDE = 1e-8
_POINTS = 3


def random_model(rng, counts):
    """Natural frequencies, damping ratios, mode shapes and speeds."""
    count = int(rng.choice(counts))
    scale = np.exp(rng.uniform(np.log(10), np.log(1e4)))
    omega = np.exp(rng.uniform(np.log(10), np.log(1e4), count)) if rng.random() < 0.5 else scale
    omega = np.sort(omega * (1 + 0.3 * rng.random(count)))
    damping = np.exp(rng.uniform(np.log(1e-4), np.log(0.2), count))
    shape = rng.normal(size=count) * 10 ** rng.uniform(-1, 2)
    waves = np.exp(rng.uniform(np.log(0.1), np.log(300)))
    speed = np.sort(omega[-1] / (2 * np.pi * waves) * np.exp(rng.uniform(-0.3, 0.3, int(rng.integers(1, 4)))))
    return omega, damping, shape, speed


def check(seed, counts, exact_too=False):
    """One model: every multiplier is a root with none beyond it, and every limit is the closed form's."""
    rng = np.random.default_rng(seed)
    omega, damping, shape, speed = random_model(rng, counts)
    process = lobex.Rub(lobex.Modes(omega, damping, shape[:, None]))
    with warnings.catch_warnings():
        # That all speeds lie above the lobes of the first mode is said, and meant here.
        warnings.filterwarnings("ignore", "every speed")
        exact = np.array([least_limit(omega, damping, shape**2, 1 / s) for s in speed])
        least = np.min(exact)
        assert np.isfinite(least)
        reach = 1e6 if rng.random() < 0.3 else 100.0
        gain = np.unique(least * np.exp(rng.uniform(np.log(0.01), np.log(reach), int(rng.integers(1, 41)))))
        chart = lobex.sweep(process, speed, gain)
        limit = lobex.critical_gain(process, speed, (least / 100, least * 100))
    assert np.max(chart.error) < 1e-9
    inside = np.where(exact < least * 100, exact, np.nan)
    if exact_too:
        assert lobex.exact_limit(process, speed).gain == pytest.approx(exact, rel=1e-9)
    assert np.array_equal(np.isnan(limit.gain), np.isnan(inside))
    found = np.isfinite(inside)
    assert np.all(np.abs(limit.gain - inside)[found] <= 10 * limit.error[found] + 1e-13 * inside[found])
    for i in range(len(speed)):
        for j in rng.choice(len(gain), min(len(gain), _POINTS), replace=False):
            check_point(Feedback(omega, damping, shape**2, 1 / speed[i], gain[j]), chart, i, j)


def check_point(function, chart, i, j):
    """The multiplier of a point of a chart is a root, and none lies beyond."""
    speed = chart.speed[i]
    z = np.log(chart.spectral_radius[i, j]) + 2j * np.pi * chart.chatter_frequency[i, j] / speed
    root, last = polished(function, z)
    assert last < 1e-9 * (1 + abs(z))
    assert abs(root.real - z.real) <= 10 * chart.error[i, j]
    assert roots_beyond(function, z.real + _BESIDE * (1 + abs(z))) == 0
    assert roots_beyond(function, z.real - _BESIDE * (1 + abs(z))) > 0


@pytest.mark.parametrize(
    "first",
    [pytest.param(first, marks=pytest.mark.search if first else pytest.mark.slow) for first in range(0, 200, 20)],
)
def test_random_models(first):
    for seed in range(first, first + 20):
        # Of three sizes, so that few programs are compiled.
        check(seed, (1, 3, 8))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [600, *(pytest.param(seed, marks=pytest.mark.search) for seed in (601, 602))])
def test_random_models_of_more_modes_than_starts_are_taken_from(seed):
    check(seed, (60,))


GRIDS = [*((seed, 3) for seed in range(400, 404)), (410, 40)]
MORE_GRIDS = [pytest.param(seed, 3, marks=pytest.mark.search) for seed in range(404, 408)]


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "modes"), [*GRIDS, *MORE_GRIDS])
def test_random_models_over_grids_that_are_proven_by_strips(seed, modes):
    rng = np.random.default_rng(seed)
    omega, damping, shape, speed = random_model(rng, (modes,))
    speed = speed[0] * np.linspace(1, 1.5, 16)
    least = min(least_limit(omega, damping, shape**2, 1 / s) for s in speed[[0, 7, 15]])
    gain = least * np.geomspace(0.01, 100.0, 512)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "every speed")
        chart = lobex.sweep(lobex.Rub(lobex.Modes(omega, damping, shape[:, None])), speed, gain)
    assert np.max(chart.error) < 1e-9
    for _ in range(2 * _POINTS):
        i, j = rng.integers(16), rng.integers(512)
        check_point(Feedback(omega, damping, shape**2, 1 / speed[i], gain[j]), chart, i, j)


def test_what_is_counted_for_a_strip_holds_at_all_its_gains():
    decided, strips = 0, 40
    for seed in range(500, 508):
        rng = np.random.default_rng(seed)
        omega, damping, shape, speed = random_model(rng, (3,))
        speed = np.full(strips, max(speed[0], omega[-1] / (2 * np.pi * 30)))
        process = lobex.Rub(lobex.Modes(omega, damping, shape[:, None]))
        weakest = least_limit(omega, damping, shape**2, 1 / speed[0]) * np.exp(rng.uniform(-2, 4, strips))
        strongest = weakest * np.exp(rng.uniform(0, 0.3, strips))
        level = rng.uniform(-1.5, 1.0, strips)
        with jax.enable_x64(True):
            _, made, _ = contacts(process, speed, 1.0)
            closed, opened = made.closed(np.arange(strips), strongest).at_delay(made.delay), made.opened
            poles = np.sum(closed.upper.real > level, axis=0) + np.sum(closed.lower.real > level, axis=0)
            found, known = roots_over(
                opened, placed(opened.filled()), Strips(np.arange(strips), level, weakest, strongest), poles
            )
        for i in np.flatnonzero(known):
            for gain in np.linspace(weakest[i], strongest[i], 4):
                function = Feedback(omega, damping, shape**2, 1 / speed[i], gain)
                assert roots_beyond(function, level[i]) == found[i]
        decided += np.sum(known)
    assert 0.5 < decided / (8 * strips) < 0.99


@pytest.mark.search
@pytest.mark.parametrize("first", range(1000, 3000, 50))
def test_many_random_models(first):
    for seed in range(first, first + 50):
        check(seed, range(1, 9), exact_too=True)


@pytest.mark.parametrize(
    ("modes", "speed", "gains", "right"),
    [
        (([1.0], [0.1], [1.0]), 0.01, [20.0, 100.0], {0: 16.9787}),
        (([1.0], [0.1], [1.0]), 0.0086, [50.0, 100.0], {0: 26.9864}),
        (([121.0], [0.069], [14.0]), 4.95, [8300.0, 45500.0], {0: 23.9099}),
        (
            (
                [381.1964108680777, 682.5502390923795, 962.3356848588046],
                [1.2559723989819302e-4] * 3,
                [219.963738, -124.415273, -16.168792],
            ),
            9.717612221279383,
            [79.08308, 299.8784607535205, 586.12408],
            # 48.55721959791245 in 30 digits.
            {1: 48.5572195979},
        ),
        (([1.0], [0.03], [1.0]), 0.0086, [10.0, 20.0, 50.0, 60.0], {0: 24.928, 2: 52.343}),
        (([1.0], [0.001], [1.0]), 0.0086, [50.0, 100.0], {0: 81.52}),
        (([1480.0], [0.03], [135.0]), 2.94, [0.146, 182.0, 361.0], {1: 13.536, 2: 20.585}),
    ],
)
def test_grids_that_lost_a_root_between_their_gains(modes, speed, gains, right):
    omega, damping, shape = map(np.array, modes)
    chart = lobex.sweep(lobex.Rub(lobex.Modes(omega, damping, shape[:, None])), [speed], gains)
    for column, value in right.items():
        assert chart.spectral_radius[0, column] == pytest.approx(value, rel=3e-5)
    assert np.max(chart.error) < 1e-11


@pytest.mark.parametrize(("waves", "right"), [(95, 6.48132), (100, 6.56927), (120, 6.65397), (1000, 7.13468)])
def test_the_rod_far_below_its_lobes(waves, right):
    rub = lobex.Rub(lobex.Rod(elements=5).modes(damping_ratio=0.03))
    chart = lobex.sweep(rub, [rub.modes.frequency[0] / waves], [4.5e4, 4.5e6])
    assert chart.spectral_radius[0, 1] == pytest.approx(right, rel=1e-6)
    # The bound that the multipliers approach as the delay grows: the peak of |H(jω)|, H = K G/(1 + K G).
    assert chart.spectral_radius[0, 1] < 7.207


@pytest.mark.parametrize(
    ("omega", "damping", "speed", "gain"),
    [([1.0], 0.2, 0.00025, 1.0), ([377.0, 17176.0], 0.05, 0.9254, 3.77), ([628.3, 12566.4], 0.03, 0.5, 1.0)],
)
def test_modes_that_die_out_many_times_within_a_delay(omega, damping, speed, gain):
    omega = np.array(omega)
    chart = lobex.sweep(
        lobex.Rub(lobex.Modes(omega, np.full(len(omega), damping), np.ones((len(omega), 1)))), [speed], [gain]
    )
    function = Feedback(omega, np.full(len(omega), damping), np.ones(len(omega)), 1 / speed, gain)
    level = np.log(chart.spectral_radius[0, 0])
    assert roots_beyond(function, level + 1e-6) == 0
    assert roots_beyond(function, level - 1e-6) > 0


def test_a_limit_beside_a_mode_that_dies_out_within_a_delay():
    omega, damping = np.array([4400.0, 12000.0, 14000.0, 15000.0]), np.array([0.001, 0.00043, 0.15, 0.0034])
    process = lobex.Rub(lobex.Modes(omega, damping, np.array([[1.1], [-2.5], [-0.71], [-1.5]])))
    limit = lobex.critical_gain(process, 1.27, (20.8, 62301.0))
    assert limit.gain[0] == pytest.approx(20767.105, rel=1e-7)
    assert limit.gain[0] == pytest.approx(lobex.exact_limit(process, 1.27).gain[0], rel=1e-12)
    chart = lobex.sweep(process, [1.27], limit.gain[0] * np.array([0.5, 0.99, 1.0, 1.01, 3.0]))
    assert np.array_equal(chart.spectral_radius[0] > 1, [False, False, chart.spectral_radius[0, 2] > 1, True, True])
    assert chart.spectral_radius[0, 2] == pytest.approx(1.0, abs=1e-10)
