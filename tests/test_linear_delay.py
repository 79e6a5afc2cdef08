"""Anybody's own equation: equal to lobex' own where it is theirs, to closed forms and other codes where it is not."""

import json
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.tree_util import Partial
from scipy.optimize import brentq
from scipy.special import lambertw

import lobex
from cases import THESIS_TOOL, milling, rub
from lobex.systems.mesh import mesh_of
from reference_tools import process_damping
from refusals import refused

SIXTEEN = lobex.Duhamel(nodes=16)


def times_gain(matrix, t, speed, gain):
    return gain * matrix


def vibration(modes):
    """A, E and C of modes, the state of each being (q, q'/ω)."""
    omega, ratio, shape = modes.angular_frequency, modes.damping_ratio, np.asarray(modes.shape)
    n, none = len(omega), np.zeros(np.shape(shape))
    drift = np.block([[np.zeros((n, n)), np.diag(omega)], [-np.diag(omega), -2 * np.diag(ratio * omega)]])
    inputs, outputs = np.concatenate([none, shape / omega[:, None]]), np.concatenate([shape, none]).T
    return {"drift": drift, "inputs": inputs, "outputs": outputs}


def own_rub(process):
    unit = np.eye(1)
    return lobex.LinearDelay(
        **vibration(process.modes),
        present=Partial(times_gain, -unit),
        delayed=[(Partial(times_gain, unit), None)],
    )


def stiffened(numbers, t, speed, gain):
    return numbers[0] + numbers[1] * gain


def radial(numbers, t, speed, gain):
    return numbers[1] * gain


def own_turning(mode, force):
    mass, omega = 1 / mode.shape[0, 0] ** 2, mode.angular_frequency[0]
    numbers = np.array([mass * omega**2, force])
    return lobex.LinearDelay.second_order(
        mass,
        2 * mass * mode.damping_ratio[0] * omega,
        Partial(stiffened, numbers),
        delayed=[(Partial(radial, numbers), None)],
    )


def cutting(numbers, t, speed, gain):
    """sign b Σ (Kt t + Kn n) nᵀ over the teeth that cut, down-milling of half a diameter."""
    sign, tangential, normal = numbers[:3]
    angle = jnp.mod(2 * jnp.pi * speed * t + numbers[3:], 2 * jnp.pi)
    sine, cosine = jnp.sin(angle), jnp.cos(angle)
    across, along = jnp.stack([sine, cosine]), jnp.stack([cosine, -sine])
    force = (tangential * along + normal * across) * ((angle > jnp.pi / 2) & (angle < jnp.pi))
    return sign * gain * force @ across.T


def cutting_along(numbers, t, speed, gain):
    return cutting(numbers, t, speed, gain)[:1, :1]


def tooth_period(teeth, speed, gain):
    return 1 / (teeth * speed)


def own_milling(process):
    force = cutting if process.modes.directions == 2 else cutting_along
    angle = 2 * np.pi * np.arange(process.teeth) / process.teeth
    numbers = np.array([process.tangential, process.normal, *angle])
    # A tooth enters at a right angle and leaves at half a turn, which the others do at whole pitches from there.
    breaks = np.unique(np.mod(np.array([0.25, 0.5]) * process.teeth, 1.0))
    return lobex.LinearDelay(
        **vibration(process.modes),
        present=Partial(force, np.append(-1.0, numbers)),
        delayed=[(Partial(force, np.append(1.0, numbers)), None)],
        period=Partial(tooth_period, float(process.teeth)),
        breaks=breaks,
    )


def pulsating(numbers, t, speed, gain):
    return numbers[0] + numbers[1] * jnp.cos(t)


def own_mathieu(delta, epsilon, damping, delay=None):
    return lobex.LinearDelay.second_order(
        1.0,
        damping,
        Partial(pulsating, np.array([delta, epsilon])),
        delayed=[(Partial(times_gain, np.eye(1)), delay)],
        period=2 * np.pi,
    )


TURNED = lobex.Modes.single(frequency=146.5, damping_ratio=0.02, mass=2.573)
ALONG = milling(THESIS_TOOL, 0.5, "down")
SAME = {
    "rub": (rub(2), own_rub(rub(2)), 112.0, 4e5),
    "mathieu": (lobex.DelayedMathieu(3.0, 2.0, 0.1), own_mathieu(3.0, 2.0, 0.1), 1 / (2 * np.pi), -0.15),
    "milling in the plane": (
        milling(THESIS_TOOL, 0.5, "down", 2),
        own_milling(milling(THESIS_TOOL, 0.5, "down", 2)),
        150.0,
        1e-3,
    ),
}


@pytest.mark.parametrize("name", ["rub", "mathieu", pytest.param("milling in the plane", marks=pytest.mark.slow)])
def test_an_equation_written_by_hand_is_the_process_that_it_is(name):
    process, own, speed, gain = SAME[name]
    values, wanted = (lobex.multipliers(one, speed, gain, SIXTEEN)[:4] for one in (own, process))
    assert values == pytest.approx(wanted, rel=1e-10, abs=1e-10 * abs(wanted[0]))


@pytest.mark.parametrize(("start", "stop"), [pytest.param(0.0, 0.25, marks=pytest.mark.slow), (0.25, 0.5), (0.5, 1.0)])
def test_the_force_of_a_tooth_is_that_of_milling_between_its_jumps(start, stop):
    phase = np.linspace(start, stop, 11)
    with jax.enable_x64(True):
        own, known = (one.system(150.0, 1e-3).within((start + stop) / 2, phase) for one in (own_milling(ALONG), ALONG))
    assert np.any(known.present) == (start == 0.25)
    np.testing.assert_allclose(own.present, known.present, rtol=1e-9, atol=1e-3)
    np.testing.assert_allclose(own.delayed[0], known.delayed[0], rtol=1e-9, atol=1e-3)


@pytest.mark.slow
def test_matrices_in_si_units_are_as_good_as_their_modes():
    blade, contact = lobex.Rod(elements=2), np.diag([0.0, 1.0])
    mass, stiffness, damping = blade.matrices(damping_ratio=0.03)
    process = lobex.Rub(blade.modes(damping_ratio=0.03))
    own = lobex.LinearDelay.second_order(
        mass,
        damping,
        Partial(held_at_the_tip, stiffness, contact),
        delayed=[(Partial(times_gain, contact), None)],
    )
    chart, wanted = (lobex.sweep(one, [112.0], [4e5]) for one in (own, process))
    assert chart.multiplier == pytest.approx(wanted.multiplier, rel=1e-8)
    assert chart.error[0, 0] < 1e-8


def held_at_the_tip(stiffness, contact, t, speed, gain):
    return stiffness + gain * contact


@pytest.mark.slow
def test_what_does_not_follow_the_time_is_constant_and_goes_to_the_roots():
    process, own, _, _ = SAME["rub"]
    speeds = [85.0, 112.0]
    limit, wanted = (lobex.critical_gain(one, speeds, (4.5e4, 4.5e6)) for one in (own, process))
    assert limit.method == wanted.method == {"type": "CharacteristicRoots"}
    assert limit.gain == pytest.approx(wanted.gain, rel=1e-10)
    assert lobex.sweep(own_turning(TURNED, 2e8), [90.0], [2e-3]).method == wanted.method


# Hayes' equation with the delay 1/speed, seen over a shorter period: μ = exp(λ T), whatever T is.
SHARE = 0.7
SPEEDS, GAINS = np.array([0.5, 1.0]), np.linspace(-3.0, 2.0, 5)


def parts_of_a_turn(share, speed, gain):
    return share / speed


def a_turn_ago(more, t, speed, gain):
    return (1 + more * (speed - 0.5) * (1 - speed)) / speed


def hayes(a, more=0.0):
    return lobex.LinearDelay(
        drift=a,
        delayed=[(Partial(times_gain, np.eye(1)), Partial(a_turn_ago, more))],
        period=Partial(parts_of_a_turn, SHARE),
        delay_range=(1 / SHARE, 1 / SHARE),
    )


def multiplier(a, speed, gain):
    """By Lambert's W."""
    return np.exp((a / speed + lambertw(gain / speed * np.exp(-a / speed))) * SHARE)


def oscillating_limit(a, speed):
    """The gain −θ/(τ sin θ) at a τ = θ cot θ."""
    theta = brentq(lambda theta: theta / np.tan(theta) - a / speed, 0.1, np.pi - 1e-9)
    return -theta / np.sin(theta) * speed


def test_a_sweep_of_constant_coefficients_over_any_period():
    chart = lobex.sweep(hayes(-1.0), SPEEDS, GAINS)
    wanted = multiplier(-1.0, SPEEDS[:, None], GAINS)
    assert chart.spectral_radius == pytest.approx(np.abs(wanted), rel=1e-8)
    assert chart.failed == 0


def test_limits_of_constant_coefficients_over_any_period():
    limit = lobex.critical_gain(hayes(-1.0), SPEEDS, (-4.0, 3.0))
    assert limit.intervals[:, 0, 0] == pytest.approx([oscillating_limit(-1.0, s) for s in SPEEDS], rel=1e-8)
    assert limit.intervals[:, 0, 1] == pytest.approx(1.0, rel=1e-8)
    assert set(limit.status) == {"unstable at the lower bound"}
    above = lobex.critical_gain(hayes(-1.0), SPEEDS, (-0.5, 3.0))
    assert above.gain == pytest.approx(1.0, rel=1e-8)
    assert set(above.kind) == {"fold"}


def test_derivatives_are_those_of_the_closed_form():
    def growth(a, gain):
        return lobex.spectral_radius(hayes(a), 1.0, gain, SIXTEEN)

    with jax.enable_x64(True):
        value, slopes = jax.jit(jax.value_and_grad(growth, argnums=(0, 1)))(-1.0, -1.5)
    assert value == pytest.approx(abs(multiplier(-1.0, 1.0, -1.5)), rel=1e-10)
    step = 1e-5
    by_a, by_gain = (
        (abs(multiplier(-1.0 + i, 1.0, -1.5 + j)) - abs(multiplier(-1.0 - i, 1.0, -1.5 - j))) / (2 * step)
        for i, j in ((step, 0.0), (0.0, step))
    )
    assert [float(slope) for slope in slopes] == pytest.approx([by_a, by_gain], rel=1e-8)


@pytest.mark.slow
def test_sensitivities_are_those_of_the_numbers_of_functions():
    told = lobex.sensitivities(own_turning(TURNED, 2e8), [90.0], bounds=(1e-5, 1e-2))
    known = lobex.sensitivities(lobex.Turning(TURNED, 2e8), [90.0])

    def of(number, *functions):
        names = [name for name in told.names if name.endswith(f"[{number}]") and name.startswith(functions)]
        assert len(names) == len(functions)
        return sum(told[name][0] for name in names)

    # The force is handed to both functions. A stiffness moves ω with its root, and ξ = c/2mω against that.
    assert of(1, "present", "delayed") == pytest.approx(known["radial"][0], rel=1e-7)
    by_mode = known["modes.angular_frequency[0]"][0] - known["modes.damping_ratio[0]"][0]
    assert of(0, "present") == pytest.approx(by_mode / 2, rel=1e-7)


def test_a_saved_chart_names_its_functions_and_does_not_make_them_again(tmp_path):
    chart = lobex.sweep(own_rub(rub(2)), [112.0], [0.0, 4e5])
    chart.save(tmp_path / "own.nc")
    read = lobex.load(tmp_path / "own.nc")
    assert read.process == chart.process
    assert read.process["present"]["type"] == "function times_gain"
    assert json.dumps(read.process).count("times_gain") == 2
    with pytest.raises(ValueError, match=r"'function times_gain', which cannot be made again") as caught:
        lobex.boundary(read)
    assert "\n" not in str(caught.value)


@pytest.mark.slow
@pytest.mark.parametrize("more", [1e-3, -1e-3])
def test_a_delay_that_leaves_its_range_between_the_ends_is_no_number_and_counted(more):
    process = replace(hayes(-1.0), delayed=hayes(-1.0, more).delayed)
    with pytest.warns(lobex.SweepWarning, match="5 of 15 points failed and are NaN"):
        chart = lobex.sweep(process, [0.5, 0.75, 1.0], GAINS)
    assert np.isnan(chart.spectral_radius[1]).all()
    assert not np.isnan(chart.spectral_radius[[0, 2]]).any()


def of_time(t, speed, gain):
    return 1.0 if t > 0.5 else 0.0


def of_shape(t, speed, gain):
    return jnp.zeros((2, 3))


def of_numpy(t, speed, gain):
    return np.sin(t)


GIVEN = {"drift": np.eye(2), "delayed": [(np.eye(2), 0.5)], "period": 1.0}


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"delayed": [(np.eye(2), -0.5)]}, r"the delay of delayed\[0\] = -0.5 must be positive"),
        ({"delayed": [(np.eye(2), np.nan)]}, r"the delay of delayed\[0\] = nan has NaN"),
        ({"delayed": [(np.eye(2), [0.5, 1.0])]}, r"the delay of delayed\[0\] has shape \(2,\); give one number"),
        ({"delayed": [np.eye(2)]}, r"delayed\[0\] = .* must be a pair"),
        ({"delayed": [(np.eye(3), 0.5)]}, r"delayed\[0\] has shape \(3, 3\); give \(2, 2\)"),
        ({"period": 0.0}, "period = 0 must be positive"),
        ({"period": -1.0}, "period = -1 must be positive"),
        ({"period": None}, "delay_range is needed where"),
        ({"breaks": [0.2, 1.0]}, r"breaks = \[0.2, 1.0\] must be phases t/T from 0 to below 1"),
        ({"breaks": [-0.1]}, r"breaks = \[-0.1\] must be phases"),
        ({"breaks": [np.nan]}, r"breaks = \[nan\] has NaN"),
        ({"breaks": 0.5}, r"breaks = 0.5 must be phases"),
        ({"period": np.nan}, "period = nan has NaN"),
        ({"period": [1.0, 2.0]}, r"period has shape \(2,\); give one number"),
        ({"outputs": np.ones((1, 3))}, r"inputs has shape \(none\) and outputs \(1, 3\)"),
        ({"delayed": [(np.ones((2, 2, 2)), 0.5)]}, r"delayed\[0\] has shape \(2, 2, 2\); give a matrix"),
        ({"drift": np.ones((2, 3))}, r"drift has shape \(2, 3\); give a square matrix"),
        ({"drift": [[np.inf, 0], [0, 1]]}, "drift = .* has NaN or infinite values"),
        ({"inputs": np.ones((3, 1))}, r"inputs has shape \(3, 1\) and outputs \(none\)"),
        ({"present": np.eye(3)}, r"present has shape \(3, 3\); give \(2, 2\)"),
        ({"delayed": 3.0}, "delayed = 3.0 must be a list of pairs, empty for none"),
        ({"delayed": None}, "delayed = None must be a list of pairs"),
        ({"distributed": "none"}, "distributed = 'none' must be a list of pairs"),
        ({"drift": 1j * np.eye(2)}, "drift = .* is complex; give real numbers"),
        ({"delay_range": (1.0, 0.5)}, "delay_range = .* must be two numbers of periods, the shortest first"),
    ],
)
def test_bad_input_is_one_line_when_it_is_given(changed, message):
    with refused(match=message):
        lobex.LinearDelay(**GIVEN | changed)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"present": of_time}, r"present cannot be traced by JAX; write it with jax.numpy"),
        ({"present": of_numpy}, r"present cannot be traced by JAX; write it with jax.numpy"),
        ({"present": lambda t: np.eye(2)}, r"present cannot be traced by JAX; .*positional"),
        ({"present": lambda t, speed, gain: 1j * jnp.eye(2)}, "present returns complex numbers; return real ones"),
        ({"present": lambda t, speed, gain: "none"}, "present cannot be traced by JAX; write it with jax.numpy"),
        ({"present": lambda t, speed, gain: None}, "present cannot be traced by JAX; write it with jax.numpy"),
        ({"present": of_shape}, r"present returns the shape \(2, 3\); return \(2, 2\)"),
        ({"delayed": [(of_shape, 0.5)]}, r"delayed\[0\] returns the shape \(2, 3\); return \(2, 2\)"),
        (
            {"delayed": [(np.eye(2), of_shape)], "delay_range": (0.5, 0.5)},
            r"the delay of delayed\[0\] returns the shape \(2, 3\); return \(\)",
        ),
        ({"period": lambda speed, gain: jnp.ones(2), "delay_range": (0.5, 0.5)}, r"period returns the shape \(2,\)"),
    ],
)
def test_functions_that_cannot_be_are_refused_before_any_computing(changed, message):
    process = lobex.LinearDelay(**GIVEN | changed)
    for verb in (lobex.sweep, lobex.spectral_radius):
        with refused(match=message):
            verb(process, [1.0], [1.0])


def test_masses_that_are_none_are_refused():
    with pytest.raises(ValueError, match="mass is singular"):
        lobex.LinearDelay.second_order(np.diag([1.0, 0.0]), np.eye(2), np.eye(2))
    with pytest.raises(ValueError, match=r"mass has shape \(2, 2\), damping \(1, 1\); give two of \(p, p\)"):
        lobex.LinearDelay.second_order(np.eye(2), 1.0, np.eye(2))
    with pytest.raises(ValueError, match=r"stiffness has shape \(3, 3\); give \(2, 2\)"):
        lobex.LinearDelay.second_order(np.eye(2), np.eye(2), np.eye(3))


@pytest.mark.slow
def test_a_delay_far_shorter_than_another_costs_no_more_pieces():
    short, near, far = 1e-3, 0.3, 0.5
    process = lobex.LinearDelay(
        drift=-1.0,
        delayed=[(near, lambda t, speed, gain: short / speed), (far, lambda t, speed, gain: 1 / speed)],
        delay_range=(short, 1.0),
    )
    root = 0.0
    for _ in range(50):
        pull = near * np.exp(-short * root), far * np.exp(-root)
        root -= (root + 1 - sum(pull)) / (1 + short * pull[0] + pull[1])
    chart = lobex.sweep(process, [1.0], [0.0])
    assert mesh_of(process.system(1.0, 0.0)).pieces <= 16
    np.testing.assert_allclose(chart.spectral_radius, np.exp(root), rtol=1e-10)


def test_a_mode_that_turns_nearly_a_hundred_radians_in_half_a_delay_gets_the_nodes_it_needs():
    machine = {
        "modes": [{"frequency_Hz": 450.0, "damping_ratio": 0.0316, "modal_mass_kg": 0.8106}],
        "K_N_per_m2": 1.5e9,
        "C_N_per_m": 611000.0,
        "radius_m": 0.0175,
    }
    # By Newton's method on the characteristic function.
    expected = {0.0004922: (-0.104342917518, 0.796173948867), 0.001477: (0.14333359661, 1.05647189748)}
    turning = {"machine": "one", "rpm": 1000, "depth_m": 0.000984487513269, "rel_diff": 1e-12}
    turning["points"] = [{"depth_m": depth, "mu": mu} for depth, mu in expected.items()]
    content = {"milling_mu": [], "milling_critical": [], "machines": {"one": machine}, "turning": [turning]}
    task = list(process_damping(content))[-1]
    chart = lobex.sweep(task.process, [task.speed], list(expected))
    assert chart.multiplier[0] == pytest.approx([complex(*mu) for mu in expected.values()], rel=1e-10)
    assert np.max(chart.error) < 1e-10
