"""A spindle whose speed goes up and down: the angle between two passes is fixed, the time between them is not."""

from dataclasses import replace
from fractions import Fraction
from math import ceil
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Real

from lobex import _checks
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._roots import bracketed_root
from lobex._shapes import AnyArray, Number
from lobex.systems.at_angle import AtAngle, ByPace, SinceAngle
from lobex.systems.coefficients import Coefficient
from lobex.systems.system import DelaySystem

# Of a profile, samples at which it is held against what a speed can do, for each of its own.
_FINER = 16
_MOST_SAMPLES = 256
# By so much do speeds change that are provided for where numbers are not known yet; else in steps of that size.
_UNKNOWN, _STEPS = 0.5, 20
# A spindle does not come closer to standing still than this share of its mean speed.
_SLOWEST = 0.01
# Variations until the teeth come back to the same speeds, at most, and the passes that they take.
_MOST_CYCLES, _MOST_PASSES = 12, 240
_ROUNDING = 1e-9


@pytree(static=("frequency_ratio", "spread"))
class SpeedVariation:
    """n(t) = n₀ [1 + A p(R n₀ t)] of a profile p of period and amplitude 1, by default sin(2π R n₀ t).

    The delay is exact: the time in which the spindle turned by the angle between two passes. Other forms of the law
    make other limits (Insperger and Stépán, Stability analysis of turning with periodic spindle speed modulation via
    semidiscretization, J. Vib. Control 10, 2004; Seguy, Insperger, Arnaud, Dessein and Peigné, On the stability of
    high-speed milling with spindle speed variation, Int. J. Adv. Manuf. Technol. 48, 2010).

    Attributes:
        amplitude: A, usually called RVA: of the speed, over its mean.
        frequency_ratio: R, usually called RVF: variations per mean revolution. In milling one whose variations and
            tooth passes come back together, such as 0.1 or 1/3.
        profile: p at equal steps of its period, (samples,), beginning where a cut does, of mean 0; between them it is
            the trigonometric polynomial. None for the sine.
        spread: the most by which the speed differs from its mean, over it, rounded up; leave it out.
    """

    amplitude: Number
    frequency_ratio: float
    profile: Real[AnyArray, " samples"] | None = None
    spread: float = _UNKNOWN

    def __post_init__(self) -> None:
        _checks.not_negative("amplitude", self.amplitude)
        _checks.scalar("amplitude", self.amplitude)
        _checks.positive("frequency_ratio", self.frequency_ratio)
        ratio = _checks.as_numbers("frequency_ratio", self.frequency_ratio)
        if ratio is None or ratio.ndim:
            raise ValueError("frequency_ratio is traced; give a number: the period of the whole depends on it")
        if not 1 / _MOST_PASSES <= ratio <= _MOST_CYCLES:
            raise ValueError(
                f"frequency_ratio = {float(ratio):.6g} is of no spindle; give variations per revolution, from "
                f"{1 / _MOST_PASSES:.2g} to {_MOST_CYCLES}"
            )
        object.__setattr__(self, "frequency_ratio", float(ratio))
        object.__setattr__(self, "profile", _checks.as_array(self.profile, "profile"))
        if self.profile is not None:
            self._check_profile(self.profile)
        if not _checks.is_traced((self.amplitude, self.profile)):
            object.__setattr__(self, "spread", self._spread())

    def rotation(self, cycles: int = 1) -> "Varied":
        """How the spindle turns in so many variations."""
        return Varied(self.amplitude * self._terms(), cycles)

    def passes(self, per_revolution: int) -> tuple[int, int]:
        """How many passes and how many variations it takes until both come back together.

        Raises:
            ValueError: where they do not, or after too many.
        """
        exact = Fraction(per_revolution / self.frequency_ratio)
        found = exact.limit_denominator(_MOST_CYCLES)
        if abs(found - exact) > _ROUNDING * exact or not 0 < found.numerator <= _MOST_PASSES:
            raise ValueError(
                f"frequency_ratio = {self.frequency_ratio:.10g} with {per_revolution} passes of the teeth per "
                f"revolution: they do not come back together in {_MOST_CYCLES} variations and {_MOST_PASSES} passes; "
                "give a ratio such as 0.1 or 1/3"
            )
        return found.numerator, found.denominator

    def delay_range(self, shortest: float, longest: float) -> tuple[float, float]:
        """That of delays which are in this range at the mean speed."""
        return shortest / (1 + self.spread), longest / (1 - self.spread)

    def acting_on(self, system: DelaySystem, repeats: Any, cycles: int = 1, **known: Any) -> DelaySystem:
        """A system of even turning, whose period then comes ``repeats`` times in so many variations.

        Its delays and coefficients are those of the angle. ``known`` is what else is known of the new one.
        """
        rotation = self.rotation(cycles)

        def turned(term: Any) -> Any:
            term = replace(term, coefficient=_at_angle(term.coefficient, rotation, repeats))
            delay = getattr(term, "delay", None)
            return term if delay is None else replace(term, delay=SinceAngle(delay, rotation, repeats))

        return replace(system, period=repeats * system.period, terms=tuple(map(turned, system.terms)), **known)

    def per_pace(self, coefficient: Coefficient, repeats: int = 1, cycles: int = 1) -> Coefficient:
        """A coefficient of even turning that goes with the inverse of the speed."""
        rotation = self.rotation(cycles)
        return ByPace(_at_angle(coefficient, rotation, repeats), rotation)

    def _terms(self) -> Float[AnyArray, "2 K"]:
        """p by its cosines and sines, k = 1 … K."""
        if self.profile is None:
            return np.array([[0.0], [1.0]])
        lib = namespace(self.profile)
        samples = np.shape(self.profile)[0]
        order = np.arange(1, (samples - 1) // 2 + 1)
        angle = 2 * np.pi / samples * order * np.arange(samples)[:, None]
        return 2 / samples * lib.stack([self.profile @ np.cos(angle), self.profile @ np.sin(angle)])

    def _check_profile(self, profile: Any) -> None:
        _checks.as_numbers("profile", profile)
        shape = np.shape(profile)
        if len(shape) != 1 or not 3 <= shape[0] <= _MOST_SAMPLES or shape[0] % 2 == 0:
            raise ValueError(
                f"profile has shape {shape}; give an odd number of samples, 3 to {_MOST_SAMPLES - 1}, of one period"
            )
        known = None if _checks.is_traced(profile) else np.asarray(profile, dtype=float)
        if known is not None and abs(known.mean()) > 1e-6 * max(np.abs(known).max(), 1e-300):
            raise ValueError(f"profile has the mean {known.mean():.6g}; give one of mean 0: n₀ is the mean speed")

    def _spread(self) -> float:
        """As the attribute says, of known numbers, which make a speed above zero."""
        terms = float(self.amplitude) * np.asarray(self._terms())
        count = np.shape(terms)[1]
        angle = 2 * np.pi / (_FINER * (2 * count + 1)) * np.arange(1, count + 1)
        angle = angle * np.arange(_FINER * (2 * count + 1))[:, None]
        change = np.cos(angle) @ terms[0] + np.sin(angle) @ terms[1]
        largest = float(np.abs(change).max())
        if largest > 1 - _SLOWEST:
            raise ValueError(
                f"amplitude = {float(self.amplitude):.6g} takes the speed to {1 - largest:.3g} of its mean; "
                f"give one that leaves {_SLOWEST:g} of it"
            )
        return min(ceil(largest * _STEPS - _ROUNDING) / _STEPS, 1 - _SLOWEST)


def _at_angle(coefficient: Coefficient, rotation: Any, repeats: Any) -> Any:
    """A coefficient of even turning, of one that varies."""
    return coefficient if coefficient.constant else AtAngle(coefficient, rotation, repeats)


def check_variation(variation: Any) -> None:
    """Require a speed variation as such."""
    if variation is not None and not isinstance(variation, SpeedVariation):
        raise ValueError(
            f"speed_variation = {_checks.brief(variation)}; give lobex.SpeedVariation(amplitude, frequency_ratio)"
        )


@pytree(static=("cycles",))
class Varied:
    """A spindle that varies its speed: a ``Rotation``.

    Attributes:
        terms: by which the speed exceeds its mean, over it: cosines and sines of a variation, (2, K).
        cycles: variations in the period.
    """

    terms: Float[AnyArray, "2 K"]
    cycles: int

    def turned(self, phase: Float[AnyArray, " *k"]) -> Float[AnyArray, " *k"]:
        order = np.arange(1, jnp.shape(self.terms)[1] + 1)
        begun = jnp.sum(self.terms[1] / (2 * np.pi * order))
        return phase + (self._ahead(phase) + begun) / self.cycles

    def pace(self, phase: Float[AnyArray, " *k"]) -> Float[AnyArray, " *k"]:
        cosine, sine = self._waves(phase)
        return 1 + cosine @ self.terms[0] + sine @ self.terms[1]

    def since(self, phase: Float[AnyArray, " *k"], share: Float[AnyArray, " *k"]) -> Float[AnyArray, " *k"]:
        phase, share = jnp.broadcast_arrays(jnp.asarray(phase), jnp.asarray(share))
        one, turn, part = jax.lax.stop_gradient((self, phase.ravel(), share.ravel()))
        known = jax.vmap(one._since)(turn, part).reshape(share.shape)
        # One more step of Newton's method, by which derivatives come out right.
        return known - (self._turned_since(phase, known) - share) / jax.lax.stop_gradient(self.pace(phase - known))

    def _since(self, phase: Float[Array, ""], share: Float[Array, ""]) -> Float[AnyArray, ""]:
        order = jnp.arange(1, jnp.shape(self.terms)[1] + 1)
        farthest = 2 * jnp.sum(jnp.linalg.norm(self.terms, axis=0) / (2 * jnp.pi * order)) / self.cycles

        def missed(at: tuple[Any, Any], lag: Any) -> tuple[Any, Any]:
            phase, share = at
            return self._turned_since(phase, lag) - share, self.pace(phase - lag)

        even = share / self.pace(phase)
        start = jnp.clip(even, share - farthest, share + farthest)
        tolerance = float(jnp.finfo(share.dtype).eps)
        return bracketed_root(missed, (phase, share), share - farthest, share + farthest, True, start, tolerance)

    def _turned_since(self, phase: Float[AnyArray, " *k"], lag: Float[AnyArray, " *k"]) -> Float[AnyArray, " *k"]:
        return lag + (self._ahead(phase) - self._ahead(phase - lag)) / self.cycles

    def _ahead(self, phase: Float[AnyArray, " *k"]) -> Float[AnyArray, " *k"]:
        """By how much it is ahead of even turning, in variations, of a spindle that is not where it began."""
        order = np.arange(1, jnp.shape(self.terms)[1] + 1)
        cosine, sine = self._waves(phase)
        return (sine @ (self.terms[0] / order) - cosine @ (self.terms[1] / order)) / (2 * jnp.pi)

    def _waves(self, phase: Float[AnyArray, " *k"]) -> tuple[Float[AnyArray, "*k K"], Float[AnyArray, "*k K"]]:
        order = np.arange(1, jnp.shape(self.terms)[1] + 1)
        angle = 2 * jnp.pi * order * jnp.mod(self.cycles * jnp.asarray(phase), 1.0)[..., None]
        return jnp.cos(angle), jnp.sin(angle)
