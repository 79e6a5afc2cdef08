"""The receptance at the contact: measured, and interpolated between its samples, or of modes."""

from dataclasses import InitVar
from typing import Any, ClassVar

import numpy as np
from jaxtyping import Bool, Complex, Float, Inexact, Int, Real

from lobex import _checks
from lobex._missing import where_there
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, ArrayLike
from lobex._warnings import warn
from lobex.limits.cubics import Cubics, inverted
from lobex.limits.measurement import MEASURED, as_receptance, suspicion
from lobex.limits.sections import Sections, modal_response, sections_of
from lobex.structures.modes import Modes

# Parts that each interval of a measured curve is searched in.
_PARTS = 3


@pytree()
class Receptance:
    """A measured frequency response at the contact, displacement over force, used in place of modes.

    Between samples the dynamic stiffness 1/G is interpolated by piecewise cubics, with the slope at a sample
    from the quartic through it and its four nearest neighbours (``Cubics``, error of order h⁴).
    Near a resonance 1/G is close to a parabola, so that it is followed even where a resonance holds
    only a few samples, and a stray sample changes the curve no further than three samples away. Noise is
    interpolated as it stands: smooth a noisy measurement first.

    Args:
        frequency: increasing frequencies, shape (n,), Hz; a first line at 0 Hz is left out.
        response: what was measured over force at those frequencies, not zero: complex, shape (n,), or real and
            imaginary parts as columns, shape (n, 2).
        measured: "displacement" (m/N), "velocity" (m/s/N) or "acceleration" (m/s²/N).
        conjugate: True where the analyser's time dependence is e^{−jωt}: the response is then conjugated.

    Attributes:
        frequency: the frequencies above zero, shape (n,), n ≥ 4, Hz.
        response: the receptance G there, whatever was measured, shape (n,), m/N, for the time dependence e^{jωt}.

    Raises:
        ValueError: for fewer than 4 samples above 0 Hz, lengths that do not agree, frequencies that are not
            increasing or are negative, or a response that is zero or not finite.

    Warns:
        LobexWarning: where a line at 0 Hz is left out, and where the samples cannot be a driving point, which takes
            in energy (Im G ≤ 0) and whose Re G falls through a resonance: the message names the arguments
            with which they can.
    """

    frequency: Real[AnyArray, " points"]
    response: Inexact[AnyArray, " points"]
    measured: InitVar[str] = "displacement"
    conjugate: InitVar[bool] = False

    directions: ClassVar[int] = 1

    def __post_init__(self, measured: str, conjugate: bool) -> None:
        _checks.choice("measured", measured, MEASURED)
        _checks.choice("conjugate", conjugate, (False, True))
        frequency, response = self.frequency, self.response
        known = not (_checks.is_traced(frequency) or _checks.is_traced(response))
        if not _checks.is_traced(frequency):
            frequency = _checks.grid("frequency", frequency, "Hz")
        if not _checks.is_traced(response):
            response = _in_complex(response)
        if np.shape(response) != np.shape(frequency):
            raise ValueError(
                f"response has shape {np.shape(response)}; give one value per frequency, shape {np.shape(frequency)}, "
                "or columns of real and imaginary parts"
            )
        still = known and frequency[0] == 0
        if still:
            frequency, response = frequency[1:], response[1:]
        if not _checks.is_traced(frequency):
            _checks.positive("frequency", frequency, "Hz")
        if not _checks.is_traced(response):
            _check_response(response)
        if np.shape(frequency)[0] < 4:
            raise ValueError(f"frequency has {np.shape(frequency)[0]} samples above 0 Hz; give at least 4")
        if still:
            warn("frequency begins at 0 Hz, where nothing vibrates; that line is left out")
        if known and (message := suspicion(response, measured, conjugate)) is not None:
            warn(message)
        object.__setattr__(self, "frequency", frequency)
        object.__setattr__(self, "response", as_receptance(frequency, response, measured, conjugate))


def receptance(source: Modes | Sections | Receptance, omega: ArrayLike) -> complex | Complex[AnyArray, "..."]:
    """G(ω) = Σ φᵢψᵢ/(ωᵢ² − ω² + 2jξᵢωᵢω) at the contact, complex, m/N.

    Args:
        source: modes with one contact direction, or their sections, or a measured receptance, which is interpolated.
        omega: ω, rad/s, any shape.

    Returns:
        Array of the shape of ``omega``; NaN outside the band of a measurement.
    """
    lib = namespace(source, omega)
    at = lib.asarray(omega, dtype=lib.result_type(float))
    with np.errstate(divide="ignore", invalid="ignore"):
        if not isinstance(source, Receptance):
            sections = sections_of(source) if isinstance(source, Modes) else source
            return modal_response(sections, lib.asarray(sections.angular_frequency) - at[..., None], at)[0]
        curve = SampledCurve(source, at)
        row = lib.clip(lib.searchsorted(curve.anchor, at, side="right") - 1, 0, curve.rows - 1)
        inside = (at >= curve.anchor[0]) & (at <= curve.knot[-1])
        return where_there(inside, curve.at(row, at - curve.anchor[row])[0])


class SampledCurve:
    """The receptance between samples: one row per interval.

    Args:
        source: the samples.
        beside: numbers that it is asked at, in JAX where that traces them.
    """

    def __init__(self, source: Receptance, *beside: Any) -> None:
        lib = namespace(source, *beside)
        self.knot = 2 * lib.pi * lib.asarray(source.frequency, dtype=lib.result_type(float))
        self.anchor, self.step = self.knot[:-1], lib.diff(self.knot)
        self.rows = self.anchor.shape[0]
        self._stiffness = Cubics(self.knot, 1 / lib.asarray(source.response))
        self.turn = 0.0
        self.open_ended = False
        self.most_breaks = None

    def grid(self) -> tuple[Int[AnyArray, " points"], Float[AnyArray, " points"]]:
        lib = namespace(self.knot)
        offset = self.step[:, None] * (lib.arange(_PARTS + 1) / _PARTS)
        return lib.repeat(lib.arange(self.rows), _PARTS + 1), offset.ravel()

    def at(
        self, row: Int[AnyArray, " *points"], offset: Float[AnyArray, " *points"]
    ) -> tuple[Complex[AnyArray, " *points"], Complex[AnyArray, " *points"], Complex[AnyArray, " *points"]]:
        return inverted(*self._stiffness.at(row, offset))

    def undamped_at(
        self, row: Int[AnyArray, " *points"], offset: Float[AnyArray, " *points"]
    ) -> Bool[AnyArray, " *points"]:
        return namespace(offset).zeros(np.shape(offset), dtype=bool)


def _in_complex(response: Any) -> np.ndarray:
    """Complex samples, also of real and imaginary columns."""
    try:
        values = np.asarray(response, dtype=complex)
    except (TypeError, ValueError):
        raise ValueError(f"response = {response!r} is not a list of numbers; give complex values in m/N") from None
    columns = values.ndim == 2 and values.shape[1] == 2 and not np.any(np.imag(values))
    return values[:, 0] + 1j * values[:, 1] if columns else values


def _check_response(values: Inexact[AnyArray, " points"]) -> None:
    if not np.all(np.isfinite(values)):
        raise ValueError("response has NaN or infinite values; give finite numbers in m/N")
    if np.any(values == 0):
        raise ValueError("response has zeros, where 1/G does not exist; leave those samples out")
