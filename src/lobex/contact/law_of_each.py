"""Laws of several kinds, one for each contact, as one law."""

from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from lobex._pytree import pytree
from lobex._shapes import AnyArray, Numbers
from lobex.contact.laws import ContactLaw


@pytree()
class OfEach:
    """The law of each contact, along the first axis of what it is asked.

    Attributes:
        laws: one for each contact.
    """

    laws: tuple[ContactLaw, ...]

    @property
    def follows_rate(self) -> bool:
        """Whether any of them does."""
        return any(map(_follows_rate, self.laws))

    def force(self, penetration: Numbers, depth: Numbers = 0.0, rate: Numbers | None = None) -> Float[AnyArray, "..."]:
        """The contact forces, N."""

        def one(law: Any, penetration: Any, depth: Any, *rate: Any) -> Any:
            return law.force(penetration, depth, *rate) if _follows_rate(law) else law.force(penetration, depth)

        return self._stacked(one, penetration, depth, *(() if rate is None else (rate,)))

    def energy(self, penetration: Numbers, depth: Numbers = 0.0) -> Float[AnyArray, "..."]:
        """The potentials of the forces, J."""
        return self._stacked(lambda law, *at: law.energy(*at), penetration, depth)

    def removed(self, penetration: Numbers, depth: Numbers, residual: Numbers) -> Float[AnyArray, "..."]:
        """The depths that the contacts remove, m."""
        return self._stacked(lambda law, *at: law.removed(*at), penetration, depth, residual)

    def _stacked(self, ask: Callable[..., Any], *at: Any) -> Float[AnyArray, "..."]:
        return jnp.stack(
            [
                ask(law, *(part[number] if np.ndim(part) else part for part in at))
                for number, law in enumerate(self.laws)
            ]
        )


def _follows_rate(law: Any) -> bool:
    return bool(getattr(law, "follows_rate", False))
