"""The feedback of a gain of one around the structure alone: L = −Σ (p + q e^{−z}) H, with roots where 1 + K L = 0.

The sum is over the outputs that the feedback sees: one where what acts now is what is remembered, else two.
"""

from functools import reduce
from operator import add
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float, Inexact

from lobex.characteristic.closed_loop import Loops


class Open(NamedTuple):
    """L of lanes (b,).

    Attributes:
        present: p of each output, (o, b).
        delayed: q, (o, b).
        loops: H of each, with the same poles.
        lag: the delay of each, of the longest, (o, b); None where there is one.
    """

    present: Float[Any, "o b"]
    delayed: Float[Any, "o b"]
    loops: Loops
    lag: Any | None = None

    @property
    def fading(self) -> Any:
        """q by the delay: of −L′, what of q e^{−zθ} is by z."""
        return self.delayed if self.lag is None else self.delayed * self.lag

    def filled(self) -> "Open":
        """With modes that add nothing, up to one of a few numbers of them, for which programs are compiled."""
        return self._replace(loops=self.loops.filled())

    def bounding(self, size: Float[Any, " b"]) -> Loops:
        """A response whose bound, from its coefficients, is one of Σ (|p| + |q| size) |H|."""
        weight = np.abs(self.present) + np.abs(self.delayed) * size
        first, constant = (np.sum(weight * np.abs(part), axis=1) for part in self.loops[:2])
        return self.loops._replace(first=first, constant=constant)


def weighted(weights: Any, parts: Any) -> Inexact[Any, "..."]:
    """Σ of weights (o, …) times as many parts."""
    return reduce(add, (weight * part for weight, part in zip(weights, parts, strict=True)))
