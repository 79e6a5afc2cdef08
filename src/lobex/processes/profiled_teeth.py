"""Edges of a profile: a corner of a radius, and above it a line at a lead angle.

At the lead angle κ of a point of an edge the chip is as thick as the motion along (sin φ sin κ, cos φ sin κ, −cos κ),
and dz/sin κ wide (Altintas and Lee, Mechanics and dynamics of ball end milling, J. Manuf. Sci. Eng. 120, 1998; Engin
and Altintas, Mechanics and dynamics of general milling cutters, Int. J. Mach. Tools Manuf. 41, 2001). Widths are those
along the profile, which has no singular place, as the height has at the tip of a ball.
"""

from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Real

from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.processes.specific_force import Cutting, Law
from lobex.processes.teeth import HelicalTeeth, Parts, StraightTeeth, Teeth, helical_pieces
from lobex.systems.coefficients import Piece, gauss_nodes, mean_by_quadrature

_TURN = 2 * np.pi
# Points of a corner: what turns by X radians to either side of the middle is off by (eX/4n)^{2n}, below 1e-13 where the
# edge lags by π over a corner of 90 degrees.
_POINTS = 14
# Of the height of a corner, where a piece ends as well: what it takes of motion along the axis begins with the root of
# the time since its tip enters or leaves, which polynomials follow where it is short.
_GRADED = 1 / 64


@pytree(static=("parts",))
class ProfiledTeeth(Teeth):
    """Teeth of which each has a profile, the same along its edge as around the tool.

    No number where the edge is in the cut twice at a time within its corner.

    Attributes:
        corner: radius of the corner, m; None for none.
        lead: κ above it, rad.
        twist: by which edges lag, rad/m; None of straight ones.
        parts: as of ``StraightTeeth``.
    """

    corner: Number | None
    lead: Number
    twist: Number | None
    parts: Parts | None

    def pieces(self) -> tuple[Piece, ...]:
        if self.twist is None:
            return self._straight().pieces()
        if self.corner is None:
            return helical_pieces(self, (0.0, self.depth))
        top = self._top()
        graded = (_GRADED * top,) if self.directions == 3 else ()
        return helical_pieces(self, (0.0, *graded, top, self.depth))

    def at(self, phase: Real[Any, " k"]) -> Float[Any, "k e r"]:
        return self._straight().at(phase) if self.twist is None else self.within(phase, phase)

    def within(self, inside: Real[Any, "..."], phase: Real[Any, " k"]) -> Float[Any, "k e r"]:
        if self.twist is None:
            return self._straight().within(inside, phase)
        line = self._line().within(inside, phase)
        return line if self.corner is None else line + self._corner(inside, phase)

    def mean(self, start: Real[Any, " k"], stop: Real[Any, " k"]) -> Float[Any, "k e r"]:
        return self._straight().mean(start, stop) if self.twist is None else mean_by_quadrature(self, start, stop)

    def _top(self) -> Any:
        """The height of the corner, or the depth of cut within it, m."""
        return jnp.minimum(self.depth, self._height(self.lead))

    def _height(self, lead: Any) -> Any:
        """Of the points of the corner, m."""
        radius: Any = self.corner
        return 2 * radius * jnp.sin(lead / 2) ** 2

    def _angle(self, height: Real[Any, "*points"]) -> Float[AnyArray, "*points"]:
        """The lead angle of the corner at heights."""
        # Of a root of none the derivative is none either.
        radius: Any = self.corner
        share = jnp.where(height > 0, height, radius) / (2 * radius)
        return jnp.where(height > 0, 2 * jnp.arcsin(jnp.sqrt(share)), 0.0)

    def _straight(self) -> StraightTeeth:
        """Straight teeth of the same force: all heights of an edge are at one angle."""
        bottom = 0.0 if self.corner is None else self._top()
        widths: list[tuple[Cutting, Any]] = [(per_width(self, self.lead), (self.depth - bottom) / jnp.sin(self.lead))]
        if self.corner is not None:
            points, weights = gauss_nodes(_POINTS)
            angle = self._angle(bottom)
            widths.append((per_width(self, angle * points), self.corner * angle * weights))

        def over(part: Callable[[Cutting], Any]) -> Any:
            return sum(jnp.sum(part(cut) * width) for cut, width in widths)

        whole = over(lambda cut: cut.tangential), over(lambda cut: cut.normal), over(lambda cut: cut.axial)
        plunge: Any = tuple(over(lambda cut, index=index: cut.plunge[index]) for index in range(3))
        return StraightTeeth(1.0, *whole, plunge, *self._others(self.before), self.parts)

    def _line(self) -> HelicalTeeth:
        """The edges above the corner, whose tips are at its top."""
        bottom = 0.0 if self.corner is None else self._top()
        wide, before = 1 / jnp.sin(self.lead), 0.0 if self.before is None else self.before
        tangential, normal, axial, plunge, _ = per_width(self, self.lead)
        parts = wide * tangential, wide * normal, wide * axial, (wide * plunge[0], wide * plunge[1], wide * plunge[2])
        twist: Any = self.twist
        others = self._others(before - twist * bottom * self.teeth / _TURN)
        return HelicalTeeth(self.depth - bottom, *parts, *others, twist)

    def _others(self, before: Number | None) -> tuple[Number, Number, Number | None, int, int, Law]:
        return self.entry, self.exit, before, self.teeth, self.directions, self.law

    def _corner(self, inside: Real[Any, "..."], phase: Real[Any, " k"]) -> Float[Any, "k e r"]:
        """The corner's force, by Gauss' rule over the part of it in the cut."""
        pitch, top = _TURN / self.teeth, self._top()
        twist: Any = self.twist
        radius: Any = self.corner
        order = jnp.arange(self.teeth)[:, None]
        middle, angle = (pitch * (self._since(place) + order) for place in (inside, phase))
        # Since the tip entered last.
        turn = _TURN * jnp.floor((middle - self.entry) / _TURN)
        middle, angle = middle - turn, angle - turn

        def height(limit: Number) -> Any:
            """Where the edge is at an angle, or the nearest of its ends."""
            known = (middle - limit) / twist
            return jnp.where(known > 0, jnp.where(known < top, (angle - limit) / twist, top), 0.0)

        low, high = self._angle(height(self.exit)), self._angle(height(self.entry))
        points, weights = (part[:, None, None] for part in gauss_nodes(_POINTS))
        lead = low + points * (high - low)
        force = self.law.at(per_width(self, lead), angle - twist * self._height(lead))
        once = twist * top <= _TURN - (self.exit - self.entry)
        width = jnp.where(once, radius * (high - low), jnp.nan)
        return self._shaped(1.0, jnp.sum(width * weights * force, axis=(-3, -2)))


def per_width(teeth: Teeth, lead: Any) -> Cutting:
    """Coefficients per width along the profile at lead angles, of the specific ones of teeth."""
    sine, cosine = jnp.sin(lead), jnp.cos(lead)
    axial = 0.0 if teeth.axial is None else teeth.axial
    three = teeth.tangential, teeth.normal * sine + axial * cosine, axial * sine - teeth.normal * cosine
    lateral = [sine * part for part in three] if teeth.law.chip else three
    plunge = cosine * three[0], cosine * three[1], cosine * three[2]
    return Cutting(lateral[0], lateral[1], lateral[2], plunge, teeth.directions)
