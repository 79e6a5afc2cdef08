"""The force of a cut by its chip: specific coefficients, and what the edge adds to them."""

from typing import Any

import numpy as np

from lobex import _checks
from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import Number

# At which specific forces are tabulated, m.
_TABULATED = 1e-3


@pytree()
class CuttingForce:
    """The force K h + K_e per width of a chip h thick, against the motion of the edge, along and across it.

    ``Milling`` and ``Turning`` take it as ``force``. What does not depend on the chip acts on motion and power alone,
    and has no part in multipliers and limits (Altintas, Manufacturing Automation, 2nd ed., 2012, ch. 2).

    Attributes:
        tangential: K_t, along the cutting velocity, N/m².
        normal: K_n, along the thickness of the chip, N/m².
        axial: K_a, along the edge, N/m².
        tangential_edge, normal_edge, axial_edge: the same of the edge, N/m.
    """

    tangential: Number
    normal: Number
    axial: Number = 0.0
    tangential_edge: Number = 0.0
    normal_edge: Number = 0.0
    axial_edge: Number = 0.0

    def __post_init__(self) -> None:
        _checks.positive("tangential", self.tangential, "N/m²")
        _checks.not_negative("normal", self.normal, "N/m²")
        _checks.as_numbers("axial", self.axial, "N/m²")
        for name in ("tangential_edge", "normal_edge", "axial_edge"):
            _checks.as_numbers(name, getattr(self, name), "N/m")
        for name in self.__dataclass_fields__:
            _checks.scalar(name, getattr(self, name))

    @property
    def edge(self) -> tuple[Number, Number, Number] | None:
        """The three forces of the edge, N/m; None where they are known to be zero."""
        edge = (self.tangential_edge, self.normal_edge, self.axial_edge)
        return edge if _checks.is_traced(edge) or np.any(np.asarray(edge)) else None

    @classmethod
    def from_angle(cls, specific: Number, angle_degrees: Number, axial: Number = 0.0) -> "CuttingForce":
        """Of the specific force K_s, N/m², and its angle β from the normal of the surface, degrees.

        K_t = K_s sin β and K_n = K_s cos β (Schmitz and Smith, Machining Dynamics, 2nd ed., 2019, ch. 3 and 4).

        Raises:
            ValueError: for an angle outside (0, 90].
        """
        _checks.positive("specific", specific, "N/m²")
        _checks.scalar("angle_degrees", angle_degrees)
        angle = _checks.as_numbers("angle_degrees", angle_degrees, "degrees")
        if angle is not None and not 0 < angle <= 90:
            raise ValueError(
                f"angle_degrees = {float(angle):.6g}; give the angle from the normal, above 0 and up to 90"
            )
        return cls(*_by_angle(specific, angle_degrees), axial)

    @classmethod
    def kienzle(
        cls,
        chip: Number,
        *,
        tangential: tuple[Number, Number],
        normal: tuple[Number, Number],
        axial: tuple[Number, Number] | None = None,
    ) -> "CuttingForce":
        """The tangent, at a mean chip, of forces k_c1.1 h^(−m) · h b (Kienzle, VDI-Z 94, 1952).

        Its slope is (1 − m) k_c, and what it has at a chip of none, m k_c h, stands as force of the edge.

        Args:
            chip: the mean chip thickness h, m.
            tangential, normal, axial: k_c1.1, N/m² (of a chip 1 mm thick and 1 mm wide), and m of each part.

        Raises:
            ValueError: for a chip that is not above 0, and exponents outside [0, 1).
        """
        _checks.positive("chip", chip, "m")
        parts: dict[str, Any] = {"tangential": tangential, "normal": normal} | (
            {} if axial is None else {"axial": axial}
        )
        for name, part in parts.items():
            numbers = _checks.as_numbers(name, part)
            if np.shape(part) != (2,) or (numbers is not None and not (numbers[0] > 0 and 0 <= numbers[1] < 1)):
                raise ValueError(
                    f"{name} = {_checks.brief(part)}; give k_c1.1 in N/m², above 0, and m, from 0 to below 1"
                )
        return cls(**_tangent(chip, parts))


def check_force(force: Any) -> None:
    """Require a ``CuttingForce``."""
    if not isinstance(force, CuttingForce):
        raise ValueError(f"force = {_checks.brief(force)}; give lobex.CuttingForce(tangential, normal)")


def of_force(force: Any, *others: Any) -> tuple[Number, Number, Number | None, Any]:
    """Tangential, normal, axial and edge of a ``CuttingForce``, in place of which none of them is given."""
    check_force(force)
    if any(other is not None for other in others):
        raise ValueError("force is given beside tangential, normal, axial or edge; give one of both")
    axial = force.axial if _checks.is_traced(force.axial) or force.axial != 0 else None
    return force.tangential, force.normal, axial, force.edge


@in_float64
def _by_angle(specific: Any, angle_degrees: Any) -> tuple[Any, Any]:
    lib = namespace(specific, angle_degrees)
    angle = angle_degrees * (np.pi / 180)
    return specific * lib.sin(angle), specific * lib.cos(angle)


@in_float64
def _tangent(chip: Any, parts: dict[str, Any]) -> dict[str, Any]:
    found = {}
    for name, (size, exponent) in parts.items():
        at_chip = size * (chip / _TABULATED) ** -exponent
        found |= {name: (1 - exponent) * at_chip, f"{name}_edge": exponent * at_chip * chip}
    return found
