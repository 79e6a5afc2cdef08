"""Edges whose helix is another than that of the tooth ahead: what each meets was left longer ago at one height than at
another.

The sum over heights is Gauss' rule over the part of each edge that is in the cut, which ends with it: of that part the
force is smooth, so that a few points serve, where discs of the cutter jump into the cut one after another.
"""

from collections.abc import Iterator
from math import lgamma
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Real

from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.processes.teeth import HelicalTeeth
from lobex.systems.coefficients import gauss_nodes
from lobex.systems.delays import OneOfMany

_TURN = 2 * np.pi
# Of a force along an edge, what its points may leave without a word, and what those leave that are advised.
_LEFT, _ENOUGH = 1e-6, 1e-8
# So many are chosen from, as each number of them is compiled for itself, and what they may leave of a tolerance, since
# multipliers follow the force by a power of it.
_COUNTS, _SHARE = (3, 4, 6, 8, 12, 16, 24, 32, 48, 64), 0.1
MOST_POINTS = _COUNTS[-1]
"""Along an edge."""


@pytree()
class EdgePoint(HelicalTeeth):
    """The share that one point has in the force of an edge: it moves with the part of the edge in the cut.

    No number where the edge is so long that it is in the cut twice at a time.

    Attributes:
        place: of the point in that part, from 0 to 1.
        weight: its share of the part.
    """

    place: Number
    weight: Number

    def within(self, inside: Real[Any, "..."], phase: Real[Any, " k"]) -> Float[Any, "k e r"]:
        """Of the ends of the part as they are at the phase ``inside``."""
        angle, height, length = self.part(inside, phase)
        once = self.twist * self.depth <= _TURN - (self.exit - self.entry)
        force: Any = self.law.at(self, angle - self.twist * height)
        return self._shaped(self.weight, jnp.where(once, length, jnp.nan) * force)

    def part(
        self, inside: Real[Any, "..."], phase: Real[Any, " *k"]
    ) -> tuple[Real[Any, " *k"], Real[Any, " *k"], Real[Any, " *k"]]:
        """The angle of the tip, the height of the point and the length of the part in the cut, (k,) each."""
        middle, angle = (_TURN * self._since(place) for place in (inside, phase))
        # Since the tip entered last.
        turn = _TURN * jnp.floor((middle - self.entry) / _TURN)
        middle, angle = middle - turn, angle - turn

        def height(limit: Number) -> Any:
            """Where the edge is at an angle, or the nearest of its ends."""
            known = (middle - limit) / self.twist
            inner: Any = jnp.where(known < self.depth, (angle - limit) / self.twist, self.depth)
            return jnp.where(known > 0, inner, 0.0)

        low, high = height(self.exit), height(self.entry)
        return angle, low + self.place * (high - low), high - low


@pytree()
class EdgeDelay(OneOfMany):
    """How long ago the tooth ahead was where a point of an edge is, as a share of a revolution.

    Attributes:
        point: of the edge.
        pitch: the angle to the tooth ahead at the tips, rad.
        narrowing: by which that becomes less with the height, rad/m.
    """

    point: EdgePoint
    pitch: Number
    narrowing: Number

    def shares(self, phase: Float[AnyArray, " *k"], period: Number) -> Float[AnyArray, " *k"]:
        return (self.pitch - self.narrowing * self.point.part(phase, phase)[1]) / _TURN


def edge_points(
    edge: HelicalTeeth, pitch: Number, narrowing: Number, count: int
) -> Iterator[tuple[EdgePoint, EdgeDelay]]:
    """The points of an edge, each with its delay."""
    numbers = edge.depth, edge.tangential, edge.normal, edge.axial, edge.plunge, edge.entry, edge.exit, edge.before
    for place, weight in zip(*gauss_nodes(count), strict=True):
        point = EdgePoint(*numbers, edge.teeth, edge.directions, edge.law, edge.twist, place, weight)
        yield point, EdgeDelay(point, pitch, narrowing)


def radians_along(twist: Float[np.ndarray, " teeth"], arc: Number, depth: Number, waves: Number) -> float:
    """How far the fastest wave turns along half of the part of an edge in the cut, the angle of the force with it.

    Args:
        twist: of each tooth, rad/m.
        arc: of the cut, rad.
        depth: m.
        waves: angular frequency over speed, rad per revolution.
    """
    part = np.minimum(depth, arc / twist)
    apart = np.abs(np.roll(twist, -1) - twist) / _TURN
    return float(np.max(part * (twist + waves * apart / 2)))


def missed_by(radians: float, count: int) -> float:
    """What Gauss' rule of so many points misses at most of a mean of waves e^{iXx}, x from −1 to 1, of X radians.

    The remainder of the rule (Davis and Rabinowitz, Methods of Numerical Integration, 2nd ed., 1984, eq. 2.7.12).
    """
    logarithm = 2 * count * (np.log(2) + np.log(max(radians, 1e-100))) + 4 * lgamma(count + 1)
    return float(np.exp(logarithm - np.log(2 * count + 1) - 3 * lgamma(2 * count + 1)))


def points_for(radians: float, tolerance: float) -> int:
    """How many points along an edge leave of waves of X radians less than a relative error of multipliers."""
    return next((count for count in _COUNTS if missed_by(radians, count) < _SHARE * tolerance), MOST_POINTS)


def doubt_of_points(radians: float, count: int | None) -> str | None:
    """In words what points along an edge may leave, and how many to take; None for little. They are so many, or as
    many as a tolerance asks for.
    """
    left = missed_by(radians, MOST_POINTS if count is None else count)
    if left < _LEFT:
        return None
    if count is None:
        return (
            f"of edges with a helix angle each {MOST_POINTS} points may leave {min(left, 1.0):.1e} of the force, at "
            "the slowest speed and the largest depth; give higher speeds or smaller depths"
        )
    needed = next((more for more in range(count, MOST_POINTS) if missed_by(radians, more) < _ENOUGH), MOST_POINTS)
    return (
        f"heights = {count} may leave {min(left, 1.0):.1e} of the force along an edge, at the slowest speed and the "
        f"largest depth; give {needed}, or None for as many as the tolerance asks for"
    )
