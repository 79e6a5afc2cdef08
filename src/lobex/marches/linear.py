"""The march of one delay system, in pure JAX: periods of steps, each period fed the record of the one before."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from lobex.marches.stepping import step_of, times
from lobex.systems.system import DelaySystem

Array = Any


class Motion(NamedTuple):
    """What a march leaves: y at the kept steps, (periods, steps/every, r), and z after every period, (periods, d)."""

    output: Array
    states: Array


def march_system(system: DelaySystem, past: Array, state: Array, periods: int, every: int = 1) -> Motion:
    """March ż = A z + E [P y + Q y(t − τ)] from t = 0 on, in equal steps of τ/steps.

    The free motion of every block is exact, so stiff modes cost nothing and do not limit the step. The force is that
    of the exact means of P and Q over the step times the means of y and y(t − τ) at its ends, with the present y
    implicit (a trapezoidal rule): second order in the step, also where a coefficient jumps within one, since
    the impulse of a constant y is exact there.

    Args:
        system: the delay system of one point.
        past: y over [−τ, 0] at equal distances, both ends included, (steps + 1, r).
        state: z(0), (d,).
        periods: how many delays to march.
        every: which steps are kept; a divisor of the number of steps.
    """
    steps = np.shape(past)[0] - 1
    n, s, r = np.shape(system.inputs)
    step = step_of(system, system.period / steps)
    edges = jnp.arange(steps + 1) / steps
    constant = system.constant
    starts, stops = (edges[:1], edges[1:2]) if constant else (edges[:-1], edges[1:])
    # f = P (y + y₊)/2 + Q w with y₊ = (output after free motion) + C R f, solved for f once and for all.
    present, (delayed,) = system.mean(starts, stops)
    implicit = jnp.eye(r) - present @ step.compliance / 2
    coefficients = jnp.linalg.solve(implicit, present / 2), jnp.linalg.solve(implicit, delayed)
    if constant:
        coefficients = (coefficients[0][0], coefficients[1][0])

    def advance(carry: tuple[Array, Array], given: Any) -> tuple[tuple[Array, Array], Array]:
        z, y = carry
        mean_past, (of_present, of_past) = (given, coefficients) if constant else given
        free = step.free(z)
        free_output = step.output(free)
        force = times(of_present, y + free_output) + times(of_past, mean_past)
        y = free_output + times(step.compliance, force)
        return (free + step.push(force), y), y

    def one_period(carry: tuple[Array, Array], _: None) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        z, record = carry
        means = (record[:-1] + record[1:]) / 2
        first = step.output(z)
        (z, _), after = jax.lax.scan(advance, (z, first), means if constant else (means, coefficients))
        record = jnp.concatenate([first[None], after])
        return (z, record), (after[every - 1 :: every], z.reshape(-1))

    start = jnp.reshape(state, (n, s)), past
    return Motion(*jax.lax.scan(one_period, start, None, length=periods)[1])
