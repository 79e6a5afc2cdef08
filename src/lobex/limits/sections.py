"""The receptance of a structure as a sum of second-order sections, and its derivatives by frequency."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float, Inexact

from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray
from lobex.structures.modes import Modes


@pytree()
class Sections:
    """G(s) = Σ (β + α s)/(s² + 2ξω s + ω²) at a contact, or at m of them a matrix.

    Attributes:
        angular_frequency: ω, (n,), rad/s.
        damping_ratio: ξ, (n,).
        weight: β, (n,), or (n, m, m), of what each contact sees of the force of each, 1/kg. Complex, as α, of what a
            wave of blades sees of waves that travel one way, which is no response to real forces alone.
        rate: α, as many, s/kg; None where no velocity is seen.
    """

    angular_frequency: Float[AnyArray, " n"]
    damping_ratio: Float[AnyArray, " n"]
    weight: Inexact[AnyArray, " n *contacts"]
    rate: Inexact[AnyArray, " n *contacts"] | None = None


def sections_of(modes: Modes) -> Sections:
    """G of modes with one contact direction."""
    if modes.directions != 1:
        raise ValueError(f"source has {modes.directions} contact directions; give modes with one")
    lib = namespace(modes)
    shape, loading = (lib.asarray(side)[:, 0] for side in (modes.shape, modes.loading))
    if not modes.complex:
        return Sections(modes.angular_frequency, modes.damping_ratio, shape * loading)
    seen, acting = (
        lib.zeros_like(shape) if side is None else lib.asarray(side)[:, 0]
        for side in (modes.quadrature, modes.force_quadrature)
    )
    weight = shape * (loading + 2 * modes.damping_ratio * acting) - seen * acting
    rate = (shape * acting + seen * loading) / modes.angular_frequency
    return Sections(modes.angular_frequency, modes.damping_ratio, weight, rate)


def sections_of_blocks(
    blocks: Float[AnyArray, "*n 2 2"], inputs: Float[AnyArray, "... 2"], seen: Float[AnyArray, "... 2"], rates: bool
) -> Sections:
    """G of ż = A z + b f, y = c z with blocks of two states that oscillate.

    Args:
        blocks: A, (…, 2, 2), with ω of the shape (…).
        inputs, seen: b and c, (…, 2), or with axes for contacts, (…, m, m, 2) together.
        rates: whether a force acts at once on what is seen of the velocities.
    """
    lib = namespace(blocks, inputs, seen)
    a00, a01, a10, a11 = (blocks[..., i, j] for i in (0, 1) for j in (0, 1))
    own = lib.sqrt(a00 * a11 - a01 * a10)
    damping_ratio = -(a00 + a11) / (2 * own)
    contacts = (1,) * (max(np.ndim(inputs), np.ndim(seen)) - np.ndim(own) - 1)
    a00, a01, a10, a11 = (part.reshape(*np.shape(part), *contacts) for part in (a00, a01, a10, a11))
    (e0, e1), (c0, c1) = ((lib.asarray(part)[..., 0], lib.asarray(part)[..., 1]) for part in (inputs, seen))
    weight = c0 * (a01 * e1 - a11 * e0) + c1 * (a10 * e0 - a00 * e1)
    rate = lib.broadcast_to(c0 * e0 + c1 * e1, np.shape(weight)) if rates else None
    return Sections(own, damping_ratio, weight, rate)


def on_boundary(value: Float[AnyArray, " *points"] | float) -> Any:
    """K = −1/(2 Re G) of a root on the imaginary axis, of Re G; and Re G of K: of its shape, (…)."""
    return -0.5 / value


def modal_response(
    sections: Sections, distance: Float[AnyArray, "*points n"], omega: Float[AnyArray, " *points"]
) -> tuple[Complex[AnyArray, "..."], Complex[AnyArray, "..."], Complex[AnyArray, "..."]]:
    """G, G′ and G″ at ω, shape (…,) or (…, m, m), where ``distance`` is ωᵢ − ω, shape (…, n)."""
    lib = namespace(sections, distance, omega)
    angular_frequency, weight = map(lib.asarray, (sections.angular_frequency, sections.weight))
    damping = 2 * lib.asarray(sections.damping_ratio) * angular_frequency
    omega = omega[..., None]
    inverse = 1 / from_parts(distance * (angular_frequency + omega), damping * omega)
    ratio = from_parts(-2 * omega, damping) * inverse
    terms = (inverse, -inverse * ratio, 2 * inverse * (ratio**2 + inverse))
    if np.ndim(weight) == 3:
        return _of_contacts(sections, terms, omega)
    parts: list[Array] = [weight * term for term in terms]
    if sections.rate is not None:
        # (β + jαω)/D, whose numerator has the slope jα.
        steep = 1j * lib.asarray(sections.rate)
        further = (0.0, terms[0], 2 * terms[1])
        parts = [part + steep * (omega * term + more) for part, term, more in zip(parts, terms, further, strict=True)]
    response, slope, bend = (lib.sum(part, axis=-1) for part in parts)
    return response, slope, bend


def _of_contacts(
    sections: Sections, terms: tuple[Complex[AnyArray, "*points n"], ...], omega: Float[AnyArray, "*points 1"]
) -> tuple[Complex[AnyArray, "*points m m"], Complex[AnyArray, "*points m m"], Complex[AnyArray, "*points m m"]]:
    """As ``modal_response``, from 1/D and its derivatives, where weights are matrices."""
    lib = namespace(sections, terms)
    response, slope, bend = (lib.tensordot(term, sections.weight, 1) for term in terms)
    if sections.rate is None:
        return response, slope, bend
    rated = omega * terms[0], omega * terms[1] + terms[0], omega * terms[2] + 2 * terms[1]
    more = [1j * lib.tensordot(term, sections.rate, 1) for term in rated]
    return response + more[0], slope + more[1], bend + more[2]


def from_parts(real: Float[AnyArray, "..."], imaginary: Float[AnyArray, "..."]) -> Complex[AnyArray, "..."]:
    """A complex number from its parts, which broadcast."""
    if namespace(real, imaginary) is np:
        return real + 1j * imaginary
    return jax.lax.complex(*jnp.broadcast_arrays(real, imaginary))
