"""What the teeth of a cutter do along a motion: the chip that each takes, and the torque that all of them ask for."""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol, runtime_checkable

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.systems.coefficients import gauss_nodes

_TURN = 2 * np.pi
# How often an edge may be in the cut at a time: one that goes around the cutter twice has no number.
_WINDOWS = 2

Motion = Callable[[Float[AnyArray, "..."]], Float[AnyArray, "... r"]]
"""The outputs y of a system, (…, r), at any phases t/T, (…): in pure JAX."""


class AtWork(NamedTuple):
    """What the teeth do at k phases.

    Attributes:
        thickness: of the chip of each tooth, m, the mean along the part of its edge in the cut, and 0 out of it,
            (k, teeth).
        chip: cross-section of the chip along the edges of each tooth and of those that are like it, m², (k, teeth).
        pulled: of it what is below zero, with a sign that makes it positive: there a tooth is pushed as if it pulled
            at the material, m², (k, teeth).
        torque: that the spindle has to give, N m, (k,). NaN without a diameter.
    """

    thickness: Float[AnyArray, "k teeth"]
    chip: Float[AnyArray, "k teeth"]
    pulled: Float[AnyArray, "k teeth"]
    torque: Float[AnyArray, " k"]


@runtime_checkable
class Toothed(Protocol):
    """A process whose cut knows its teeth: what its orbit tells beyond the motion."""

    @property
    def teeth(self) -> int:
        """Their number."""
        ...

    @property
    def tells_of_teeth(self) -> bool:
        """Whether it can say what they do: else its orbit is a motion alone."""
        ...

    @property
    def straight(self) -> bool:
        """Whether what it leaves is the same at every height."""
        ...

    def at_work(self, speed: Number, gain: Number, phase: Float[AnyArray, " k"], motion: Motion) -> AtWork:
        """What the teeth do at phases t/T, (k,), along a motion of period T, in pure JAX."""
        ...

    def left_standing(
        self, gain: Number, height: Float[AnyArray, " h"]
    ) -> tuple[Float[Array, "teeth h"], Float[AnyArray, " r"]]:
        """When each tooth passes the finished wall, at heights that are shares of the depth of cut, (h,), as phases
        t/T, (teeth, h), and by which weights of y, (r,), it then leaves material."""
        ...


@pytree(static=("alike", "directions", "points"))
class WorkingEdges:
    """The edges of a cutter in a cut.

    Attributes:
        depth: of the cut b, m.
        entry, exit: the angles of the cut, rad.
        share: the pitch angle of each tooth until they repeat, in periods, (count,).
        twist: by which each edge lags behind its tip, rad/m, (count,); None of straight teeth.
        narrowing: by which the pitch angle of each becomes less with the height, rad/m, (count,); None where all edges
            have the same helix.
        feed: of all teeth of a period, m.
        step: what the radius of each has above that of the tooth ahead, m, (count,).
        alike: how often the teeth repeat in a turn.
        directions: 1 along the feed, 2 with the one across it.
        points: along the part of an edge in the cut, by Gauss' rule.
    """

    depth: Number
    entry: Number
    exit: Number
    share: Float[AnyArray, " count"]
    twist: Float[AnyArray, " count"] | None
    narrowing: Float[AnyArray, " count"] | None
    feed: Number
    step: Float[AnyArray, " count"]
    alike: int
    directions: int
    points: int

    @property
    def before(self) -> Float[AnyArray, " count"]:
        """How far ahead each is at t = 0, in periods."""
        return jnp.cumsum(self.share) - self.share

    def in_cut(self, phase: Float[AnyArray, " k"], motion: Motion) -> "InCut":
        """Points along the parts of all edges that are in the cut, p of each."""
        order = jnp.arange(self.alike)[:, None]
        tip = _TURN / self.alike * (phase[:, None, None] + order + self.before)
        since = jnp.mod(tip - self.entry, _TURN)[..., None]
        height: Any = 0.0
        if self.twist is None:
            angle = self.entry + since
            length = jnp.where(since < self.exit - self.entry, self.depth, 0.0)
        else:
            angle, height, length = self._parts(since, self.twist[:, None])
        lag = self.share[:, None]
        if self.narrowing is not None:
            lag = lag - self.alike / _TURN * self.narrowing[:, None] * height
        now = motion(phase)[:, None, None, None]
        # A period ago the motion was the same.
        whole = self.narrowing is None and jnp.shape(self.share) == (1,)
        before = now if whole else motion(phase[:, None, None, None] - lag)
        sine, cosine = jnp.sin(angle), jnp.cos(angle)

        def inwards(output: Any, first: int) -> Any:
            """The part of outputs from the ``first`` on along the normal of the edge."""
            along = sine * output[..., first]
            return along if self.directions == 1 else along + cosine * output[..., first + 1]

        gained = inwards(now, 0) - inwards(before, 0)
        thickness = self.feed * lag * sine + self.step[:, None] + gained
        rate = inwards(now, self.directions) if jnp.shape(now)[-1] > self.directions else jnp.zeros_like(thickness)
        return InCut(thickness, jnp.broadcast_to(length, jnp.shape(thickness)), rate)

    def _parts(
        self, since: Float[Array, "k alike count 1"], twist: Float[AnyArray, "count 1"]
    ) -> tuple[Float[AnyArray, "k alike count p"], ...]:
        """Angle, height and length of points of the edges, from by how much each tip is beyond the entry."""
        places, weights = gauss_nodes(self.points)
        # Since the tip entered last, and a turn before.
        since, arc = since + _TURN * np.arange(_WINDOWS), self.exit - self.entry
        low, high = (jnp.clip((since - angle) / twist, 0.0, self.depth) for angle in (arc, 0.0))
        length = jnp.where(self.depth * twist <= _TURN * _WINDOWS - arc, high - low, jnp.nan)
        height = low[..., None] + (high - low)[..., None] * places
        angle = (self.entry + since)[..., None] - twist[..., None] * height
        every = angle, height, length[..., None] * weights
        angle, height, length = (part.reshape(*jnp.shape(since)[:-1], -1) for part in every)
        return angle, height, length

    def passes(self, angle: Number, height: Float[AnyArray, " h"]) -> Float[Array, "teeth h"]:
        """When each edge is at an angle, rad, at heights that are shares of the depth of cut, as phases t/T."""
        twist = jnp.zeros(jnp.shape(self.share)) if self.twist is None else self.twist
        lag = twist[:, None] * self.depth * height
        phase = self.alike / _TURN * (angle + lag) - self.before[:, None]
        return jnp.tile(jnp.mod(phase, 1.0), (self.alike, 1))


def working_edges(process: Any, depth: Number) -> WorkingEdges:
    """The teeth of a period of milling, as what they cut along a motion is made of."""
    cutter, count = process.cutter, process.teeth // process.cutter.alike
    entry, exit_ = process.engagement
    twist = None if cutter.twist is None else jnp.broadcast_to(cutter.twist, (count,))
    return WorkingEdges(
        depth,
        entry,
        exit_,
        jnp.asarray(cutter.shares),
        twist,
        None if cutter.one_helix or twist is None else jnp.roll(twist, -1) - twist,
        0.0 if process.feed_per_tooth is None else count * process.feed_per_tooth,
        jnp.zeros(count) if cutter.runout is None else cutter.steps,
        cutter.alike,
        process.modes.directions,
        process.points,
    )


class InCut(NamedTuple):
    """Points of edges in the cut, p of each of the teeth that are alike and follow one another.

    Attributes:
        thickness: of the chip, m.
        length: of the edge that a point stands for, m; 0 out of the cut.
        rate: at which the edge moves into the material, in the unit of further outputs; 0 without.
    """

    thickness: Float[AnyArray, "k alike count p"]
    length: Float[AnyArray, "k alike count p"]
    rate: Float[AnyArray, "k alike count p"]

    def along(self, values: Float[AnyArray, "k alike count p"]) -> Float[Array, "k teeth"]:
        """The integral along each edge, (k, teeth)."""
        whole = jnp.sum(self.length * values, axis=-1)
        return whole.reshape(jnp.shape(whole)[0], -1)

    def alike(self, values: Float[AnyArray, "k teeth"]) -> Float[AnyArray, "k teeth"]:
        """The sum over all teeth that are like each."""
        times = jnp.shape(self.thickness)[1]
        return jnp.tile(jnp.sum(values.reshape(len(values), times, -1), axis=1), (1, times))


def at_work(found: InCut, tangential: Number, edge: Number, friction: Number, radius: Number | None) -> AtWork:
    """What teeth do, of the parts of their edges in the cut.

    Args:
        found: these parts.
        tangential: specific cutting force K_t, N/m².
        edge: the force of the edge along it, N/m.
        friction: of the flank, N/m² per unit of ``InCut.rate``.
        radius: of the cutter, m.
    """
    chip, length = found.along(found.thickness), found.along(jnp.ones_like(found.thickness))
    force = jnp.sum(tangential * chip + edge * length + friction * found.along(found.rate), axis=1)
    inside = length > 0
    return AtWork(
        thickness=jnp.where(inside, chip / jnp.where(inside, length, 1.0), 0.0),
        chip=found.alike(chip),
        pulled=found.alike(found.along(jnp.maximum(-found.thickness, 0.0))),
        torque=jnp.nan * force if radius is None else radius * force,
    )
