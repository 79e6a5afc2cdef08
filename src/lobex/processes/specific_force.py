"""The force of a point of an edge at an angle, and its integral over angles: of the chip, of a step in its radius, and
of the edge itself.

All are of anything that has ``tangential`` K_t and ``normal`` K_n, N/m², and ``directions``: 1 along the feed, 2 with
the one across it, 3 with the axis of the tool. Of these a force has an ``axial`` part Z, and motion along the axis
makes forces T, R and Z of its own, ``plunge``: each None for none.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax.numpy as jnp
from jaxtyping import Float

from lobex._shapes import AnyArray


class Law(NamedTuple):
    """A force of one tooth by its entries, shape (entries, …).

    Attributes:
        at: of a cut and an angle, rad: the force, N/m².
        work: an antiderivative of it over the angle.
        between: of a cut, the middle and the span of a range of angles: its integral, with the digits of the span.
        square: whether the entries are those of a square matrix, and not of a column.
        chip: whether it is that of a chip, which a lead angle makes thinner.
    """

    at: Callable[[Any, Float[Any, " *lanes"]], Float[Any, " entries *lanes"]]
    work: Callable[[Any, Float[Any, " *lanes"]], Float[Any, " entries *lanes"]]
    between: Callable[[Any, Float[Any, " *lanes"], Float[Any, " *lanes"]], Float[Any, " entries *lanes"]]
    square: bool
    chip: bool = True


class Cutting(NamedTuple):
    """Coefficients of a force, as the laws take them."""

    tangential: Any
    normal: Any
    axial: Any
    plunge: tuple[Any, Any, Any]
    directions: int


class Moments(NamedTuple):
    """Integrals over angles: of sin², cos² and sin cos; of sin and cos; and of 1. Or, at an angle, these themselves."""

    sine_squared: Any
    cosine_squared: Any
    product: Any
    sine: Any
    cosine: Any
    one: Any


def specific_force(cutting: Any, angle: Float[Any, " *lanes"]) -> Float[Any, " entries *lanes"]:
    """H of one tooth at an angle, N/m², row by row (xx or xx, xy, yx, yy or xx, xy, xz, …), shape (entries, …)."""
    sine, cosine = jnp.sin(angle), jnp.cos(angle)
    along, *across = by_thickness(cutting, sine, cosine)
    if not across:
        return (along * sine)[None]
    rows = [(force * sine, force * cosine) for force in (along, across[0])]
    if cutting.directions == 2:
        return jnp.stack([entry for row in rows for entry in row])
    return _in_space(cutting, rows, Moments(None, None, None, sine, cosine, jnp.ones_like(sine)))


def by_thickness(
    cutting: Any, sine: Float[Any, " *lanes"], cosine: Float[Any, " *lanes"]
) -> tuple[Float[Any, " *lanes"], ...]:
    """The force of one tooth per chip thickness and depth, N/m², along the feed and, of more directions, across it.

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
    return _by_moments(cutting, Moments(sine_squared, cosine_squared, product, -jnp.cos(angle), sine, angle))


def work_between(cutting: Any, middle: Float[Any, "..."], span: Float[Any, "..."]) -> Float[Any, "entries ..."]:
    """The integral of ``specific_force`` over a range of angles, from its middle and span."""
    half = jnp.sin(span) / 2
    turned = half * jnp.cos(2 * middle)
    # ∫ sin = 2 sin(span/2) sin(middle), and so for the cosine.
    chord = 2 * jnp.sin(span / 2)
    return _by_moments(
        cutting,
        Moments(
            span / 2 - turned,
            span / 2 + turned,
            half * jnp.sin(2 * middle),
            chord * jnp.sin(middle),
            chord * jnp.cos(middle),
            span,
        ),
    )


def _by_moments(cutting: Any, moments: Moments) -> Float[AnyArray, "entries ..."]:
    t, n = cutting.tangential, cutting.normal
    along = t * moments.product + n * moments.sine_squared
    if cutting.directions == 1:
        return jnp.stack([along])
    if cutting.directions == 2:
        # As a product, since XLA would compute the moments for each entry anew.
        none = jnp.zeros_like(t + n)
        shares = jnp.stack([jnp.stack(row) for row in ([n, none, t], [none, t, n], [-t, none, n], [none, n, -t])])
        return jnp.tensordot(shares, jnp.stack(jnp.broadcast_arrays(*moments[:3])), axes=1)
    rows = [
        (along, t * moments.cosine_squared + n * moments.product),
        (n * moments.product - t * moments.sine_squared, n * moments.cosine_squared - t * moments.product),
    ]
    return _in_space(cutting, rows, moments)


def _in_space(cutting: Any, rows: Any, moments: Moments) -> Float[AnyArray, "entries ..."]:
    """The nine entries: those in the plane, −(T cos + R sin, R cos − T sin, Z) of plunging, and Z (sin, cos)."""
    axial = 0.0 if cutting.axial is None else cutting.axial
    t, r, z = (0.0, 0.0, 0.0) if cutting.plunge is None else cutting.plunge
    down = (t * moments.cosine + r * moments.sine, r * moments.cosine - t * moments.sine, z * moments.one)
    rows = [*rows, (axial * moments.sine, axial * moments.cosine)]
    entries = [entry for row, into in zip(rows, down, strict=True) for entry in (*row, -into)]
    return jnp.stack(jnp.broadcast_arrays(*entries))


def _step(cutting: Any, angle: Float[Any, " *lanes"]) -> Float[Any, " entries *lanes"]:
    return _column(cutting, jnp.sin(angle), jnp.cos(angle), jnp.ones_like(angle))


def _step_work(cutting: Any, angle: Float[Any, " *lanes"]) -> Float[Any, " entries *lanes"]:
    return _column(cutting, -jnp.cos(angle), jnp.sin(angle), angle)


def _step_between(cutting: Any, middle: Float[Any, "..."], span: Float[Any, "..."]) -> Float[Any, "entries ..."]:
    chord = 2 * jnp.sin(span / 2)
    return _column(cutting, chord * jnp.sin(middle), chord * jnp.cos(middle), span)


def _column(
    cutting: Any, sine: Float[Any, "..."], cosine: Float[Any, "..."], one: Float[Any, "..."]
) -> Float[Any, "entries ..."]:
    plane = by_thickness(cutting, sine, cosine)
    if cutting.directions < 3:
        return jnp.stack(plane)
    return jnp.stack(jnp.broadcast_arrays(*plane, (0.0 if cutting.axial is None else cutting.axial) * one))


CHIP = Law(specific_force, specific_work, work_between, True)
"""H, of what the chip gains by a motion, K_t t nᵀ + K_n n nᵀ, and K_a a nᵀ in space."""

STEP = Law(_step, _step_work, _step_between, False)
"""K_t t + K_n n, and K_a a in space, of a chip that is thicker by as much at every angle."""

EDGE = STEP._replace(chip=False)
"""The same of a force that does not depend on the chip."""
