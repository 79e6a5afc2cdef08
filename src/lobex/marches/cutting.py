"""One lane of turning in time, in pure JAX: a structure, a cutting law, and the surface that earlier passes left."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex._shapes import AnyArray, Number
from lobex.contact.laws import ContactLaw
from lobex.marches.stepping import step_of
from lobex.systems.system import DelaySystem

# Newton's method on h + β F(h) = c, with β F' far below 1: linear laws are exact after one.
_NEWTON_STEPS = 4


class Pass(NamedTuple):
    """Tool displacement (m), chip thickness (m) and cutting force (N) at sampled times, each (samples,)."""

    displacement: Float[Array, " *samples"]
    chip_thickness: Float[Array, " *samples"]
    force: Float[AnyArray, " *samples"]


def march_cut(
    system: DelaySystem,
    law: ContactLaw,
    depth: Number,
    feed: Number,
    past: Float[AnyArray, "edges 1"],
    state: Float[AnyArray, " d"],
    revolutions: int,
    every: int = 1,
) -> tuple[Pass, Float[Array, " d"]]:
    """March q from (2.8) with F = b · law(h), where h is how far the tool stands below the lowest surface.

    Seen from the tool's mean path, the surface rises by the feed h₀ in each revolution, w(t) = h₀ + min(w, q)(t − τ).
    The chip is h = w − q where that is positive; elsewhere there is none (Tlusty and Ismail, Basic non-linearity in
    machining chatter, CIRP Annals 30, 1981). One record of w thus holds all earlier passes.
    Free motion is exact and the force follows the trapezoidal rule with its end implicit, as in
    ``march_system``.

    Returns the samples, the start included, and the state (d,) at the end.
    """
    steps = np.shape(past)[0] - 1
    n, s, _ = np.shape(system.inputs)
    step = step_of(system, system.period / steps)
    half = step.compliance[0, 0] / 2

    def force_at(chip: Float[AnyArray, ""]) -> Float[AnyArray, ""]:
        return depth * law.force(chip)

    def chip_at_end(known: Float[AnyArray, ""]) -> Float[Array, ""]:
        """The root h of h + half · F(h) = known, unique since no law falls."""

        def newton(chip: Float[Array, ""], _: None) -> tuple[Float[Array, ""], None]:
            value, slope = jax.jvp(force_at, (chip,), (jnp.ones_like(chip),))
            better = chip - (chip + half * value - known) / (1 + half * slope)
            return jnp.clip(better, 0.0, jnp.maximum(known, 0.0)), None

        chip = jax.lax.scan(newton, jnp.maximum(known, 0.0), None, length=_NEWTON_STEPS, unroll=_NEWTON_STEPS)[0]
        return jnp.where(known > 0, chip, known)

    def advance(
        carry: tuple[Float[Array, "n s"], Float[AnyArray, ""]], surface: Float[AnyArray, ""]
    ) -> tuple[tuple[Float[Array, "n s"], Float[AnyArray, ""]], Pass]:
        z, force = carry
        free = step.free(z)
        free_output = step.output(free)[0]
        end = force_at(chip_at_end(surface - free_output - half * force))
        mean = (force + end) / 2
        q = free_output + 2 * half * mean
        chip = surface - q
        force = force_at(chip)
        return (free + step.push(mean), force), Pass(q, jnp.maximum(chip, 0.0), force)

    def begin(z: Float[Array, "n s"], surface: Float[AnyArray, " edges"]) -> Pass:
        q = step.output(z)[0]
        chip = surface[0] - q
        return Pass(q, jnp.maximum(chip, 0.0), force_at(chip))

    def one_revolution(
        carry: tuple[Float[Array, "n s"], Float[AnyArray, " edges"]], _revolution: None
    ) -> tuple[tuple[Float[Array, "n s"], Float[AnyArray, " edges"]], Pass]:
        z, surface = carry
        first = begin(z, surface)
        (z, _), after = jax.lax.scan(advance, (z, first.force), surface[1:], unroll=2)
        track = jnp.concatenate([first.displacement[None], after.displacement])
        return (z, feed + jnp.minimum(surface, track)), jax.tree.map(lambda part: part[every - 1 :: every], after)

    z, surface = jnp.reshape(state, (n, s)), feed + past[:, 0]
    start = begin(z, surface)
    (z, _), rest = jax.lax.scan(one_revolution, (z, surface), None, length=revolutions)
    samples = jax.tree.map(lambda a, b: jnp.concatenate([a[None], b.ravel()]), start, rest)
    return samples, z.reshape(-1)
