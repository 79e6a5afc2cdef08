"""The march of one delay system, in pure JAX: periods of steps, each fed the record of what went before."""

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex._shapes import AnyArray
from lobex.marches.stepping import step_of, times
from lobex.systems.delays import WholePeriod
from lobex.systems.system import DelaySystem

# A loop over so few stretches is written out.
_FEW = 4
# Of a step, what rounding may add to a delay.
_ROUNDING = 1e-6


# z, and the record of w.
_Carry = tuple[Float[AnyArray, "n s"], Float[AnyArray, "back m"]]


class Marched(NamedTuple):
    """What a march leaves: y at the kept steps, (periods, steps/every, r), and z after every period, (periods, d)."""

    output: Float[AnyArray, "*lanes periods steps r"]
    states: Float[AnyArray, "*lanes periods d"]


def steps_back(system: DelaySystem, steps: int) -> int:
    """How many of ``steps`` per period the longest delay reaches back."""
    return int(np.ceil(system.longest * steps - _ROUNDING))


def steps_ahead(system: DelaySystem, steps: int) -> int:
    """For how many of ``steps`` per period all that delays bring is known before; 0 if not for a single one."""
    return int(min(system.shortest * steps + _ROUNDING, steps))


def march_system(
    system: DelaySystem,
    past: Float[AnyArray, "back m"],
    state: Float[AnyArray, " d"],
    steps: int,
    periods: int,
    every: int = 1,
) -> Marched:
    """March ż = A z + E [P y + Σ Q w(t − τ) + g] from t = 0 on, in equal steps of T/steps.

    The free motion of every block is exact, so stiff modes cost nothing and do not limit the step. The force is that
    of the exact means of P, Q and g over the step, P and Q times the means of y and w(t − τ) at its ends, with the
    present y implicit (a trapezoidal rule): second order in the step, also where a coefficient jumps within one, since
    the impulse of a constant y is exact there. Between steps, w is a straight line.

    Args:
        system: the delay system of one point.
        past: w over the longest delay before t = 0 at equal distances, both ends included, (``steps_back`` + 1, m).
        state: z(0), (d,).
        steps: per period; a shortest delay of one at least.
        periods: how many to march.
        every: which steps are kept; a divisor of the number of steps.
    """
    n, s, e = np.shape(system.inputs)
    step = step_of(system, system.period / steps)
    edges = jnp.arange(steps + 1) / steps
    constant = system.constant
    starts, stops = (edges[:1], edges[1:2]) if constant else (edges[:-1], edges[1:])
    # f = P (y + y₊)/2 + Σ Q w with y₊ = (output after free motion) + C R f, solved for f once and for all.
    forces = system.mean(starts, stops)
    implicit = jnp.eye(e) - forces.present @ step.compliance / 2
    coefficients = jax.tree.map(lambda part: jnp.linalg.solve(implicit, part), (forces.present / 2, forces.delayed))
    if constant:
        coefficients = jax.tree.map(lambda part: part[0], coefficients)
    pushes = system.mean_forcing(edges[:-1], edges[1:])
    if pushes is not None:
        pushes = jnp.linalg.solve(implicit, pushes[..., None])[..., 0]
    lags = zip(system.delays, system.lags(edges), strict=True)
    # A period is found without looking.
    places = [None if isinstance(delay, WholePeriod) else _places(steps * lag) for delay, lag in lags]

    def advance(
        carry: tuple[Float[AnyArray, "n s"], Float[Array, " r"]], given: Any
    ) -> tuple[tuple[Float[Array, "n s"], Float[Array, " r"]], tuple[Float[Array, " r"], Any]]:
        z, y = carry
        brought, changing, push = given
        of_present, of_past = coefficients if constant else changing
        free = step.free(z)
        free_output = step.output(free)
        force = times(of_present, y + free_output)
        for matrix, mean in zip(of_past, brought, strict=True):
            force = force + times(matrix, mean)
        if push is not None:
            force = force + push
        y = free_output + times(step.compliance, force)
        z = free + step.push(force)
        return (z, y), (y, None if system.remembered is None else _remembered(system, z))

    def over(
        count: int, carry: tuple[Float[AnyArray, "n s"], Float[Array, " r"], Float[AnyArray, "back m"]], given: Any
    ) -> tuple[tuple[Float[AnyArray, "n s"], Float[Array, " r"], Float[AnyArray, "back m"]], Float[Array, "count r"]]:
        z, y, record = carry
        places, *others = given
        brought = tuple(_means(record, place, steps, count) for place in places)
        # Where z begins is known of itself, whatever the history before it ends in.
        now = y if system.remembered is None else _remembered(system, z)
        (z, y), (outputs, kept) = jax.lax.scan(advance, (z, y), (brought, *others))
        record = [record[count:-1], now[None], outputs if kept is None else kept]
        return (z, y, jnp.concatenate(record)), outputs

    # As many steps are taken at once as the shortest delay lets be known before.
    ahead = steps_ahead(system, steps)
    count, rest = divmod(steps, ahead)
    changing = places, None if constant else coefficients, pushes
    most = jax.tree.map(lambda part: part[: steps - rest].reshape(count, ahead, *part.shape[1:]), changing)
    last = jax.tree.map(lambda part: part[steps - rest :], changing)

    def one_period(
        carry: _Carry, _period: None
    ) -> tuple[
        tuple[Float[AnyArray, "n s"], Float[AnyArray, "back m"]],
        tuple[Float[AnyArray, "kept r"], Float[AnyArray, " d"]],
    ]:
        z, record = carry
        state = z, step.output(z), record
        state, after = jax.lax.scan(partial(over, ahead), state, most, length=count, unroll=count <= _FEW or 1)
        after = after.reshape(steps - rest, -1)
        if rest:
            state, others = over(rest, state, last)
            after = jnp.concatenate([after, others])
        z, _, record = state
        return (z, record), (after[every - 1 :: every], z.reshape(-1))

    start = jnp.reshape(state, (n, s)), past
    return Marched(*jax.lax.scan(one_period, start, None, length=periods)[1])


def _remembered(system: DelaySystem, state: Float[AnyArray, "n s"]) -> Float[Array, " m"]:
    """w = D z of a state (n, s), (m,)."""
    return jnp.sum(system.recalled * state[:, None, :], axis=(0, 2))


def _places(back: Float[Array, " edges"]) -> Float[Array, "steps 2"]:
    """How many steps before each step's start and end what acts there lies, (steps, 2), from a delay in steps."""
    return jnp.stack([back[:-1], back[1:] - 1], axis=1)


def _means(
    record: Float[AnyArray, "back m"], place: Float[Array, "steps 2"] | None, steps: int, count: int
) -> Float[AnyArray, "{count} m"]:
    """The means of what a delay brings to the ends of the next ``count`` steps, (count, m)."""
    now = len(record) - 1
    if place is None:
        found = record[now - steps : now - steps + count + 1]
        return (found[:-1] + found[1:]) / 2
    at = now + jnp.arange(count)[:, None] - place
    before = jnp.clip(jnp.nan_to_num(jnp.floor(at)).astype(int), 0, now - 1)
    share = (at - before)[..., None]
    return jnp.mean((1 - share) * record[before] + share * record[before + 1], axis=1)
