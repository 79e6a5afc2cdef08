"""What was measured, turned into a receptance, and whether that can be the receptance of a driving point."""

from itertools import product
from typing import NamedTuple

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
# Of the square of the largest |G|: the area that a resonance goes around, twice that of its circle, is π/2.
_CIRCLE = 0.25
# From −90°, which is that of a receptance at its resonances: what is another's, and what is known for one's.
_OTHER, _KNOWN = 60.0, 45.0
# From line to line at the largest peak the phase turns by less, if the lines are close enough to tell it.
_CLOSE = 60.0
_TURNS = (1.0, -1j, -1.0)


class Reading(NamedTuple):
    """What samples can be: what was measured, with which sign of time, and whether against the force."""

    measured: str
    conjugate: bool
    against: bool


def as_receptance(
    frequency: Real[AnyArray, " points"], response: Inexact[AnyArray, " points"], measured: str, conjugate: bool
) -> Inexact[AnyArray, " points"]:
    """Displacement over force, m/N, for the time dependence e^{jωt}, of what was measured over force."""
    response = response.conj() if conjugate else response
    omega = 2 * np.pi * frequency
    if measured == "velocity":
        return response / (1j * omega)
    return -response / omega**2 if measured == "acceleration" else response


def suspicion(response: Inexact[AnyArray, " points"], measured: str, conjugate: bool) -> str | None:
    """Why samples, taken for what they are said to be, are no driving point, and the arguments with which they are."""
    found = oddity(response, measured, conjugate)
    if found is None:
        return None
    if not np.any(np.imag(response)):
        return f"response has {found}; give complex values, or columns of real and imaginary parts"
    others = readings(response)
    if not others:
        return f"response has {found}, which {NO_DRIVING_POINT}"
    ways = [
        f"{named(*other)} {'' if number else 'is read '}by {'-response and ' * other.against}"
        f"measured={other.measured!r}{', conjugate=True' * other.conjugate}"
        for number, other in enumerate(others)
    ]
    return f"response has {found}, which no receptance of a driving point has; {', or '.join(ways)}"


def readings(response: Inexact[AnyArray, " points"]) -> list[Reading]:
    """What samples can be by their phase at resonances, around which it falls; sensors against the force last."""
    conjugate = bool(_area(response) > 0)
    possible = [Reading(one, conjugate, against) for against, one in product((False, True), MEASURED)]
    return [one for one in possible if abs(_off(_seen(response, one))) < _KNOWN]


def named(measured: str, conjugate: bool = False, against: bool = False) -> str:
    """Such as "an accelerance"."""
    kind = _NAME[measured] + (" with the other sign of time, e^{−jωt}" if conjugate else "")
    kind += " of a sensor that pointed against the force" if against else ""
    return f"an {kind}" if kind.startswith("a") else f"a {kind}"


def oddity(response: Inexact[AnyArray, " points"], measured: str, conjugate: bool) -> str | None:
    """What a driving point cannot have: it takes in energy, Im G ≤ 0, and its phase falls to −90° at resonances.

    Lines count by what was measured, of which noise is as large at all of them.
    """
    if not np.any(np.imag(response)):
        return "no imaginary part, as a magnitude without phase"
    seen = _seen(response, Reading(measured, conjugate, False))
    area, off = _area(seen), _off(seen)
    if abs(area) > _CIRCLE * np.max(np.abs(seen)) ** 2 and _turn_at_peak(seen) < _CLOSE:
        if abs(off) > _OTHER:
            return f"a phase of about {(off + 90) % 360 - 180:.0f}° at its resonances, and not of −90°"
        return "a phase that rises through its resonances" if area > 0 else None
    considerable = np.imag(seen)[np.abs(np.imag(seen)) > _CONSIDERABLE * np.abs(seen)]
    if considerable.size and np.mean(considerable > 0) > 0.5:
        return f"a positive imaginary part at {np.sum(considerable > 0)} of {considerable.size} frequencies"
    return None


def _seen(response: Inexact[AnyArray, " points"], reading: Reading) -> Inexact[AnyArray, " points"]:
    """With the phase of the receptance, and the size of what was measured."""
    turned = (response.conj() if reading.conjugate else response) * _TURNS[MEASURED.index(reading.measured)]
    return -turned if reading.against else turned


def _area(response: Inexact[AnyArray, " points"]) -> float:
    """Twice the area that is gone around from 0, anticlockwise."""
    return float(np.sum(np.imag(np.conj(response[:-1]) * response[1:])))


def _turn_at_peak(response: Inexact[AnyArray, " points"]) -> float:
    """By how many degrees the phase turns from the largest to the lines beside it, at most."""
    peak = int(np.argmax(np.abs(response)))
    around = response[max(peak - 1, 0) : peak + 2]
    return float(np.max(np.abs(np.rad2deg(np.angle(around * np.conj(response[peak]))))))


def _off(seen: Inexact[AnyArray, " points"]) -> float:
    """By how many degrees the phase where it is largest lies beyond −90°, from −180° to 180°."""
    return float(np.rad2deg(np.angle(1j * np.sum(np.abs(seen) ** 2 * seen))))
