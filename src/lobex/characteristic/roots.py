"""Where the roots begin, and their paths along the gain.

A root that is ever to the right of a line begins there at a gain of zero, as a pole of L, or it enters through the
line, or it comes of a double root on the real axis, where two real roots meet and become a pair or the reverse.
From each beginning a path is followed in steps of log K: a cubic through the last two points predicts, and Newton's
method corrects.
"""

from functools import partial
from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np

from lobex.characteristic.count import Crossings, bound_response, in_lanes
from lobex.characteristic.function import Contact, loop, newton_step

Array = Any

# How far, in z, the first step from a pole may go, as a part of the distance to the next.
_FIRST_STEP = 0.05
# A path this far to the left of its line is given up: should it come back, it enters anew.
_LEFT_BEHIND = 1.0
_NEWTON_STEPS = 3
_CONVERGED = 1e-2
_REAL_SAMPLES = 128
# Steps from a double root that are predicted from it.
_NEAR_DOUBLE = 4.0
_HALVINGS = 50
# Step off the real axis to take L″ by.
_ASIDE = 1e-4
_BATCH = 128


class Poles(NamedTuple):
    """The poles per speed, the eigenvalues of τA, each (b, d).

    Attributes:
        place: z.
        rate: dz/dK of the root that begins there.
        safe: the gain up to which it goes straight.
        still: whether the contact neither moves nor sees it, so that it is a root at every gain.
    """

    place: Array
    rate: Array
    safe: Array
    still: Array


class Starts(NamedTuple):
    """Beginnings of paths, each of shape (e,).

    The path goes as root + rate·log(K/gain), from a double root as root + rate·√(1 − gain/K).

    Attributes:
        owner: number of the speed.
        gain: K.
        root: z.
        rate: see above.
        double: whether it begins at a double root.
        pole: z at a gain of zero, NaN where the path begins elsewhere.
    """

    owner: Array
    gain: Array
    root: Array
    rate: Array
    double: Array
    pole: Array


def find_poles(contact: Contact, blocks: Array) -> Poles:
    """The poles of L for contacts of lanes (b,) and matrices τA of shape (b, n, s, s)."""
    rows, n, s = blocks.shape[:3]
    place = np.linalg.eigvals(blocks).reshape(rows, n * s) + 0j
    near = 1e-12 * np.abs(place)
    top, slope = np.zeros_like(place), np.zeros_like(place)
    index = np.repeat(np.arange(n), s)
    for k in range(s):
        top += contact.numerator[index, k].T * place**k
        low = contact.denominator[index, k].T if k else 0.0
        slope += k * low * place ** max(k - 1, 0)
    slope += s * place ** (s - 1)
    with np.errstate(all="ignore"):
        residue = top / slope
        strength = np.abs(contact.current)[:, None] + np.abs(contact.delayed[:, None] * np.exp(-place))
        feedback = contact.current[:, None] + contact.delayed[:, None] * np.exp(-place)
    # A pole that several blocks share is one pole of L, with the sum of their residues, and still otherwise.
    same = np.abs(place[:, :, None] - place[:, None, :]) <= near[:, :, None]
    first = np.argmax(same, axis=2) == np.arange(n * s)
    residue = np.sum(np.where(same, residue[:, None, :], 0), axis=2)
    gap = np.min(np.where(same, np.inf, np.abs(place[:, :, None] - place[:, None, :])), axis=2)
    still = ~first | (residue == 0)
    with np.errstate(divide="ignore"):
        safe = _FIRST_STEP * np.minimum(gap, 1.0) / (np.abs(residue) * strength)
    return Poles(place, feedback * residue, safe, still)


def beginning(poles: Poles, level: Array) -> Array:
    """Whether a path begins at each pole, (b, d): it moves, and is on the right of the line."""
    return (poles.place.real > level[:, None]) & ~poles.still


def pole_starts(poles: Poles, level: Array, first: Array) -> Starts:
    """Beginnings at the gains ``first``, (b,), of the poles on the right of the lines."""
    owner, index = np.nonzero(beginning(poles, level) & (poles.place.imag >= 0))
    place, step = poles.place[owner, index], poles.rate[owner, index] * first[owner]
    return Starts(owner, first[owner], place + step, step, np.zeros(len(owner), dtype=bool), place)


def crossing_starts(crossings: Crossings) -> Starts:
    """Beginnings where roots enter through a line."""
    inward = crossings.change > 0
    owner, gain, root, rate = (a[inward] for a in (crossings.owner, crossings.gain, crossings.root, crossings.rate))
    return Starts(owner, gain, root, rate, np.zeros(len(owner), dtype=bool), np.full(len(owner), np.nan + 0j))


def double_starts(contact: Contact, level: Array, poles: Poles, largest: float) -> Starts:
    """Beginnings at the double roots on the real axis, to the right of the lines."""
    right = np.max(poles.place.real, axis=1)
    distance = np.full_like(level, 0.5)
    strength = np.abs(contact.current) + np.abs(contact.delayed) * np.exp(-np.minimum(level, right))
    highest = np.max(np.abs(poles.place), axis=1)
    for _ in range(200):
        large = bound_response(contact, distance, highest + distance) * strength * largest > 0.9
        if not np.any(large):
            break
        distance = np.where(large, 1.2 * distance, distance)
    x = level[:, None] + (right + distance - level)[:, None] * np.linspace(0, 1, _REAL_SAMPLES)
    value, slope = (np.asarray(a) for a in _on_axis(contact, x))
    turning = (slope[:, :-1] * slope[:, 1:] < 0) & (value[:, :-1] < 0) & (value[:, 1:] < 0)
    owner, cell = np.nonzero(turning)
    if len(owner) == 0:
        nothing = np.zeros(0)
        return Starts(owner, nothing, nothing, nothing, np.zeros(0, dtype=bool), nothing)
    ends = x[owner, cell], x[owner, cell + 1], slope[owner, cell] < 0
    place, bottom, bend = in_lanes(_turn, contact, owner, ends, _BATCH)
    gain = -1 / bottom
    rate = np.sqrt(2 / (gain * bend) + 0j)
    kept = np.isfinite(rate) & (gain < largest) & (gain > 0)
    owner, gain, place, rate = owner[kept], gain[kept], place[kept], rate[kept]
    # Two real roots leave each other in both directions; a pair is followed by its upper member.
    twice = rate.imag == 0
    owner, gain, place = (np.concatenate([a, a[twice]]) for a in (owner, gain, place))
    rate = np.concatenate([rate, -rate[twice]])
    return Starts(owner, gain, place + 0j, rate, np.ones(len(owner), dtype=bool), np.full(len(owner), np.nan + 0j))


@jax.jit
def _on_axis(contact: Contact, x: Array) -> tuple[Array, Array]:
    at = loop(jax.tree.map(lambda a: a[..., None], contact), x + 0j)
    return at.value.real, at.slope.real


@jax.jit
def _turn(contact: Contact, low: Array, high: Array, rising: Array) -> tuple[Array, Array, Array]:
    """Where L′ is zero on the real axis between two samples, with L and L″ there."""

    def halve(_: int, ends: tuple[Array, Array]) -> tuple[Array, Array]:
        low, high = ends
        middle = (low + high) / 2
        beyond = (loop(contact, middle + 0j).slope.real > 0) == rising
        return jnp.where(beyond, low, middle), jnp.where(beyond, middle, high)

    x = sum(jax.lax.fori_loop(0, _HALVINGS, halve, (low, high))) / 2
    aside = loop(contact, x + 1j * _ASIDE)
    bend = aside.slope.imag / _ASIDE
    return x, aside.value.real + bend * _ASIDE**2 / 2, bend


def follow(
    contact: Contact, level: Array, starts: Starts, first: Array, step: Array, nodes: int, parts: int
) -> tuple[Array, Array]:
    """Paths at the gains first·exp(j·step), j < nodes: z and dz/d(log K)·step, each (nodes, e), NaN off the path.

    Between two nodes ``parts`` steps are taken.
    """
    owner = starts.owner
    fine = step[owner] / parts
    begin = np.log(starts.gain / first[owner]) / fine
    arrays = (level[owner], first[owner], fine, begin, starts.root, starts.rate, starts.double)
    paths, slopes = in_lanes(partial(_follow, np.arange(nodes), parts), contact, owner, arrays, _BATCH)
    return paths, slopes * parts


@jax.jit
def _follow(
    nodes: Array,
    parts: Array,
    contact: Contact,
    level: Array,
    first: Array,
    step: Array,
    begin: Array,
    root: Array,
    rate: Array,
    double: Array,
) -> tuple[Array, Array]:
    def advance(count: Array, state: tuple[Array, ...]) -> tuple[Array, ...]:
        z, slope, before, slope_before, age = state
        along = count - begin
        since = jnp.maximum(along, 0.0) * step
        initial: Array = root + rate * jnp.where(double, jnp.sqrt(-jnp.expm1(-since)), since)
        # Hermite's cubic through the last two points, extended by a step.
        cubic = 5 * before - 4 * z + 4 * slope + 2 * slope_before
        # Close to a double root no polynomial predicts the path.
        anew = (age < 1) | (double & (along < _NEAR_DOUBLE))
        later = cast(Any, jnp.where(age < 2, z + slope, cubic))
        guess = jnp.where(anew, initial, later)
        gain = first * jnp.exp(count * step)

        def correct(_: int, state: tuple[Array, ...]) -> tuple[Array, ...]:
            at = loop(contact, state[0])
            change = newton_step(at, gain)
            return state[0] + change, change, -at.value / at.slope * step

        guess, change, tangent = jax.lax.fori_loop(0, _NEWTON_STEPS, correct, (guess, guess, guess))
        flip = guess.imag < 0
        place, going = (cast(Any, jnp.where(flip, a.conj(), a)) for a in (guess, tangent))
        good = (jnp.abs(change) < _CONVERGED) & (place.real > level - _LEFT_BEHIND) & (age >= 0)
        # Before its beginning a path has age 0, from its end on −1.
        age = cast(Any, jnp.where(along < 0, 0, cast(Any, jnp.where(good, age + 1, -1))))
        return jnp.where(age > 0, place, root), jnp.where(age > 0, going, 0), z, slope, age

    def to_node(state: tuple[Array, ...], node: Array) -> tuple[tuple[Array, ...], tuple[Array, Array]]:
        state = jax.lax.fori_loop(jnp.where(node > 0, (node - 1) * parts + 1, 0), node * parts + 1, advance, state)
        shown = state[4] > 0
        return state, (jnp.where(shown, state[0], jnp.nan), jnp.where(shown, state[1], jnp.nan))

    zero = jnp.zeros_like(root)
    state = (root, zero, root, zero, jnp.zeros(jnp.shape(begin), dtype=int))
    return jax.lax.scan(to_node, state, nodes)[1]
