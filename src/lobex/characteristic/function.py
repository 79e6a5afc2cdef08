"""The characteristic function of one contact with constant feedback, and its derivative.

With z = sτ and feedback P = K p, Q = K q, the multipliers are e^z of the roots of 1 + K L(z) = 0, where
L(z) = −(p + q e^{−z}) H(z) and H(z) = τ C (zI − τA)⁻¹ E is a sum over the blocks of A. Along a root
dz/d(log K) = −L/L′.
"""

import math
from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np

from lobex._pytree import pytree
from lobex.characteristic.lanes import with_modes
from lobex.systems.system import DelaySystem

Array = Any

# Blocks summed without a loop in between.
_UNROLLED = 8
# z where poles of modes that are none lie: out of the way.
_FAR = 1e9
# π/2 in two parts, the first so short that its multiples are exact.
_QUARTER_TURN = (1.5707963267341256, 6.077100506506192e-11)


@pytree()
class Contact:
    """One contact as the delay sees it; the trailing axes are lanes, such as speeds.

    Attributes:
        numerator: coefficients of the numerators of H in z, lowest first, shape (n, s, …).
        denominator: those of the monic denominators, without the leading one, shape (n, s, …).
        current: p, shape (…,).
        delayed: q, shape (…,).
    """

    numerator: Array
    denominator: Array
    current: Array
    delayed: Array

    def filled(self) -> "Contact":
        """With modes that add nothing, up to one of a few numbers of them, for which programs are compiled."""
        far = np.append(_FAR**2, np.zeros(np.shape(self.denominator)[1] - 1))[:, None]
        numerator, denominator = with_modes(self.numerator, np.zeros(1)), with_modes(self.denominator, far)
        return Contact(numerator, denominator, self.current, self.delayed)


class Response(NamedTuple):
    """H, its derivative by z, and how many ulps of 1 rounding may have put into it."""

    value: Array
    slope: Array
    rounding: Array


class Loop(NamedTuple):
    """L and its derivative by z."""

    value: Array
    slope: Array


def contact(system: DelaySystem) -> Contact:
    """The contact of one delay system, with its gain as it stands.

    The coefficients of C adj(zI − τA) E and of the characteristic polynomial by Faddeev and LeVerrier.
    """
    blocks = system.blocks * system.period
    size = jnp.shape(blocks)[-1]
    unit = jnp.eye(size, dtype=blocks.dtype)
    power = jnp.broadcast_to(unit, blocks.shape)
    numerator, denominator = [], []
    for degree in range(1, size + 1):
        numerator.append(system.period * jnp.einsum("nrs,nst,ntr->n", system.outputs, power, system.inputs))
        product = blocks @ power
        coefficient = -jnp.trace(product, axis1=-2, axis2=-1) / degree
        denominator.append(coefficient)
        power = product + coefficient[:, None, None] * unit
    present, (delayed,) = system.at(jnp.zeros(1))
    return Contact(
        jnp.stack(numerator[::-1], axis=1), jnp.stack(denominator[::-1], axis=1), present[0, 0, 0], delayed[0, 0, 0]
    )


def response(contact: Contact, z: Array) -> Response:
    """H; ``z`` is complex, and its trailing axes are the contact's lanes."""
    size = jnp.abs(z)

    def add(sums: tuple[Array, ...], block: tuple[Array, Array]) -> tuple[tuple[Array, ...], None]:
        top, top_slope = _polynomial(block[0], z)
        denominator = jnp.concatenate([block[1], jnp.ones_like(block[1][:1])])
        bottom, bottom_slope = _polynomial(denominator, z)
        flipped = inverse(bottom)
        ratio, term = bottom_slope * flipped, top * flipped
        # Next to a pole the terms of the denominator take each other away.
        lost = jnp.abs(term * flipped) * _polynomial(jnp.abs(denominator), size)[0]
        return tuple(s + t for s, t in zip(sums, (term, top_slope * flipped - term * ratio, lost), strict=True)), None

    zero = jnp.zeros_like(z)
    blocks = (contact.numerator, contact.denominator)
    return Response(*jax.lax.scan(add, (zero, zero, jnp.zeros_like(size)), blocks, unroll=_UNROLLED)[0])


def loop(contact: Contact, z: Array) -> Loop:
    """L and its derivative; ``z`` is complex, and its trailing axes are the contact's lanes."""
    at = response(contact, z)
    before = contact.delayed * decaying(z)
    feedback = contact.current + before
    return Loop(-feedback * at.value, before * at.value - feedback * at.slope)


def _polynomial(coefficients: Array, z: Array) -> tuple[Array, Array]:
    """A polynomial and its derivative from real coefficients (s, …), lowest first."""
    value, slope = coefficients[-1], jnp.zeros_like(coefficients[0])
    for coefficient in coefficients[-2::-1]:
        value, slope = value * z + coefficient, slope * z + value
    return value, slope


def inverse(z: Array) -> Array:
    """1/z without the scaling that guards against overflow, which takes longer than all the rest."""
    return z.conj() * (1 / (jnp.square(z.real) + jnp.square(z.imag)))


def decaying(z: Array) -> Array:
    """e^{−z}, with sine and cosine by Taylor polynomials: the library's own take longer than all the rest.

    To rounding for |Im z| below 1e5.
    """
    quarter = jnp.round(z.imag * (2 / jnp.pi))
    rest = (z.imag - quarter * _QUARTER_TURN[0]) - quarter * _QUARTER_TURN[1]
    square = jnp.square(rest)
    sine, cosine = jnp.zeros_like(rest), jnp.zeros_like(rest)
    for k in reversed(range(9)):
        sine = sine * square + (-1) ** k / math.factorial(2 * k + 1)
        cosine = cosine * square + (-1) ** k / math.factorial(2 * k)
    sine = sine * rest
    odd, half = jnp.mod(quarter, 2) == 1, jnp.mod(jnp.floor(quarter / 2), 2) == 1
    turned = [cast(Array, jnp.where(odd, *pair)) for pair in ((sine, cosine), (cosine, sine))]
    size = jnp.exp(-z.real)
    signs = [cast(Array, jnp.where(negative, -size, size)) for negative in (half != odd, ~half)]
    return jax.lax.complex(signs[0] * turned[0], signs[1] * turned[1])
