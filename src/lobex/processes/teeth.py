"""The force of teeth that are alike, with straight or helical edges."""

from typing import Any, ClassVar

import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Real

from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import Number
from lobex.processes.specific_force import CHIP, STEP, Law
from lobex.systems.coefficients import Piece, mean_by_quadrature, pieces_between

# Which parts of a period are in the cut, where that is known before tracing.
Parts = tuple[str, ...]
# Of a period in one piece, of several teeth or of one that enters as another one leaves.
WHOLE: Parts = ("cut",)
ALONE: Parts = ("one",)


AT = 1e-9
"""Of an angle, rad, how near to a jump it is at it: a piece of no length between two is on both."""


def in_one_piece(parts: Parts | None) -> bool:
    """Whether no force jumps in a period."""
    return parts in (WHOLE, ALONE)


@pytree(static=("teeth", "directions", "law"))
class Teeth:
    """The force b H(t) of teeth that follow one another at equal angles, one a period.

    Tooth k is at the angle 2π (t/T + before + k)/teeth with its tip, k = 0, 1, …

    Attributes:
        depth: b, m.
        tangential, normal: K_t and K_n, N/m².
        axial: K_a, N/m², of three directions; None for none.
        plunge: what motion along the axis makes, N/m²; None of edges parallel to it.
        entry, exit: the angles of the cut, rad.
        before: how far ahead the first one is at t = 0, in periods; None for not at all.
        teeth: how many make a turn.
        directions: of the force.
        law: the force of a point of an edge.
    """

    depth: Number
    tangential: Number
    normal: Number
    axial: Number | None
    plunge: tuple[Number, Number, Number] | None
    entry: Number
    exit: Number
    before: Number | None
    teeth: int
    directions: int
    law: Law

    constant: ClassVar[bool] = False

    def _since(self, phase: Real[Any, "..."]) -> Real[Any, "..."]:
        """Phases from where the first tooth is at the angle 0."""
        return phase if self.before is None else phase + self.before

    def _shaped(self, factor: Any, entries: Float[Any, "entries k"]) -> Float[Any, "k e r"]:
        matrix = factor * jnp.moveaxis(entries, 0, -1)
        return matrix.reshape(*np.shape(matrix)[:-1], self.directions, self.directions if self.law.square else 1)


@pytree(static=("parts",))
class StraightTeeth(Teeth):
    """A period that starts when a tooth enters has one further jump, when a tooth leaves.

    Attributes:
        parts: of such a period, where they are known.
    """

    parts: Parts | None

    def pieces(self) -> tuple[Piece, ...]:
        start = self.entry * self.teeth / (2 * jnp.pi)
        if self.before is not None:
            start = start - self.before
        if in_one_piece(self.parts):
            return (Piece(start, 1.0, False),)
        whole, part = self._engaged()
        idle = (whole == 0) if self.parts is None else self.parts[1] == "idle"
        return Piece(start, part, False), Piece(start + part, 1.0 - part, idle)

    def within(self, inside: Real[Any, "..."], phase: Real[Any, " k"]) -> Float[Any, "k e r"]:
        cutting, angle = self._cutting(inside, phase)
        return self._shaped(self.depth, jnp.sum(cutting * self.law.at(self, angle), axis=-2))

    def _cutting(
        self, inside: Real[Any, "..."], phase: Real[Any, " k"]
    ) -> tuple[Bool[Any, "teeth 1"], Float[Any, "teeth k"]]:
        """The teeth that are in the cut at the phase ``inside``, and their angles, wherever they are at the others."""
        pitch = 2 * jnp.pi / self.teeth
        # A whole number of revolutions, so that the angles of a piece that goes on beyond the last are its own.
        order = jnp.arange(self.teeth)[:, None]
        inside, phase = self._since(inside), self._since(phase)
        behind = 2 * jnp.pi * jnp.floor((pitch * (inside + order) + AT) / (2 * jnp.pi))
        middle, angle = (pitch * (place + order) - behind for place in (inside, phase))
        return (middle >= self.entry - AT) & (middle <= self.exit + AT), angle

    @property
    def single(self) -> bool:
        """Whether no more than one of them cuts at a time, so that the force is that of one chip."""
        return self.parts in (ALONE, ("cut", "idle")) and self.law is CHIP and self.plunge is None

    def factors(
        self, inside: Real[Any, "..."], phase: Real[Any, " k"]
    ) -> tuple[Float[Any, "k e 1"], Float[Any, "k 1 r"]]:
        cutting, angle = self._cutting(inside, phase)
        push = jnp.sum(cutting * STEP.at(self, angle), axis=-2)
        normal = [jnp.sin(angle), jnp.cos(angle), jnp.zeros_like(angle)][: self.directions]
        chip = jnp.sum(cutting * jnp.stack(normal), axis=-2)
        return self.depth * push.T[..., None], chip.T[:, None]

    def at(self, phase: Real[Any, " k"]) -> Float[Any, "k e r"]:
        angle = 2 * jnp.pi / self.teeth * (self._since(phase) + jnp.arange(self.teeth)[:, None])
        angle = jnp.mod(angle, 2 * jnp.pi)
        cutting = (angle >= self.entry) & (angle <= self.exit)
        return self._shaped(self.depth, jnp.sum(cutting * self.law.at(self, angle), axis=-2))

    def mean(self, start: Real[Any, " k"], stop: Real[Any, " k"]) -> Float[Any, "k e r"]:
        pitch = 2 * jnp.pi / self.teeth
        if self.before is not None:
            first = jnp.mod(self._since(start), 1.0)
            start, stop = first, first + (stop - start)
        # An interval may reach past the end of the revolution, so the tooth behind is counted there too.
        order = jnp.arange(-self.teeth, self.teeth)[:, None]
        ends = [jnp.clip(pitch * (edge + order), self.entry, self.exit) for edge in (start, stop)]
        work = jnp.sum(self.law.work(self, ends[1]) - self.law.work(self, ends[0]), axis=-2)
        return self._shaped(self.depth, work / (pitch * (stop - start)))

    def _engaged(self) -> tuple[Number, Number]:
        """Teeth in the cut just before a tooth enters, and the phase after it at which one leaves."""
        lib = namespace(self.exit, self.entry)
        engaged = (self.exit - self.entry) * self.teeth / (2 * lib.pi)
        if in_one_piece(self.parts):
            return lib.round(engaged), lib.zeros_like(engaged)
        if self.parts == ("cut", "idle"):
            return lib.zeros_like(engaged), engaged
        whole = lib.floor(engaged)
        return whole, engaged - whole


@pytree()
class HelicalTeeth(Teeth):
    """Edges that lag behind their tips: their force is exact, an integral over the angles that each takes in.

    It bends where a tip or the end of an edge at the depth b enters or leaves, and does not jump (Zatarain, Muñoa,
    Peigné and Insperger, Analysis of the influence of mill helix angle on chatter stability, CIRP Ann. 55, 2006).

    Attributes:
        twist: by which an edge lags, rad/m.
    """

    twist: Number

    def pieces(self) -> tuple[Piece, ...]:
        return helical_pieces(self, (0.0, self.depth))

    def at(self, phase: Real[Any, " k"]) -> Float[Any, "k e r"]:
        return self.within(phase, phase)

    def within(self, inside: Real[Any, "..."], phase: Real[Any, " k"]) -> Float[Any, "k e r"]:
        """Of the places of tip and end at the phase ``inside``, before, in or after the cut."""
        lag = self.twist * self.depth
        turn, tip, tip_cuts = self._end(0.0, inside, phase)
        last_turn, last, last_cuts = self._end(lag, inside, phase)
        # The digits of the lag itself, however little it is.
        span = jnp.where((turn == last_turn) & tip_cuts & last_cuts, lag, tip - last)
        work = self.law.between(self, (tip + last) / 2, span)
        whole = self.law.between(self, (self.entry + self.exit) / 2, self.exit - self.entry)
        work = work + (turn - last_turn) * whole[:, None, None]
        return self._shaped(1 / self.twist, jnp.sum(work, axis=-2))

    def mean(self, start: Real[Any, " k"], stop: Real[Any, " k"]) -> Float[Any, "k e r"]:
        return mean_by_quadrature(self, start, stop)

    def _end(
        self, lag: Any, inside: Real[Any, "..."], phase: Real[Any, " k"]
    ) -> tuple[Float[Any, "..."], Float[Any, "teeth k"], Bool[Any, "..."]]:
        """Of an end of every edge, its revolution, its angle in it or the nearest in the cut, and whether it cuts."""
        pitch = 2 * jnp.pi / self.teeth
        order = jnp.arange(self.teeth)[:, None]
        middle, angle = (pitch * (self._since(place) + order) - lag for place in (inside, phase))
        turn = jnp.floor(middle / (2 * jnp.pi))
        middle, angle = middle - 2 * jnp.pi * turn, angle - 2 * jnp.pi * turn
        nearest = jnp.where(middle > self.entry, self.exit, self.entry)
        cuts = (middle > self.entry) & (middle < self.exit)
        return turn, jnp.where(cuts, angle, nearest), cuts


def helical_pieces(teeth: Any, heights: tuple[Number, ...]) -> tuple[Piece, ...]:
    """Between points of an edge at heights, such as tip and end, entering and leaving."""
    lags = [teeth.twist * height for height in heights]
    angles = [angle + behind for behind in lags for angle in (teeth.entry, teeth.exit)]
    lib = namespace(angles, teeth.before)
    place = lib.stack([lib.asarray(angle, dtype=lib.result_type(float)) for angle in angles])
    place = place * teeth.teeth / (2 * np.pi)
    return pieces_between(place if teeth.before is None else place - teeth.before)
