"""Which poles stay where they are while the order grows."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Complex, Float, Int

# From one order to the next, of frequency and of damping.
_FREQUENCY, _DAMPING = 0.01, 0.15
# Orders in a row that a pole takes to count, and the largest damping ratio of one that does.
_LEAST, _DAMPED = 4, 0.5


class Stabilisation(NamedTuple):
    """All poles of all orders.

    Attributes:
        order: of which each pole is, (p,).
        pole: λ, (p,), rad/s.
        stable: whether the order below has one at nearly the same place, (p,).
        candidate: poles that stay for several orders, (c,), those that stay longest first.
        orders: how many orders each stays, (c,).
    """

    order: Int[np.ndarray, " p"]
    pole: Complex[np.ndarray, " p"]
    stable: Bool[np.ndarray, " p"]
    candidate: Complex[np.ndarray, " c"]
    orders: Int[np.ndarray, " c"]

    @property
    def frequency(self) -> Float[np.ndarray, " p"]:
        """|λ|/2π, Hz."""
        return np.abs(self.pole) / (2 * np.pi)

    @property
    def damping_ratio(self) -> Float[np.ndarray, " p"]:
        """−Re λ/|λ|."""
        return -np.real(self.pole) / np.abs(self.pole)


def stabilised(poles: list[Complex[np.ndarray, "..."]]) -> Stabilisation:
    """Follow poles from order to order, each to the nearest of the next; tracks that break are joined."""
    ended: list[list[tuple[int, complex]]] = []
    tracks: list[list[tuple[int, complex]]] = []
    flags = []
    for order, found in enumerate(poles, start=1):
        last = np.array([track[-1][1] for track in tracks], complex)
        free, joined = set(range(len(found))), {}
        apart = _apart(last[:, None], found[None, :]) if len(last) and len(found) else np.zeros((0, 0))
        for i, j in sorted(np.ndindex(apart.shape), key=lambda place: apart[place]):
            if apart[i, j] < 1 and i not in joined and j in free:
                joined[i] = j
                free.remove(j)
        flags.append(np.isin(np.arange(len(found)), list(joined.values())))
        ended += [track for i, track in enumerate(tracks) if i not in joined]
        tracks = [[*tracks[i], (order, found[j])] for i, j in joined.items()] + [[(order, found[j])] for j in free]
    long = sorted((track for track in [*ended, *tracks] if len(track) >= _LEAST), key=len, reverse=True)
    whole: list[list[tuple[int, complex]]] = []
    for track in long:
        for other in whole:
            here = {order for order, _ in other}
            alike = _apart(np.array([_middle(track)]), np.array([_middle(other)]))[0] < 1
            if alike and here.isdisjoint(order for order, _ in track):
                other += track
                break
        else:
            whole.append(list(track))
    whole.sort(key=len, reverse=True)
    candidate = np.array([_middle(track) for track in whole], complex)
    kept = -np.real(candidate) / np.maximum(np.abs(candidate), 1e-300) < _DAMPED
    return Stabilisation(
        np.repeat(np.arange(1, len(poles) + 1), [len(found) for found in poles]),
        np.concatenate(poles) if poles else np.zeros(0, complex),
        np.concatenate(flags) if flags else np.zeros(0, bool),
        candidate[kept],
        np.array([len(track) for track in whole], int)[kept],
    )


def _middle(track: list[tuple[int, complex]]) -> complex:
    """The median of the higher orders of a track, of whose damping less is noise."""
    upper = np.array([pole for _, pole in sorted(track)[len(track) // 2 :]])
    return complex(np.median(np.real(upper)), np.median(np.imag(upper)))


def _apart(one: Complex[np.ndarray, "*a"], other: Complex[np.ndarray, "*b"]) -> Float[np.ndarray, "*c"]:
    """How far two poles are apart, in what is allowed from order to order."""
    size, ratio = np.abs(one), -np.real(one) / np.abs(one)
    further, other_ratio = np.abs(other), -np.real(other) / np.abs(other)
    apart = np.abs(further - size) / size / np.minimum(_FREQUENCY, np.maximum(ratio, 1e-3))
    return np.hypot(apart, np.abs(other_ratio / np.maximum(ratio, 1e-6) - 1) / _DAMPING)
