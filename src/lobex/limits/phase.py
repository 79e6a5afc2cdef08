"""The phase of the delay and of a receptance, in turns: at a whole number a lobe of that number passes."""

from typing import Any

import numpy as np
from jaxtyping import Complex, Float, Int

from lobex._namespace import namespace, still
from lobex._shapes import AnyArray, Numbers
from lobex.limits.receptance_curve import ReceptanceCurve


def half_turns(response: Complex[AnyArray, " *points"] | complex) -> Any:
    """−arg G/π − 1/2, of its shape, (…), with arg G in (−2π, 0]: continuous where Re G < 0, for Im G of either sign."""
    lib = namespace(response)
    return lib.mod(lib.arctan2(-response.imag, response.real), 2 * lib.pi) / lib.pi - 0.5


def turns_of(curve: ReceptanceCurve, response: Complex[AnyArray, " *points"]) -> Float[AnyArray, " *points"]:
    """The turns of the phase without those of the delay."""
    return half_turns(response) + curve.turn


def half_turn_rate(
    response: Complex[AnyArray, " *points"], slope: Complex[AnyArray, " *points"]
) -> Float[AnyArray, " *points"]:
    """Derivative of ``half_turns`` by ω."""
    return -(slope / response).imag / np.pi


def half_turn_bend(
    response: Complex[AnyArray, " *points"], slope: Complex[AnyArray, " *points"], bend: Complex[AnyArray, " *points"]
) -> Float[AnyArray, " *points"]:
    """Second derivative of ``half_turns`` by ω."""
    return -(bend / response - (slope / response) ** 2).imag / np.pi


def phase(
    curve: ReceptanceCurve, speed: Numbers, row: Int[AnyArray, " *points"], offset: Float[AnyArray, " *points"]
) -> tuple[Float[AnyArray, " *points"], Float[AnyArray, " *points"], Float[AnyArray, " *points"]]:
    """(ωτ − 2 arg G)/2π − 1/2 and the turn of the curve, a lobe number where one passes, less the whole turns at the
    row's anchor; ′ and ″.
    """
    rate = 1 / (2 * np.pi * speed)
    response, slope, bend = curve.at(row, offset)
    turns = curve.anchor[row] * rate
    within = turns - still(namespace(turns).floor(turns))
    return (
        within + offset * rate + turns_of(curve, response),
        rate + half_turn_rate(response, slope),
        half_turn_bend(response, slope, bend),
    )
