"""Serrated edges: a wave along each edge, which stands out where those of other teeth stand back."""

from typing import Any

import numpy as np
from jaxtyping import Complex, Float, Real

from lobex import _checks
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number


@pytree()
class Serration:
    """A wave along the edges of a cutter: at the height z above its tip tooth j stands out by a cos(2π z/λ + ψ_j).

    Attributes:
        amplitude: a, m, half of what is between crest and valley: one of all teeth, or one of each, (teeth,).
        wave_length: λ along the axis, m.
        phase_degrees: ψ of each tooth, degrees of the wave, (teeth,). None for equal parts of one, 0, 360/teeth, …,
            as waves that are ground in one turn.
    """

    amplitude: Number | Real[AnyArray, " teeth"]
    wave_length: Number
    phase_degrees: Real[AnyArray, " teeth"] | None = None

    def __post_init__(self) -> None:
        for name in ("amplitude", "phase_degrees"):
            object.__setattr__(self, name, _checks.as_array(getattr(self, name), name))
        _checks.not_negative("amplitude", self.amplitude, "m")
        _checks.positive("wave_length", self.wave_length, "m")
        _checks.scalar("wave_length", self.wave_length)
        if self.phase_degrees is not None:
            _checks.as_numbers("phase_degrees", self.phase_degrees, "degrees")

    def of_teeth(self, teeth: int) -> Complex[Any, " teeth"]:
        """a e^{iψ} of each tooth, m, (teeth,)."""
        degrees = 360.0 / teeth * np.arange(teeth) if self.phase_degrees is None else self.phase_degrees
        lib = namespace(self.amplitude, degrees)
        return self.amplitude * lib.exp(1j * np.pi / 180 * lib.asarray(degrees))

    def along(self, height: Float[AnyArray, " k"], teeth: int) -> Float[Any, "k teeth"]:
        """What the radius of each tooth has above the mean at heights, m, (k,)."""
        lib = namespace(self.amplitude, self.wave_length, self.phase_degrees, height)
        turned = lib.exp(2j * np.pi / self.wave_length * lib.asarray(height))
        return lib.real(turned[:, None] * self.of_teeth(teeth))


def check_serration(serration: Any, teeth: int, diameter: Number | None) -> None:
    """Require waves of as many teeth, that are not as high as the cutter is wide.

    Raises:
        ValueError: for what is no ``Serration``, a number of amplitudes or phases that is not that of the teeth, and an
            amplitude that is not below the radius.
    """
    if not isinstance(serration, Serration):
        raise ValueError(f"serration = {_checks.brief(serration)} is none; give a lobex.Serration")
    if np.shape(serration.amplitude) not in ((), (teeth,)):
        shape = np.shape(serration.amplitude)
        raise ValueError(f"amplitude has shape {shape}; give one in m, or one a tooth, {(teeth,)}")
    if serration.phase_degrees is not None and np.shape(serration.phase_degrees) != (teeth,):
        shape = np.shape(serration.phase_degrees)
        raise ValueError(f"phase_degrees has shape {shape}; give one angle a tooth, {(teeth,)}")
    if diameter is None or _checks.is_traced((serration.amplitude, diameter)):
        return
    highest = float(np.max(serration.amplitude))
    if highest >= float(diameter) / 2:
        raise ValueError(
            f"amplitude = {highest:.6g} m is not below the radius of the cutter; give less than {diameter / 2:.6g} m"
        )
