"""Where the foremost roots are likely to be: beside the peaks of |M|, whose heights are those of its poles."""

from typing import Any

import numpy as np
from jaxtyping import Complex, Float, Int

from lobex.characteristic.closed_loop import Loops
from lobex.characteristic.line import response_of_loops

_ROUNDS = 6
_NEAREST = 1e-3
_HARDLY = 0.5
# Of many modes those looked at: what is likely need not be complete.
_MODES = 24


def highest(loops: Loops) -> Int[Any, "k l"]:
    """Numbers of the modes that peak highest by themselves, (modes or fewer, lanes)."""
    z = loops.rightmost + 0.1 + 1j * loops.upper.imag
    with np.errstate(all="ignore"):
        own = np.abs((loops.first * z + loops.constant) / ((z - loops.upper) * (z - loops.lower)))
    return np.argsort(-own, axis=0)[:_MODES]


def foremost(loops: Any) -> Int[Any, "k l"]:
    """Numbers of the modes whose poles have the largest real parts, (modes or fewer, lanes)."""
    return np.argsort(-np.maximum(loops.upper.real, loops.lower.real), axis=0)[:_MODES]


def peaks(loops: Loops, modes: Int[Any, "k l"]) -> Float[Any, "k l"]:
    """At the height y of each mode's pole, (k, lanes), a real part x near log |M(x + jy)|: there |w| is near 1."""
    height = np.take_along_axis(loops.upper.imag, modes, axis=0)
    level = loops.rightmost + np.full(np.shape(modes), 0.1)
    for _ in range(_ROUNDS):
        with np.errstate(divide="ignore"):
            size = np.stack([np.log(np.abs(response_of_loops(loops, z))) for z in level + 1j * height])
        level = np.maximum((level + size) / 2, loops.rightmost + _NEAREST)
    return level


def moved_poles(loops: Loops, modes: Int[Any, "k l"]) -> tuple[Complex[Any, "_ l"], Complex[Any, "_ l"]]:
    """The poles of modes (k, lanes), first those named upper, and how far off the roots of w = 1 beside them are,
    (2k, lanes).
    """
    poles, moves = [], []
    first, constant, upper, lower = (np.take_along_axis(part, modes, axis=0) for part in loops)
    for pole, partner in ((upper, lower), (lower, upper)):
        for k, mode in enumerate(modes):
            with np.errstate(all="ignore"):
                # M = r/(z − π) + rest.
                at_pole, at_partner = (
                    (first[k] * z + constant[k]) / (z - o) for z, o in ((pole[k], partner[k]), (partner[k], pole[k]))
                )
                terms = (loops.first * pole[k] + loops.constant) / ((pole[k] - loops.upper) * (pole[k] - loops.lower))
                np.put_along_axis(terms, mode[None], 0.0, axis=0)
                rest = np.sum(terms, axis=0) + at_partner / (pole[k] - partner[k])
                moves.append(at_pole / (np.exp(pole[k]) - rest))
        poles.append(pole)
    return np.concatenate(poles), np.stack(moves)


def likely_roots(loops: Loops) -> Complex[Any, "l _"]:
    """Starts for Newton's method, (lanes, 3k), NaN-filled.

    Beside a pole that has hardly moved, or on either side of a peak, where the phase of w is near 0.
    """
    modes = highest(loops)
    level = peaks(loops, modes)
    starts = []
    for x, pole, move in zip(level, *(a[: len(level)] for a in moved_poles(loops, modes)), strict=True):
        with np.errstate(all="ignore"):
            still = np.abs(move) < _HARDLY
            phase = np.angle(response_of_loops(loops, x + 1j * pole.imag)) - pole.imag
            phase = phase - 2 * np.pi * np.round(phase / (2 * np.pi))
            # M turns as beside a pole alone, and e^{−z} turns by the height.
            turning = 1 + 1 / (x - pole.real)
            beside = [
                x + 1j * np.abs(pole.imag + turned / turning)
                for turned in (phase, phase - 2 * np.pi * np.where(phase > 0, 1, -1))
            ]
        starts += [np.where(still, pole + move, np.nan), *(np.where(still, np.nan, start) for start in beside)]
    return np.stack(starts, axis=1)
