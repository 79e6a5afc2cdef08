"""Milling with straight teeth that are not equally spaced: one delay a tooth."""

from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar, NamedTuple

import jax.numpy as jnp
import numpy as np

from lobex import _checks
from lobex._float64 import at_once, in_float64
from lobex._pytree import pytree
from lobex.processes.milling import (
    by_thickness,
    check_cutting,
    cutting_angles,
    feed_force,
    specific_force,
    specific_work,
)
from lobex.processes.process import check_point
from lobex.processes.quantity import DEPTH_OF_CUT, Quantity
from lobex.structures.modes import Modes
from lobex.systems.coefficients import Piece
from lobex.systems.delays import Share
from lobex.systems.mesh import places_that_matter
from lobex.systems.system import DelaySystem, Places, modal_system
from lobex.systems.terms import Forcing, Regenerative, Term

Array = Any

_TURN = 2 * np.pi


class Layout(NamedTuple):
    """Where pieces end, as ``mesh.places_that_matter`` says, and the shortest and longest delay in revolutions."""

    places: Places | None = None
    shortest: float = 0.0
    longest: float = 1.0


@pytree(static=("direction", "speed_unit", "layout"))
class VariablePitch:
    """Milling with straight teeth at any pitch angles; the period is one revolution.

    Tooth j is at the angle 2π t/T + θ_j from the feed-normal axis and meets what tooth j + 1, which runs ahead of it by
    its pitch angle, has left: the force on the tool is −b Σ H_j(t) [y(t) − y(t − τ_j)] with τ_j = pitch_j/Ω (Budak, An
    analytical design method for milling cutters with nonconstant pitch to increase stability, J. Manuf. Sci. Eng. 125,
    2003). H and the angles of the cut are those of ``Milling``.

    Attributes:
        modes: the tool's modes, r = 1 (along the feed) or r = 2 directions.
        pitch: the angle from each tooth to the next, rad, (teeth,); they make one turn together.
        tangential, normal, radial_immersion, direction, speed_unit: as of ``Milling``.
        feed_per_tooth: the mean of all teeth, m, as of ``Milling``: each takes its share by its pitch angle.
        runout: what the radius of each tooth has above the nominal one, m, (teeth,): the chip is thicker by what it has
            above that of the tooth ahead. No tooth leaves the cut for it. None where there is none.
        layout: where pieces end, and the range of the delays, found from the numbers; leave it out.

    The gain is the axial depth of cut b, m.
    """

    modes: Modes
    pitch: Array
    tangential: Array
    normal: Array
    radial_immersion: Array
    direction: str = "down"
    speed_unit: str = "rpm"
    layout: Layout = Layout()
    feed_per_tooth: Array | None = None
    runout: Array | None = None

    gain: ClassVar[Quantity] = DEPTH_OF_CUT

    def __post_init__(self) -> None:
        check_cutting(self)
        _checks.positive("pitch", self.pitch, "rad")
        if np.ndim(self.pitch) != 1:
            raise ValueError(f"pitch has shape {np.shape(self.pitch)}; give one angle a tooth")
        if self.runout is not None:
            _checks.as_numbers("runout", self.runout, "m")
            if np.shape(self.runout) != np.shape(self.pitch):
                raise ValueError(f"runout has shape {np.shape(self.runout)}; give one number a tooth")
        if _checks.is_traced(self.pitch):
            return
        turn = float(np.sum(np.asarray(self.pitch)))
        if abs(turn - _TURN) > 1e-6:
            hint = "; they are in degrees: use numpy.deg2rad" if abs(turn - 360) < 1e-3 else ""
            raise ValueError(f"pitch sums to {turn:.6g} rad; give angles that make one turn, 2π{hint}")
        share = np.asarray(self.pitch, dtype=float) / turn
        object.__setattr__(self, "pitch", _TURN * share)
        object.__setattr__(self, "layout", Layout(shortest=float(share.min()), longest=float(share.max())))
        if not _checks.is_traced((self.radial_immersion, self.tangential, self.normal, self.modes)):
            with at_once():
                places = places_that_matter(self.system(1.0, 1.0))
            object.__setattr__(self, "layout", self.layout._replace(places=places))

    @property
    def passes(self) -> int:
        """Tooth passes per revolution."""
        return np.shape(self.pitch)[0]

    @in_float64
    def system(self, speed: Array, gain: Array) -> DelaySystem:
        """The delay system at one spindle speed (revolutions per second) and one depth of cut (m)."""
        check_point(self, speed, gain)
        entry, exit_ = cutting_angles(self.radial_immersion, self.direction)
        share = jnp.asarray(self.pitch) / _TURN
        before = jnp.cumsum(share) - share
        cuts = [
            Regenerative(
                ToothForce(gain, self.tangential, self.normal, entry, exit_, before[tooth], self.modes.directions),
                Share(share[tooth]),
            )
            for tooth in range(self.passes)
        ]
        teeth: list[Any] = [cut.coefficient for cut in cuts]
        terms: list[Term] = [*cuts]
        if self.feed_per_tooth is not None:
            feeds = self.feed_per_tooth * self.passes * share
            terms += [feed_force(tooth, feeds[number]) for number, tooth in enumerate(teeth)]
        if self.runout is not None:
            steps = jnp.asarray(self.runout) - jnp.roll(jnp.asarray(self.runout), -1)
            terms += [Forcing(RunoutForce(tooth, steps[number])) for number, tooth in enumerate(teeth)]
        return modal_system(self.modes, 1 / speed, tuple(terms), **self.layout._asdict())


@pytree(static=("directions",))
class ToothForce:
    """b H(t) of one tooth over a revolution; it is at the angle 2π (t/T + before)."""

    depth: Array
    tangential: Array
    normal: Array
    entry: Array
    exit: Array
    before: Array
    directions: int

    constant: ClassVar[bool] = False

    def pieces(self) -> tuple[Piece, ...]:
        start, cut = self.entry / _TURN - self.before, (self.exit - self.entry) / _TURN
        return Piece(start, cut, False), Piece(start + cut, 1 - cut, True)

    def at(self, phase: Array) -> Array:
        return self._where(phase, phase)

    def within(self, inside: Array, phase: Array) -> Array:
        return self._where(inside, phase)

    def mean(self, start: Array, stop: Array) -> Array:
        return self._matrix(self.averaged(partial(specific_work, self), start, stop))

    def averaged(self, work: Callable[[Array], Array], start: Array, stop: Array) -> Array:
        """Averages over intervals of what acts in the cut, from its antiderivative over the angle, (entries, k)."""
        first = jnp.mod(_TURN * (start + self.before), _TURN)
        last = first + _TURN * (stop - start)
        done = 0.0
        for turn in (0.0, _TURN):
            ends = (jnp.clip(edge - turn, self.entry, self.exit) for edge in (last, first))
            done = done + work(next(ends)) - work(next(ends))
        return done / (last - first)

    def cutting(self, inside: Array) -> Array:
        """Whether the tooth is in the cut."""
        angle = jnp.mod(_TURN * (inside + self.before), _TURN)
        return (angle >= self.entry) & (angle <= self.exit)

    def _where(self, inside: Array, phase: Array) -> Array:
        """What the tooth does at ``phase`` if it is in the cut at ``inside``."""
        return self._matrix(self.cutting(inside) * specific_force(self, _TURN * (phase + self.before)))

    def _matrix(self, entries: Array) -> Array:
        matrix = self.depth * jnp.moveaxis(entries, 0, -1)
        return matrix.reshape(*jnp.shape(matrix)[:-1], self.directions, self.directions)


@pytree()
class RunoutForce:
    """The force of a tooth that cuts a step more than the one ahead of it, −b (K_t t + K_n n) step, (directions, 1)."""

    tooth: ToothForce
    step: Array

    constant: ClassVar[bool] = False

    @property
    def breaks(self) -> ToothForce:
        """Those of the tooth, by which coefficients that share them are known."""
        return self.tooth

    def pieces(self) -> tuple[Piece, ...]:
        return self.tooth.pieces()

    def at(self, phase: Array) -> Array:
        return self.within(phase, phase)

    def within(self, inside: Array, phase: Array) -> Array:
        angle = _TURN * (phase + self.tooth.before)
        return self._column(self.tooth.cutting(inside) * self._by_thickness(jnp.sin(angle), jnp.cos(angle)))

    def mean(self, start: Array, stop: Array) -> Array:
        def work(angle: Array) -> Array:
            return self._by_thickness(-jnp.cos(angle), jnp.sin(angle))

        return self._column(self.tooth.averaged(work, start, stop))

    def _by_thickness(self, sine: Array, cosine: Array) -> Array:
        return jnp.stack(by_thickness(self.tooth, sine, cosine))

    def _column(self, entries: Array) -> Array:
        return -self.tooth.depth * self.step * jnp.moveaxis(entries, 0, -1)[..., None]
