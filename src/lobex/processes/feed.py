"""The feed: what moves on steadily between two passes is there to cut, however long they are apart."""

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from jaxtyping import Float

from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.systems.coefficients import Coefficient, Following, Framed, Piece, mean_by_quadrature
from lobex.systems.delays import Delay, Share, WholePeriod
from lobex.systems.system import DelaySystem
from lobex.systems.terms import Forcing, Regenerative


@pytree()
class Fed:
    """−H(t) τ(t)/T · travel, (e, 1): what is left by a pass before which was not always as long ago.

    Attributes:
        force: H.
        delay: τ.
        travel: the feed in a period, (r, 1), m.
    """

    force: Coefficient
    delay: Delay
    travel: Float[AnyArray, "r 1"]

    constant: ClassVar[bool] = False

    def pieces(self) -> tuple[Piece, ...]:
        return self.force.pieces()

    def at(self, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k e 1"]:
        return self._fed(self.force.at(phase), phase)

    def within(self, inside: Number, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k e 1"]:
        return self._fed(self.force.within(inside, phase), phase)

    def mean(self, start: Float[AnyArray, " k"], stop: Float[AnyArray, " k"]) -> Float[AnyArray, "k e 1"]:
        return mean_by_quadrature(self, start, stop)

    def _fed(self, force: Float[AnyArray, "k e r"], phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k e 1"]:
        return -self.delay.shares(phase, 1.0)[:, None, None] * (force @ self.travel)


def with_feed(system: DelaySystem, travel: Number) -> DelaySystem:
    """The same, fed along its first direction: every regenerative force meets what was fed since, −H(t) (v τ, 0, …).

    Args:
        system: of delays that do not follow the length of the period, in periods.
        travel: the feed in a period, m.
    """
    lib = namespace(travel)
    along = lib.asarray(travel) * np.eye(system.output_size, 1)

    def forcing(term: Regenerative) -> Forcing:
        share = {WholePeriod: 1.0, Share: getattr(term.delay, "share", None)}.get(type(term.delay))
        if share is None:
            return Forcing(Following(Fed(term.coefficient, term.delay, along)))
        pushed: Any = Framed(-np.eye(system.force_size), Following(term.coefficient), share * along)
        return Forcing(pushed)

    fed = [forcing(term) for term in system.feedback if isinstance(term, Regenerative)]
    return replace(system, terms=(*system.terms, *fed))
