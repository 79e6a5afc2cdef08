"""The receptance matrix of several directions, measured or of modes, at any frequency."""

from typing import Any

import numpy as np
from jaxtyping import Complex, Float, Inexact, Real

from lobex import _checks
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray
from lobex.limits.cubics import Cubics, inverted
from lobex.limits.receptance import Receptance
from lobex.limits.sections import Sections, modal_response
from lobex.structures.modes import Modes

# Lines that say how stiff the structure is below the measured band.
_FIRST = 5


@pytree()
class ReceptanceMatrix:
    """Measured receptances of several directions, displacement over force, in place of the modes of ``Milling``.

    ``zero_order_limit`` and ``multi_frequency_limit`` take it. Between samples a driving point's 1/G is interpolated by
    cubics, and G itself of a cross receptance, as ``Receptance`` does; one that was not measured is zero.

    Attributes:
        frequency: increasing frequencies above zero, (n,), n ≥ 4, Hz.
        response: (n, r, r), m/N, of r displacements to forces along the same directions, x first, for the time
            dependence e^{jωt}.

    Raises:
        ValueError: for fewer than 4 samples, shapes that do not agree, frequencies that are not increasing or above
            zero, values that are not finite, and a driving point that is zero somewhere.
    """

    frequency: Real[AnyArray, " n"]
    response: Inexact[AnyArray, "n r r"]

    def __post_init__(self) -> None:
        frequency = _checks.grid("frequency", self.frequency, "Hz")
        _checks.positive("frequency", frequency, "Hz")
        response: Any = np.asarray(self.response, dtype=complex)
        if len(frequency) < 4:
            raise ValueError(f"frequency has {len(frequency)} samples; give at least 4")
        if response.ndim != 3 or response.shape[1:] != response.shape[:0:-1] or len(response) != len(frequency):
            raise ValueError(
                f"response has shape {response.shape}; give ({len(frequency)}, r, r), the displacements to forces "
                "along the same directions"
            )
        if not np.isfinite(response).all():
            raise ValueError("response has NaN or infinite values; give finite numbers in m/N")
        if np.any(np.einsum("nii->ni", response) == 0):
            raise ValueError("response has zeros at a driving point, where 1/G does not exist; leave those samples out")
        object.__setattr__(self, "frequency", frequency)
        object.__setattr__(self, "response", response)

    @property
    def directions(self) -> int:
        """Number of directions r."""
        return np.shape(self.response)[1]


class MatrixCurve:
    """G(ω) of modes or of samples, as a matrix; of numbers, or of what JAX traces.

    Args:
        source: the modes or samples.
        beside: numbers that it is asked at, in JAX where that traces them.

    Attributes:
        low, high: the band in which it is known, rad/s.
    """

    def __init__(self, source: Modes | Receptance | ReceptanceMatrix, *beside: Any) -> None:
        self.source, self.directions = source, source.directions
        if isinstance(source, Modes):
            self._sections, self.low, self.high = _sections_of(source), 0.0, np.inf
            return
        lib = namespace(source, *beside)
        self.knot = 2 * np.pi * lib.asarray(source.frequency, dtype=lib.result_type(float))
        self.low, self.high = self.knot[0], self.knot[-1]
        response = lib.asarray(source.response).reshape(len(self.knot), self.directions, self.directions)
        self._static = lib.real(response[:_FIRST]).mean(axis=0)
        self._crossed, self._driven = (
            Cubics(self.knot, response),
            Cubics(self.knot, 1 / lib.einsum("nii->ni", response)),
        )

    @property
    def resonance(self) -> Float[np.ndarray, " n"]:
        """Of modes, about where it is largest, rad/s, increasing."""
        return np.sort(np.asarray(self._modes.angular_frequency, float))

    @property
    def width(self) -> Float[np.ndarray, " n"]:
        """Half widths of these, rad/s."""
        omega = np.asarray(self._modes.angular_frequency, float)
        return (np.asarray(self._modes.damping_ratio, float) * omega)[np.argsort(omega)]

    @property
    def _modes(self) -> Any:
        return self.source

    def __call__(self, omega: Float[AnyArray, " *k"]) -> Complex[AnyArray, "*k r r"]:
        """G at frequencies of either sign, zero above the band, and below it the mean real part of its first lines."""
        return self.with_slopes(omega)[0]

    def with_slopes(
        self, omega: Float[AnyArray, " *k"]
    ) -> tuple[Complex[AnyArray, "*k r r"], Complex[AnyArray, "*k r r"], Complex[AnyArray, "*k r r"]]:
        """The same, and its first and second derivative by ω, which outside the band are zero."""
        if isinstance(self.source, Modes):
            natural = namespace(self.source, omega).asarray(self._sections.angular_frequency)
            found: Any = modal_response(self._sections, natural - omega[..., None], omega)
            return found
        lib = namespace(self.source, omega)
        size = lib.abs(omega)
        row = lib.clip(lib.searchsorted(self.knot, size, side="right") - 1, 0, len(self.knot) - 2)
        offset = size - self.knot[row]
        crossed, driven = self._crossed.at(row, offset), inverted(*self._driven.at(row, offset))
        below, above, backward = (part[..., None, None] for part in (size < self.low, size > self.high, omega < 0))
        diagonal = np.eye(self.directions, dtype=bool)
        kept: list[Any] = []
        for number, static in enumerate((self._static, 0.0, 0.0)):
            inside = lib.where(diagonal, driven[number][..., None], crossed[number])
            known = lib.where(above, 0.0, lib.where(below, static, inside))
            # G(−ω) is the conjugate.
            kept.append(lib.where(backward, (-1) ** number * lib.conj(known), known))
        first, second, third = kept
        return first, second, third


def _sections_of(modes: Modes) -> Sections:
    """G of modes in all directions."""
    lib = namespace(modes)
    shape, loading, omega = (lib.asarray(part) for part in (modes.shape, modes.loading, modes.angular_frequency))
    ratio = lib.asarray(modes.damping_ratio)[:, None]
    seen, acting = (
        lib.zeros_like(shape) if side is None else lib.asarray(side)
        for side in (modes.quadrature, modes.force_quadrature)
    )
    weight = lib.einsum("ni,nj->nij", shape, loading + 2 * ratio * acting) - lib.einsum("ni,nj->nij", seen, acting)
    rate = lib.einsum("ni,nj->nij", shape, acting) + lib.einsum("ni,nj->nij", seen, loading)
    return Sections(omega, modes.damping_ratio, weight, rate / omega[:, None, None] if modes.complex else None)
