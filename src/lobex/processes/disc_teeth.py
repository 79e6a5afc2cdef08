"""Teeth as a stack of straight discs, each of which lags and leads by angles of its own."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Real

from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray
from lobex.processes.profiled_teeth import per_width
from lobex.processes.teeth import AT, Teeth
from lobex.systems.coefficients import Jumps, Piece, mean_by_quadrature, pieces_between

_TURN = 2 * np.pi


@pytree()
class DiscTeeth(Teeth):
    """The teeth of a stack, whose force jumps where a disc enters or leaves.

    Attributes:
        entry, exit: of all discs, or of each, (discs,), rad.
        discs: thickness, m, lead angle and lag, rad, and radius, m, from the tip, (discs, 4); the last is as thick as
            it takes.
    """

    discs: Real[AnyArray, "discs 4"]

    def jumps(self) -> Jumps:
        lib = namespace(self.discs, self.entry, self.exit, self.before)
        lag = lib.asarray(self.discs)[:, 2]
        place = lib.concatenate([angle + lag for angle in (self.entry, self.exit)]) * self.teeth / _TURN
        return Jumps(place if self.before is None else place - self.before, np.repeat([False, True], len(lag)))

    def pieces(self) -> tuple[Piece, ...]:
        return pieces_between(self.jumps().phase)

    def at(self, phase: Real[Any, " k"]) -> Float[Any, "k e r"]:
        return self.within(phase, phase)

    def within(self, inside: Real[Any, "..."], phase: Real[Any, " k"]) -> Float[Any, "k e r"]:
        thickness, lead, lag = (part[:, None, None] for part in jnp.asarray(self.discs)[:, :3].T)
        entry, exit_ = (jnp.broadcast_to(angle, lag.shape[:1])[:, None, None] for angle in (self.entry, self.exit))
        below = jnp.cumsum(thickness, axis=0) - thickness
        upper = jnp.append(thickness[:-1], jnp.full((1, 1, 1), jnp.inf), axis=0)
        wide = jnp.clip(self.depth - below, 0.0, upper) / jnp.sin(lead)
        order = jnp.arange(self.teeth)[:, None]
        middle, angle = (_TURN / self.teeth * (self._since(place) + order) - lag for place in (inside, phase))
        turn = _TURN * jnp.floor((middle + AT) / _TURN)
        cutting = (middle - turn >= entry - AT) & (middle - turn <= exit_ + AT) & (entry < exit_)
        force = self.law.at(per_width(self, lead), angle - turn)
        return self._shaped(1.0, jnp.sum(wide * cutting * force, axis=(-3, -2)))

    def mean(self, start: Real[Any, " k"], stop: Real[Any, " k"]) -> Float[Any, "k e r"]:
        return mean_by_quadrature(self, start, stop)
