"""The last digits of roots, from the characteristic equation itself."""

from collections.abc import Callable
from functools import partial
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from lobex._batches import in_one_size
from lobex._compiled import compiled
from lobex.characteristic.function import Contact, response
from lobex.characteristic.lanes import placed, take
from lobex.characteristic.open_loop import weighted

# Of a sum of rounded terms.
_ULPS = 4.0
_AWAY = 10.0


def polish(
    contact: Contact, lane: Int[Any, " k"], gain: Float[Any, " k"], root: Complex[Any, " k"]
) -> tuple[Complex[Any, " k"], Float[Any, " k"]]:
    """Roots z of the lanes' contacts at gains, (k,), and how far off they may be, from the last step and rounding.

    What is a root at every gain, since the contact does not see it, is left as it is.
    """
    steps = _polish if contact.lag is None else _polish_several
    better, error, stays = in_one_size(partial(steps, placed(contact.filled())), (lane, gain, root))
    still = stays | ~np.isfinite(better) | ~(np.abs(better - root) < 1e-6 * (1 + np.abs(root)))
    better = np.where(still, root, better)
    error = np.where(still, _ULPS * np.finfo(float).eps * _largest_pole(contact)[lane], error)
    return better.real + 1j * np.abs(better.imag), error


def _largest_pole(contact: Contact) -> Float[Any, " l"]:
    """A bound of every pole, (lanes,), by Fujiwara's (1916)."""
    size = np.shape(contact.denominator)[1]
    root = np.abs(contact.denominator) ** (1 / np.arange(size, 0, -1))[:, None]
    return 1 + 2 * np.max(root, axis=(0, 1))


@compiled
def _polish(
    contacts: Contact, lane: Int[Any, " k"], gain: Float[Any, " k"], z: Complex[Any, " k"]
) -> tuple[Complex[Any, " k"], Float[Any, " k"], Bool[Any, " k"]]:
    """Two steps on log M(z) − z, whose terms cannot overflow."""
    contact = take(contacts, lane)
    feedback = gain * contact.present, gain * contact.delayed
    sizes = [jnp.abs(part) for part in feedback]

    def rest(z: Complex[Any, " k"]) -> tuple[Complex[Any, " k"], Complex[Any, " k"], Float[Any, " k"]]:
        at = response(contact, z)
        (now, now_slope), (before, slope) = ([weighted(part, of) for of in at[:2]] for part in feedback)
        doubt, doubt_before = (weighted(part, at.rounding) for part in sizes)
        opened = 1 - now
        value = jnp.log(before / opened) - z
        value = value - 2j * jnp.pi * jnp.round(value.imag / (2 * jnp.pi))
        rounding = doubt_before / jnp.abs(before) + doubt / jnp.abs(opened) + 1 + jnp.abs(z)
        return value, slope / before + now_slope / opened - 1, rounding

    return _two_steps(rest, z)


@compiled
def _polish_several(contacts: Contact, lane: Any, gain: Any, z: Any) -> tuple[Any, Any, Any]:
    """As ``_polish`` of several delays, on F = 1 + K L."""
    contact = take(contacts, lane)

    def rest(z: Any) -> tuple[Any, Any, Any]:
        at = response(contact, z)
        before, fading = contact.before(z)
        whole = [p + b for p, b in zip(contact.present, before, strict=True)]
        value = 1 - gain * weighted(whole, at.value)
        slope = gain * (weighted(fading, at.value) - weighted(whole, at.slope))
        sizes = [jnp.abs(p) + jnp.abs(b) for p, b in zip(contact.present, before, strict=True)]
        terms = weighted(
            sizes, [of + (1 + jnp.abs(z)) * jnp.abs(one) for of, one in zip(at.rounding, at.value, strict=True)]
        )
        return value, slope, 1 + jnp.abs(gain) * terms

    return _two_steps(rest, z)


def _two_steps(
    rest: Callable[[Any], tuple[Any, Any, Any]], z: Complex[Any, " k"]
) -> tuple[Complex[Any, " k"], Float[Any, " k"], Bool[Any, " k"]]:
    """Two of Newton's steps on what ``rest`` says at z: value, slope, and rounding in units of it; how far off they may
    leave z, and whether they lead away from the root.
    """
    machine = jnp.finfo(z.dtype)
    value, slope, _ = rest(z)
    first = value / slope
    z = z - first
    value, slope, rounding = rest(z)
    second = value / slope
    # A third step would be less by more than the second is less than the first.
    share = jnp.minimum(jnp.abs(second) / jnp.maximum(jnp.abs(first), machine.tiny), 1.0)
    error = share * jnp.abs(second) + _ULPS * machine.eps * rounding / jnp.abs(slope)
    # From a pole that is a root to rounding each step leads further.
    return z - second, error, jnp.abs(second) > _AWAY * jnp.abs(first)
