"""Collocation and semi-discretization of several delays that are not the period, may vary, and act over jumps."""

import json
from pathlib import Path
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lobex
from lobex._pytree import pytree
from lobex.processes.quantity import PLAIN_GAIN, Quantity
from lobex.systems.coefficients import Constant
from lobex.systems.delays import ConstantDelay
from lobex.systems.system import DelaySystem
from lobex.systems.terms import Delayed, Present

KNOWN = json.loads((Path(__file__).parent / "data" / "general.json").read_text())
METHODS = [lobex.Chebyshev(28), lobex.SemiDiscretization(64, order=1)]


def _stiffness(numbers, t, speed, gain):
    delta, epsilon = numbers
    return jnp.reshape(delta + epsilon * jnp.cos(t), (1, 1))


def _gain(t, speed, gain):
    return jnp.reshape(gain, (1, 1))


def mathieu(case):
    """x'' + a1 x' + (delta + eps cos t) x = b x(t − tau), T = 2π, with the gain b."""
    share = case["tau"] / (2 * np.pi)
    stiffness = jax.tree_util.Partial(_stiffness, (float(case["delta"]), float(case["eps"])))
    pulled = [(_gain, case["tau"])]
    others = {"period": 2 * np.pi, "delay_range": (share, share)}
    return lobex.LinearDelay.second_order(1.0, case["a1"], stiffness, pulled, **others)


_OMEGA = 200 * np.pi


def _held(t, speed, gain):
    return jnp.reshape(_OMEGA**2 * (1 + gain), (1, 1))


def _pulled(t, speed, gain):
    return jnp.reshape(_OMEGA**2 * gain, (1, 1))


def _lag(numbers, t, speed, gain):
    spindle, amplitude, ratio = numbers
    return 2 * jnp.pi / spindle / (1 + amplitude * jnp.sin(ratio * spindle * t))


def speed_variation(case):
    """A mode of 100 Hz that cuts with a spindle whose speed varies."""
    spindle, amplitude, ratio = case["rpm"] * np.pi / 30, case["RVA"], case["RVF"]
    lag = jax.tree_util.Partial(_lag, (spindle, amplitude, ratio))
    delays = ratio / (1 + amplitude), ratio / (1 - amplitude)
    others = {"period": 2 * np.pi / (ratio * spindle), "delay_range": delays}
    return lobex.LinearDelay.second_order(1.0, 0.04 * _OMEGA, _held, [(_pulled, lag)], **others)


def _acting(t, speed, gain):
    return jnp.where(t >= 0.55, gain, 0.0).reshape(1, 1)


def _acting_less(t, speed, gain):
    return -0.4 * _acting(t, speed, gain)


ACT_AND_WAIT = lobex.LinearDelay([[0.7]], [(_acting, 0.3), (_acting_less, 0.45)], period=1.0, breaks=[0.0, 0.55])
"""ẋ = 0.7 x + g(t) b [x(t − 0.3) − 0.4 x(t − 0.45)], where g = 0 until t = 0.55 of a period of 1 and then 1."""


def act_and_wait(b):
    """Its multiplier: e^{−0.7 t} x(t) is 1, then a straight line, from t = 0.85 on a parabola."""
    first, second = b * np.exp(-0.7 * 0.3), -0.4 * b * np.exp(-0.7 * 0.45)
    return np.exp(0.7) * (1 + (first + second) * 0.45 + first * (first + second) * 0.15**2 / 2)


@pytree()
class Damper:
    """ẍ + 0.2 ẋ + 2 x = −0.3 ẋ − 0.1 x + b x(t − 0.8) − 0.5 b x(t − 1.7), with a period of 1.

    What acts now is not what is remembered.
    """

    gain: ClassVar[Quantity] = PLAIN_GAIN
    speed_unit: ClassVar[str] = "1"

    def system(self, speed, gain):
        gain = jnp.reshape(gain, (1, 1))
        return DelaySystem(
            blocks=jnp.array([[[0.0, 1.0], [-2.0, -0.2]]]),
            inputs=jnp.array([[[0.0], [1.0]]]),
            outputs=jnp.eye(2)[None],
            period=1 / speed,
            terms=(
                Present(Constant(jnp.array([[-0.1, -0.3]]))),
                Delayed(Constant(gain), ConstantDelay(0.8)),
                Delayed(Constant(-0.5 * gain), ConstantDelay(1.7)),
            ),
            remembered=jnp.array([[[1.0, 0.0]]]),
            longest=1.7,
            shortest=0.8,
        )


def damper(b):
    """|μ| by the roots of its characteristic function, from Newton's method on a net of starts."""
    root = (np.linspace(-2, 2, 41)[:, None] + 1j * np.linspace(0, 12, 61)).ravel()
    for _ in range(60):
        one, two = np.exp(-0.8 * root), np.exp(-1.7 * root)
        value = root**2 + 0.5 * root + 2.1 - b * one + 0.5 * b * two
        root = root - value / (2 * root + 0.5 + 0.8 * b * one - 0.85 * b * two)
    value = root**2 + 0.5 * root + 2.1 - b * np.exp(-0.8 * root) + 0.5 * b * np.exp(-1.7 * root)
    return np.exp(np.max(root.real[np.abs(value) < 1e-9]))


def radius(process, gain, method):
    return float(lobex.spectral_radius(process, 1.0, gain, method))


def fitted_order(process, gain, exact, order, steps):
    errors = [abs(radius(process, gain, lobex.SemiDiscretization(k, order)) / exact - 1) for k in steps]
    return -np.polyfit(np.log(steps), np.log(errors), 1)[0]


# --- collocation


@pytest.mark.parametrize("case", KNOWN["mathieu"], ids=lambda case: f"{case['ratio']}-{case['delta']}")
def test_collocation_meets_the_delayed_mathieu_equation_whatever_the_delay(case):
    found = lobex.multipliers(mathieu(case), 1.0, case["b"], lobex.Chebyshev(36))[0]
    assert [found.real, abs(found.imag)] == pytest.approx(case["mu"], rel=1e-9, abs=1e-10)


@pytest.mark.parametrize("case", KNOWN["speed_variation"], ids=lambda case: case["rpm"])
def test_collocation_meets_speed_variation(case):
    found = lobex.multipliers(speed_variation(case), 1.0, case["gain"], lobex.Chebyshev(28))[0]
    assert [found.real, abs(found.imag)] == pytest.approx(case["mu"], rel=1e-8, abs=1e-9)


@pytest.mark.parametrize("b", [-2.5, 1.5])
def test_collocation_is_exact_over_jumps_with_several_delays(b):
    assert radius(ACT_AND_WAIT, b, lobex.Chebyshev(12)) == pytest.approx(abs(act_and_wait(b)), rel=1e-12)


@pytest.mark.parametrize("b", [-1.2, 1.6])
def test_what_acts_now_need_not_be_what_is_remembered(b):
    assert radius(Damper(), b, lobex.Chebyshev(24)) == pytest.approx(damper(b), rel=1e-11)


def test_collocation_converges_geometrically():
    case = KNOWN["mathieu"][0]
    exact = np.hypot(*case["mu"])
    errors = [abs(radius(mathieu(case), case["b"], lobex.Chebyshev(n)) / exact - 1) for n in (8, 16)]
    assert errors[1] < errors[0] / 1e3


# --- semi-discretization: where a sample falls within a delay moves the constant, so that it is kept nearly the same
# (a delay that was rounded to whole steps would leave the first order)

ORDERS = [(case, order) for case, order in zip(KNOWN["mathieu"][::2], (1, 2, 0, 1), strict=True)]


@pytest.mark.parametrize(("case", "order"), ORDERS, ids=lambda part: part["ratio"] if isinstance(part, dict) else part)
def test_semi_discretization_is_of_second_order_whatever_the_delay(case, order):
    # Of the golden section, Fibonacci's numbers nearly divide the delay.
    steps = (34, 89) if case["ratio"] == "golden" else (40, 80)
    found = fitted_order(mathieu(case), case["b"], np.hypot(*case["mu"]), order, steps)
    assert found == pytest.approx(2, abs=0.2)


@pytest.mark.parametrize("order", [0, 1])
def test_semi_discretization_is_of_second_order_with_a_delay_that_varies(order):
    case = KNOWN["speed_variation"][1]
    exact = np.hypot(*case["mu"])
    assert fitted_order(speed_variation(case), case["gain"], exact, order, (80, 160)) == pytest.approx(2, abs=0.3)


@pytest.mark.parametrize("order", [0, 1, 2])
def test_semi_discretization_is_of_second_order_over_jumps_with_several_delays(order):
    # Each jump and delay is a whole number of steps, or not: the error stays below the same constant over k².
    scaled = [
        k**2 * abs(radius(ACT_AND_WAIT, 1.5, lobex.SemiDiscretization(k, order)) / act_and_wait(1.5) - 1)
        for k in (40, 83)
    ]
    assert max(scaled) < 2.0


def test_semi_discretization_remembers_what_does_not_act_now():
    exact = damper(1.6)
    assert fitted_order(Damper(), 1.6, exact, 1, (20, 40)) == pytest.approx(2, abs=0.2)


# --- marches


def marched(process, gain, steps):
    return float(lobex.march_delay(process, 1.0, gain, np.cos, 24, steps).growth)


def test_marches_are_of_second_order_over_jumps_with_several_delays():
    exact = act_and_wait(1.5)
    errors = [abs(marched(ACT_AND_WAIT, 1.5, steps) / exact - 1) for steps in (40, 160)]
    assert errors[0] < 3e-3
    assert errors[1] < errors[0] / 10


def test_marches_remember_what_does_not_act_now_for_longer_than_a_period():
    errors = [abs(marched(Damper(), 1.6, steps) / damper(1.6) - 1) for steps in (20, 80)]
    assert errors[1] < errors[0] / 10
    assert errors[1] < 1e-3


def test_marches_follow_a_delay_that_varies():
    case = KNOWN["speed_variation"][1]
    growth = marched(speed_variation(case), case["gain"], 400)
    assert growth == pytest.approx(np.hypot(*case["mu"]), rel=1e-3)


def test_a_march_refuses_delays_shorter_than_a_step():
    with pytest.raises(
        ValueError, match=r"steps_per_period = 3 is too few for a delay of 0\.3 periods.*give 4 or more"
    ):
        lobex.march_delay(ACT_AND_WAIT, 1.0, 0.5, np.cos, 4, 3)


# --- verbs, sizes and refusals


def test_charts_and_limits_of_a_delay_that_is_not_the_period():
    case = KNOWN["mathieu_limits"][0]
    process, method = mathieu(case), METHODS[0]
    limit = lobex.critical_gain(process, [1.0], (-1.5, 1.5), method, scan=17)
    assert limit.intervals[0] == pytest.approx(np.array([case["b"]]), rel=1e-8)
    chart = lobex.sweep(process, [1.0], limit.intervals[0, 0], method)
    assert chart.spectral_radius[0] == pytest.approx(1, abs=1e-8)


@pytest.mark.parametrize("method", METHODS, ids=repr)
@pytest.mark.parametrize(
    "process", [ACT_AND_WAIT, Damper(), mathieu(KNOWN["mathieu"][2])], ids=["jumps", "two", "long"]
)
def test_sizes_are_those_of_the_operators(process, method):
    with jax.enable_x64(True):
        system = process.system(1.0, 0.5)
        matrix = jax.eval_shape(lambda: method.operator(system).matrix)
        assert matrix.shape == (method.size(system), method.size(system))


@pytest.mark.parametrize(
    ("method", "words"),
    [
        (lobex.Chebyshev(aligned=False), "aligned = False takes systems whose only delay is the period"),
        (lobex.Chebyshev(full=True), "full = True takes systems"),
        (lobex.SemiDiscretization(full=True), "full = True takes systems"),
    ],
    ids=["single", "whole state", "whole state by steps"],
)
def test_what_a_method_cannot_serve_is_refused(method, words):
    for verb in (lobex.spectral_radius, lobex.sweep):
        with pytest.raises(ValueError, match=words) as error:
            verb(ACT_AND_WAIT, [1.0], [0.5], method)
        assert "\n" not in str(error.value)


@pytest.mark.parametrize(("delay", "said"), [(0.02, (0.9, 1.1)), (0.35, (0.1, 0.2))], ids=["shorter", "longer"])
@pytest.mark.parametrize("method", [*METHODS, lobex.Duhamel(12)], ids=repr)
def test_a_delay_that_is_not_what_was_said_makes_no_number(method, delay, said):
    process = lobex.LinearDelay([[-0.5]], [([[0.5]], delay)], period=1.0, delay_range=said)
    matrix = jax.jit(lambda speed: method.operator(process.system(speed, 0.0)).matrix)(1.0)
    assert np.isnan(np.asarray(matrix)).any()
