"""One revolution of rubbing blades at many speeds: every contact moves on by one casing cell per step."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Float

from lobex._shapes import AnyArray
from lobex.contact.laws import ContactLaw
from lobex.marches.bodies import Body, in_lanes
from lobex.marches.central_difference import energy
from lobex.marches.decimation import decimate
from lobex.marches.rub_step import Bladed, Moving, RubStep, Still, Totals
from lobex.marches.tracks import Depth, Tracks

# Steps that are compiled one after the other: the loop around them costs a tenth of what they do.
_TOGETHER = 4


class Rubbing(NamedTuple):
    """Where a revolution begins and ends.

    Attributes:
        bodies: the blades and, if it is flexible, the casing.
        depth: removed from the tracks, (cells, tracks · lanes).
        tail: what was last seen, (tail, seen · blades · lanes), for the decimation's filter.
    """

    bodies: tuple[Still, ...]
    depth: Depth
    tail: Float[AnyArray, "tail columns"]


class Revolution(NamedTuple):
    """What a revolution leaves: samples of what is seen (samples, seen, blades, lanes), totals, and the kinetic and
    strain energy of every body (blades, lanes) at its start and end."""

    seen: Float[AnyArray, "samples seen blades lanes"]
    totals: Totals
    start_energy: tuple[Bladed, ...]
    stored_energy: tuple[Bladed, ...]


def at_rest(bodies: tuple[Body, ...], blades: int, tracks: Tracks, lanes: int, tail: int) -> Rubbing:
    """Bodies at rest in equilibrium, before an unworn casing."""
    still = [jnp.zeros((body.count, blades if number == 0 else 1, lanes)) for number, body in enumerate(bodies)]
    depth = jnp.zeros((tracks.cells, tracks.number * lanes))
    columns = bodies[0].shape.shape[1] * blades * lanes
    return Rubbing(tuple(Still(zero, zero) for zero in still), depth, jnp.zeros((tail, columns)))


def revolve(
    bodies: tuple[Body, ...],
    law: ContactLaw,
    unworn: Float[AnyArray, "cells contacts blades"],
    closing: Float[AnyArray, " ends"] | None,
    speed: Float[AnyArray, " lanes"],
    state: Rubbing,
    matrix: Float[AnyArray, "tile stretch"],
    tracks: Tracks,
    factor: int,
) -> tuple[Rubbing, Revolution]:
    """One revolution at the speeds (lanes,), Hz, over the unworn profiles (cells, contacts, blades), m, in the order in
    which the contacts come to them. The casing comes closer by ``closing`` (cells + 1,), m, at the instants.

    In cell c, with the penetration h = q_i − profile[c] − depth[c]: force from h; q_{i+1}; then what the law
    removes comes off that cell, §1.4. A cell that the tip has not reached yet stays as it is: removed earlier, it
    could never push the tip. Where the casing is flexible, q is how far the tip goes beyond it, and the force acts on
    both.

    The energies sum by the trapezoidal rule over the instants of the steps: ``input_energy`` is the work of the
    contact on bodies that it drives back, ``removal_energy`` that of those that move into the coating against the
    force, ``damping_energy`` that of the modal damping. The kinetic and strain energy ``stored_energy`` grows by
    input − removal − damping, up to the square of the time step. Of removal − input, ``friction_energy`` is what the
    part of the force along the surface takes.
    """
    cells, blades, lanes = tracks.cells, unworn.shape[2], speed.shape[0]
    side_by_side = blades > 1 and len(bodies) == 1 and bodies[0].coupling is None
    marched, stills, speeds = bodies, state.bodies, speed
    if side_by_side:
        # Blades that nothing couples are marched as lanes: a loop over all of them leaves less of a remainder.
        marched, speeds = (in_lanes(bodies[0], blades, lanes),), jnp.tile(speed, blades)
        stills = jax.tree.map(lambda part: part.reshape(part.shape[0], 1, -1), stills)
    step = RubStep(marched, law, speeds, cells, (unworn.shape[1], 1 if side_by_side else blades))
    profile, here = (part.reshape(step.touching) for part in (_over_lanes(unworn[0], lanes), tracks.here(state.depth)))
    begun, first = step.begin(stills, profile + here, here, closing)
    after = None if closing is None else closing[1:]
    ended, depth, signal = _over_cells(step, begun, unworn, after, state.depth, tracks)
    here = tracks.here(depth).reshape(step.touching)
    last = step.end(ended, profile + here, here)
    if factor == 1:
        samples, tail = signal, state.tail
    else:
        samples = decimate(matrix, factor, state.tail, signal)
        tail = signal[cells - state.tail.shape[0] :]
    totals, stills = step.summed(ended.totals, first, last, cells), last.bodies
    seen = begun.tip.shape[0]
    if side_by_side:
        totals, stills = jax.tree.map(lambda part: part.reshape(*part.shape[:-2], blades, lanes), (totals, stills))
    energies = [tuple(map(energy, bodies, *zip(*every, strict=True))) for every in (state.bodies, stills)]
    revolution = Revolution(samples.reshape(-1, seen, blades, lanes), totals, *energies)
    return Rubbing(stills, depth, tail), revolution


def _over_lanes(profile: Float[AnyArray, "*some blades"], lanes: int) -> Float[AnyArray, "*some blades lanes"]:
    return jnp.broadcast_to(profile[..., None], (*profile.shape, lanes))


def _over_cells(
    step: RubStep,
    begun: Moving,
    unworn: Float[AnyArray, "cells contacts blades"],
    closing: Float[AnyArray, " cells"] | None,
    depth: Depth,
    tracks: Tracks,
) -> tuple[Moving, Depth, Float[AnyArray, "cells columns"]]:
    """All steps of a revolution: the last state, the depth of the tracks, and what was seen at the steps.

    For as many steps as no contact comes to what another one leaves, the cells lie ready in order.
    """

    def by_column(profile: Float[AnyArray, "steps contacts blades"]) -> Float[AnyArray, "steps contacts ..."]:
        if profile.shape[2] == step.touching[1]:
            return profile[..., None]
        lanes = step.touching[2] // profile.shape[2]
        return _over_lanes(profile, lanes).reshape(profile.shape[0], *step.touching)

    def over(carry: tuple[Moving, Depth], rows: Any) -> tuple[tuple[Moving, Depth], Float[AnyArray, "steps columns"]]:
        (state, depth), (number, profile, closed) = carry, rows
        given = by_column(profile), tracks.ahead(depth, number), closed
        state, (worn, seen) = jax.lax.scan(step.advance, state, given, unroll=_TOGETHER)
        return (state, tracks.left(depth, number, worn)), seen

    if tracks.alone:
        (state, depth), seen = over((begun, depth), (0, unworn, closing))
        return state, depth, seen
    count = tracks.cells // tracks.stretch
    numbers = jnp.arange(count)
    parts = [None if part is None else part.reshape(count, -1, *part.shape[1:]) for part in (unworn, closing)]
    (state, longer), seen = jax.lax.scan(over, (begun, tracks.longer(depth)), (numbers, *parts))
    return state, longer[: tracks.cells], seen.reshape(tracks.cells, -1)
