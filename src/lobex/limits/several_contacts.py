"""The exact limit of several contacts: found on the branches of the eigenvalues, settled on the eigenvalue itself."""

from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from lobex import _checks
from lobex._compiled import compiled
from lobex._missing import where_there
from lobex._namespace import namespace
from lobex._shapes import AnyArray, Numbers
from lobex.limits.eigenvalue_branches import EigenvalueBranches, eigenvalue_branches
from lobex.limits.phase import half_turn_rate, half_turns
from lobex.limits.sections import Sections, modal_response, on_boundary

_STEPS = 3
# Of the frequency, how far a branch may be from what it stands for.
_ASIDE = 1e-6
# Two eigenvalues within this relative distance are a tie.
_TIE = 1e-9


class Branched(NamedTuple):
    """As ``Regeneration``, with the eigenvalues of a receptance for one."""

    receptance: EigenvalueBranches
    stiffness: float = 1.0


class _Root(NamedTuple):
    """Where an eigenvalue is on the boundary.

    Attributes:
        left, right: its vectors.
        anchor, offset: ω as the sum of both.
        lobe: the whole turns of the phase.
    """

    left: Complex[AnyArray, "*lanes m"]
    right: Complex[AnyArray, "*lanes m"]
    anchor: Float[AnyArray, " *lanes"]
    offset: Float[AnyArray, " *lanes"]
    lobe: Int[AnyArray, " *lanes"]


def branched(sections: Sections, speed: Numbers) -> tuple[Branched, Float[np.ndarray, " *lanes"]]:
    """The eigenvalues of a receptance, and the speeds, Hz, up to which they serve, as the numbers that they are.

    Raises:
        ValueError: where JAX does not know these, as within ``jit`` and ``vmap``.
    """
    known, still = numbers_of((sections, speed))
    return Branched(eigenvalue_branches(known, 2 * np.pi * np.max(still, initial=0.0))), still


def settled(
    sections: Sections,
    speed: Numbers,
    still: Float[np.ndarray, " *lanes"],
    gain: Float[AnyArray, " *lanes"],
    omega: Float[AnyArray, " *lanes"],
    lobe: Int[AnyArray, " *lanes"],
    tie: Bool[AnyArray, " *lanes"],
) -> tuple[Float[AnyArray, " *lanes"], Float[AnyArray, " *lanes"], Int[AnyArray, " *lanes"], Bool[AnyArray, " *lanes"]]:
    """Gain, ω, lobe and tie from those of the branches: to rounding, and with their first derivative.

    With the vectors of an eigenvalue λ, xᵀ y = 1, it is xᵀ G y, and so is its derivative.

    Args:
        sections: G of the contacts.
        speed: (…), Hz, and ``still`` what of it is a number.
    """
    there = np.isfinite(gain)
    known = numbers_of(sections)
    omega = np.where(there, omega, known.angular_frequency[0])
    # Beside a sharp resonance the distance from it keeps its digits, see ``ReceptanceCurve``.
    nearest = np.argmin(np.abs(known.angular_frequency - omega[..., None]), axis=-1)
    anchor = known.angular_frequency[nearest]
    offset = omega - anchor
    # On the boundary 1 + K λ (1 − e^{−jωτ}) = 0.
    value = -1 / (np.where(there, gain, 1.0) * (1 - np.exp(-1j * np.where(there, omega / still, 1.0))))
    for _ in range(_STEPS):
        left, right, _ = _vectors(known, anchor, offset, value)
        value, miss, rate = _missed(known, still, _Root(left, right, anchor, offset, lobe))
        step = miss / np.where(rate == 0, np.inf, rate)
        offset = offset - np.where(np.abs(step) < _ASIDE * omega, step, 0.0)
    left, right, twice = _vectors(known, anchor, offset, value)
    found = _carried if _checks.is_traced((sections, speed)) else _on_the_boundary
    gain, omega = found(sections, speed, _Root(left, right, anchor, offset, lobe))
    return where_there(there, gain), where_there(there, omega), lobe, tie | twice & there


def _on_the_boundary(
    sections: Sections, speed: Numbers, root: _Root
) -> tuple[Float[AnyArray, " *lanes"], Float[AnyArray, " *lanes"]]:
    """Gain and ω of a root."""
    return on_boundary(_missed(sections, speed, root)[0].real), root.anchor + root.offset


@compiled
def _carried(
    sections: Sections, speed: Numbers, root: _Root
) -> tuple[Float[AnyArray, " *lanes"], Float[AnyArray, " *lanes"]]:
    """As above, with derivatives: a step of Newton's method from the root carries them."""
    _, miss, rate = _missed(sections, speed, root)
    offset = root.offset - (miss - jax.lax.stop_gradient(miss)) / rate
    return _on_the_boundary(sections, speed, root._replace(offset=offset))


def numbers_of(tree: Any) -> Any:
    """What ``grad`` traces as the numbers that it is, in NumPy."""

    def one(leaf: Any) -> np.ndarray:
        # Of what is not traced it would be one of single precision.
        still = jax.lax.stop_gradient(leaf) if _checks.is_traced(leaf) else leaf
        if _checks.is_traced(still):
            raise ValueError(
                "process has several contact directions, and its numbers are traced by JAX; call exact_limit outside "
                "jit and vmap, within grad alone, or give critical_gain"
            )
        return np.asarray(still, dtype=float)

    return jax.tree.map(one, tree)


def _vectors(
    sections: Sections,
    anchor: Float[AnyArray, " *lanes"],
    offset: Float[AnyArray, " *lanes"],
    expected: Complex[AnyArray, " *lanes"],
) -> tuple[Complex[np.ndarray, "*lanes m"], Complex[np.ndarray, "*lanes m"], Bool[np.ndarray, " *lanes"]]:
    """Of the eigenvalue nearest to the one expected, (…), the vectors x and y, and whether it has a double."""
    values, vectors = np.linalg.eig(_responses(sections, anchor, offset)[0])
    nearest = np.argmin(np.abs(values - expected[..., None]), axis=-1)[..., None]
    value = np.take_along_axis(values, nearest, axis=-1)
    double = np.sum(np.abs(values - value) <= _TIE * np.abs(value), axis=-1) > 1
    left = np.take_along_axis(np.linalg.inv(vectors), nearest[..., None], axis=-2)[..., 0, :]
    return left, np.take_along_axis(vectors, nearest[..., None], axis=-1)[..., 0], double


def _missed(
    sections: Sections, speed: Numbers, root: _Root
) -> tuple[Complex[AnyArray, " *lanes"], Float[AnyArray, " *lanes"], Float[AnyArray, " *lanes"]]:
    """λ, by how many turns the phase misses that of the lobe, and the derivative of that by ω."""
    lib, responses = namespace(sections, root.offset), _responses(sections, root.anchor, root.offset)[:2]
    response, slope = (lib.einsum("...i,...ij,...j", root.left, part, root.right) for part in responses)
    rate = 1 / (2 * np.pi * speed)
    turns = (root.anchor * rate - root.lobe) + root.offset * rate
    return response, turns + half_turns(response), rate + half_turn_rate(response, slope)


def _responses(
    sections: Sections, anchor: Float[AnyArray, " *lanes"], offset: Float[AnyArray, " *lanes"]
) -> tuple[Complex[AnyArray, "*lanes m m"], Complex[AnyArray, "*lanes m m"], Complex[AnyArray, "*lanes m m"]]:
    lib = namespace(sections, offset)
    distance = (lib.asarray(sections.angular_frequency) - anchor[..., None]) - offset[..., None]
    return modal_response(sections, distance, anchor + offset)
