"""The force of a point of an edge at an angle, and its integral over angles: of the chip, and of a step in its radius.

Both are of anything that has ``tangential`` K_t and ``normal`` K_n, N/m², and ``directions``: 1 along the feed, 2 with
the one across it.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax.numpy as jnp
from jaxtyping import Float


class Law(NamedTuple):
    """A force of one tooth by its entries, shape (entries, …).

    Attributes:
        at: of a cut and an angle, rad: the force, N/m².
        work: an antiderivative of it over the angle.
        between: of a cut, the middle and the span of a range of angles: its integral, with the digits of the span.
        square: whether the entries are those of a square matrix, and not of a column.
    """

    at: Callable[[Any, Float[Any, " *lanes"]], Float[Any, " entries *lanes"]]
    work: Callable[[Any, Float[Any, " *lanes"]], Float[Any, " entries *lanes"]]
    between: Callable[[Any, Float[Any, " *lanes"], Float[Any, " *lanes"]], Float[Any, " entries *lanes"]]
    square: bool


def specific_force(cutting: Any, angle: Float[Any, " *lanes"]) -> Float[Any, " entries *lanes"]:
    """H of one tooth at an angle, N/m², by entry (xx or xx, xy, yx, yy), shape (entries, …)."""
    sine, cosine = jnp.sin(angle), jnp.cos(angle)
    along, *across = by_thickness(cutting, sine, cosine)
    if not across:
        return (along * sine)[None]
    return jnp.stack([along * sine, along * cosine, across[0] * sine, across[0] * cosine])


def by_thickness(
    cutting: Any, sine: Float[Any, " *lanes"], cosine: Float[Any, " *lanes"]
) -> tuple[Float[Any, " *lanes"], ...]:
    """The force of one tooth per chip thickness and depth, N/m², along the feed and, of two directions, across it.

    Its antiderivative over the angle is that of −cosine and sine.
    """
    along = cutting.tangential * cosine + cutting.normal * sine
    return (along,) if cutting.directions == 1 else (along, cutting.normal * cosine - cutting.tangential * sine)


def specific_work(cutting: Any, angle: Float[Any, " *lanes"]) -> Float[Any, " entries *lanes"]:
    """Antiderivative of ``specific_force`` over the angle."""
    sine = jnp.sin(angle)
    product = sine * sine / 2
    sine_squared = angle / 2 - jnp.sin(2 * angle) / 4
    cosine_squared = angle / 2 + jnp.sin(2 * angle) / 4
    return _by_squares(cutting, product, sine_squared, cosine_squared)


def work_between(cutting: Any, middle: Float[Any, "..."], span: Float[Any, "..."]) -> Float[Any, "entries ..."]:
    """The integral of ``specific_force`` over a range of angles, from its middle and span."""
    half = jnp.sin(span) / 2
    turned = half * jnp.cos(2 * middle)
    return _by_squares(cutting, half * jnp.sin(2 * middle), span / 2 - turned, span / 2 + turned)


def _by_squares(
    cutting: Any, product: Float[Any, "..."], sine_squared: Float[Any, "..."], cosine_squared: Float[Any, "..."]
) -> Float[Any, "entries ..."]:
    t, n = cutting.tangential, cutting.normal
    entries = [t * product + n * sine_squared]
    if cutting.directions == 2:
        entries += [
            t * cosine_squared + n * product,
            n * product - t * sine_squared,
            n * cosine_squared - t * product,
        ]
    return jnp.stack(entries)


def _step(cutting: Any, angle: Float[Any, " *lanes"]) -> Float[Any, " entries *lanes"]:
    return jnp.stack(by_thickness(cutting, jnp.sin(angle), jnp.cos(angle)))


def _step_work(cutting: Any, angle: Float[Any, " *lanes"]) -> Float[Any, " entries *lanes"]:
    return jnp.stack(by_thickness(cutting, -jnp.cos(angle), jnp.sin(angle)))


def _step_between(cutting: Any, middle: Float[Any, "..."], span: Float[Any, "..."]) -> Float[Any, "entries ..."]:
    # ∫ sin = 2 sin(span/2) sin(middle), and so for the cosine.
    return 2 * jnp.sin(span / 2) * _step(cutting, middle)


CHIP = Law(specific_force, specific_work, work_between, True)
"""H, of what the chip gains by a motion, K_t t nᵀ + K_n n nᵀ."""

STEP = Law(_step, _step_work, _step_between, False)
"""K_t t + K_n n, of a chip that is thicker by as much at every angle."""
