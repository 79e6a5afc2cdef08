"""Piecewise cubics through samples, with the slopes of the quartics through each sample and its neighbours."""

import numpy as np
from jaxtyping import Complex, Float, Int, Real

from lobex._namespace import namespace
from lobex._shapes import AnyArray

# Samples that the slope at one of them is taken from.
_NEIGHBOURS = 5


class Cubics:
    """Hermite's interpolation of samples over increasing knots, (n,), of values of any shape, (n, …): of order h⁴.

    A stray sample changes it no further than three samples away.
    """

    def __init__(self, knot: Real[AnyArray, " n"], value: Complex[AnyArray, " n *of"]) -> None:
        lib = namespace(knot, value)
        slope = _slopes(knot, value)
        self._free = (None,) * (np.ndim(value) - 1)
        step = lib.diff(knot)[:, *self._free]
        secant = lib.diff(value, axis=0) / step
        self._coefficients = (
            value[:-1],
            slope[:-1],
            (3 * secant - 2 * slope[:-1] - slope[1:]) / step,
            (slope[:-1] + slope[1:] - 2 * secant) / step**2,
        )

    def at(
        self, row: Int[AnyArray, " *points"], offset: Float[AnyArray, " *points"]
    ) -> tuple[Complex[AnyArray, "..."], Complex[AnyArray, "..."], Complex[AnyArray, "..."]]:
        """Value and first and second derivative at offsets from the knots ``row``, each of the shape (*points, …)."""
        c0, c1, c2, c3 = (c[row] for c in self._coefficients)
        x = offset[..., *self._free]
        return c0 + x * (c1 + x * (c2 + x * c3)), c1 + x * (2 * c2 + x * 3 * c3), 2 * c2 + 6 * x * c3


def inverted(
    value: Complex[AnyArray, "..."], slope: Complex[AnyArray, "..."], bend: Complex[AnyArray, "..."]
) -> tuple[Complex[AnyArray, "..."], Complex[AnyArray, "..."], Complex[AnyArray, "..."]]:
    """1/v and its first and second derivative, from those of v."""
    inverse = 1 / value
    ratio = slope * inverse
    return inverse, -inverse * ratio, inverse * (2 * ratio**2 - bend * inverse)


def _slopes(knot: Real[AnyArray, " n"], value: Complex[AnyArray, " n *of"]) -> Complex[AnyArray, " n *of"]:
    """Derivative at each knot of the polynomial through the (at most five) samples around it."""
    lib = namespace(knot, value)
    count = knot.shape[0]
    points = min(_NEIGHBOURS, count)
    first = np.clip(np.arange(count) - points // 2, 0, count - points)
    index = first[:, None] + np.arange(points)
    own = np.arange(count) - first
    span = knot[index[:, -1]] - knot[index[:, 0]]
    x = (knot[index] - knot[:, None]) / span[:, None]
    mine = own[:, None] == np.arange(points)
    # Lagrange's polynomial j has the slope λⱼ/(λᵢ (xᵢ − xⱼ)) at the node i, with xᵢ = 0 and 1/λⱼ = Π (xⱼ − xₖ).
    apart = x[:, :, None] - x[:, None, :] + np.eye(points)
    inverse = apart[..., 0]
    for k in range(1, points):
        inverse = inverse * apart[..., k]
    weights = lib.sum(lib.where(mine, inverse, 0.0), axis=1, keepdims=True) / (-inverse * lib.where(mine, 1.0, x))
    # Differences of values and not values: the slope of a constant is exactly zero.
    change = lib.einsum("nj,nj...->n...", lib.where(mine, 0.0, weights), value[index] - value[:, None])
    return change / span[:, *(None,) * (np.ndim(value) - 1)]
