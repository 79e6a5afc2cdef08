"""The span of a beam in equal elements: points of quadrature, shape functions, and what adds up towards the tip.

Deflections are Hermite's cubics, stretch and rotation about the span are quadratic with a node in the middle, so that
frequencies of all of them converge with the fourth power of the element's length. Lobatto's points have the ends of
every element among them, and are exact to the seventh degree: a taper times two cubics.
"""

from typing import Any

import numpy as np
from jaxtyping import Float

from lobex import _checks
from lobex._namespace import namespace
from lobex._shapes import AnyArray, Number

POINTS = 5
NODE, MIDDLE = 6, 2
ELEMENT = 2 * NODE + MIDDLE
STRETCH, ACROSS, ACROSS_SLOPE, ALONG, ALONG_SLOPE, TURN = range(NODE)
"""Of a node: the displacement along the span, two across it with their slopes, and the rotation about it."""

# On (0, 1), (points,) each.
_PLACE = (1 + np.array([-1.0, -np.sqrt(3 / 7), 0.0, np.sqrt(3 / 7), 1.0])) / 2
WEIGHT = np.array([1 / 10, 49 / 90, 32 / 45, 49 / 90, 1 / 10]) / 2


def places(elements: int) -> Float[np.ndarray, "elements points"]:
    """Shares of the span, 0 at the root and 1 at the tip, of all points."""
    return (np.arange(elements)[:, None] + _PLACE) / elements


def along(name: str, given: Any, elements: int) -> Any:
    """A number as it is, values at equal steps along the span as they are, and a function's values at all points.

    Raises:
        ValueError: for a function that returns another shape, and values of another.
    """
    every = places(elements)
    if callable(given):
        values: Any = given(every)
        if np.shape(values) not in ((), every.shape):
            raise ValueError(f"{name} returns the shape {np.shape(values)} at {every.shape} shares of the span")
        return values
    _checks.as_numbers(name, given)
    values = _checks.as_array(given)
    if (np.ndim(values) > 1 and np.shape(values) != every.shape) or np.shape(values) in ((0,), (1,)):
        raise ValueError(
            f"{name} has shape {np.shape(values)}; give one number, two or more from root to tip at equal steps, or a "
            "function of the share of the span"
        )
    return values


def at_points(given: Any, elements: int) -> Float[AnyArray, "elements points"]:
    """What ``along`` returns, at all points; between values given at steps there are lines."""
    lib = namespace(given)
    values, every = lib.asarray(given, dtype=lib.result_type(float)), places(elements)
    if np.ndim(values) == 1:
        return lib.interp(every.ravel(), np.linspace(0.0, 1.0, np.shape(values)[0]), values).reshape(every.shape)
    return lib.broadcast_to(values, every.shape)


def outboard(density: Float[AnyArray, "elements points"], length: Number) -> Float[AnyArray, "elements points"]:
    """∫ of a density from every point to the tip, of a span of this length."""
    lib = namespace(density, length)
    step = length / density.shape[0]
    whole = step * density @ WEIGHT
    beyond = lib.cumsum(whole[::-1])[::-1] - whole
    return beyond[:, None] + step * density @ _TO_THE_END.T


def _to_the_end() -> Float[np.ndarray, "points points"]:
    """∫ from each point to the end of (0, 1), of the polynomial through values at the points."""
    power = np.arange(1, POINTS + 1)
    integral = (1 - _PLACE[:, None] ** power) / power
    return np.linalg.solve(np.vander(_PLACE, increasing=True).T, integral.T).T


def _hermite(order: int) -> Float[np.ndarray, "points 4"]:
    """Derivatives of Hermite's cubics, of the value and the slope at both ends of (0, 1)."""
    cubics = [[1, 0, -3, 2], [0, 1, -2, 1], [0, 0, 3, -2], [0, 0, -1, 1]]
    return np.stack([np.polynomial.Polynomial(c).deriv(order)(_PLACE) for c in cubics], axis=1)


def _quadratic(order: int) -> Float[np.ndarray, "points 3"]:
    """Derivatives of the parabolas of the values at both ends of (0, 1) and in the middle."""
    parabolas = [[1, -3, 2], [0, -1, 2], [0, 4, -4]]
    return np.stack([np.polynomial.Polynomial(c).deriv(order)(_PLACE) for c in parabolas], axis=1)


def _spread(values: Float[np.ndarray, "points k"], rows: list[int]) -> Float[np.ndarray, "points element"]:
    wide = np.zeros((POINTS, ELEMENT))
    wide[:, rows] = values
    return wide


# Degrees of freedom of an element: those of one end, of the middle, and of the other end.
_END, _MID = NODE + MIDDLE, NODE
STRETCHED = [_spread(_quadratic(d), [STRETCH, _END + STRETCH, _MID]) for d in range(2)]
TURNED = [_spread(_quadratic(d), [TURN, _END + TURN, _MID + 1]) for d in range(2)]
DEFLECTED = [
    [_spread(_hermite(d), [one, one + 1, _END + one, _END + one + 1]) for d in range(3)] for one in (ACROSS, ALONG)
]
"""Values and derivatives by the element's share of each motion, (points, 14) each."""
_TO_THE_END = _to_the_end()


def scale(step: Number) -> Float[AnyArray, " element"]:
    """What slopes are multiplied by: they are taken by the span, and shape functions by the element's share."""
    lib = namespace(step)
    slopes = np.zeros(ELEMENT)
    slopes[[start + slope for start in (0, _END) for slope in (ACROSS_SLOPE, ALONG_SLOPE)]] = 1.0
    return lib.where(slopes == 1.0, step, 1.0)


def assembled(parts: Float[AnyArray, "elements 14 14"]) -> Float[AnyArray, "dof dof"]:
    """The matrix of the whole span, of those of its elements, root first: 8 numbers an element and 6 at the tip."""
    lib = namespace(parts)
    count = parts.shape[0]
    rows = (NODE + MIDDLE) * np.arange(count)[:, None] + np.arange(ELEMENT)
    whole = lib.zeros(2 * ((NODE + MIDDLE) * count + NODE,), dtype=parts.dtype)
    place = rows[:, :, None], rows[:, None, :]
    if lib is not np:
        return whole.at[place].add(parts)
    np.add.at(whole, place, parts)
    return whole
