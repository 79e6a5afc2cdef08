"""Contact laws: the force on the tip, the energy behind it, and what a contact removes.

Every law answers three questions, elementwise and for arrays of any shape. ``penetration`` is how far the tip
has gone past the profile as it is, and ``depth`` is what has been removed there already:

    force(penetration, depth)              N, exactly zero where there is no penetration
    energy(penetration, depth)             J, the integral of the force from zero penetration at that depth
    removed(penetration, depth, residual)  m, at least zero, what this contact adds to the depth

where ``residual`` is the penetration that is left after the tip has moved on by one step. Only ``Plastic``
depends on the depth. A law that says ``follows_rate = True`` is asked for force(penetration, depth, rate), with the
velocity of the penetration, m/s.
"""

from typing import Any, ClassVar, Protocol, runtime_checkable

import jax.numpy as jnp
from jaxtyping import Array, Float

from lobex import _checks
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number, Numbers


@runtime_checkable
class ContactLaw(Protocol):
    """What ``march_wear`` and ``simulate_turning`` ask of a law."""

    def force(self, penetration: Numbers, depth: Numbers = 0.0) -> Float[AnyArray, "..."]:
        """The contact force, N."""
        ...

    def energy(self, penetration: Numbers, depth: Numbers = 0.0) -> Float[AnyArray, "..."]:
        """The potential of the force, J."""
        ...

    def removed(self, penetration: Numbers, depth: Numbers, residual: Numbers) -> Float[AnyArray, "..."]:
        """The depth that this contact removes, m."""
        ...


class Penalty:
    """A law whose coating gives way to wherever the tip stands once it has moved, §1.4."""

    def removed(self, penetration: Numbers, depth: Numbers, residual: Numbers) -> Float[AnyArray, "..."]:
        """What is left of a penetration after the step, m; nothing out of contact."""
        return jnp.where(penetration > 0, _positive(residual), 0.0)


@pytree()
class Linear(Penalty):
    """F = K h, (1.12).

    Attributes:
        stiffness: contact stiffness K, N/m.

    Raises:
        ValueError: for a stiffness that is negative, not finite, or not one number.
    """

    stiffness: Number

    def __post_init__(self) -> None:
        _not_negative(stiffness=(self.stiffness, "N/m"))

    def force(self, penetration: Numbers, depth: Numbers = 0.0) -> Float[AnyArray, "..."]:
        """The contact force, N."""
        return self.stiffness * _positive(penetration)

    def energy(self, penetration: Numbers, depth: Numbers = 0.0) -> Float[AnyArray, "..."]:
        """The potential of the force, J."""
        return self.stiffness / 2 * _positive(penetration) ** 2


@pytree()
class Cubic(Penalty):
    """F = b (ρ₁ h + ρ₂ h² + ρ₃ h³), (2.4).

    Attributes:
        width: width of the contact or depth of cut b, m.
        first, second, third: ρ₁ (N/m²), ρ₂ (N/m³) and ρ₃ (N/m⁴).

    Raises:
        ValueError: for values that are not finite numbers, a negative width, and coefficients that pull the
            tip in at some penetration.
    """

    width: Number
    first: Number
    second: Number
    third: Number

    def __post_init__(self) -> None:
        _not_negative(width=(self.width, "m"))
        numbers = []
        for name, unit in (("first", "N/m²"), ("second", "N/m³"), ("third", "N/m⁴")):
            value = getattr(self, name)
            _checks.scalar(name, value)
            numbers.append(_checks.as_numbers(name, value, unit))
        one, two, three = numbers
        if one is None or two is None or three is None:
            return
        if one < 0 or three < 0 or (two < 0 and two * two > 4 * one * three):
            raise ValueError(
                f"first = {one:.6g}, second = {two:.6g}, third = {three:.6g} give a negative force at some "
                "penetration; give first, third ≥ 0 and second ≥ −2 √(first · third)"
            )

    def force(self, penetration: Numbers, depth: Numbers = 0.0) -> Float[AnyArray, "..."]:
        """The contact force, N."""
        h = _positive(penetration)
        return self.width * h * (self.first + h * (self.second + h * self.third))

    def energy(self, penetration: Numbers, depth: Numbers = 0.0) -> Float[AnyArray, "..."]:
        """The potential of the force, J."""
        h = _positive(penetration)
        return self.width * h**2 * (self.first / 2 + h * (self.second / 3 + h * self.third / 4))


@pytree()
class Threshold(Penalty):
    """F = b (K₀ + K_s h) in contact, (2.5): the force starts with a jump.

    Attributes:
        width: width of the contact or depth of cut b, m.
        offset: K₀, N/m.
        slope: K_s, N/m².

    Raises:
        ValueError: for values that are negative, not finite, or not one number.
    """

    width: Number
    offset: Number
    slope: Number

    def __post_init__(self) -> None:
        _not_negative(width=(self.width, "m"), offset=(self.offset, "N/m"), slope=(self.slope, "N/m²"))

    def force(self, penetration: Numbers, depth: Numbers = 0.0) -> Float[AnyArray, "..."]:
        """The contact force, N."""
        return jnp.where(penetration > 0, self.width * (self.offset + self.slope * penetration), 0.0)

    def energy(self, penetration: Numbers, depth: Numbers = 0.0) -> Float[AnyArray, "..."]:
        """The potential of the force, J."""
        h = _positive(penetration)
        return self.width * h * (self.offset + self.slope * h / 2)


@pytree()
class Power(Penalty):
    """F = b K h^p, (2.6).

    Attributes:
        width: width of the contact or depth of cut b, m.
        coefficient: K, N/m^(1 + p).
        exponent: p, above 0.

    Raises:
        ValueError: for values that are negative, not finite, or not one number, and an exponent of zero.
    """

    width: Number
    coefficient: Number
    exponent: Number

    def __post_init__(self) -> None:
        _not_negative(width=(self.width, "m"), coefficient=(self.coefficient, "N/m^(1 + p)"))
        _checks.positive("exponent", self.exponent)
        _checks.scalar("exponent", self.exponent)

    def force(self, penetration: Numbers, depth: Numbers = 0.0) -> Float[AnyArray, "..."]:
        """The contact force, N."""
        return self.width * self.coefficient * _power(penetration, self.exponent)

    def energy(self, penetration: Numbers, depth: Numbers = 0.0) -> Float[AnyArray, "..."]:
        """The potential of the force, J."""
        rise = self.exponent + 1
        return self.width * self.coefficient * _power(penetration, rise) / rise


@pytree()
class Bilinear(Penalty):
    """F = K h up to a penetration h₁, and from there on K h₁ + K₂ (h − h₁): a coating that crushes or that locks.

    Attributes:
        stiffness: K, N/m.
        second_stiffness: K₂, N/m.
        transition: h₁, m.

    Raises:
        ValueError: for values that are negative, not finite, or not one number.
    """

    stiffness: Number
    second_stiffness: Number
    transition: Number

    def __post_init__(self) -> None:
        _not_negative(
            stiffness=(self.stiffness, "N/m"),
            second_stiffness=(self.second_stiffness, "N/m"),
            transition=(self.transition, "m"),
        )

    def force(self, penetration: Numbers, depth: Numbers = 0.0) -> Float[AnyArray, "..."]:
        """The contact force, N."""
        beyond = _positive(penetration - self.transition)
        return self.stiffness * (_positive(penetration) - beyond) + self.second_stiffness * beyond

    def energy(self, penetration: Numbers, depth: Numbers = 0.0) -> Float[AnyArray, "..."]:
        """The potential of the force, J."""
        beyond = _positive(penetration - self.transition)
        within = _positive(penetration) - beyond
        return self.stiffness * (within**2 / 2 + self.transition * beyond) + self.second_stiffness * beyond**2 / 2


@pytree()
class KelvinVoigt(Penalty):
    """F = K h + C ḣ in contact, and never a pull: a coating that is the harder the faster the tip comes in.

    ḣ is the velocity of the tip along the normal, beyond that of a flexible casing.

    Attributes:
        stiffness: K, N/m.
        viscosity: C, N s/m.

    Raises:
        ValueError: for values that are negative, not finite, or not one number.
    """

    follows_rate: ClassVar[bool] = True

    stiffness: Number
    viscosity: Number

    def __post_init__(self) -> None:
        _not_negative(stiffness=(self.stiffness, "N/m"), viscosity=(self.viscosity, "N s/m"))

    def force(self, penetration: Numbers, depth: Numbers = 0.0, rate: Numbers = 0.0) -> Float[AnyArray, "..."]:
        """The contact force, N, at a velocity of the penetration, m/s."""
        pushed = self.stiffness * penetration + self.viscosity * rate
        return jnp.where(penetration > 0, _positive(pushed), 0.0)

    def energy(self, penetration: Numbers, depth: Numbers = 0.0) -> Float[AnyArray, "..."]:
        """The potential of its elastic part, J."""
        return self.stiffness / 2 * _positive(penetration) ** 2


@pytree()
class Plastic:
    """An elastic-plastic coating with linear hardening; its plastic strain is the wear.

    A penetration h beyond the profile loads it elastically, F = k h, up to the yield force Y + H δ, where δ is
    the depth removed so far; what exceeds it flows (return mapping, Simo and Hughes, *Computational
    Inelasticity*, 1998, §1.4): Δδ = (k h − Y − H δ)/(k + H), F = k (h − Δδ). Unlike the other laws it removes
    nothing below the yield force.

    Attributes:
        stiffness: elastic stiffness k, N/m.
        yield_force: Y, N.
        hardening: H, N/m.

    Raises:
        ValueError: for values that are negative, not finite, or not one number, and a stiffness of zero.
    """

    stiffness: Number
    yield_force: Number
    hardening: Number = 0.0

    def __post_init__(self) -> None:
        _checks.positive("stiffness", self.stiffness, "N/m")
        _not_negative(
            stiffness=(self.stiffness, "N/m"), yield_force=(self.yield_force, "N"), hardening=(self.hardening, "N/m")
        )

    def force(self, penetration: Numbers, depth: Numbers = 0.0) -> Float[AnyArray, "..."]:
        """The contact force after the flow, N."""
        return self.stiffness * (_positive(penetration) - self._flow(penetration, depth))

    def energy(self, penetration: Numbers, depth: Numbers = 0.0) -> Float[AnyArray, "..."]:
        """The work of loading from zero penetration, elastic and plastic, J."""
        flow = self._flow(penetration, depth)
        elastic = _positive(penetration) - flow
        limit = self.yield_force + self.hardening * depth
        return self.stiffness / 2 * elastic**2 + flow * (limit + self.hardening * flow / 2)

    def removed(self, penetration: Numbers, depth: Numbers, residual: Numbers) -> Float[AnyArray, "..."]:
        """The plastic flow, m."""
        return self._flow(penetration, depth)

    def _flow(self, penetration: Numbers, depth: Numbers) -> Float[AnyArray, "..."]:
        excess = self.stiffness * penetration - self.yield_force - self.hardening * depth
        return _positive(excess) / (self.stiffness + self.hardening)


KINDS: dict[str, Any] = {
    "linear": Linear,
    "cubic": Cubic,
    "threshold": Threshold,
    "power": Power,
    "bilinear": Bilinear,
    "kelvin-voigt": KelvinVoigt,
    "plastic": Plastic,
}
"""The laws by the names that files and the shell give them."""


def check_law(law: Any, by_rate: bool = True) -> None:
    """Require a contact law, and unless ``by_rate`` one that asks for no rate."""
    methods = ("force", "energy", "removed")
    if isinstance(law, type) or not all(callable(getattr(law, name, None)) for name in methods):
        raise ValueError(f"law = {_checks.brief(law)} is no contact law; give one such as lobex.Linear(4.5e6)")
    if not by_rate and getattr(law, "follows_rate", False):
        raise ValueError(f"law = {_checks.brief(law)} follows the rate, which march_wear alone takes; give another law")


def _not_negative(**values: tuple[Any, str]) -> None:
    for name, (value, unit) in values.items():
        _checks.not_negative(name, value, unit)
        _checks.scalar(name, value)


def _positive(x: Numbers) -> Float[Array, "..."]:
    # Unlike maximum, of derivative 0 at 0.
    return jnp.where(x > 0, x, 0.0)


def _power(x: Numbers, exponent: Number) -> Float[Array, "..."]:
    # The inner choice keeps log 0 out of the derivative.
    inside = x > 0
    return jnp.where(inside, jnp.where(inside, x, 1.0) ** exponent, 0.0)
