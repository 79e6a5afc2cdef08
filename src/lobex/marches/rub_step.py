"""One step of rubbing bodies: forces of all contacts, the bodies a step later, and what comes off the cells."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Float

from lobex._shapes import AnyArray
from lobex.contact.laws import ContactLaw
from lobex.marches.bodies import Body
from lobex.marches.central_difference import ModalStep, normal_velocity, pace, seen_at

Modal = Float[AnyArray, "modes blades lanes"]
Touching = Float[AnyArray, "contacts blades lanes"]
Bladed = Float[AnyArray, "blades lanes"]
# Profile, depth and closing of the cells of a step.
Row = tuple[Float[AnyArray, "contacts *#columns"], Float[AnyArray, " all"], Float[AnyArray, ""] | None]


class Still(NamedTuple):
    """A body at an instant: modal displacement and velocity, (modes, blades, lanes)."""

    displacement: Modal
    velocity: Modal


class Totals(NamedTuple):
    """Over one revolution, per contact, blade and lane: the largest |displacement| of all that is seen (seen, blades,
    lanes), the share of steps in contact, the largest force, the sum of what was removed, and the energies; see
    ``revolve``. The largest displacement of the casing and what friction took are None where there is none.
    """

    amplitude: Float[AnyArray, "seen blades lanes"]
    contact: Touching
    force: Touching
    removed: Touching
    input_energy: Touching
    removal_energy: Touching
    friction_energy: Touching | None
    casing_amplitude: Touching | None
    damping_energy: tuple[Bladed, ...]


class _Motion(NamedTuple):
    """A body between two instants; with what its contact forces work on, now and a step before, where no mode is
    complex."""

    displacement: Modal
    increment: Modal
    driven: tuple[Touching, Touching] | None


class Moving(NamedTuple):
    """Between two instants.

    Attributes:
        bodies: the blades and, if it is flexible, the casing.
        tip: what is seen of the blades.
        reach: how far contacts reach, where that is not what is seen of them.
        tip_before: for friction, what was seen at the contacts a step before.
        moved: for laws that follow the rate, how far contacts moved in the last step and the one before.
        totals: so far.
    """

    bodies: tuple[_Motion, ...]
    tip: Float[AnyArray, "seen blades lanes"]
    reach: Touching | None
    tip_before: Touching | None
    moved: tuple[Touching, Touching] | None
    totals: Totals


class Instant(NamedTuple):
    """The bodies at an instant, the power of the contact forces on them and of friction, W, and what damping takes."""

    bodies: tuple[Still, ...]
    power: Touching
    friction: Touching | None
    losses: tuple[Bladed, ...]


class RubStep:
    """The step of bodies, blades first, at the speeds (lanes,), Hz, for so many cells and contacts of each blade."""

    def __init__(
        self,
        bodies: tuple[Body, ...],
        law: ContactLaw,
        speed: Float[AnyArray, " lanes"],
        cells: int,
        shape: tuple[int, int],
    ) -> None:
        self.bodies, self.law, self.speed = bodies, law, speed
        self.marches = tuple(ModalStep.of(body, 1 / (cells * speed)) for body in bodies)
        self.size = self.marches[0].step
        self.touching = (*shape, speed.shape[0])
        self.sided = bodies[0].force_shape is not None or bodies[0].quadrature is not None
        self.follows_rate = bool(getattr(law, "follows_rate", False))

    def begin(
        self, bodies: tuple[Still, ...], surface: Touching, depth: Touching, closing: Float[AnyArray, " ends"] | None
    ) -> tuple[Moving, Instant]:
        """Between the first instant of a revolution and the step before it; surfaces are worn by the depth."""
        every = tuple(zip(self.bodies, bodies, strict=True))
        tips = tuple(seen_at(body, *still) for body, still in every)
        velocities = tuple(normal_velocity(body, *still) for body, still in every)
        reach, rate = self._relative(tips), self._relative(velocities)
        if closing is not None:
            reach, rate = reach + closing[0], rate + (closing[-1] - closing[0]) * self.speed
        force = self._force(reach - surface, depth, rate if self.follows_rate else None)
        motions = []
        for march, still, push in zip(self.marches, bodies, self._on_each(force), strict=True):
            displacement, increment = march.start(still.displacement, still.velocity, push)
            driven = None
            if march.jump is None:
                now = march.driven(displacement)
                driven = now, now - march.driven(increment)
            motions.append(_Motion(displacement, increment, driven))
        instant, zero = self._instant(bodies, force), jnp.zeros(self.touching)
        moving = Moving(
            tuple(motions),
            tips[0],
            None if closing is None and len(bodies) == 1 else reach,
            self._at_contacts(tips[0]) - self.size * self._at_contacts(velocities[0]) if self.sided else None,
            (self.size * rate, self.size * rate) if self.follows_rate else None,
            Totals(
                amplitude=jnp.zeros_like(tips[0]),
                contact=zero,
                force=zero,
                removed=zero,
                input_energy=zero,
                removal_energy=zero,
                friction_energy=zero if self.sided else None,
                casing_amplitude=zero if len(bodies) > 1 else None,
                damping_energy=tuple(jnp.zeros_like(loss) for loss in instant.losses),
            ),
        )
        return moving, instant

    def end(self, moving: Moving, surface: Touching, depth: Touching) -> Instant:
        """The last instant of a revolution."""
        force = self._force(self._reach(moving) - surface, depth, self._rate(moving))
        bodies = [
            Still(*march.stop(own.displacement, own.increment, push))
            for march, own, push in zip(self.marches, moving.bodies, self._on_each(force), strict=True)
        ]
        return self._instant(tuple(bodies), force)

    def advance(
        self, state: Moving, row: Row
    ) -> tuple[Moving, tuple[Float[AnyArray, " all"], Float[AnyArray, " seen_of_all"]]]:
        """A step later: what moves, and the depth of the cells and what was seen before it."""
        profile, depth, closed = row
        depth = depth.reshape(self.touching)
        surface = profile + depth
        penetration = self._reach(state) - surface
        force = self._force(penetration, depth, self._rate(state))
        # XLA would work them out again for each of the sums.
        surface, depth, penetration, force = jax.lax.optimization_barrier((surface, depth, penetration, force))
        after, tips, works, damped = [], [], [], []
        for march, old, push in zip(self.marches, state.bodies, self._on_each(force), strict=True):
            displacement, increment = march.advance(old.displacement, old.increment, push)
            if old.driven is None:
                driven = None
                works.append(march.worked(old.displacement, old.increment, increment, push))
            else:
                driven = march.driven(displacement), old.driven[0]
                works.append(driven[0] - old.driven[1])
            after.append(_Motion(displacement, increment, driven))
            tips.append(march.tip(displacement, increment, push))
            damped.append(jnp.sum(march.damping * (increment + old.increment) ** 2, axis=0))
        reach = self._relative(tuple(tips))
        reach = reach if closed is None else reach + closed
        removed = self.law.removed(penetration, depth, reach - surface)
        work = force * self._relative(tuple(works))
        old = state.totals
        friction, casing_amplitude = old.friction_energy, old.casing_amplitude
        if friction is not None and state.tip_before is not None:
            along = self._at_contacts(tips[0]) - state.tip_before
            friction = friction + force * (works[0] - along)
        if casing_amplitude is not None:
            casing_amplitude = jnp.maximum(casing_amplitude, jnp.abs(tips[1].reshape(self.touching)))
        totals = Totals(
            amplitude=jnp.maximum(old.amplitude, jnp.abs(tips[0])),
            contact=old.contact + (penetration > 0),
            force=jnp.maximum(old.force, force),
            removed=old.removed + removed,
            input_energy=old.input_energy + jnp.maximum(-work, 0),
            removal_energy=old.removal_energy + jnp.maximum(work, 0),
            friction_energy=friction,
            casing_amplitude=casing_amplitude,
            damping_energy=tuple(lost + more for lost, more in zip(old.damping_energy, damped, strict=True)),
        )
        moving = Moving(
            tuple(after),
            tips[0],
            None if state.reach is None else reach,
            None if state.tip_before is None else self._at_contacts(state.tip),
            None if state.moved is None else (reach - self._reach(state), state.moved[0]),
            totals,
        )
        return moving, ((depth + removed).ravel(), state.tip.ravel())

    def summed(self, totals: Totals, first: Instant, last: Instant, cells: int) -> Totals:
        """Totals of a whole revolution: the steps count the first instant fully and the last not at all, and half of
        each is due."""
        half = self.size / 2
        friction = totals.friction_energy
        if friction is not None and first.friction is not None and last.friction is not None:
            friction = friction / 2 + half * (last.friction - first.friction)
        return totals._replace(
            contact=totals.contact / cells,
            input_energy=totals.input_energy / 2 + half * (jnp.maximum(-last.power, 0) - jnp.maximum(-first.power, 0)),
            removal_energy=totals.removal_energy / 2
            + half * (jnp.maximum(last.power, 0) - jnp.maximum(first.power, 0)),
            friction_energy=friction,
            damping_energy=tuple(
                spent / (2 * self.size) + half * (late - early)
                for spent, early, late in zip(totals.damping_energy, first.losses, last.losses, strict=True)
            ),
        )

    def _instant(self, bodies: tuple[Still, ...], force: Touching) -> Instant:
        every = tuple(zip(self.bodies, bodies, strict=True))
        paces = tuple(pace(body, *still) for body, still in every)
        friction = None
        if self.sided:
            friction = force * (paces[0] - self._at_contacts(normal_velocity(self.bodies[0], *bodies[0])))
        losses = tuple(march.dissipation(still.velocity) for march, still in zip(self.marches, bodies, strict=True))
        return Instant(bodies, force * self._relative(paces), friction, losses)

    def _force(self, penetration: Touching, depth: Touching, rate: Touching | None) -> Touching:
        law: Any = self.law
        return law.force(penetration, depth) if rate is None else law.force(penetration, depth, rate)

    def _rate(self, state: Moving) -> Touching | None:
        """The velocity of penetration at an instant, of the steps before it."""
        return None if state.moved is None else (1.5 * state.moved[0] - 0.5 * state.moved[1]) / self.size

    def _reach(self, state: Moving) -> Touching:
        return self._at_contacts(state.tip) if state.reach is None else state.reach

    def _at_contacts(self, seen: Float[AnyArray, "seen blades lanes"]) -> Touching:
        return seen[: self.touching[0]]

    def _on_each(self, force: Touching) -> tuple[Float[AnyArray, "_ _ lanes"], ...]:
        """The force as each body has it: the casing has a direction for each contact of each blade."""
        return force, *(-force.reshape(-1, 1, self.touching[2]) for _ in self.bodies[1:])

    def _relative(self, of_bodies: tuple[Float[AnyArray, "_ _ lanes"], ...]) -> Touching:
        """Of what each body has at its contacts, that of the blades beyond that of the casing."""
        own = self._at_contacts(of_bodies[0])
        return own - of_bodies[1].reshape(self.touching) if len(of_bodies) > 1 else own
