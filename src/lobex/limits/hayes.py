"""The exact stability limits of Hayes' equation ẋ(t) = a x(t) + b x(t − τ)."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Real

from lobex import _checks
from lobex._compiled import compiled
from lobex._float64 import in_float64
from lobex._missing import where_there, with_stand_in
from lobex._pytree import pytree
from lobex._shapes import AnyArray, ArrayLike

# From its side Newton's method converges monotonically; a double root, at aτ = 1, halves the error a step.
_STEPS = 40


@pytree()
class HayesInterval:
    """The gains b that are stable, lower < b < upper; NaN where none is, from aτ = 1.

    Attributes:
        lower: where a pair ±jω crosses, 1/s.
        upper: −a, where a real root crosses, 1/s.
        angular_frequency: ω at the lower end, in (0, π/τ), rad/s.
    """

    lower: Float[AnyArray, " *lanes"]
    upper: Float[AnyArray, " *lanes"]
    angular_frequency: Float[AnyArray, " *lanes"]


def hayes_interval(a: ArrayLike, speed: ArrayLike) -> HayesInterval:
    """Stable gains of ẋ = a x(t) + b x(t − τ), τ = 1/speed (Hayes, J. London Math. Soc. 25, 1950).

    With θ = ωτ in (0, π), aτ = θ cot θ and bτ = −θ/sin θ at the lower end. Differentiable with respect to
    both arguments.

    Args:
        a: a, 1/s, any shape.
        speed: 1/τ, Hz, broadcast against ``a``.

    Raises:
        ValueError: for values that are not finite, speeds not above zero, or shapes that do not broadcast.
    """
    a, speed = (np.asarray(v) if isinstance(v, list | tuple) else v for v in (a, speed))
    _checks.as_numbers("a", a, "1/s")
    _checks.positive("speed", speed, "Hz")
    try:
        np.broadcast_shapes(np.shape(a), np.shape(speed))
    except ValueError:
        raise ValueError(f"a has shape {np.shape(a)} and speed {np.shape(speed)}; give shapes that broadcast") from None
    return HayesInterval(*_interval(a, speed))


@in_float64
@compiled
def _interval(
    a: Real[AnyArray, "..."], speed: Real[AnyArray, "..."]
) -> tuple[Float[AnyArray, " *lanes"], Float[AnyArray, " *lanes"], Float[AnyArray, " *lanes"]]:
    a, speed = jnp.broadcast_arrays(*(jnp.asarray(v, dtype=jnp.result_type(float)) for v in (a, speed)))
    scaled = a / speed
    exists = scaled < 1
    scaled = with_stand_in(exists, scaled, 0.0)

    # θ − arg(aτ + jθ): convex and started right of its root for a > 0, concave and started left for a < 0.
    def improve(theta: Any, scaled: Float[AnyArray, " *lanes"]) -> Any:
        value = theta - jnp.arctan2(theta, scaled)
        return theta - value / (1 - scaled / (scaled**2 + theta**2))

    still = jax.lax.stop_gradient(scaled)
    start = jnp.minimum(jnp.pi / 2, jnp.sqrt(3 * (1 - still)))
    theta = jax.lax.fori_loop(0, _STEPS, lambda _, t: improve(t, still), start)
    for _ in range(2):
        theta = improve(theta, scaled)
    omega = theta * speed
    # |b| = |jω − a| keeps its digits where sin θ does not.
    lower = -jnp.sqrt(omega**2 + a**2)
    lower, upper, omega = (where_there(exists, r) for r in (lower, -a, omega))
    return lower, upper, omega
