"""The characteristic function of constant feedback with constant delays by one force, and its derivative.

With z = sτ and feedback K(p y + q w) of outputs y now and w a delay ago, the multipliers over the delay are e^z of the
roots of 1 + K L(z) = 0, where L(z) = −Σ (p + q e^{−z}) H(z) over the outputs and H(z) = τ C (zI − τA)⁻¹ E is a sum over
the blocks of A. Of several delays τ is the longest, and an output that is seen θτ ago has e^{−zθ}. Along a root
dz/d(log K) = −L/L′.
"""

import math
from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float, Inexact

from lobex._pytree import pytree
from lobex.characteristic.closed_loop import FAR, Loops
from lobex.characteristic.lanes import with_modes
from lobex.characteristic.open_loop import weighted

# Blocks summed without a loop in between.
_UNROLLED = 8
# Of a real pole without a partner: where one is put, in sizes of all poles.
_BESIDE = 10.0
# π/2 in two parts, the first so short that its multiples are exact.
_QUARTER_TURN = (1.5707963267341256, 6.077100506506192e-11)


@pytree()
class Contact:
    """The force as the delay sees it; the trailing axes are lanes, such as speeds.

    Attributes:
        numerator: coefficients of the numerators of every H in z, lowest first, shape (n, s, o, …).
        denominator: those of the monic denominators, without the leading one, shape (n, s, …).
        doubt: how far off the denominators' coefficients may be, the leading one included, in ulps of 1, (n, s + 1, …).
        present: p of each output, shape (o, …).
        delayed: q, shape (o, …).
        lag: the delay of each output, of the longest, shape (o, …); None where there is one.
    """

    numerator: Float[Any, "n s o *lanes"]
    denominator: Float[Any, "n s *lanes"]
    doubt: Float[Any, "n s+1 *lanes"]
    present: Float[Any, " o *lanes"]
    delayed: Float[Any, " o *lanes"]
    lag: Float[Any, " o *lanes"] | None = None

    def filled(self) -> "Contact":
        """With modes that add nothing, up to one of a few numbers of them, for which programs are compiled."""
        far = np.append(FAR**2, np.zeros(np.shape(self.denominator)[1] - 1))[:, None]
        return Contact(
            with_modes(self.numerator, np.zeros(1)),
            with_modes(self.denominator, far),
            with_modes(self.doubt, np.zeros(1)),
            self.present,
            self.delayed,
            self.lag,
        )

    def before(self, z: Complex[Any, "..."]) -> tuple[list[Any], list[Any]]:
        """q e^{−zθ} of each output, and less its derivative by z."""
        if self.lag is None:
            turned = [q * decaying(z) for q in self.delayed]
            return turned, turned
        turned = [q * decaying(lag * z) for q, lag in zip(self.delayed, self.lag, strict=True)]
        return turned, [lag * part for part, lag in zip(turned, self.lag, strict=True)]


class Response(NamedTuple):
    """Of each output H, its derivative by z, and how many ulps of 1 rounding may have put into it."""

    value: list[Complex[Any, " *lanes"]]
    slope: list[Complex[Any, " *lanes"]]
    rounding: list[Float[Any, " *lanes"]]


class Loop(NamedTuple):
    """L and its derivative by z."""

    value: Complex[Any, " *lanes"]
    slope: Complex[Any, " *lanes"]


def by_blocks(
    blocks: Float[Any, "n s s"],
    inputs: Float[Any, "n s"],
    outputs: Float[Any, "n o s"],
    delay: Float[Any, ""],
) -> tuple[Float[Any, "n s o"], Float[Any, "n s"]]:
    """Numerators (n, s, o) and denominators (n, s) of H of one structure with A's blocks (n, s, s).

    The coefficients of C adj(zI − τA) E and of the characteristic polynomial by Faddeev and LeVerrier.

    Args:
        blocks: A, 1/s.
        inputs: E, (n, s).
        outputs: C, (n, o, s).
        delay: τ, s.
    """
    blocks = blocks * delay
    size = jnp.shape(blocks)[-1]
    unit = jnp.eye(size, dtype=blocks.dtype)
    power = jnp.broadcast_to(unit, blocks.shape)
    numerator, denominator = [], []
    for degree in range(1, size + 1):
        numerator.append(delay * jnp.einsum("nos,nst,nt->no", outputs, power, inputs))
        product = blocks @ power
        coefficient = -jnp.trace(product, axis1=-2, axis2=-1) / degree
        denominator.append(coefficient)
        power = product + coefficient[:, None, None] * unit
    return jnp.stack(numerator[::-1], axis=1), jnp.stack(denominator[::-1], axis=1)


def by_poles(
    alone: Loops, delay: Float[Any, " l"], doubt: Float[Any, " l"]
) -> tuple[Float[Any, "n 2 o l"], Float[Any, "n 2 l"], Float[Any, "n 3 l"]]:
    """Numerators, denominators and their doubt of H in sτ, of its pairs of poles in s.

    Args:
        alone: H of each output, in s.
        delay: τ, (lanes,).
        doubt: how far off the poles of a lane may be in sτ, in ulps of 1, (lanes,).
    """
    # The partner of a real pole is taken away by the numerator wherever it is: not too far off for the others' digits.
    none = alone.lower.real == -FAR
    least = -_BESIDE * (1 / delay + np.max(np.abs(alone.upper), axis=0))
    lower = np.where(none, least, alone.lower)
    constant = np.where(none[:, None], -alone.first * least, alone.constant)
    there = Loops(alone.first, constant, alone.upper, lower).at_delay(delay)
    product, total = (there.upper * there.lower).real, -(there.upper + there.lower).real
    apart = np.abs(product) + doubt * (np.abs(there.upper) + np.abs(there.lower)), np.abs(total) + 2 * doubt
    doubts = np.stack([*apart, np.ones_like(total)], axis=1)
    return np.stack([there.constant, there.first], axis=1), np.stack([product, total], axis=1), doubts


def response(contact: Contact, z: Complex[Any, " *lanes"]) -> Response:
    """H; ``z`` is complex, and its trailing axes are the contact's lanes."""
    size = jnp.abs(z)
    outputs = range(len(contact.present))

    def add(sums: Response, block: tuple[Float[Any, "..."], ...]) -> tuple[Response, None]:
        denominator = jnp.concatenate([block[1], jnp.ones_like(block[1][:1])])
        bottom, bottom_slope = _polynomial(denominator, z)
        flipped = inverted(bottom)
        ratio = bottom_slope * flipped
        # Next to a pole the terms of the denominator take each other away.
        doubt = jnp.abs(flipped) * _polynomial(block[2], size)[0]
        tops = [_polynomial(block[0][:, j], z) for j in outputs]
        terms = [top * flipped for top, _ in tops]
        slopes = [slope * flipped - term * ratio for (_, slope), term in zip(tops, terms, strict=True)]
        return jax.tree.map(jnp.add, sums, Response(terms, slopes, [jnp.abs(term) * doubt for term in terms])), None

    zeros = Response(*([jnp.zeros_like(like) for _ in outputs] for like in (z, z, size)))
    blocks = (contact.numerator, contact.denominator, contact.doubt)
    return jax.lax.scan(add, zeros, blocks, unroll=_UNROLLED)[0]


def loop(contact: Contact, z: Complex[Any, " *lanes"]) -> Loop:
    """L and its derivative; ``z`` is complex, and its trailing axes are the contact's lanes."""
    at = response(contact, z)
    before, fading = contact.before(z)
    feedback = [p + b for p, b in zip(contact.present, before, strict=True)]
    return Loop(-weighted(feedback, at.value), weighted(fading, at.value) - weighted(feedback, at.slope))


def _polynomial(
    coefficients: Float[Any, " s *lanes"], z: Inexact[Any, " *lanes"]
) -> tuple[Inexact[Any, " *lanes"], Inexact[Any, " *lanes"]]:
    """A polynomial and its derivative from real coefficients (s, …), lowest first."""
    value, slope = coefficients[-1], jnp.zeros_like(coefficients[0])
    for coefficient in coefficients[-2::-1]:
        value, slope = value * z + coefficient, slope * z + value
    return value, slope


def inverted(z: Complex[Any, "..."]) -> Complex[Any, "..."]:
    """1/z without the scaling that guards against overflow, which takes longer than all the rest."""
    return z.conj() * (1 / (jnp.square(z.real) + jnp.square(z.imag)))


def decaying(z: Complex[Any, "..."]) -> Complex[Any, "..."]:
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
