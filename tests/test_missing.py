"""What does not exist has no derivative: NaN, which hides none of what does exist."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lobex
from cases import MILL
from lobex._missing import where_there, without_derivative
from lobex.limits.d_subdivision import exact_branches, exact_critical, exact_minimum
from lobex.limits.hayes import hayes_interval
from lobex.limits.receptance import Receptance, receptance

ONE = lobex.Modes.single(frequency=100.0, damping_ratio=0.02, mass=1.0)
# Of which the first is that of the lowest speed.
TABLE = lobex.ModesOverSpeed.from_modes([50.0, 100.0], [lobex.Modes([own], [0.02], [[1.0]]) for own in (600.0, 650.0)])
FEW = lobex.Chebyshev(16)
BAND, SPEEDS = (101.0, 120.0), [1000.0, 70.0]


def measured(share, first, last):
    """Of a mode, in a band, Hz, its damping so many times that of ``ONE``."""
    omega = 2 * np.pi * np.linspace(first, last, 41)
    response = 1 / (ONE.angular_frequency**2 - omega**2 + 2j * share * 0.02 * ONE.angular_frequency * omega)
    return Receptance(np.linspace(first, last, 41), response)


def damped(share, ratio=0.02):
    return lobex.Modes(ONE.angular_frequency, jnp.asarray([ratio]) * share, ONE.shape)


def immersed(share):
    return lobex.Milling(MILL.modes, MILL.teeth, share * MILL.tangential, MILL.normal, MILL.radial_immersion)


# One number that exists and one that does not, as functions of a share: of damping, unless the name says another.
NUMBERS = {
    "beyond a band": lambda share: lobex.exact_limit(lobex.Rub(measured(share, *BAND)), SPEEDS).gain,
    "its frequency": lambda share: lobex.exact_limit(lobex.Rub(measured(share, *BAND)), SPEEDS).chatter_frequency,
    "undamped": lambda share: lobex.exact_limit(lobex.Rub(damped(share, 0.0)), [50.0, 61.0]).gain,
    "Hayes' by the rate": lambda share: lobex.exact_limit(lobex.Scalar(share), [0.5, 2.0]).intervals[:, 0, 0],
    "his frequency by the rate": lambda share: hayes_interval(share, np.array([0.5, 2.0])).angular_frequency,
    "unstable at the lowest": lambda share: exact_critical(damped(share), np.array([95.0, 70.0]), lowest=5e4).gain,
    "nothing at the contact": lambda share: jnp.stack(
        [exact_minimum(lobex.Modes([600.0], [0.02 * share], [[seen]])).gain for seen in (0.0, 1.0)]
    ),
    "a receptance that does not oppose": lambda share: exact_branches(damped(share), np.array([500.0, 700.0])).gain,
    "nor has it speeds": lambda share: exact_branches(damped(share), np.array([500.0, 700.0])).speed[0],
    "a response beyond a band": lambda share: receptance(measured(share, *BAND), np.array([600.0, 650.0])).real,
    "modes beyond a table, by the speed": lambda share: jnp.stack(
        [TABLE.at(share * speed).angular_frequency[0] for speed in (120.0, 70.0)]
    ),
    "none between bounds": lambda share: lobex.critical_gain(lobex.Rub(damped(share)), [70.0, 95.0], (0.0, 5e4)).gain,
    "none of an operator": lambda share: (
        lobex.critical_gain(immersed(share), [50.0, 133.0], (0.0, 2e-3), FEW, scan=17).gain
    ),
}
# What compiles little.
QUICK = {"his frequency by the rate", "Hayes' by the rate", "modes beyond a table, by the speed"}
EVERY = [pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in NUMBERS]


@pytest.mark.parametrize("name", EVERY)
def test_what_does_not_exist_has_no_derivative_and_hides_none(name):
    numbers, step = NUMBERS[name], 1e-5
    with jax.enable_x64(True):
        # What compiles once does so for all.
        at = jax.jit(lambda share: jax.vjp(numbers, share))
        one, back = at(1.0)
        forward = jax.jit(lambda share: jax.jvp(numbers, (share,), (1.0,))[1])(1.0)
        exists = np.isfinite(one)
        assert np.array_equal(np.isnan(one), ~exists)
        assert set(exists) == {True, False}
        assert np.array_equal(np.isfinite(forward), exists)
        by_each = [float(back(asked)[0]) for asked in jnp.eye(2)]
        assert np.array_equal(np.isfinite(by_each), exists)
        # Of what exists alone, as in a sum over it.
        beside = float(jax.grad(lambda share: jnp.nansum(numbers(share)))(1.0))
        difference = (np.asarray(at(1 + step)[0]) - np.asarray(at(1 - step)[0])) / (2 * step)
    for found in (np.asarray(forward)[exists][0], np.asarray(by_each)[exists][0], beside):
        assert found == pytest.approx(difference[exists][0], rel=1e-6, abs=1e-12)


@pytest.mark.slow
def test_a_mark_passes_through_every_transformation():
    there, x = np.array([True, False, True]), np.array([1.0, 2.0, 3.0])
    with jax.enable_x64(True):
        marked = jax.vmap(jax.jit(jax.value_and_grad(lambda here, x: where_there(here, x**2), argnums=1)))(there, x)
        assert np.asarray(marked) == pytest.approx(np.array([[1, np.nan, 9], [2, np.nan, 6]]), nan_ok=True)
        least = jax.grad(lambda a: jnp.nanmin(where_there(there, (a * x) ** 2)))(2.0)
        assert least == 4.0
        twice = jax.hessian(lambda a: jnp.nansum(where_there(there, (a * x) ** 2)))(2.0)
        assert twice == 20.0
        unknown = jax.value_and_grad(lambda a: without_derivative(jnp.asarray(3.0), a))(2.0)
        assert unknown[0] == 3.0
        assert np.isnan(unknown[1])


@pytest.mark.slow
def test_the_chatter_frequency_of_an_operator_has_no_derivative():
    """It is not computed: a zero would be a wrong one."""

    def both(speed):
        limit = lobex.critical_gain(MILL, speed, (0.0, 2e-3), FEW, scan=17)
        return limit.chatter_frequency[0], limit.gain[0]

    with jax.enable_x64(True):
        slopes = jax.jit(jax.jacrev(both))(133.0)
    assert np.isnan(slopes[0])
    assert np.isfinite(slopes[1])
