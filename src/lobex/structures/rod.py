"""The thesis' blade: a clamped rod of truss elements that moves along its length only, §1.1."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from lobex import _checks
from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.structures.damping import modal_damping
from lobex.structures.eigenproblem import vibration_modes
from lobex.structures.modes import Modes
from lobex.structures.plausible_blade import warn_of_blade

# Its matrices are dense.
_MOST_ELEMENTS = 200


@pytree(static=("elements",))
class Rod:
    """A rod of equal two-node truss elements, clamped at one end, in contact at the other: (1.1)-(1.11).

    Attributes:
        elements: number of elements n, which is also the number of modes.
        young_modulus: E, Pa.
        density: ρ, kg/m³.
        length: L, m.
        area: cross-section S, m².

    Every attribute but ``elements`` may be traced; gradients flow through the eigenproblem.

    Raises:
        ValueError: for a value that is not a positive finite number, or elements outside 1 to 200.
    """

    elements: int = 5
    young_modulus: Number = 210e7
    density: Number = 4600.0
    length: Number = 0.5
    area: Number = 10e-4

    def __post_init__(self) -> None:
        object.__setattr__(self, "elements", _checks.integer("elements", self.elements, 1, _MOST_ELEMENTS))
        units = {"young_modulus": "Pa", "density": "kg/m³", "length": "m", "area": "m²"}
        for name, unit in units.items():
            _checks.positive(name, getattr(self, name), unit)
            _checks.scalar(name, getattr(self, name))
        warn_of_blade(length=self.length, young_modulus=self.young_modulus, density=self.density)

    def modes(self, damping_ratio: Any = 0.03, keep: Sequence[int] | None = None) -> Modes:
        """The rod's modes, seen at its tip.

        Args:
            damping_ratio: ξ, one number or one per mode kept (1.9). The thesis' text has 0.03, its Appendix B 0.0177.
            keep: mode numbers to keep, from 1; all by default. Chapter 4.2 isolates modes this way.
        """
        mass, stiffness = self._clamped()
        angular_frequency, vectors = vibration_modes(mass, stiffness, keep)
        ratio = modal_damping(damping_ratio, np.shape(vectors)[1])
        return Modes(angular_frequency, ratio, vectors[-1][:, None])

    def matrices(
        self, damping_ratio: Any = 0.03
    ) -> tuple[Float[AnyArray, "n n"], Float[AnyArray, "n n"], Float[AnyArray, "n n"]]:
        """Mass M_r (kg), stiffness K_r (N/m), both (1.11), and damping C (N s/m), (1.10), of shape (n, n)."""
        mass, stiffness = self._clamped()
        angular_frequency, vectors = vibration_modes(mass, stiffness)
        ratio = modal_damping(damping_ratio, self.elements)
        return mass, stiffness, _damping_matrix(mass, vectors, ratio, angular_frequency)

    @in_float64
    def _clamped(self) -> tuple[Float[AnyArray, "n n"], Float[AnyArray, "n n"]]:
        n = self.elements
        inner = np.ones(n)
        inner[-1] = 0.5
        neighbours = np.eye(n, k=1) + np.eye(n, k=-1)
        lib = namespace(self)
        element_length = lib.asarray(self.length, dtype=lib.result_type(float)) / n
        element_mass = self.density * self.area * element_length
        element_stiffness = self.young_modulus * self.area / element_length
        mass = element_mass / 6 * (4 * np.diag(inner) + neighbours)
        return mass, element_stiffness * (2 * np.diag(inner) - neighbours)


@in_float64
def _damping_matrix(mass: Any, vectors: Any, ratio: Any, angular_frequency: Any) -> Float[AnyArray, "n n"]:
    # V⁻¹ = Vᵀ M for mass-normalised vectors, so that (1.10) needs no inverse.
    inverse = namespace(vectors).asarray(vectors).T @ mass
    return inverse.T @ ((2 * ratio * angular_frequency)[:, None] * inverse)
