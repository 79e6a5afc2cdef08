"""Systems that are not what they declare: every verb refuses them in one line, before it computes."""

import warnings
from dataclasses import replace
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.tree_util import Partial
from scipy.special import lambertw

import lobex
from lobex._pytree import pytree
from lobex.processes.quantity import PLAIN_GAIN, Quantity
from lobex.systems.coefficients import Constant, Function, Piece
from lobex.systems.delays import ConstantDelay, Varying, WholePeriod
from lobex.systems.system import DelaySystem
from lobex.systems.terms import Delayed, Forcing, Present, Regenerative

SPEEDS, GAINS = [1.0, 2.0], [0.25, 0.5]
BOUNDS = 0.25, 0.5
VERBS = {
    "sweep": lambda p: lobex.sweep(p, SPEEDS, GAINS),
    "sweep by nodes": lambda p: lobex.sweep(p, SPEEDS, GAINS, lobex.Chebyshev(8)),
    "study": lambda p: lobex.sweep(p, SPEEDS, GAINS, over={"drift": [-2.0, -1.0]}),
    "spectral_radius": lambda p: lobex.spectral_radius(p, SPEEDS, GAINS),
    "spectral_radius by nodes": lambda p: lobex.spectral_radius(p, SPEEDS, GAINS, lobex.Chebyshev(8)),
    "multipliers": lambda p: lobex.multipliers(p, SPEEDS, GAINS),
    "monodromy": lambda p: lobex.monodromy(p, SPEEDS, GAINS, lobex.Duhamel(8)),
    "critical_gain": lambda p: lobex.critical_gain(p, SPEEDS, BOUNDS),
    "boundary": lambda p: lobex.boundary(p, SPEEDS, GAINS),
    "sensitivities": lambda p: lobex.sensitivities(p, SPEEDS, bounds=BOUNDS),
    "march_delay": lambda p: lobex.march_delay(p, SPEEDS, GAINS, np.cos, 3, 40),
}


def lag(numbers, t, speed, gain):
    """A delay about numbers[0], no number where its cosine exceeds numbers[2]."""
    wave = jnp.cos(2 * jnp.pi * t)
    return jnp.where(wave > numbers[2], jnp.nan, numbers[0] + numbers[1] * wave + numbers[3] * (speed - 1) * gain)


def jumping(t, speed, gain):
    """At three tenths of a period of ``turn`` by 1."""
    return jnp.reshape(gain * (t > 0.3 * (3 - speed)), (1, 1))


def nowhere(t, speed, gain):
    return jnp.reshape(gain * jnp.log(-1 - t), (1, 1))


def turn(factor, speed, gain):
    return factor * (3 - speed)


@pytree(static=("fault",))
class Own:
    """x' = −x + g(t) x(t − τ(t)), with a fault of its form if it has one."""

    drift: float
    numbers: np.ndarray
    breaks: np.ndarray
    factor: float
    fault: str = ""

    gain: ClassVar[Quantity] = PLAIN_GAIN
    speed_unit: ClassVar[str] = "1"

    def system(self, speed, gain) -> Any:
        period = turn(self.factor, speed, gain)
        force = Function(Partial(jumping), speed, gain, period, self.breaks)
        sound = {
            "blocks": jnp.reshape(self.drift, (1, 1, 1)),
            "inputs": jnp.ones((1, 1, 1)),
            "outputs": jnp.ones((1, 1, 1)),
            "period": period,
            "terms": (Delayed(force, Varying(Partial(lag, self.numbers), speed, gain)),),
            "longest": 1.0,
            "shortest": 0.1,
        }
        if self.fault == "no system":
            return sound
        return DelaySystem(**sound | (FORMS[self.fault][0](speed, gain) if self.fault else {}))


def as_function(function):
    return lambda speed, gain: {"terms": (Delayed(Function(Partial(function), speed, gain, 1.0, jnp.zeros(0))),)}


def delayed_by(function):
    return lambda speed, gain: {
        "terms": (Delayed(Constant(jnp.ones((1, 1))), Varying(Partial(function), speed, gain)),)
    }


NUMBERS = np.array([0.5, 0.0, 2.0, 0.0])
SOUND = Own(-1.0, NUMBERS, np.array([0.0, 0.3]), 1.0)
GIVEN = lobex.LinearDelay(
    -1.0,
    [(Partial(lambda t, speed, gain: jumping(t, speed, gain)), Partial(lag, NUMBERS))],
    period=Partial(turn, 1.0),
    breaks=[0.0, 0.3],
    delay_range=(0.1, 1.0),
)


def with_delay(process, numbers):
    if isinstance(process, Own):
        return replace(process, numbers=np.array(numbers))
    return replace(process, delayed=[(process.delayed[0][0], Partial(lag, np.array(numbers)))])


def with_period(process, factor):
    if isinstance(process, Own):
        return replace(process, factor=factor)
    return replace(process, period=Partial(turn, factor))


# A period is 2 at speed 1, and 1 at speed 2.
FAULTS = {
    "negative": (
        with_delay,
        [-0.5, 0.0, 2.0, 0.0],
        r"the delay of delayed\[0\] is -0.25 periods at .*; give one above 0",
    ),
    "negative somewhere": (
        with_delay,
        [0.5, 0.8, 2.0, 0.0],
        r"delayed\[0\] is -0.0.* periods at speed = .*t/T = 0.\d+;",
    ),
    "none somewhere": (
        with_delay,
        [0.5, 0.0, 0.9, 0.0],
        r"the delay of delayed\[0\] is nan periods at .*; give one abo",
    ),
    "none": (
        with_delay,
        [np.inf, 0.0, 2.0, 0.0],
        r"the delay of delayed\[0\] is inf periods at .* and the longest, 1, as",
    ),
    "too long at an end": (
        with_delay,
        [0.5, 0.0, 2.0, 1.2],
        r"delayed\[0\] is 1.1 periods at speed = 2, gain = 0.5, t/T = 0; that is not between the shortest, 0.1, and",
    ),
    "too short at an end": (
        with_delay,
        [0.5, 0.0, 2.0, -0.9],
        r"delayed\[0\] is 0.05 periods at speed = 2, gain = 0.5, t/T = 0; that is not between the shortest, 0.1, and",
    ),
    "no period": (with_period, 0.0, "its period is 0 s at speed = 1, gain = .*; give a finite one above 0"),
    "negative period": (with_period, -1.0, "its period is -2 s at speed = 1, gain = .*; give a finite one above 0"),
    "nan period": (with_period, np.nan, "its period is nan s at speed = 1, gain = .*; give a finite one above 0"),
}


def refused(call, process, message):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ValueError, match=message) as caught:
            call(process)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("process", [SOUND, GIVEN], ids=["own", "given"])
def test_numbers_that_are_not_what_is_declared_are_refused(process, fault, verb):
    change, value, message = FAULTS[fault]
    bad = change(process, value)
    said = refused(VERBS[verb], bad, message)
    assert said.startswith(f"process = {type(process).__name__}: ")


@pytest.mark.parametrize("verb", VERBS)
def test_matrices_and_functions_that_are_nowhere_finite_are_refused(verb):
    # A study puts other numbers in the place of the structure's.
    if verb != "study":
        refused(
            VERBS[verb], replace(SOUND, drift=np.inf), "its structure has values that are not finite at speed = .*;"
        )
    lost = lobex.LinearDelay(-1.0, [(Partial(nowhere), 0.5)], period=1.0)
    refused(VERBS[verb], lost, "its force has values that are not finite at speed = .*; give finite")


@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize("place", [1.2, -0.1, np.nan])
def test_breaks_outside_of_the_period_are_refused(place, verb):
    message = f"process = Own: one of its breaks is {place:.6g} at speed = 1, gain = .*; give phases t/T from 0 to 1"
    refused(VERBS[verb], replace(SOUND, breaks=np.array([0.0, place])), message)


FORMS = {
    "blocks": (
        lambda s, g: {"blocks": jnp.ones((1, 2, 3))},
        r"its blocks have the shape \(1, 2, 3\); give \(n, s, s\)",
    ),
    "inputs": (lambda s, g: {"inputs": jnp.ones((1, 3, 1))}, r"its inputs has the shape \(1, 3, 1\) where blocks have"),
    "inputs of a matrix": (
        lambda s, g: {"inputs": jnp.ones((1, 1))},
        r"its inputs has the shape \(1, 1\) where blocks",
    ),
    "outputs": (lambda s, g: {"outputs": jnp.ones((1, 1, 2))}, r"its outputs has the shape \(1, 1, 2\) where blocks"),
    "remembered": (lambda s, g: {"remembered": jnp.ones((2, 1, 1))}, r"its remembered has the shape \(2, 1, 1\) where"),
    "period": (
        lambda s, g: {"period": jnp.ones(2)},
        r"its period has the shape \(2,\); give one number",
    ),
    "matrix": (
        lambda s, g: {"terms": (Delayed(Constant(jnp.ones((2, 3))), ConstantDelay(0.5)),)},
        r"its terms\[0\].coefficient has the shape \(2, 3\); give \(1, 1\)",
    ),
    "present matrix": (
        lambda s, g: {"terms": (Delayed(Constant(jnp.ones((1, 1)))), Present(Constant(jnp.ones((1, 2)))))},
        r"its terms\[1\].coefficient has the shape \(1, 2\); give \(1, 1\)",
    ),
    "remembered apart": (
        lambda s, g: {"terms": (Regenerative(Constant(jnp.ones((1, 1)))),), "remembered": jnp.ones((1, 2, 1))},
        r"its terms\[0\].coefficient has the shape \(1, 1\); give \(1, 2\)",
    ),
    "function": (
        as_function(lambda t, s, g: jnp.ones((2, 3))),
        r"its terms\[0\].coefficient has the shape \(2, 3\); give \(1, 1\)",
    ),
    "function of a number": (as_function(lambda t, s, g: g), r"its terms\[0\].coefficient has the shape \(\); give"),
    "decides by time": (
        as_function(lambda t, s, g: jnp.array([[1.0 if t > 0.5 else 0.0]])),
        r"cannot be traced by JAX \(TracerBoolConversionError: .*\); write it with jax.numpy",
    ),
    "by NumPy": (
        as_function(lambda t, s, g: np.sin(t).reshape(1, 1)),
        r"cannot be traced by JAX \(TracerArrayConversionError: .*\); write it with jax.numpy",
    ),
    "fails": (as_function(lambda t: t), r"cannot be traced by JAX \(TypeError: .*positional.*\); write it"),
    "delay": (delayed_by(lambda t, s, g: jnp.ones(2)), r"its terms\[0\].delay has the shape \(2,\); give one number"),
    "delay by time": (
        delayed_by(lambda t, s, g: 0.5 if t < 0.5 else 1.0),
        r"traced by JAX \(TracerBoolConversionError",
    ),
    "no terms": (lambda s, g: {"terms": ()}, "its system has 0 terms that answer the motion"),
    "forcing alone": (lambda s, g: {"terms": (Forcing(Constant(jnp.ones((1, 1)))),)}, "its system has 0 terms that"),
    "coefficient for a term": (
        lambda s, g: {"terms": (Constant(jnp.ones((1, 1))),)},
        r"its terms\[0\] has a Constant; give a Present, Delayed",
    ),
    "array for a coefficient": (
        lambda s, g: {"terms": (Delayed(np.ones((1, 1))),)},
        r"its terms\[0\] has a ndarray; give a coefficient, such as Constant",
    ),
    "number for a delay": (
        lambda s, g: {"terms": (Delayed(Constant(jnp.ones((1, 1))), 0.5),)},
        r"its terms\[0\] has a float; give a delay, such as ConstantDelay",
    ),
    "complex matrix": (
        lambda s, g: {"terms": (Delayed(Constant(jnp.full((1, 1), 1j))),)},
        r"its terms\[0\].coefficient is of the type complex128; give real numbers",
    ),
    "complex structure": (
        lambda s, g: {"blocks": jnp.full((1, 1, 1), -1 + 2j)},
        "its blocks is of the type complex128; give real numbers",
    ),
    "whole numbers": (
        lambda s, g: {"outputs": jnp.ones((1, 1, 1), dtype=int)},
        "its outputs is of the type int64; give real numbers",
    ),
    "range": (lambda s, g: {"longest": 0.1, "shortest": 0.5}, "shortest = 0.5 and longest = 0.1 periods; give"),
    "no system": (None, "its system is .*; return a DelaySystem"),
}


@pytest.mark.parametrize("verb", [*VERBS, "exact_limit"])
@pytest.mark.parametrize("fault", FORMS)
def test_a_system_that_cannot_be_is_refused(fault, verb):
    call = VERBS.get(verb, lambda process: lobex.exact_limit(process, SPEEDS))
    said = refused(call, replace(SOUND, fault=fault), FORMS[fault][1])
    assert said.startswith("process = Own: ")


@pytest.mark.parametrize("verb", ["sweep", "spectral_radius by nodes", "march_delay"])
@pytest.mark.parametrize(
    ("function", "message"),
    [
        (
            lambda t, speed, gain: 1.0 if t > 0.5 else 0.0,
            r"delayed\[0\] cannot be traced by JAX; write it with jax.numpy",
        ),
        (lambda t, speed, gain: jnp.ones((2, 3)), r"delayed\[0\] returns the shape \(2, 3\); return \(1, 1\)"),
    ],
)
def test_functions_of_an_equation_are_refused_by_their_names(verb, function, message):
    refused(VERBS[verb], lobex.LinearDelay(-1.0, [(function, None)]), message)


def early(t, speed, gain):
    return gain * (t > 0.29 * (3 - speed))


def other_period(t, speed, gain):
    return gain * jnp.cos(t)


def sampled(t, speed, gain):
    return 0.2 + jnp.mod(t, 0.5 * (3 - speed))


@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize(
    ("changed", "place"),
    [
        ({"delayed": [(early, None)]}, "0.29"),
        ({"delayed": [(other_period, None)], "breaks": []}, "0"),
        ({"delayed": [(jumping, None)], "breaks": [0.3]}, "0"),
        ({"delayed": [(1.0, sampled)]}, "0.5"),
    ],
)
def test_jumps_that_no_break_names_are_refused(changed, place, verb):
    bad = replace(GIVEN, **changed, delay_range=(0.1, 1.0))
    refused(VERBS[verb], bad, rf"what follows the time jumps by [\d.]+ % at t/T = {place} at speed = .*; name it in")


@pytree(static=("fault",))
class Wave:
    """1 + 0.5 cos 2πt/T, with a fault in one of its functions."""

    value: float
    fault: str = ""

    @property
    def constant(self) -> bool:
        return self.fault == "constant"

    def pieces(self):
        return {
            "pieces": (Piece(0.0, 0.5, False), Piece(0.5, 0.3, False)),
            "idle": (Piece(0.0, 0.5, False), Piece(0.5, 0.5, True)),
        }.get(self.fault, ())

    def at(self, phase):
        return self.value * (1 + 0.5 * jnp.cos(2 * jnp.pi * phase))[:, None, None]

    def within(self, inside, phase):
        return (2 if self.fault == "within" else 1) * self.at(phase)

    def mean(self, start, stop):
        exact = jnp.diff(jnp.sin(2 * jnp.pi * jnp.stack([start, stop])), axis=0)[0] / (4 * jnp.pi * (stop - start))
        return (self.value * (1 + (0 if self.fault == "mean" else 1) * exact))[:, None, None]


@pytree()
class Lengthening(ConstantDelay):
    """One that is said to be constant, and follows the time."""

    def shares(self, phase, period):
        return self.delay / period * (1 + 0.5 * jnp.cos(2 * jnp.pi * phase))


@pytree()
class Shorter(WholePeriod):
    def shares(self, phase, period):
        return jnp.full_like(phase, 0.5)


@pytree()
class Waving:
    """x' = −x + g (1 + 0.5 cos 2πt) x(t − τ)."""

    coefficient: Wave
    delay: Any

    gain: ClassVar[Quantity] = PLAIN_GAIN
    speed_unit: ClassVar[str] = "1"

    def system(self, speed, gain) -> Any:
        one = jnp.ones((1, 1, 1))
        terms = (Delayed(replace(self.coefficient, value=gain), self.delay),)
        return DelaySystem(-one, one, one, jnp.asarray(1.0), terms, longest=1.0, shortest=0.1)


@pytest.mark.parametrize("verb", ["sweep", "spectral_radius by nodes", "critical_gain", "march_delay"])
@pytest.mark.parametrize(
    ("process", "message"),
    [
        (Waving(Wave(1.0, "constant"), WholePeriod()), "says that it is constant, and is not at speed"),
        (Waving(Wave(1.0, "pieces"), WholePeriod()), "has pieces that do not follow one another through a period"),
        (Waving(Wave(1.0, "idle"), WholePeriod()), "is at work in a piece that it calls idle"),
        (Waving(Wave(1.0, "within"), WholePeriod()), "is not the same by within as by at, inside of a piece"),
        (Waving(Wave(1.0, "mean"), WholePeriod()), "has another mean than what its at gives"),
        (Waving(Wave(1.0), Lengthening(0.5)), r"the delay of delayed\[0\] is not what its class says"),
        (Waving(Wave(1.0), Shorter()), r"the delay of delayed\[0\] is not what its class says"),
    ],
)
def test_classes_of_ones_own_that_contradict_themselves_are_refused(process, message, verb):
    refused(VERBS[verb], process, f"process = Waving: .*{message}")


def test_a_coefficient_of_ones_own_is_computed():
    """ln μ = A + B/μ of the means over a period (design, exact results)."""
    process, value = Waving(Wave(1.0), WholePeriod()), 0.5 / lambertw(0.5 * np.e).real
    for method in (lobex.Auto(), lobex.Chebyshev(20)):
        assert lobex.spectral_radius(process, 1.0, 0.5, method) == pytest.approx(value, rel=1e-8)


@pytest.mark.parametrize("process", [SOUND, GIVEN], ids=["own", "given"])
def test_what_is_sound_is_computed(process):
    # By Heun's rule of 2000 steps, in NumPy.
    assert lobex.spectral_radius(process, 2.0, 0.5, lobex.Chebyshev(8)) == pytest.approx(0.58129696, abs=2e-8)


def test_only_points_that_are_asked_for_are_looked_at():
    """The delay is 1.1 periods at speed 2 and gain 0.5 together, which no point of a list has."""
    bad = with_delay(SOUND, FAULTS["too long at an end"][1])
    values = lobex.spectral_radius(bad, [1.0, 2.0], [0.5, 0.25], lobex.Chebyshev(8))
    assert np.isfinite(values).all()


@pytest.mark.slow
def test_of_traced_numbers_nothing_is_asked():
    def growth(value):
        return lobex.spectral_radius(with_delay(SOUND, NUMBERS), 2.0, value, lobex.Chebyshev(8))

    with jax.enable_x64(True):
        assert np.isfinite(jax.jit(jax.grad(growth))(0.5))
