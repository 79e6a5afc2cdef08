"""Teeth whose axis is not that of the spindle, so that it goes around with them."""

from typing import Any, ClassVar

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Real

from lobex._pytree import pytree
from lobex._shapes import Number
from lobex.systems.coefficients import Coefficient, Piece, mean_by_quadrature

_TURN = 2 * np.pi


@pytree()
class OrbitingAxis:
    """−H(t) [E(t) − E(t − τ)]: what an axis off by E(t) makes a tooth cut, as a vibration would.

    At the height z tooth j has e cos(θ_j − ψ(z) − α) more radius, with its lag ψ (Kline and DeVor, The effect of runout
    on cutting geometry and forces in end milling, Int. J. Mach. Tool Des. Res. 23, 1983). The period is a revolution.

    Attributes:
        force: H, of the tooth.
        offset: e, m.
        angle: α, from tooth 0 in the direction in which the teeth lead, rad.
        share: τ, in revolutions.
    """

    force: Coefficient
    offset: Number
    angle: Number
    share: Number

    constant: ClassVar[bool] = False

    def pieces(self) -> tuple[Piece, ...]:
        return self.force.pieces()

    def at(self, phase: Real[Any, " k"]) -> Float[Any, "k e 1"]:
        return self._pushed(self.force.at(phase), phase)

    def within(self, inside: Real[Any, "..."], phase: Real[Any, " k"]) -> Float[Any, "k e 1"]:
        return self._pushed(self.force.within(inside, phase), phase)

    def mean(self, start: Real[Any, " k"], stop: Real[Any, " k"]) -> Float[Any, "k e 1"]:
        return mean_by_quadrature(self, start, stop)

    def _pushed(self, force: Float[Any, "k e r"], phase: Real[Any, " k"]) -> Float[Any, "k e 1"]:
        now, before = (_TURN * (phase - ago) + self.angle for ago in (0.0, self.share))
        moved = self.offset * jnp.stack([jnp.sin(now) - jnp.sin(before), jnp.cos(now) - jnp.cos(before)], axis=-1)
        plane = min(jnp.shape(force)[-1], 2)
        return -jnp.einsum("ker,kr->ke", force[..., :plane], moved[:, :plane])[..., None]
