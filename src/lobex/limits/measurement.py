"""What was measured, turned into a receptance, and whether that can be the receptance of a driving point."""

from itertools import product

import numpy as np
from jaxtyping import Inexact, Real

from lobex._shapes import AnyArray

MEASURED = ("displacement", "velocity", "acceleration")
_NAME = {"displacement": "receptance", "velocity": "mobility", "acceleration": "accelerance"}
NO_DRIVING_POINT = (
    "no receptance of a driving point has; check that force and displacement were measured at one point and in one "
    "direction"
)
# Imaginary parts below this share of |G| are those of noise, far from every resonance.
_CONSIDERABLE = 0.01
# Of max|Im G|: the least change of Re G over a resonance that says which way it is passed.
_SWING = 0.25
# Least share of either sign in an imaginary part that has both, and its least size beside the real part, half of which
# it is along a circle, and of which noise has less.
_MIXED, _BESIDE = 0.05, 0.2


def as_receptance(
    frequency: Real[AnyArray, " points"], response: Inexact[AnyArray, " points"], measured: str, conjugate: bool
) -> Inexact[AnyArray, " points"]:
    """Displacement over force, m/N, for the time dependence e^{jωt}, of what was measured over force."""
    response = response.conj() if conjugate else response
    omega = 2 * np.pi * frequency
    if measured == "velocity":
        return response / (1j * omega)
    return -response / omega**2 if measured == "acceleration" else response


def suspicion(
    frequency: Real[AnyArray, " points"], response: Inexact[AnyArray, " points"], measured: str, conjugate: bool
) -> str | None:
    """Why samples, taken for what they are said to be, are no driving point, and the arguments with which they are."""
    found = oddity(as_receptance(frequency, response, measured, conjugate))
    if found is None:
        return None
    if not np.any(np.imag(response)):
        return f"response has {found}; give complex values, or columns of real and imaginary parts"
    other = other_reading(frequency, response)
    if other is None:
        return f"response has {found}, which {NO_DRIVING_POINT}"
    arguments = f"measured={other[0]!r}" + (", conjugate=True" if other[1] else "")
    return f"response has {found}, which no receptance of a driving point has; {named(*other)} is read by {arguments}"


def other_reading(
    frequency: Real[AnyArray, " points"], response: Inexact[AnyArray, " points"]
) -> tuple[str, bool] | None:
    """What was measured, and whether with the other sign of time, so that samples can be a driving point."""
    for measured, conjugate in product(MEASURED, (False, True)):
        if oddity(as_receptance(frequency, response, measured, conjugate)) is None:
            return measured, conjugate
    return None


def named(measured: str, conjugate: bool = False) -> str:
    """Such as "an accelerance"."""
    kind = _NAME[measured] + (" with the other sign of time, e^{−jωt}" if conjugate else "")
    return f"an {kind}" if kind.startswith("a") else f"a {kind}"


def oddity(receptance: Inexact[AnyArray, " points"]) -> str | None:
    """What a driving point cannot have: it takes in energy, Im G ≤ 0, and Re G falls through a resonance."""
    real, imaginary = np.real(receptance), np.imag(receptance)
    if not np.any(imaginary):
        return "no imaginary part, as a magnitude without phase"
    feeds = imaginary[np.abs(imaginary) > _CONSIDERABLE * np.abs(receptance)] > 0
    if feeds.size and np.mean(feeds) > 0.5:
        return f"a positive imaginary part at {np.sum(feeds)} of {feeds.size} frequencies"
    size = np.abs(imaginary)
    share = np.sum(np.maximum(imaginary, 0)) / np.sum(size)
    one_sided = max(np.mean(real >= 0), np.mean(real <= 0)) > 0.9
    if one_sided and _BESIDE < size.max() / np.abs(real).max() < 1 and _MIXED < share < 1 - _MIXED:
        return "a real part of one sign throughout, and an imaginary part of both"
    top = int(np.argmax(size))
    # The half-power points, where a resonance has all of its real part.
    beside = np.flatnonzero(size < size[top] / 2)
    before, after = beside[beside < top], beside[beside > top]
    if before.size and after.size and real[after[0]] - real[before[-1]] > _SWING * size[top]:
        return "a real part that rises through its largest resonance"
    return None
