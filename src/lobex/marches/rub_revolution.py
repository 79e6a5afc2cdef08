"""One revolution of a rubbing blade at many speeds: every lane moves on by one casing cell per step."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lobex._shapes import AnyArray
from lobex.contact.laws import ContactLaw
from lobex.marches.central_difference import ModalStep
from lobex.marches.decimation import decimate
from lobex.structures.modes import Modes

# Steps per turn of the loop, for less overhead; more only compiled longer.
_UNROLL = 4


class Blade(NamedTuple):
    """Where a revolution begins and ends: modal displacement and velocity (modes, lanes), depth removed
    (cells, lanes), and the tip's last displacements (tail, lanes) for the decimation's filter."""

    displacement: Float[Array, "modes lanes"]
    velocity: Float[Array, "modes lanes"]
    depth: Float[Array, "cells lanes"]
    tail: Float[Array, "tail lanes"]


class Totals(NamedTuple):
    """Over one revolution, per lane (lanes,): the largest |tip|, the share of steps in contact, the sum of what was
    removed from the cells, and the energies; see ``revolve``."""

    amplitude: Float[Array, " lanes"]
    contact: Float[Array, " lanes"]
    removed: Float[Array, " lanes"]
    input_energy: Float[Array, " lanes"]
    damping_energy: Float[Array, " lanes"]
    removal_energy: Float[Array, " lanes"]


class _Step(NamedTuple):
    displacement: Float[Array, "modes lanes"]
    increment: Float[Array, "modes lanes"]
    tip: Float[Array, " lanes"]
    driven: Float[Array, " lanes"]
    driven_before: Float[Array, " lanes"]
    totals: Totals


class Revolution(NamedTuple):
    """What a revolution leaves, per lane: samples of the tip (samples, lanes), totals, and ``stored_energy`` (lanes,)
    at its end."""

    tip: Float[Array, "samples lanes"]
    totals: Totals
    stored_energy: Float[Array, " lanes"]


def at_rest(modes: Modes, cells: int, lanes: int, tail: int) -> Blade:
    """A blade at rest in equilibrium, before an unworn casing."""
    still = jnp.zeros((modes.count, lanes))
    return Blade(still, still, jnp.zeros((cells, lanes)), jnp.zeros((tail, lanes)))


def revolve(
    modes: Modes,
    law: ContactLaw,
    profile: Float[AnyArray, " cells"],
    speed: Float[AnyArray, " lanes"],
    blade: Blade,
    matrix: Float[AnyArray, "tile stretch"],
    factor: int,
) -> tuple[Blade, Revolution]:
    """One revolution at the speeds (lanes,), Hz, over the unworn profile (cells,), m.

    In cell c, with the penetration h = q_i − profile[c] − depth[c]: force from h; q_{i+1}; then what the law
    removes comes off that cell, §1.4. A cell that the tip has not reached yet stays as it is: removed earlier, it
    could never push the tip.

    The energies sum by the trapezoidal rule over the instants of the steps: ``input_energy`` is the work of the
    contact on a tip that it drives back, ``removal_energy`` that of a tip that moves into the coating against the
    force, ``damping_energy`` that of the modal damping. The kinetic and strain energy ``stored_energy`` grows by
    input − removal − damping, up to the square of the time step.
    """
    cells = profile.shape[0]
    march = ModalStep.of(modes, 1 / (cells * speed))
    none = jnp.zeros_like(speed)

    def step(
        state: _Step, cell: tuple[Float[AnyArray, ""], Float[Array, " lanes"]]
    ) -> tuple[_Step, tuple[Float[Array, " lanes"], Float[Array, " lanes"]]]:
        unworn, depth = cell
        surface = unworn + depth
        penetration = state.tip - surface
        force = law.force(penetration, depth)
        displacement, increment = march.advance(state.displacement, state.increment, force)
        tip, driven = march.tip(displacement), march.driven(displacement)
        removed = law.removed(penetration, depth, tip - surface)
        work = force * (driven - state.driven_before)
        old = state.totals
        totals = Totals(
            amplitude=jnp.maximum(old.amplitude, jnp.abs(tip)),
            contact=old.contact + (penetration > 0),
            removed=old.removed + removed,
            input_energy=old.input_energy + jnp.maximum(-work, 0),
            damping_energy=old.damping_energy + jnp.sum(march.damping * (increment + state.increment) ** 2, axis=0),
            removal_energy=old.removal_energy + jnp.maximum(work, 0),
        )
        return _Step(displacement, increment, tip, driven, state.driven, totals), (depth + removed, state.tip)

    tip, driven = march.tip(blade.displacement), march.driven(blade.displacement)
    force = _force(law, tip, profile, blade.depth)
    power = force * march.driven(blade.velocity)
    dissipation = march.dissipation(blade.velocity)
    increment = march.start(blade.displacement, blade.velocity, force)
    before = driven - march.driven(increment)
    state = _Step(blade.displacement, increment, tip, driven, before, Totals(*(none,) * 6))
    state, (depth, signal) = jax.lax.scan(step, state, (profile, blade.depth), unroll=_UNROLL)

    force = _force(law, state.tip, profile, depth)
    velocity = march.velocity(state.displacement, state.increment, force)
    final_power = force * march.driven(velocity)
    half = march.step / 2
    totals = state.totals
    # The steps count the first instant fully and the last not at all: half of each is due.
    input_energy = totals.input_energy / 2 + half * (jnp.maximum(-final_power, 0) - jnp.maximum(-power, 0))
    removal_energy = totals.removal_energy / 2 + half * (jnp.maximum(final_power, 0) - jnp.maximum(power, 0))
    damping_energy = totals.damping_energy / (2 * march.step) + half * (march.dissipation(velocity) - dissipation)
    if factor == 1:
        samples, tail = signal, blade.tail
    else:
        samples = decimate(matrix, factor, blade.tail, signal)
        tail = signal[cells - blade.tail.shape[0] :]
    totals = Totals(
        totals.amplitude, totals.contact / cells, totals.removed, input_energy, damping_energy, removal_energy
    )
    result = Revolution(samples, totals, march.energy(state.displacement, velocity))
    return Blade(state.displacement, velocity, depth, tail), result


def _force(
    law: ContactLaw, tip: Float[Array, " lanes"], profile: Float[AnyArray, " cells"], depth: Float[Array, "cells lanes"]
) -> Float[AnyArray, " lanes"]:
    """The force in the first cell of the revolution."""
    return law.force(tip - profile[0] - depth[0], depth[0])
