"""How many roots lie to the right of a line Re z = x, at every gain: D-subdivision on a shifted axis.

A root moves continuously with the gain K, and crosses the line only where L(x + jy) is real and negative, at
K = −1/L. Those crossings are found for all gains at once from samples of arg L along the line. The count at a
gain is then that of the poles of L on the right, with every crossing below the gain added (entering) or taken away
(leaving); a pair counts twice. The samples resolve every turn of e^{−jy}, every pole and every zero of the feedback
near the line; a line on which arg L turns a right angle or more from one sample to the next, or on which a crossing
is not found as precisely as the samples announce it, is not trusted.
"""

from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np

from lobex._hidden import hidden_crossings
from lobex.characteristic.function import Contact, loop

Array = Any

# Samples per turn of e^{−jy}, and on either side of a pole, up to a distance of half a turn.
_PER_TURN = 12
_BESIDE = 12
_REACH = 3.0
# Turns up to which a line is looked at: beyond, there are too many roots to follow.
_MOST_TURNS = 2048
# Where the samples begin: on the real axis the sign of Im L is rounding.
_FIRST = 1e-7
_STEPS = 8
_BATCH = 256
_BLOCK = 256
# Parts of a cell in which a pair of crossings may hide, and how often in turn.
_PARTS = 15
_ROUNDS = 2


class Crossings(NamedTuple):
    """Where roots cross the lines, each of shape (e,).

    Attributes:
        owner: number of the line.
        gain: K.
        root: z, Im z ≥ 0.
        rate: dz/d(log K).
        change: of the number of roots on the right: 2 or −2, on the real axis 1 or −1.
    """

    owner: Array
    gain: Array
    root: Array
    rate: Array
    change: Array


class Lines(NamedTuple):
    """Lines Re z = x, one per speed, with what crosses them.

    Attributes:
        level: x, (b,).
        start: roots on the right at a gain of zero, (b,).
        crossings: at gains up to the largest.
        trusted: whether the count closes, (b,).
    """

    level: Array
    start: Array
    crossings: Crossings
    trusted: Array

    def beyond(self, position: Array, columns: int) -> Array:
        """The number of roots on the right, (b, columns), where each crossing comes before column ``position``."""
        change = np.zeros((len(self.level), columns + 1), dtype=int)
        np.add.at(change, (self.crossings.owner, np.clip(position, 0, columns)), self.crossings.change)
        return self.start[:, None] + np.cumsum(change[:, :-1], axis=1)


def cross(contact: Contact, level: Array, poles: Array, largest: float) -> Lines:
    """The crossings of the lines Re z = ``level``, (b,), by the roots at gains up to ``largest``.

    Args:
        contact: with lanes (b,).
        level: x of each line.
        poles: all poles of L, (b, d).
        largest: K.
    """
    top = _reach(contact, level, poles, largest)
    y = _samples(contact, level, poles, np.minimum(top, _MOST_TURNS * 2 * np.pi))
    changes, sides, smooth, near_axis = [], [], np.ones(len(level), dtype=bool), level + 0j
    for first in range(0, y.shape[1] - 1, _BLOCK - 1):
        block = y[:, first : first + _BLOCK]
        block = np.pad(block, ((0, 0), (0, _BLOCK - block.shape[1])), "edge")
        part, side, fine, start = (np.asarray(a) for a in _on_line(contact, level, block, largest))
        changes.append(part)
        sides.append(side[:, :-1])
        smooth &= fine
        near_axis = near_axis if first else start
    changes = np.concatenate(changes, axis=1)[:, : y.shape[1] - 1]
    owner, cell = np.nonzero(changes)
    brackets = owner, y[owner, cell], y[owner, cell + 1], changes[owner, cell]
    # Without the last sample, which belongs to no cell of its block.
    inner = y[:, :-1]
    pairs = _hidden_pairs(contact, level, inner, np.concatenate(sides, axis=1)[:, : inner.shape[1]], largest)
    owner, low, high, change = (np.concatenate(pair) for pair in zip(brackets, pairs, strict=True))
    crossings, lost = _refine(contact, level, owner, low, high, change, largest)
    crossings = joined(crossings, _on_axis(level, near_axis, largest))
    return Lines(
        level, np.sum(poles.real > level[:, None], axis=1), crossings, smooth & ~lost & (top <= _MOST_TURNS * 2 * np.pi)
    )


def _reach(contact: Contact, level: Array, poles: Array, largest: float) -> Array:
    """A y beyond which |K L(x + jy)| < 1/2."""
    feedback = np.abs(contact.current) + np.abs(contact.delayed) * np.exp(-level)
    highest = np.nanmax(poles.imag, axis=1)
    distance = np.full_like(level, np.pi)
    for _ in range(200):
        bound = bound_response(contact, distance, np.hypot(level, highest + distance)) * feedback * largest
        large = bound > 0.5
        if not np.any(large):
            break
        distance = np.where(large, 1.2 * distance, distance)
    return highest + distance


def bound_response(contact: Contact, distance: Array, modulus: Array) -> Array:
    """A bound of |H| at a distance of at least ``distance`` from all poles and ``modulus`` at most from 0."""
    size = np.shape(contact.numerator)[1]
    top = sum(np.abs(contact.numerator[:, k]) * modulus**k for k in range(size))
    return np.sum(top, axis=0) / distance**size


def _samples(contact: Contact, level: Array, poles: Array, top: Array) -> Array:
    """Increasing y on each line, (b, S), denser where a pole or a zero of p + q e^{−z} is near."""
    with np.errstate(divide="ignore"):
        zero = np.log(-contact.delayed / contact.current + 0j)
    distance = np.abs(zero.real - level)
    # Through a zero on the line itself L changes its sign and no root crosses: a sample on either side, where L is
    # negligible, says all there is to say.
    on = distance < _FIRST
    width = np.maximum(distance, _FIRST)
    far = on | ~np.isfinite(width) | (width > _REACH)
    turns = int(np.max(top) / (2 * np.pi)) + 2
    middle = np.where(far & ~on, 0.0, zero.imag)[:, None] + 2 * np.pi * np.arange(turns + 1)
    steps = np.arange(-_PER_TURN // 2, _PER_TURN // 2) / (_PER_TURN / 2)
    part = np.where(far[:, None], np.pi * steps, _clustered(np.where(far, 1.0, width), np.pi, steps))
    if np.any(on):
        part = np.concatenate([part + np.where(on, -_FIRST, 0.0)[:, None], np.where(on, _FIRST, 0.0)[:, None]], axis=1)
    upper: Array = np.sort_complex(np.where(poles.imag >= 0, poles, np.nan))
    upper = upper[:, : int(np.max(np.sum(poles.imag >= 0, axis=1)))]
    width = np.maximum(np.abs(upper.real - level[:, None]), 1e-9)
    steps = np.linspace(-1, 1, 2 * _BESIDE + 1)
    beside = np.where((width < _REACH)[..., None], upper.imag[..., None] + _clustered(width, _REACH, steps), _FIRST)
    rows = len(level)
    y = np.concatenate([(middle[..., None] + part[:, None]).reshape(rows, -1), beside.reshape(rows, -1)], axis=1)
    y = np.clip(y, _FIRST, top[:, None])
    y.sort(axis=1)
    return y


def _clustered(width: Array, reach: float, steps: Array) -> Array:
    """Offsets up to ``reach`` at ``steps`` in [−1, 1], whose angle seen from ``width`` aside is about even."""
    return width[..., None] * np.sinh(steps * np.arcsinh(reach / width)[..., None])


@jax.jit
def _on_line(contact: Contact, level: Array, y: Array, largest: Array) -> tuple[Array, Array, Array, Array]:
    """2 and −2 where a pair enters or leaves between two samples, (b, S − 1).

    And the side of the negative axis that L is on, (b, S), see ``_side``; whether every phase step is small, (b,);
    and L at the first sample, (b,).
    """
    lanes = jax.tree.map(lambda a: a[..., None], contact)
    # Without the barrier L would be evaluated anew for each of its uses.
    trace = jax.lax.optimization_barrier(loop(lanes, level[:, None] + 1j * y).value * largest)
    below, above = trace[:, :-1], trace[:, 1:]
    size = jnp.maximum(jnp.square(below.real) + jnp.square(below.imag), jnp.square(above.real) + jnp.square(above.imag))
    large = size > 0.8
    forward = below.real * above.real + below.imag * above.imag > 0
    left = (below.real < 0) | (above.real < 0)
    entering = (below.imag < 0) & (above.imag >= 0)
    leaving = (below.imag >= 0) & (above.imag < 0)
    changes = jnp.where(large & left, 2 * (entering.astype(jnp.int8) - leaving.astype(jnp.int8)), 0)
    return changes, _side(trace), jnp.all(forward | ~large, axis=1), trace[:, 0] / largest


def _side(trace: Array) -> Array:
    """How far K L is from the negative axis: sin arg(−K L), extended to ±2 behind; NaN where no root can be near."""
    size = jnp.sqrt(jnp.square(trace.real) + jnp.square(trace.imag))
    sine = -trace.imag / size
    away = cast(Array, jnp.where(trace.real < 0, sine, jnp.sign(sine) * (2 - jnp.abs(sine))))
    return jnp.where(size > 0.5, away, jnp.nan)


def _hidden_pairs(
    contact: Contact, level: Array, y: Array, sides: Array, largest: float
) -> tuple[Array, Array, Array, Array]:
    """Brackets (line, y, y, change) of crossings that come in pairs between two samples.

    They are looked for where the chords beside a cell, which a convex curve does not fall below, meet behind the
    negative axis; the cell is sampled finely, twice.
    """
    # One row of samples per line at first, then per cell.
    owner, place, side = np.arange(len(y)), y, sides
    found = []
    for _ in range(_ROUNDS):
        lane = np.repeat(np.arange(len(owner)), place.shape[1])
        cells, _ = hidden_crossings(lane, place.ravel(), side.ravel())
        if not cells.size:
            break
        line, column = owner[lane[cells]], cells % place.shape[1]
        row = lane[cells]
        low, high = place[row, column], place[row, column + 1]
        # With a sample beyond either end, so that the first and the last part have chords beside them.
        within = low[:, None] + (high - low)[:, None] * (np.arange(-1, _PARTS + 2) / _PARTS)
        many = np.repeat(line, _PARTS + 3)
        (inside,) = in_lanes(
            _side_at, contact, many, (level[many], within.ravel(), np.full(len(many), largest)), _BATCH
        )
        owner, place, side = line, within, inside.reshape(within.shape)
        with np.errstate(invalid="ignore"):
            crossed = (side[:, 1:] * side[:, :-1] < 0) & (np.abs(side[:, 1:] - side[:, :-1]) < 1)
        index, part = np.nonzero(crossed[:, 1:-1])
        part += 1
        # Seen with growing y, a root enters where L comes from below: there arg(−L) falls.
        change = np.where(side[index, part] > 0, 2, -2)
        found.append((owner[index], place[index, part], place[index, part + 1], change))
    nothing = np.zeros(0, dtype=int), np.zeros(0), np.zeros(0), np.zeros(0, dtype=int)
    return tuple(map(np.concatenate, zip(nothing, *found, strict=True)))  # pyright: ignore[reportReturnType]


@jax.jit
def _side_at(contact: Contact, x: Array, y: Array, largest: Array) -> tuple[Array]:
    return (_side(loop(contact, x + 1j * y).value * largest),)


def _refine(
    contact: Contact,
    level: Array,
    owner: Array,
    low: Array,
    high: Array,
    change: Array,
    largest: float,
) -> tuple[Crossings, Array]:
    """The crossings between the given y of their lines, and the lines that have lost one."""
    brackets = level[owner], low, high, change < 0
    gain, root, rate, done = in_lanes(_phase_root, contact, owner, brackets, _BATCH)
    lost = np.zeros(len(level), dtype=bool)
    lost[owner[~(done & ((rate.real > 0) == (change > 0)))]] = True
    kept = done & (gain <= largest)
    return Crossings(*(a[kept] for a in (owner, gain, root, rate, change))), lost


@jax.jit
def _phase_root(contact: Contact, x: Array, low: Array, high: Array, rising: Array) -> tuple[Array, ...]:
    """The zero of arg(−L) between two samples, by Newton's method, bisecting where it leaves the bracket.

    Returns K, z, dz/d(log K), and whether it was found.
    """

    def improve(_: int, state: tuple[Array, ...]) -> tuple[Array, ...]:
        low, high, _, y, _, _ = state
        at = loop(contact, x + 1j * y)
        phase, slope = jnp.angle(-at.value), (at.slope / at.value).real
        beyond = (phase > 0) == rising
        low, high = jnp.where(beyond, low, y), jnp.where(beyond, y, high)
        newton = y - phase / slope
        following = jnp.where((newton >= low) & (newton <= high), newton, (low + high) / 2)
        return low, high, y, following, at.value, at.slope

    middle = (low + high) / 2
    zero = jnp.zeros_like(middle) + 0j
    _, _, y, _, value, slope = jax.lax.fori_loop(0, _STEPS, improve, (low, high, middle, middle, zero, zero))
    found = jnp.abs(jnp.angle(-value)) < 1e-6
    return 1 / jnp.abs(value), x + 1j * y, -value / slope, found


def _on_axis(level: Array, near_axis: Array, largest: float) -> Crossings:
    """The crossings at y = 0, from L at the first sample: its real part is L(x) and its imaginary part y L′(x)."""
    owner = np.nonzero(-near_axis.real * largest > 1)[0]
    value, slope = near_axis.real[owner], near_axis.imag[owner] / _FIRST
    rate = -value / slope
    return Crossings(owner, -1 / value, level[owner] + 0j, rate + 0j, np.where(rate > 0, 1, -1))


def joined(*parts: Crossings) -> Crossings:
    """All crossings in one."""
    return Crossings(*map(np.concatenate, zip(*parts, strict=True)))


def take(contact: Contact, index: Array) -> Contact:
    """The contacts of the lanes of the given numbers."""
    return jax.tree.map(lambda a: a[..., index], contact)


def in_lanes(function: Any, contact: Contact, owner: Array, arrays: tuple[Array, ...], size: int) -> Any:
    """``function(contact of the owner, *arrays)`` over lanes, ``size`` at a time so that it is compiled once."""
    parts = []
    for start in range(0, max(len(owner), 1), size):
        part = slice(start, start + size)
        count = len(owner[part])
        if count == 0:
            index = np.zeros(size, dtype=int)
            padded = tuple(np.zeros(size, dtype=a.dtype) for a in arrays)
        else:
            index = np.resize(owner[part], size)
            padded = tuple(np.resize(a[part], size) for a in arrays)
        results = function(take(contact, index), *padded)
        parts.append(jax.tree.map(lambda a, count=count: np.asarray(a)[..., :count], results))
    return jax.tree.map(lambda *part: np.concatenate(part, axis=-1), *parts)
