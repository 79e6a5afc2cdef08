"""The march of delayed processes: against multipliers, a method of steps, and closed forms."""

import itertools

import jax
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import lobex
from cases import MILL, MULTIPLIER_CASES, MULTIPLIER_TOOLS, ROD, milling, point
from lobex.grids.sweep import SweepWarning
from lobex.marches.delay import march_delay
from lobex.marches.fed_vibrations import fastest_fed
from lobex.marches.growth_fit import fit_growth
from lobex.marches.linear import march_system
from lobex.marches.start import growing_history
from refusals import refused

RATE = np.log(1.0005) / 1e-6
SECTION_44 = (np.array([85.0, 85.0, 112.0, 112.0]), np.array([4.5e5, 1.35e6, 4.5e5, 1.35e6]))


def pulse(time):
    """A displacement that excites all modes."""
    return 1e-6 * np.cos(40 * time / np.min(time)) * np.exp(3 * time / np.min(time))


def order_of(steps, errors):
    """Convergence order as the slope of log error over log step size."""
    return -np.polyfit(np.log(steps), np.log(errors), 1)[0]


# --- growth per period against the monodromy operator


@pytest.mark.parametrize(
    ("process", "speed", "gain", "steps"),
    [(ROD, (50, 400), (4.5e4, 4.5e6), 3000), (MILL, (2000 / 60, 25000 / 60), (1e-4, 5e-3), 1000)],
    ids=["rod", "milling"],
)
def test_fitted_growth_is_the_spectral_radius_at_50_random_points(process, speed, gain, steps):
    random = np.random.default_rng(4)
    speeds, gains = random.uniform(*speed, 50), random.uniform(*gain, 50)
    march = march_delay(process, speeds, gains, pulse, periods=30, steps_per_period=steps, every=10)
    radius = lobex.spectral_radius(process, speeds, gains)
    assert march.growth == pytest.approx(radius, rel=1e-4)
    assert march.growth_error.max() < 1e-6
    assert np.array_equal(march.growth > 1, radius > 1)


def test_growth_of_the_lanes_converges_with_the_square_of_the_step():
    process, speed, gain = point(next(c for c in MULTIPLIER_CASES if c["problem"] == "rod-rub"))
    exact = lobex.spectral_radius(process, speed, gain, lobex.Chebyshev(64))
    steps = np.array([200, 400, 800])
    found = [march_delay(process, speed, gain, pulse, 30, int(k)).growth for k in steps]
    assert order_of(steps, np.abs(np.array(found) - exact)) == pytest.approx(2, abs=0.1)


@pytest.mark.slow
def test_modes_that_the_contact_can_feed_are_resolved_or_the_steps_refused():
    """The third mode chatters: with 16 to 64 steps, which resolve the first, the growth came out as 2.3."""
    modes = lobex.Modes(2 * np.pi * np.array([100.0, 800.0, 2300.0]), [0.02] * 3, [[0.3], [1.0], [1.0]])
    fast = lobex.Rub(modes)
    with pytest.raises(ValueError, match="steps_per_period = 64 is too few at speed = 50 Hz") as error:
        march_delay(fast, 50.0, 1e7, pulse, 40, 64)
    least = int(str(error.value).split("give ")[1].split()[0])
    exact = float(lobex.spectral_radius(fast, 50.0, 1e7, lobex.Chebyshev(200)))
    found = [march_delay(fast, 50.0, 1e7, pulse, 40, steps).growth for steps in (least, 4 * least)]
    assert found == [pytest.approx(exact, rel=0.01)] * 2
    assert abs(found[1] - exact) < abs(found[0] - exact) / 12


def test_the_fastest_vibration_that_is_fed_is_where_the_loop_gain_is_one():
    # One mode in permanent contact: (κ/m)/|ω_n² − ω²| = 1 above its frequency, without damping.
    single = lobex.Modes.single(frequency=100.0, damping_ratio=0.0, mass=2.0)
    stiffness = np.array([0.0, 1e5, 1e6, 1e8])
    with jax.enable_x64(True):
        system = jax.vmap(lobex.Rub(single).system)(np.full(4, 50.0), stiffness)
    first, fed = fastest_fed(jax.tree.map(np.asarray, system), 2 * stiffness)
    assert first == pytest.approx(np.full(4, 200 * np.pi), rel=1e-6)
    # The search takes 400 frequencies.
    assert fed[1:] == pytest.approx(np.sqrt((200 * np.pi) ** 2 + stiffness[1:]), rel=0.03)
    assert fed[0] == 0


def test_the_fit_tells_two_close_pairs_apart():
    random = np.random.default_rng(0)
    values = np.array([1.02 * np.exp(0.7j), 1.019 * np.exp(2.1j), 0.6 + 0j, 0.4j])
    basis = random.standard_normal((4, 30)) + 1j * random.standard_normal((4, 30))
    states = np.array([np.real((values**k) @ basis) for k in range(20, 29)])
    growth = fit_growth(states[None])
    assert growth.multiplier[0] == pytest.approx(values[0], rel=1e-10)
    assert growth.error[0] < 1e-8


@pytest.mark.parametrize("noise", [1e-9, 5.6e-9, 1e-8])
def test_the_fit_takes_no_direction_that_it_left_out_for_a_multiplier(noise):
    """Some of the noise is below what is left out; of the rest the fit has an error of 1e-6."""
    value = 0.966 * np.exp(3.141j)
    for seed in range(30):
        random = np.random.default_rng(seed)
        basis = random.standard_normal(20) + 1j * random.standard_normal(20)
        states = np.array([np.real(value**k * basis) for k in range(10)])
        growth = fit_growth(states[None] + noise * random.standard_normal(states.shape))
        assert abs(growth.multiplier[0]) == pytest.approx(0.966, abs=1e-4), seed
        assert growth.error[0] > 1e-9, seed


def test_the_error_of_the_fit_is_large_while_other_multipliers_still_matter():
    exact = lobex.spectral_radius(ROD, 300.0, 3e6, lobex.Chebyshev(64))
    marches = [march_delay(ROD, 300.0, 3e6, pulse, periods, 2000) for periods in (4, 40)]
    for march in marches:
        assert abs(march.growth - exact) < 10 * march.growth_error + 1e-4
    assert marches[0].growth_error > 1e3 * marches[1].growth_error


def test_without_motion_or_with_one_period_there_is_no_growth():
    still = march_delay(ROD, 85.0, 1e5, lambda t: 0 * t, 6, 300)
    assert np.isnan(still.growth)
    assert np.all(still.displacement == 0)
    assert np.isnan(march_delay(ROD, 85.0, 1e5, pulse, 1, 300).growth)


# --- §4.4


def test_section_44_converges_and_diverges_as_predicted():
    speed, gain = SECTION_44
    history, state = growing_history(lobex.Rod(5), speed)
    march = march_delay(ROD, speed, gain, history, 10, 12000, state=state)
    assert np.max(march.delay / 12000) <= 1e-6
    radius = lobex.spectral_radius(ROD, speed, gain)
    assert np.array_equal(radius > 1, [False, True, False, True])
    revolution = np.abs(march.displacement[:, 1:, 0]).reshape(4, 10, 12000).max(axis=-1)
    assert np.all(np.diff(revolution[[0, 2], 3:], axis=1) < 0)
    assert np.all(revolution[[1, 3], -1] > revolution[[1, 3], 3])
    assert march.growth == pytest.approx(radius, rel=1e-3)
    # After ten revolutions the fit still moves, and says so.
    assert np.all(np.abs(march.growth - radius) < march.growth_error + 1e-5)


def test_the_thesis_start_is_its_recursion():
    history, state = growing_history(lobex.Rod(5), 100.0)
    time = np.arange(-10, 1) * 1e-6
    values = history(time)
    assert values[1:] / values[:-1] == pytest.approx(1.0005, rel=1e-12)
    assert history(np.array([-0.01]))[0] == pytest.approx(1e-7, rel=1e-12)
    assert state.shape == (10,)


def test_by_default_the_structure_is_bent_by_a_force_at_the_contact():
    # A rod pulled at its tip stretches evenly: (4.3)'s shape, without growth.
    _, state = growing_history(lobex.Rod(5), 85.0, tip=2e-6, rate=0.0)
    given_state = march_delay(ROD, 85.0, 4.5e5, lambda t: 2e-6, 3, 300, state=state)
    by_default = march_delay(ROD, 85.0, 4.5e5, lambda t: 2e-6, 3, 300)
    assert by_default.displacement == pytest.approx(given_state.displacement, abs=1e-18)
    assert by_default.displacement[0, 0] == pytest.approx(2e-6, rel=1e-12)


# --- against a method of steps with a Runge-Kutta method of order 8


def method_of_steps(force, matrices, contact, past, start, tau, periods, breaks=()):
    """Positions at the ends of the periods of M q̈ + C q̇ + K q = contact · force(t, y, y delayed)."""
    mass, damping, stiffness = (np.atleast_2d(m) for m in matrices)
    n = len(mass)
    inverse = np.linalg.inv(mass)
    delayed, z, ends = past, np.asarray(start, dtype=float), []
    for p in range(periods):
        pieces = []
        edges = [p * tau, *(p * tau + b for b in breaks), (p + 1) * tau]
        for a, b in itertools.pairwise(edges):

            def slope(t, z, delayed=delayed, middle=(a + b) / 2):
                # The coefficient is that of the piece, whatever rounding makes of t at its ends.
                push = contact * force(t, middle, contact @ z[:n], delayed(t - tau))
                return np.r_[z[n:], inverse @ (push - damping @ z[n:] - stiffness @ z[:n])]

            done = solve_ivp(slope, (a, b), z, "DOP853", rtol=1e-12, atol=1e-18, dense_output=True, max_step=tau / 60)
            pieces.append((b, done.sol))
            z = done.y[:, -1]

        def delayed(t, pieces=pieces):
            return contact @ next(s for b, s in pieces if t <= b or b is pieces[-1][0])(t)[:n]

        ends.append(contact @ z[:n])
    return np.array(ends)


def error_at_ends(march, exact):
    each = (len(march.phase) - 1) // len(exact)
    return np.max(np.abs(march.displacement[each::each, 0] - exact)) / np.max(np.abs(exact))


def test_rod_against_the_method_of_steps():
    rod, speed, gain = lobex.Rod(2), 112.0, 1.35e6
    mass, stiffness, damping = rod.matrices(0.03)
    start = np.array([0.5, 1.0]) * 1e-7 * np.exp(RATE / speed)
    exact = method_of_steps(
        lambda t, middle, y, past: -gain * (y - past),
        (mass, damping, stiffness),
        np.array([0.0, 1.0]),
        lambda t: 1e-7 * np.exp(RATE * (t + 1 / speed)),
        np.r_[start, RATE * start],
        1 / speed,
        4,
    )
    history, state = growing_history(rod, speed)
    process = lobex.Rub(rod.modes(0.03))
    steps = np.array([200, 400, 800])
    errors = [error_at_ends(march_delay(process, speed, gain, history, 4, int(k), state=state), exact) for k in steps]
    assert order_of(steps, errors) == pytest.approx(2, abs=0.05)
    assert errors[-1] < 1e-3
    # Richardson's extrapolation removes the leading term: nothing but the second-order error was there.
    coarse, fine = (
        march_delay(process, speed, gain, history, 4, k, state=state).displacement[k::k, 0] for k in (400, 800)
    )
    assert (4 * fine - coarse) / 3 == pytest.approx(exact, rel=1e-5)


@pytest.mark.parametrize(("immersion", "direction"), [(0.5, "down"), (0.3, "up")])
def test_milling_against_the_method_of_steps(immersion, direction):
    tool = MULTIPLIER_TOOLS["thesis-3.4"]
    process, speed, depth = milling(tool, immersion, direction), 8000 / 60, 1e-3
    omega, xi, mass = 2 * np.pi * tool["natural_frequency_Hz"], tool["damping_ratio"], tool["modal_mass_kg"]
    entry, leave = (np.arccos(2 * immersion - 1), np.pi) if direction == "down" else (0, np.arccos(1 - 2 * immersion))

    def force(t, middle, y, past):
        angle, inside = (2 * np.pi * ((x * speed) % 1) for x in (t, middle))
        stiffness = (5.5e8 * np.cos(angle) + 2e8 * np.sin(angle)) * np.sin(angle) * (entry < inside < leave)
        return -depth * stiffness * (y - past)

    exact = method_of_steps(
        force,
        (mass, 2 * xi * omega * mass, omega**2 * mass),
        np.ones(1),
        lambda t: 1e-6,
        [1e-6, 0.0],
        1 / speed,
        5,
        breaks=[a / (2 * np.pi * speed) for a in (entry, leave) if a > 0],
    )
    steps = np.array([200, 400, 800])
    errors = [error_at_ends(march_delay(process, speed, depth, lambda t: 1e-6, 5, int(k)), exact) for k in steps]
    assert errors[-1] < 3e-6
    if direction == "down":
        # The tooth enters and leaves at quarters of the turn, on steps' ends.
        assert order_of(steps, errors) == pytest.approx(2, abs=0.01)
    else:
        # Where a jump falls within its step moves the constant of the second-order error, and no more.
        scaled = errors * steps**2
        assert scaled.max() < 2 * scaled.min()


def test_mathieu_against_the_method_of_steps():
    delta, epsilon, damping, b, tau = 3.0, 2.0, 0.1, -0.15, 2 * np.pi
    exact = method_of_steps(
        lambda t, middle, y, past: b * past - epsilon * np.cos(t) * y,
        ([1.0], [damping], [delta]),
        np.ones(1),
        lambda t: np.cos(0.3 * t),
        [1.0, 0.0],
        tau,
        4,
    )
    process = lobex.DelayedMathieu(delta=delta, epsilon=epsilon, damping=damping)
    steps = np.array([100, 200, 400])
    errors = [
        error_at_ends(march_delay(process, 1 / tau, b, lambda t: np.cos(0.3 * t), 4, int(k)), exact) for k in steps
    ]
    assert order_of(steps, errors) == pytest.approx(2, abs=0.05)
    assert errors[-1] < 1e-3


def test_scalar_against_its_first_two_delays():
    # ẋ = b x(t − 1), x = 1 before: 1 + b t, then 1 + b t + b² (t − 1)²/2; straight lines are exact.
    march = march_delay(lobex.Scalar(0.0), 1.0, -0.7, lambda t: 1.0, 2, 50)
    x, t = march.displacement[:, 0], march.time
    assert x[:51] == pytest.approx(1 - 0.7 * t[:51], abs=1e-14)
    assert x[51:] == pytest.approx(1 - 0.7 * t[51:] + 0.245 * (t[51:] - 1) ** 2, abs=1e-14)


# --- properties


def test_free_vibration_is_exact_at_any_step():
    tool = lobex.Modes.single(frequency=100.0, damping_ratio=0.02, mass=3.0)
    march = march_delay(lobex.Turning(tool, 2e8), 35.0, 0.0, lambda t: 1e-3, 6, 24)
    omega, damped = 200 * np.pi, 200 * np.pi * np.sqrt(1 - 0.02**2)
    t = march.time
    exact = np.exp(-0.02 * omega * t) * (np.cos(damped * t) + 0.02 * omega / damped * np.sin(damped * t))
    assert march.displacement[:, 0] == pytest.approx(1e-3 * exact, abs=1e-15)


def test_a_batch_is_its_single_lanes():
    speed, gain = np.array([[85.0], [112.0]]), np.array([4.5e5, 1.35e6])
    batch = march_delay(ROD, speed, gain, pulse, 6, 400)
    assert batch.displacement.shape == (2, 2, 2401, 1)
    for i, j in np.ndindex(2, 2):
        time = np.arange(401) / 400 - 1
        single = march_delay(
            ROD, speed[i, 0], gain[j], lambda t, time=time, s=speed[i, 0]: batch_history(time / s), 6, 400
        )
        assert batch.displacement[i, j] == pytest.approx(single.displacement, rel=1e-9, abs=1e-18)
        assert batch.growth[i, j] == pytest.approx(single.growth, rel=1e-9)


def batch_history(time):
    """``pulse`` as the lanes of the batch above see it: its scale is that of the slowest lane."""
    return 1e-6 * np.cos(-40 * time * 85) * np.exp(-3 * time * 85)


@settings(max_examples=20)
@given(scale=st.floats(1e-6, 1e6), every=st.sampled_from([1, 5, 30]))
def test_the_motion_scales_with_its_history_and_thins_out_exactly(scale, every):
    unit = march_delay(ROD, 85.0, 1.35e6, pulse, 3, 300)
    scaled = march_delay(ROD, 85.0, 1.35e6, lambda t: scale * pulse(t), 3, 300, every=every)
    assert scaled.displacement == pytest.approx(scale * unit.displacement[::every], rel=1e-9)
    assert scaled.phase == pytest.approx(unit.phase[::every], rel=1e-14)


def test_the_end_of_one_march_is_the_start_of_the_next():
    whole = march_delay(MILL, 100.0, 2e-3, lambda t: 1e-6, 6, 200)
    first = march_delay(MILL, 100.0, 2e-3, lambda t: 1e-6, 2, 200)
    second = march_delay(MILL, 100.0, 2e-3, lambda t: first.displacement[-201:], 4, 200, state=first.state)
    assert second.displacement == pytest.approx(whole.displacement[400:], rel=1e-12)


def test_two_outputs_march_as_two_tools_where_nothing_couples_them():
    # At depth 0 both directions vibrate by themselves.
    process = milling(MULTIPLIER_TOOLS["Insperger-Stepan"], 0.3, "up", directions=2)
    march = march_delay(process, 90.0, 0.0, lambda t: np.array([1e-6, 2e-6]), 3, 100)
    assert march.displacement.shape == (301, 2)
    assert march.displacement[:, 1] == pytest.approx(2 * march.displacement[:, 0], rel=1e-12)


def test_jit_changes_nothing():
    with jax.enable_x64(True):
        system = lobex.Scalar(-0.5).system(1.0, 0.3)
        past, state = np.linspace(0.5, 1, 13)[:, None], np.ones(1)
        compiled = jax.jit(march_system, static_argnums=(3, 4))(system, past, state, 12, 2)
        with jax.disable_jit():
            plain = march_system(system, past, state, 12, 2)
    assert np.asarray(compiled.output) == pytest.approx(np.asarray(plain.output), rel=1e-12)


# --- lost lanes and bad input


def test_a_lane_that_blows_up_is_nan_and_named():
    with pytest.warns(SweepWarning, match=r"1 of 2 lanes .* speed = 2 Hz, delayed gain = 250; march fewer"):
        march = march_delay(lobex.Scalar(1.0), 2.0, [0.1, 250.0], lambda t: 1.0, 200, 160)
    assert np.isfinite(march.displacement[0]).all()
    assert np.isnan(march.displacement[1, -1]).all()
    assert not np.isinf(march.displacement).any()
    assert np.isnan(march.state[1]).all()
    assert np.isnan(march.growth[1])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"steps_per_period": 2}, "steps_per_period = 2"),
        ({"steps_per_period": 20}, "at speed = 85 Hz; give 32 or more"),
        ({"steps_per_period": 90, "gain": 1.35e6}, "give 100 or more, 8 per wave of the fastest vibration that the"),
        ({"steps_per_period": 100.5}, "steps_per_period = 100.5"),
        ({"periods": 0}, "periods = 0"),
        ({"periods": 2.5}, "periods = 2.5"),
        ({"every": 7}, "every = 7 does not divide"),
        ({"every": 0}, "every = 0"),
        ({"history": 1e-6}, "history = 1e-06 is no function"),
        ({"history": lambda t: np.nan * t}, "history(t) = [nan, nan"),
        ({"history": lambda t: t[:7]}, "history(t) has shape (7,); give (101,)"),
        ({"history": lambda t: "far"}, "history(t) = 'far'"),
        ({"state": np.zeros(1)}, "state has shape (1,); give the 10 numbers"),
        ({"state": 0.0}, "state has shape (); give the 10 numbers"),
        ({"state": np.zeros(3)}, "state has shape (3,); give the 10 numbers"),
        ({"state": np.full(10, np.nan)}, "state = [nan"),
        ({"state": np.zeros((2, 10))}, "state has shape (2, 10)"),
        ({"speed": 0.0}, "speed = 0"),
        ({"speed": []}, "speed and gain have no values"),
        ({"gain": -1.0}, "gain = -1"),
        ({"gain": [1.0, 2.0], "speed": [1.0, 2.0, 3.0]}, "give shapes that broadcast"),
        ({"process": None}, "process = None"),
        ({"process": lobex.DelayedMathieu(0.0, 0.1), "speed": 0.2, "gain": 0.1}, "give z at t = 0"),
    ],
)
def test_bad_input_is_refused_in_one_line(changes, words):
    arguments = {"process": ROD, "speed": 85.0, "gain": 1e5, "history": pulse, "periods": 3, "steps_per_period": 100}
    with refused(words):
        march_delay(**{**arguments, **changes})


@pytest.mark.parametrize(
    ("changes", "words"),
    [({"rod": 5}, "rod = 5 is no rod"), ({"tip": np.nan}, "tip = nan"), ({"speed": -1.0}, "speed = -1")],
)
def test_a_bad_start_of_the_rod_is_refused(changes, words):
    with pytest.raises(ValueError) as error:
        growing_history(**{"rod": lobex.Rod(5), "speed": 85.0, **changes})
    assert words in str(error.value)


def test_traced_arguments_are_refused():
    with pytest.raises(ValueError, match="gain is traced"):
        jax.jit(lambda g: march_delay(ROD, 85.0, g, pulse, 3, 100).growth)(1e5)
