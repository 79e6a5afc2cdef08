"""Every gain at which a root stands on the imaginary axis: the count of unstable roots, at all gains at once."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from lobex.characteristic.chunks import in_chunks
from lobex.characteristic.count import Crossings, cross, in_lanes, joined, take
from lobex.characteristic.function import Contact, loop
from lobex.characteristic.method import contacts
from lobex.characteristic.roots import find_poles
from lobex.processes.process import Process

Array = Any

_LAST_STEPS = 3
_BATCH = 256
_BESIDE_AXIS = 1e-9


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

    Nothing is scanned along the gain: what is sampled is the phase of L along the axis, see ``count``. Call it in the
    scope of float64, for processes that ``suits``.
    """
    sound, made, blocks, delay = contacts(process, speeds, max(abs(lowest), abs(highest)))
    number = np.flatnonzero(sound)
    parts, polished = [], []
    place: Array = np.linalg.eigvals(blocks).reshape(len(number), -1)
    # On which side of the axis a pole on it goes is not to be seen from its place.
    trusted = np.all(np.abs(place.real) > _BESIDE_AXIS * (1 + np.abs(place)), axis=1)
    for sign, most in ((1, highest), (-1, -lowest)):
        if most <= 0:
            continue
        one = Contact(made.numerator, made.denominator, sign * made.current, sign * made.delayed)
        poles = find_poles(one, blocks)
        moving: Array = np.where(poles.still, np.nan, poles.place)
        found, closed = _cross(one, moving, most)
        trusted &= closed | np.all(poles.still, axis=1)
        parts.append(found._replace(gain=sign * found.gain))
        polished.append(in_lanes(_polish, one, found.owner, (found.root.imag,), _BATCH))
    crossings = joined(*parts)
    omega, modulus, moved = (np.concatenate(part) for part in zip(*polished, strict=True))
    gain: np.ndarray = np.sign(crossings.gain) * modulus
    # In the direction of increasing gain, roots that came in on the negative side go out again.
    change = crossings.change * np.sign(gain).astype(int)
    unstable = np.sum(place.real > 0, axis=1)
    before = (gain <= lowest) if lowest >= 0 else (gain > lowest) & (gain < 0)
    np.add.at(unstable, crossings.owner[before], crossings.change[before])
    inside = (gain > lowest) & (gain < highest)
    order = np.flatnonzero(inside)
    order = order[np.lexsort((gain[order], crossings.owner[order]))]
    everywhere, closed = np.zeros(len(speeds), dtype=int), np.zeros(len(speeds), dtype=bool)
    everywhere[number], closed[number] = unstable, trusted
    owner = crossings.owner[order]
    return AxisCrossings(
        unstable=everywhere,
        trusted=closed,
        owner=number[owner],
        gain=gain[order],
        frequency=np.abs(omega[order]) / (2 * np.pi * delay[owner]),
        rate=crossings.rate.real[order],
        change=change[order],
        error=moved[order] + 8 * np.finfo(float).eps * np.abs(gain[order]) * (1 + np.abs(omega[order])),
    )


def _cross(contact: Contact, poles: np.ndarray, most: float) -> tuple[Crossings, np.ndarray]:
    """The crossings at gains up to ``most``, and whether each lane's count closes, (b,)."""

    def look(index: np.ndarray, count: int) -> tuple[Crossings, np.ndarray]:
        lines = cross(take(contact, index), np.zeros(len(index)), poles[index], most)
        mine = lines.crossings.owner < count
        crossings = Crossings(*(a[mine] for a in lines.crossings))
        return crossings._replace(owner=index[crossings.owner]), lines.trusted[:count]

    chunks = in_chunks(look, np.arange(len(poles)))
    found, trusted = zip(*chunks, strict=True)
    return joined(*found), np.concatenate(trusted)


@jax.jit
def _polish(contact: Contact, y: Array) -> tuple[Array, Array, Array]:
    """Where L(jy) is real and negative: y, K = −1/L there, and how far Newton's last step moved K."""

    def improve(state: tuple[Array, Array, Array], _: None) -> tuple[tuple[Array, Array, Array], None]:
        y, gain, _ = state
        at = loop(contact, 1j * y)
        following = jnp.where(y == 0, y, y - jnp.angle(-at.value) / (at.slope / at.value).real)
        new = -1 / loop(contact, 1j * following).value.real
        return (following, new, jnp.abs(new - gain)), None

    return jax.lax.scan(improve, (y, y, y), None, length=_LAST_STEPS)[0]
