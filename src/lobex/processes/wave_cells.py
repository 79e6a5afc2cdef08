"""Who cuts where along serrated edges: heights and, at each, the angles at which a tooth meets what another one left.

At the angle φ tooth j, whose radius stands out by ρ_j(z), meets what the tooth l pitches ahead of it has left, and cuts
F_l sin φ + ρ_j(z) − ρ_{j+l}(z) of it, with the feed F_l of l pitches. Of all l it is the least that counts, and nothing
is cut where that is below zero (Dombovari, Altintas and Stepan, The effect of serration on mechanics and stability of
milling cutters, Int. J. Mach. Tools Manuf. 50, 2010). At a height these are straight lines in sin φ: each is the lowest
of all over one range of it.
"""

from itertools import combinations
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.systems.coefficients import gauss_nodes

_TURN = 2 * np.pi
# Waves that are taken one by one; of more, as many that stand for all.
_WAVES = 10
# Of the feed of a pitch, of sin φ and of a wave: what is missed by less bends nearly, and is a bend as well.
_NEAR = 0.03


@pytree()
class Lines:
    """What each tooth may meet: nothing, or what those 1, 2, … pitches ahead left, p lines F sin φ + d(z) for each of n
    teeth.

    Attributes:
        feed: F, m, (n, p), rising with p from 0.
        apart: the mean of d, m, (n, p).
        cosine, sine: of d its parts with cos and sin of 2π z/λ, m, (n, p).
    """

    feed: Float[AnyArray, "n p"]
    apart: Float[AnyArray, "n p"]
    cosine: Float[AnyArray, "n p"]
    sine: Float[AnyArray, "n p"]

    @property
    def count(self) -> int:
        """p."""
        return np.shape(self.feed)[1]

    @property
    def waves(self) -> Float[Any, "3 n p"]:
        """The three parts of d."""
        return namespace(self).stack([self.apart, self.cosine, self.sine])

    def at(self, turned: Float[AnyArray, "n k"]) -> Float[Any, "p n k"]:
        """d at places of the wave, rad, (n, k)."""
        lib = namespace(self, turned)
        apart, cosine, sine = lib.swapaxes(self.waves, 1, 2)[..., None]
        return apart + cosine * lib.cos(turned) + sine * lib.sin(turned)

    def of(self, teeth: slice) -> "Lines":
        """Those of some of the teeth."""
        return Lines(self.feed[teeth], self.apart[teeth], self.cosine[teeth], self.sine[teeth])


class Cells(NamedTuple):
    """Places along a wave, and weights by which what is smooth between its bends is integrated over it.

    Attributes:
        turned: 2π z/λ of the wave, rad, (n, k).
        weight: rad, (n, k).
    """

    turned: Float[Array, "n k"]
    weight: Float[Array, "n k"]


def bends(lines: Lines, levels: tuple[Number, ...]) -> Float[Any, "n b"]:
    """Where along a wave, rad above 0 and up to 2π in order after some 0, integrals over angles bend as functions of
    the height: the lowest line begins or ends at one of the levels of sin φ, or three lines meet.

    Not for derivatives, which need none: what is integrated is the same on both sides of such a place.
    """
    lib = namespace(lines, levels)
    feed, waves = lib.asarray(lines.feed), lines.waves
    low, high = np.array(list(combinations(range(lines.count), 2))).T
    mean, cosine, sine = (waves[..., low] - waves[..., high])[..., None]
    level = lib.stack([lib.asarray(one, dtype=lib.result_type(float)) for one in levels])
    mean = mean - (feed[:, high] - feed[:, low])[..., None] * level
    place = [_roots(*lib.broadcast_arrays(mean, cosine, sine))]
    reached = [lib.broadcast_to(level[:, None], lib.shape(place[0])).reshape(len(feed), -1)]
    number = [np.repeat(low, 2 * len(levels))]
    if lines.count > 2:
        first, second, third = np.array(list(combinations(range(lines.count), 3))).T
        above, below = feed[:, third] - feed[:, second], feed[:, second] - feed[:, first]
        parts = above * (waves[..., first] - waves[..., second]) - below * (waves[..., second] - waves[..., third])
        place.append(_roots(*parts))
        met = lines.at(place[1].reshape(len(feed), -1))
        pair = [lib.take_along_axis(met, np.repeat(one, 2)[None, None], axis=0)[0] for one in (first, second)]
        reached.append((pair[0] - pair[1]) / lib.repeat(below, 2, axis=1))
        number.append(np.repeat(first, 2))
    turned, sine_there = (
        lib.concatenate([part.reshape(len(feed), -1) for part in parts], axis=1) for parts in (place, reached)
    )
    chips = feed.T[..., None] * sine_there + lines.at(lib.nan_to_num(turned))
    least = lib.take_along_axis(chips, np.concatenate(number)[None, None], axis=0)[0]
    near = _NEAR * feed[:, 1:2]
    lowest = lib.all(chips[1:] >= least - near, axis=0) & (least >= -near) & (lib.abs(sine_there - 0.5) < 0.5 + _NEAR)
    found = lib.sort(lib.where(lowest & lib.isfinite(turned), lib.mod(turned, _TURN), 0.0), axis=1)
    return jax.lax.stop_gradient(found) if lib is jnp else found


def _roots(mean: Float[Any, "*k"], cosine: Float[Any, "*k"], sine: Float[Any, "*k"]) -> Float[Any, "*k 2"]:
    """Where mean + cosine·cos u + sine·sin u is zero, or nearly; NaN where that is nowhere."""
    lib = namespace(mean, cosine, sine)
    swing = lib.hypot(cosine, sine)
    share = -mean / lib.where(swing > 0, swing, 1.0)
    there = (swing > 0) & (lib.abs(share) < 1 + _NEAR)
    middle, half = lib.arctan2(sine, cosine), lib.arccos(lib.clip(share, -1.0, 1.0))
    return lib.where(there[..., None], lib.stack([middle - half, middle + half], axis=-1), lib.nan)


def cells_up_to(place: Float[Array, "n b"], end: Number, count: int) -> Cells:
    """``count`` points of Gauss' rule between places of a wave, as far as ``end``, rad, so spaced that angles may go
    with the root of the height there.
    """
    inner = jnp.minimum(place, end)
    edge = jnp.pad(inner, ((0, 0), (1, 0)))
    length = jnp.concatenate([inner, jnp.broadcast_to(end, (len(inner), 1))], axis=1) - edge
    points, weights = gauss_nodes(count)
    half = np.pi / 2 * points
    turned = edge[..., None] + length[..., None] * np.sin(half) ** 2
    weight = length[..., None] * (np.pi / 2 * np.sin(2 * half) * weights)
    return Cells(turned.reshape(len(inner), -1), weight.reshape(len(inner), -1))


def angles_met(
    lines: Lines, turned: Float[Array, "n k"], ahead: int, entry: Number, exit_: Number
) -> Float[Array, "n k 4"]:
    """Where in the cut each tooth begins and ends to meet what the one ``ahead`` left, before and after π/2, rad."""
    apart, feed = lines.at(turned), jnp.asarray(lines.feed).T[..., None]
    # Of a line that rises less, what it meets is met up to there, unless that is nothing at all.
    less, other = np.arange(1, ahead), np.r_[0, ahead + 1 : lines.count]
    high, low = ((apart[part] - apart[ahead]) / (feed[ahead] - feed[part]) for part in (less, other))
    low, high = jnp.max(low, axis=0, initial=0.0), jnp.min(high, axis=0, initial=1.0)
    first, last = (_inverse_sine(level) for level in (low, jnp.maximum(low, high)))
    edges = jnp.stack([first, last, np.pi - last, np.pi - first], axis=-1)
    return jnp.clip(edges, entry, exit_)


def _inverse_sine(level: Float[Array, "n k"]) -> Float[Array, "n k"]:
    """arcsin, and π/2 from 1 on, with derivatives that are numbers."""
    inside = level < 1
    return jnp.where(inside, jnp.arcsin(jnp.where(inside, level, 0.0)), np.pi / 2)


def waves_for(count: Float[AnyArray, ""]) -> tuple[Float[Array, " w"], Float[Array, " w"]]:
    """Waves by number, 0, 1, …, and weights by which what is smooth from one to the next is summed over ``count``.

    Up to ten each has its own; of more, by Gauss' rule for such sums, of which the orthogonal polynomials are Gram's.
    """
    count = jax.lax.stop_gradient(jnp.asarray(count, dtype=jnp.result_type(float)))
    order = np.arange(1.0, _WAVES)
    square = order**2 * (count**2 - order**2) / (4 * (4 * order**2 - 1))
    beside = jnp.sqrt(jnp.maximum(square, 0.0))
    matrix = (count - 1) / 2 * jnp.eye(_WAVES) + jnp.diag(beside, 1) + jnp.diag(beside, -1)
    place, vectors = jnp.linalg.eigh(matrix)
    return place, count * vectors[0] ** 2
