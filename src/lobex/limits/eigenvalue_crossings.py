"""The lowest gain at which an eigenvalue of a response, along a frequency, is that of a limit."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Complex, Float

from lobex.limits.phase import half_turns
from lobex.limits.sections import on_boundary

_STILL = 1e-15


class Boundary(NamedTuple):
    """Where eigenvalues are those of a limit: so many turns at ω are whole there, and the gain by the eigenvalue."""

    turns: Callable[[Any, Any], Any]
    gain: Callable[[Any], Any]


def followed(values: Complex[np.ndarray, "k n"]) -> Complex[np.ndarray, "k n"]:
    """Eigenvalues in an order in which each goes on from the one before."""
    # Imported here, as that takes longer than limits of one contact.
    from scipy.optimize import linear_sum_assignment

    found = values.copy()
    for i in range(1, len(found)):
        # Where it goes if it goes on as before.
        ahead = found[i - 1] if i == 1 else 2 * found[i - 1] - found[i - 2]
        apart = np.abs(ahead[:, None] - values[i]) + np.abs(found[i - 1][:, None] - values[i])
        found[i] = values[i][linear_sum_assignment(apart)[1]]
    return found


def regenerative(tau: float) -> Boundary:
    """Of eigenvalues μ with 1 + b (1 − e^{−jωτ}) μ = 0: ωτ less what the phase asks for is whole."""
    return Boundary(lambda omega, value: omega * tau / (2 * np.pi) + half_turns(value), on_boundary)


NEGATIVE = Boundary(lambda omega, value: np.angle(-value) / (2 * np.pi), lambda real: -1 / real)
"""Of eigenvalues −1/b."""


def lowest_on(
    grid: Float[np.ndarray, " k"],
    branch: Complex[np.ndarray, "k n"],
    boundary: Boundary,
    eigenvalues: Callable[[np.ndarray], np.ndarray],
) -> tuple[float, float] | None:
    """The lowest gain, and its ω, at which an eigenvalue is that of a limit."""
    feeds = np.real(branch) < 0
    turns = boundary.turns(grid[:, None], branch)
    passed = feeds[1:] & feeds[:-1] & (np.floor(turns[1:]) != np.floor(turns[:-1]))
    brackets = []
    for i, j in zip(*np.nonzero(passed), strict=True):
        ends = np.sort(turns[i : i + 2, j])
        for whole in range(int(np.floor(ends[0])) + 1, int(np.floor(ends[1])) + 1):
            share = (whole - turns[i, j]) / (turns[i + 1, j] - turns[i, j])
            value = branch[i, j] + share * (branch[i + 1, j] - branch[i, j])
            brackets.append((boundary.gain(value.real), i, j, whole))
    best: tuple[float, float] | None = None
    for estimate, i, j, whole in sorted(brackets):
        if best is not None and estimate > 1.5 * best[0]:
            break
        gain, omega = _settled(grid[i : i + 2], branch[i : i + 2, j], whole, boundary, eigenvalues)
        if gain > 0 and (best is None or gain < best[0]):
            best = gain, omega
    return best


def _settled(
    ends: Float[np.ndarray, "2"],
    values: Complex[np.ndarray, "2"],
    whole: int,
    boundary: Boundary,
    eigenvalues: Callable[[np.ndarray], np.ndarray],
) -> tuple[float, float]:
    """A root between two points of a branch; of the eigenvalues there, that nearest to the line between its ends."""
    from scipy.optimize import brentq

    (low, high), (first, last) = ends.tolist(), values.tolist()

    def value(omega: float) -> complex:
        between = first + (last - first) * (omega - low) / (high - low)
        near = eigenvalues(np.array([omega]))[0]
        return complex(near[np.argmin(np.abs(near - between))])

    off = [float(boundary.turns(omega, one)) - whole for omega, one in ((low, first), (high, last))]
    if off[0] * off[1] >= 0:
        omega = low if off[0] == 0 else high
    else:
        omega: Any = brentq(lambda at: float(boundary.turns(at, value(at))) - whole, low, high, xtol=_STILL * high)
    return float(boundary.gain(np.asarray(value(omega).real))), float(omega)
