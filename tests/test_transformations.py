"""Models of JAX arrays, and verbs under jit, grad, vmap and jacrev: the numbers of the plain verbs, or one line."""

from dataclasses import dataclass
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lobex
from cases import ROD
from lobex.processes.quantity import Quantity
from refusals import refused
from test_critical_constant import PAIR

# Numbers that float32 holds, so that a model made of them is the same in both precisions.
FREQUENCY, DAMPING, SHAPE = np.array([2000.0, 5000.0]), np.array([1 / 32, 1 / 64]), np.array([[1.0], [0.75]])
BOUNDS = (1e3, 1e7)
FEW = lobex.Chebyshev(12)


def rub(lib):
    return lobex.Rub(lobex.Modes(*(lib.asarray(part) for part in (FREQUENCY, DAMPING, SHAPE))))


def mill(lib):
    modes = lobex.Modes(*(lib.asarray(part) for part in (FREQUENCY, DAMPING, SHAPE)))
    return lobex.Milling(modes, 1, *(lib.asarray(part) for part in (5e8, 2e8, 0.5)))


def kick(time):
    return 0 * time + 1e-6


PLAIN = {
    "radius": (rub, lambda model: lobex.spectral_radius(model, [90.0, 100.0], 1e5, FEW)),
    "radius of milling": (mill, lambda model: lobex.spectral_radius(model, 100.0, 1e-3, FEW)),
    "sweep": (rub, lambda model: lobex.sweep(model, [90.0, 100.0], [1e5, 2e5]).spectral_radius),
    "sweep of milling": (mill, lambda model: lobex.sweep(model, [90.0, 100.0], [1e-3, 2e-3], FEW).spectral_radius),
    "limit": (rub, lambda model: lobex.critical_gain(model, [90.0, 100.0], BOUNDS).gain),
    "limit of milling": (mill, lambda model: lobex.critical_gain(model, [100.0], (0.0, 2e-2), FEW, scan=9).gain),
    "exact limit": (rub, lambda model: lobex.exact_limit(model, [90.0, 100.0]).gain),
    "lobes": (rub, lambda model: lobex.exact_lobes(model, 2).minimum.gain),
    "sensitivities": (rub, lambda model: lobex.sensitivities(model, [90.0, 100.0]).logarithmic),
    "march": (mill, lambda model: lobex.march_delay(model, 100.0, 1e-3, kick, 2, 200).multiplier),
}
LONG = ("sweep of milling", "limit of milling", "sensitivities")


@pytest.mark.parametrize(
    "verb", [pytest.param(verb, marks=pytest.mark.slow) if verb in LONG else verb for verb in PLAIN]
)
def test_models_of_jax_arrays_are_those_of_numpy_inside_and_outside_of_jit(verb):
    make, call = PLAIN[verb]
    expected, model = call(make(np)), make(jnp)
    seen = [call(model)]
    with jax.enable_x64(True):
        seen.append(call(model))
    jax.jit(lambda x: seen.append(call(model)) or x)(1.0)
    jax.grad(lambda x: seen.append(call(model)) or x)(1.0)
    jax.jit(lambda x: seen.append(call(make(np))) or x)(1.0)
    assert len(seen) == 5
    for result in seen:
        np.testing.assert_array_equal(result, expected)


@pytest.mark.slow
@pytest.mark.parametrize(("make", "gain", "bounds"), [(rub, 1e5, BOUNDS), (mill, 1e-3, (0.0, 2e-2))])
def test_a_speed_is_traced_with_a_model_of_float32_arrays_closed_over(make, gain, bounds):
    process = make(jnp)
    assert process.modes.angular_frequency.dtype == jnp.float32
    radius = lobex.spectral_radius(make(np), 100.0, gain, FEW)
    limit = lobex.critical_gain(make(np), 100.0, bounds, lobex.Auto() if make is rub else FEW, scan=9)

    @jax.jit
    def traced(speed):
        found = lobex.critical_gain(process, speed, bounds, lobex.Auto() if make is rub else FEW, scan=9)
        pair = lobex.spectral_radius(process, [speed, 90.0], gain, FEW)
        return pair[0], found.gain[0], found.chatter_frequency[0], found.kind_code[0], found.status_code[0]

    single = traced(100.0)
    assert single[0].dtype == jnp.float32
    assert np.array(single[:2]) == pytest.approx([float(radius), limit.gain[0]], rel=1e-3)
    with jax.enable_x64(True):
        double = [float(part) for part in traced(100.0)]
    expected = [radius, limit.gain[0], limit.chatter_frequency[0], limit.kind_code[0], limit.status_code[0]]
    assert double == pytest.approx([float(part) for part in expected], rel=1e-9)


def stiffness(young_modulus, speed=100.0):
    blade = lobex.Rod(2, young_modulus=young_modulus).modes(0.03)
    return lobex.critical_gain(lobex.Rub(blade), speed, (1e4, 1e7)).gain[0]


@pytest.fixture(scope="module")
def slope():
    """d K/d E, by fourth-order central differences of the plain verb."""
    near = [float(stiffness(210e7 * (1 + 1e-3 * k))) for k in (-2, -1, 1, 2)]
    return (8 * (near[2] - near[1]) - (near[3] - near[0])) / (12 * 210e7 * 1e-3)


@pytest.mark.slow
def test_the_gradient_of_the_critical_gain_through_a_rod_as_jax_comes(slope):
    assert not jax.config.jax_enable_x64
    assert float(jax.grad(stiffness)(210e7)) == pytest.approx(slope, rel=1e-3)


@pytest.mark.slow
def test_the_gradient_of_the_critical_gain_through_a_rod_in_every_form(slope):
    many = np.array([0.5, 1.0, 2.0]) * 210e7
    with jax.enable_x64(True):
        value, (by_modulus, by_speed) = jax.jit(
            jax.vmap(jax.value_and_grad(stiffness, argnums=(0, 1)), in_axes=(0, None))
        )(many, 100.0)
        reverse = jax.jit(jax.jacrev(jax.vmap(stiffness)))(many)
        forward = jax.jit(jax.jacfwd(stiffness))(210e7)
    assert np.asarray(value) == pytest.approx([float(stiffness(e)) for e in many], rel=1e-11)
    assert float(by_modulus[1]) == pytest.approx(slope, rel=1e-8)
    # E → αE, f → √α f is K → αK: closed form.
    assert many * np.asarray(by_modulus) + 50.0 * np.asarray(by_speed) == pytest.approx(np.asarray(value), rel=1e-9)
    assert np.asarray(reverse) == pytest.approx(np.diag(by_modulus), rel=1e-9, abs=1e-20)
    assert float(forward) == pytest.approx(float(by_modulus[1]), rel=1e-9)


@pytest.mark.slow
def test_the_traced_limit_is_the_plain_one_above_a_first_unstable_interval_too():
    speed = np.linspace(60, 300, 41)
    statuses = set()
    for bounds in ((1e3, 1e6), (1.9e6, 4e6), (4.5e5, 4e6)):
        limit = lobex.critical_gain(PAIR, speed, bounds)
        with jax.enable_x64(True):
            traced = jax.jit(lambda s, b=bounds: vars_of(lobex.critical_gain(PAIR, s, b)))(speed)
        assert np.asarray(traced[0]) == pytest.approx(limit.gain, rel=1e-10, nan_ok=True)
        assert np.asarray(traced[1]) == pytest.approx(limit.chatter_frequency, rel=1e-10, nan_ok=True)
        assert np.asarray(traced[2]).tolist() == limit.kind_code.tolist()
        assert np.asarray(traced[3]).tolist() == limit.status_code.tolist()
        statuses |= set(limit.status)
        if bounds[0] == 1.9e6:
            first = lobex.exact_limit(PAIR, speed).gain
            assert np.any(np.isfinite(limit.gain) & (first < bounds[0]))
    assert statuses == {"found", "none in range", "unstable at the lower bound"}


def vars_of(limit):
    return limit.gain, limit.chatter_frequency, limit.kind_code, limit.status_code


@pytest.mark.slow
def test_where_there_is_no_limit_the_derivative_is_no_number():
    with jax.enable_x64(True):
        value, slope = jax.jit(jax.value_and_grad(lambda s: lobex.critical_gain(ROD, s, (1e4, 2e4)).gain[0]))(85.0)
    assert np.isnan([value, slope]).all()


ROWS = [
    (
        lambda x: lobex.sweep(lobex.Rub(lobex.Modes(x, DAMPING, SHAPE)), [90.0], [1e5]),
        "process is traced by JAX; sweep",
    ),
    (lambda x: lobex.sweep(ROD, x, [1e5]), "speed is traced by JAX; sweep"),
    (lambda x: lobex.sweep(ROD, [x[0]], [1e5]), "speed is traced by JAX; sweep"),
    (lambda x: lobex.boundary(ROD, x, [1e5, 2e5]), "speed is traced by JAX; boundary"),
    (lambda x: lobex.sensitivities(ROD, x), "speed is traced by JAX; sensitivities"),
    (lambda x: lobex.critical_gain(ROD, 90.0, (x[0], x[1])), "bounds are traced"),
    (lambda x: lobex.critical_gain(ROD, 90.0, x), "bounds are traced"),
    (lambda x: lobex.exact_lobes(lobex.Rub(lobex.Modes(x, DAMPING, SHAPE))), "process is traced by JAX; exact_lobes"),
    (lambda x: lobex.critical_speeds(lobex.Modes(x, DAMPING, SHAPE)), "modes is traced"),
    (lambda x: lobex.campbell(lobex.Modes(x, DAMPING, SHAPE)), "modes is traced"),
    (lambda x: lobex.growing_history(lobex.Rod(young_modulus=x[0]), 90.0), "rod is traced"),
    (
        lambda x: lobex.march_delay(lobex.Rub(lobex.Modes(x, DAMPING, SHAPE)), 90.0, 1e5, kick, 2, 90),
        "process is traced",
    ),
    (
        lambda x: lobex.simulate_turning(ROD.modes, lobex.Linear(x[0]), 90.0, 1e-3, 1e-4, 2, 90),
        "law is traced",
    ),
    (
        lambda x: lobex.march_wear(ROD.modes, lobex.Casing(2, x[0] * 1e-9), lobex.Linear(1e6), [90.0]),
        "casing is traced",
    ),
    (
        lambda x: lobex.sweep(ROD, [90.0], [1e5], over={"modes.damping_ratio": x}),
        "traced",
    ),
]


@pytest.mark.parametrize(("call", "words"), ROWS)
@pytest.mark.parametrize("transform", [jax.jit, jax.grad])
def test_what_cannot_be_traced_says_so_in_one_line(transform, call, words):
    with refused(words) as error:
        transform(lambda x: call(x) and jnp.sum(x))(jnp.asarray(FREQUENCY))
    assert "give plain numbers" in str(error.value)


class Unknown:
    gain: ClassVar[Quantity] = lobex.Rub.gain
    speed_unit: ClassVar[str] = "Hz"

    def system(self, speed, gain):
        return ROD.system(speed, gain)


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Named(Unknown):
    name: str = "blade"


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Complex(Unknown):
    stiffness: complex = 2.0 + 1.0j


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Nameless:
    def system(self, speed, gain):
        return ROD.system(speed, gain)


class Finer(lobex.Chebyshev):
    """A subclass is no pytree by itself."""


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: lobex.sweep(Unknown(), [90.0], [1e5]), "register_dataclass"),
        (lambda: lobex.critical_gain(Unknown(), [90.0], BOUNDS), "register_dataclass"),
        (lambda: lobex.spectral_radius(Unknown(), 90.0, 1e5), "register_dataclass"),
        (lambda: lobex.march_delay(Unknown(), 90.0, 1e5, kick, 2, 90), "register_dataclass"),
        (lambda: lobex.boundary(Unknown(), [90.0, 91.0], [1e5, 2e5]), "register_dataclass"),
        (lambda: lobex.sweep(Named(), [90.0], [1e5]), "process.name = 'blade' is no number"),
        (lambda: lobex.sweep(Complex(), [90.0], [1e5]), "process.stiffness is complex"),
        (lambda: lobex.march_delay(Complex(), 90.0, 1e5, kick, 2, 90), "process.stiffness is complex"),
        (lambda: lobex.sweep(Nameless(), [90.0], [1e5]), "has no gain"),
        (lambda: lobex.spectral_radius(ROD, 90.0, 1e5, Finer()), "register_dataclass"),
    ],
)
def test_an_own_process_or_method_that_jax_does_not_know_is_refused_in_one_line(call, words):
    with refused(words):
        call()
