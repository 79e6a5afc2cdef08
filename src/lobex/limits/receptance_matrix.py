"""The receptance matrix of several directions, measured or of modes, at any frequency."""

from typing import Any

import numpy as np
from jaxtyping import Complex, Float, Inexact, Real

from lobex import _checks
from lobex._pytree import pytree
from lobex._shapes import AnyArray
from lobex.limits.receptance import Receptance, SampledCurve, slopes
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
    """G(ω) of modes or of samples, as a matrix of numbers.

    Attributes:
        low, high: the band in which it is known, rad/s.
        resonance: about where it is largest, rad/s.
    """

    def __init__(self, source: Modes | Receptance | ReceptanceMatrix) -> None:
        self.source, self.directions = source, source.directions
        if isinstance(source, Modes):
            self._sections = _sections_of(source)
            omega = np.asarray(source.angular_frequency, float)
            self.low, self.high, self.resonance = 0.0, np.inf, np.sort(omega)
            self.width = (np.asarray(source.damping_ratio, float) * omega)[np.argsort(omega)]
            return
        self.knot = 2 * np.pi * np.asarray(source.frequency, float)
        self.low, self.high = float(self.knot[0]), float(self.knot[-1])
        response = np.asarray(source.response, complex).reshape(len(self.knot), self.directions, self.directions)
        self._static = np.real(response[:_FIRST]).mean(axis=0)
        self._parts = [
            [self._interpolated(response[:, i, j], i == j) for j in range(self.directions)]
            for i in range(self.directions)
        ]

    def __call__(self, omega: Float[np.ndarray, " *k"]) -> Complex[np.ndarray, "*k r r"]:
        """G at frequencies of either sign, zero above the band, and below it the mean real part of its first lines."""
        size = np.abs(omega)
        found = self.with_slopes(size)[0]
        if not isinstance(self.source, Modes):
            found = np.where((size < self.low)[..., None, None], self._static, found)
            found = np.where((size > self.high)[..., None, None], 0.0, found)
        return np.where((omega < 0)[..., None, None], np.conj(found), found)

    def with_slopes(
        self, omega: Float[np.ndarray, " *k"]
    ) -> tuple[Complex[np.ndarray, "*k r r"], Complex[np.ndarray, "*k r r"], Complex[np.ndarray, "*k r r"]]:
        """G and its first and second derivative by ω, at frequencies above zero within the band."""
        if isinstance(self.source, Modes):
            found: Any = modal_response(
                self._sections, np.asarray(self._sections.angular_frequency) - omega[..., None], omega
            )
            return found
        row = np.clip(np.searchsorted(self.knot, omega, side="right") - 1, 0, len(self.knot) - 2)
        offset = omega - self.knot[row]
        each = [[part(row, offset) for part in line] for line in self._parts]
        first, second, third = (
            np.stack([np.stack([part[i] for part in line], axis=-1) for line in each], axis=-2) for i in range(3)
        )
        return first, second, third

    def _interpolated(self, values: Complex[np.ndarray, " n"], inverse: bool) -> Any:
        """A function of row and offset, with its derivatives."""
        if inverse:
            return SampledCurve(Receptance(np.asarray(self.knot) / (2 * np.pi), values)).at
        if not np.any(values):
            return lambda row, offset: (np.zeros(np.shape(offset), complex),) * 3
        step, slope = np.diff(self.knot), slopes(self.knot, values)
        secant = np.diff(values) / step
        square, cube = (3 * secant - 2 * slope[:-1] - slope[1:]) / step, (slope[:-1] + slope[1:] - 2 * secant) / step**2

        def at(row: Any, x: Any) -> tuple[Any, Any, Any]:
            first, second, third = slope[row], square[row], cube[row]
            value = values[row] + x * (first + x * (second + x * third))
            return value, first + x * (2 * second + x * 3 * third), 2 * second + x * 6 * third

        return at


def _sections_of(modes: Modes) -> Sections:
    """G of modes in all directions."""
    shape, loading = np.asarray(modes.shape), np.asarray(modes.loading)
    ratio = np.asarray(modes.damping_ratio)[:, None]
    seen, acting = (
        np.zeros_like(shape) if side is None else np.asarray(side)
        for side in (modes.quadrature, modes.force_quadrature)
    )
    weight = np.einsum("ni,nj->nij", shape, loading + 2 * ratio * acting) - np.einsum("ni,nj->nij", seen, acting)
    rate = np.einsum("ni,nj->nij", shape, acting) + np.einsum("ni,nj->nij", seen, loading)
    omega = np.asarray(modes.angular_frequency)
    return Sections(
        omega, np.asarray(modes.damping_ratio), weight, rate / omega[:, None, None] if modes.complex else None
    )
