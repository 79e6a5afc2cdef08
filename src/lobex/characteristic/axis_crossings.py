"""Every gain at which a root stands on the imaginary axis: the count of unstable roots, at all gains at once."""

from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Complex, Float, Int

from lobex._batches import in_chunks, in_one_size
from lobex._compiled import compiled
from lobex.characteristic.function import Contact, loop
from lobex.characteristic.lanes import placed, take
from lobex.characteristic.method import contacts
from lobex.characteristic.nyquist import AxisPlaces, axis_places
from lobex.characteristic.open_loop import Open, weighted
from lobex.processes.process import Process

_LAST_STEPS = 3
_BESIDE_AXIS = 1e-9
_SPEEDS = 256


class AxisCrossings(NamedTuple):
    """The crossings of the imaginary axis between two gains, by speed and then by gain.

    Attributes:
        unstable: roots to the right of the axis at the lowest gain, (n,).
        trusted: whether the count closes at a speed, (n,); what the crossings say of the others is nothing.
        owner: number of the speed of each crossing, (e,).
        gain: K, (e,).
        frequency: |ω|/2π, Hz, (e,).
        rate: d Re(sτ)/d(log|K|), (e,).
        change: of the number of roots to the right as the gain increases, (e,).
        error: of the gain, from Newton's last step and rounding, (e,).
    """

    unstable: np.ndarray
    trusted: np.ndarray
    owner: np.ndarray
    gain: np.ndarray
    frequency: np.ndarray
    rate: np.ndarray
    change: np.ndarray
    error: np.ndarray


def axis_crossings(process: Process, speeds: np.ndarray, lowest: float, highest: float) -> AxisCrossings:
    """The crossings with lowest < K < highest, by D-subdivision (Neimark, 1949), at speeds (n,), Hz, in any order.

    Call it in the scope of float64, for processes that ``CharacteristicRoots`` serves.
    """
    sound, structure, contact = contacts(process, speeds, max(abs(lowest), abs(highest)))
    number = np.flatnonzero(sound)
    if not len(number):
        nothing, none = np.zeros(len(speeds), dtype=int), np.zeros(0)
        return AxisCrossings(nothing, nothing > 0, none.astype(int), none, none, none, none, none)
    place: Any = np.linalg.eigvals(structure.drift) * structure.delay[:, None]
    # On which side of the axis a pole on it goes is not to be seen from its place.
    trusted = np.all(np.abs(place.real) > _BESIDE_AXIS * (1 + np.abs(place)), axis=1)
    parts, opened = [], structure.opened
    for sign, most in ((1, highest), (-1, -lowest)):
        if most > 0:
            found, closed = _one_sign(
                replace(contact, present=sign * contact.present, delayed=sign * contact.delayed),
                opened._replace(present=sign * opened.present, delayed=sign * opened.delayed),
                most,
            )
            trusted &= closed
            parts.append((found.lane, found.height, sign * found.gain, found.rate, found.moved))
    owner, omega, gain, moved = (np.concatenate([part[i] for part in parts]) for i in (0, 1, 2, 4))
    rate: Any = np.concatenate([part[3] for part in parts])
    # A pair, or one on the real axis; with falling |K| roots that came in on the negative side go out again.
    change = np.sign(rate.real * gain).astype(int) * np.where(omega == 0, 1, 2)
    unstable = np.sum(place.real > 0, axis=1)
    before = (gain <= lowest) if lowest >= 0 else (gain > lowest) & (gain < 0)
    np.add.at(unstable, owner[before], np.where(gain > 0, change, -change)[before])
    inside = (gain > lowest) & (gain < highest)
    order = np.flatnonzero(inside)
    order = order[np.lexsort((gain[order], owner[order]))]
    everywhere, closed = np.zeros(len(speeds), dtype=int), np.zeros(len(speeds), dtype=bool)
    everywhere[number], closed[number] = unstable, trusted
    owner = owner[order]
    return AxisCrossings(
        unstable=everywhere,
        trusted=closed,
        owner=number[owner],
        gain=gain[order],
        frequency=np.abs(omega[order]) / (2 * np.pi * structure.delay[owner]),
        rate=rate.real[order],
        change=change[order],
        # Rounding of y, and of the terms of a denominator at a resonance, which the slope of log L makes of it.
        error=moved[order]
        + 8 * np.finfo(float).eps * np.abs(gain[order]) * (1 + np.abs(omega[order]) * (1 + 1 / np.abs(rate[order]))),
    )


def _one_sign(contact: Contact, opened: Open, most: float) -> tuple[AxisPlaces, np.ndarray]:
    """The crossings at gains in (0, most], and whether those of a lane are all known, (b,)."""

    def look(index: np.ndarray) -> tuple[AxisPlaces, np.ndarray]:
        found, decided = axis_places(take(opened, index), most)
        return found._replace(lane=index[found.lane]), decided

    found, decided = zip(*in_chunks(look, np.shape(opened.present)[1], _SPEEDS), strict=True)
    found = AxisPlaces(*map(np.concatenate, zip(*found, strict=True)))
    height, gain, moved, rate = in_one_size(partial(_polish, placed(contact.filled())), (found.lane, found.height))
    still = _at_zero(opened, most)
    polished = AxisPlaces(found.lane, height, gain, rate, moved)
    return AxisPlaces(*map(np.concatenate, zip(polished, still, strict=True))), np.concatenate(decided)


def _at_zero(opened: Open, most: float) -> AxisPlaces:
    """The crossings at 0, where L = −Σ (p + q) H(0) < 0, with the rate from its derivative along the real axis."""
    first, constant, upper, lower = opened.loops
    both, either = (1 / (upper * lower))[:, None], (1 / upper + 1 / lower)[:, None]
    terms = constant * both
    response, steepness = np.sum(terms, axis=0).real, np.sum(first * both + terms * either, axis=0).real
    feedback = opened.present + opened.delayed
    value, slope = -weighted(feedback, response), weighted(opened.fading, response) - weighted(feedback, steepness)
    lane = np.flatnonzero(-value * most > 1)
    zero = np.zeros(len(lane))
    return AxisPlaces(lane, zero, -1 / value[lane], -value[lane] / slope[lane] + 0j, zero)


@compiled
def _polish(
    contacts: Contact, lane: Int[Any, " l"], y: Float[Any, " l"]
) -> tuple[Float[Any, " l"], Float[Any, " l"], Float[Any, " l"], Complex[Any, " l"]]:
    """Where L(jy) is real and negative: y, K = −1/L there, how far Newton's last step moved K, and dz/d(log K)."""
    contact = take(contacts, lane)

    def improve(
        state: tuple[Float[Any, " l"], Float[Any, " l"], Float[Any, " l"]], _: None
    ) -> tuple[tuple[Float[Any, " l"], Float[Any, " l"], Float[Any, " l"]], None]:
        y, gain, _ = state
        at = loop(contact, 1j * y)
        following = y - jnp.angle(-at.value) / (at.slope / at.value).real
        new = -1 / loop(contact, 1j * following).value.real
        return (following, new, jnp.abs(new - gain)), None

    y, gain, moved = jax.lax.scan(improve, (y, y, y), None, length=_LAST_STEPS)[0]
    at = loop(contact, 1j * y)
    return y, gain, moved, -at.value / at.slope
