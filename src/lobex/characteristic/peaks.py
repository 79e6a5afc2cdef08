"""Where the foremost roots are likely to be: beside the peaks of |M|, whose heights are those of its poles."""

from typing import Any

import numpy as np

from lobex.characteristic.closed_loop import Loops
from lobex.characteristic.line import response

Array = Any

_ROUNDS = 6
_NEAREST = 1e-3
_HARDLY = 0.5


def peaks(loops: Loops) -> Array:
    """At the height of each pole, (modes, lanes), a real part x near log |M(x + jy)|: there |w| is near 1."""
    level = loops.rightmost + np.full(np.shape(loops.upper), 0.1)
    for _ in range(_ROUNDS):
        with np.errstate(divide="ignore"):
            size = np.stack([np.log(np.abs(response(loops, z))) for z in level + 1j * loops.upper.imag])
        level = np.maximum((level + size) / 2, loops.rightmost + _NEAREST)
    return level


def moved_poles(loops: Loops) -> tuple[Array, Array]:
    """The poles, first those named upper, and how far off the roots of w = 1 beside them are, (2 × modes, lanes)."""
    poles, moves = np.concatenate([loops.upper, loops.lower]), []
    for mode, (pole, partner) in enumerate(zip(poles, np.concatenate([loops.lower, loops.upper]), strict=True)):
        mode = mode % len(loops.upper)
        with np.errstate(all="ignore"):
            # M = r/(z − π) + rest.
            at_pole, at_partner = (
                (loops.first[mode] * z + loops.constant[mode]) / (z - o) for z, o in ((pole, partner), (partner, pole))
            )
            terms = (loops.first * pole + loops.constant) / ((pole - loops.upper) * (pole - loops.lower))
            rest = np.sum(np.delete(terms, mode, axis=0), axis=0) + at_partner / (pole - partner)
            moves.append(at_pole / (np.exp(pole) - rest))
    return poles, np.stack(moves)


def likely_roots(loops: Loops) -> Array:
    """Starts for Newton's method, (lanes, 3 × modes), NaN-filled.

    Beside a pole that has hardly moved, or on either side of a peak, where the phase of w is near 0.
    """
    level = peaks(loops)
    starts = []
    for x, pole, move in zip(level, *(a[: len(level)] for a in moved_poles(loops)), strict=True):
        with np.errstate(all="ignore"):
            still = np.abs(move) < _HARDLY
            phase = np.angle(response(loops, x + 1j * pole.imag)) - pole.imag
            phase = phase - 2 * np.pi * np.round(phase / (2 * np.pi))
            # M turns as beside a pole alone, and e^{−z} turns by the height.
            turning = 1 + 1 / (x - pole.real)
            beside = [
                x + 1j * np.abs(pole.imag + turned / turning)
                for turned in (phase, phase - 2 * np.pi * np.where(phase > 0, 1, -1))
            ]
        starts += [np.where(still, pole + move, np.nan), *(np.where(still, np.nan, start) for start in beside)]
    return np.stack(starts, axis=1)
