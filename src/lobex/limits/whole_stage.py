"""The exact limit of blades, each in the track of the one before it, that more than their tracks couple: of any stage.

With the receptances G of all blades together −1/K is an eigenvalue of A(ω) = G (I − P) on the boundary, P from each
blade to the one before it with e^{−jωτⱼ}. Along ω its eigenvalues are followed in cells, as those of several contacts
are, and the least K is that of all places where one of them crosses the negative real axis.
"""

from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Bool, Complex, Float, Real

from lobex import _checks
from lobex._missing import where_there
from lobex._namespace import namespace
from lobex._shapes import AnyArray, Numbers
from lobex.limits.eigenvalue_branches import POWERS, smooth_cells
from lobex.limits.sections import Sections, modal_response
from lobex.limits.several_contacts import numbers_of

# Of the highest frequency, up to where a limit is sought first.
_TOP = 1.5
# Eigenvalues that are smaller, in units of the largest, are rounding.
_NOTHING = 1e-12
# Of a cell, by how much a crossing may lie beyond its ends; and of its root, what is left of an imaginary part.
_BEYOND, _REAL = 1e-9, 1e-7
_STEPS = 4
_TIE, _SAME = 1e-9, 1e-6


class WholeStage(NamedTuple):
    """Blades with forces −K [yⱼ − yⱼ₋₁(t − τⱼ)], the sum of τⱼ one revolution, that disc or casing couple.

    Attributes:
        receptance: G of all blades, with weights (n, N, N), each after the one whose track it is in.
        lag: τⱼ, (N,), in revolutions.
        mode: the number, from 1, of the mode that each section is of, (n,).
    """

    receptance: Sections
    lag: Float[AnyArray, " N"]
    mode: Real[np.ndarray, " n"]


def limits_of_stage(
    stage: WholeStage, speed: Float[AnyArray, " s"]
) -> tuple[Float[AnyArray, " s"], Float[AnyArray, " s"], Bool[np.ndarray, " s"]]:
    """The least K on the boundary at speeds (s,), Hz, NaN where there is none; ω there; and whether two are a tie.

    Differentiable once, outside ``jit`` and ``vmap``: a step of Newton's method from the place carries it.
    """
    known, still = numbers_of(stage), np.asarray(numbers_of(speed), dtype=float)
    found = [_least(known, float(one)) for one in still]
    omega, tie = np.array([one[1] for one in found]), np.array([one[2] for one in found])
    there = np.isfinite(omega)
    at = np.where(there, omega, known.receptance.angular_frequency[0])
    sides = [_vectors(known, *point) for point in zip(still, at, (one[0] for one in found), strict=True)]
    left, right = (np.stack(side) for side in zip(*sides, strict=True))
    settle = jax.jit(_settled) if _checks.is_traced((stage, speed)) else _settled
    gain, omega = settle(stage, speed, at, left, right)
    return where_there(there, gain), where_there(there, omega), tie & there


def _response(
    stage: WholeStage, speed: Numbers, anchor: Float[AnyArray, " c"], offset: Float[AnyArray, "c p"]
) -> tuple[Complex[AnyArray, "c p N N"], Complex[AnyArray, "c p N N"]]:
    """A and its derivative by ω, at offsets (c, p) from anchors (c,), rad/s, and a speed or one of each, (c,)."""
    sections, omega = stage.receptance, anchor[:, None] + offset
    lib = namespace(stage, speed, omega)
    distance = (lib.asarray(sections.angular_frequency) - anchor[:, None])[:, None] - offset[..., None]
    response, slope, _ = modal_response(sections, distance, omega)
    delay = lib.asarray(stage.lag) / lib.reshape(speed, (-1, 1, 1, 1))
    late = lib.exp(-1j * omega[..., None, None] * delay)

    def met(part: Any) -> Any:
        """What of a force on each blade the one after it meets."""
        return lib.roll(part * late, -1, axis=-1)

    return response - met(response), slope - met(slope - 1j * delay * response)


def _least(stage: WholeStage, speed: float) -> tuple[float, float, bool]:
    """The least K at a speed, its ω, and whether another one is a tie; NaN where there is none."""
    sections = stage.receptance
    own = np.unique(np.asarray(sections.angular_frequency))
    low, top = 0.0, _TOP * own[-1]
    gains, places = np.empty(0), np.empty(0)
    while True:
        more = _crossings(stage, speed, own, low, top)
        gains, places = np.append(gains, more[0]), np.append(places, more[1])
        # Beyond no eigenvalue is larger than twice the receptance, which falls there.
        if gains.size and 2 * _size(stage, top) * np.min(gains) < 1:
            break
        if top > 1e3 * own[-1]:
            break
        low, top = top, 2 * top
    if not gains.size:
        return np.nan, np.nan, False
    least = np.argmin(gains)
    near = gains <= gains[least] * (1 + _TIE)
    return (
        float(gains[least]),
        float(places[least]),
        bool(np.any(near & (np.abs(places - places[least]) > _SAME * places[least]))),
    )


def _size(stage: WholeStage, omega: float) -> float:
    """A bound of |G| beyond ω, above all resonances."""
    sections = stage.receptance
    own = np.asarray(sections.angular_frequency)
    weight = np.linalg.norm(sections.weight, axis=(1, 2))
    rate = 0.0 if sections.rate is None else np.linalg.norm(sections.rate, axis=(1, 2))
    return float(np.sum((weight + omega * rate) / (omega**2 - own**2)))


def _crossings(
    stage: WholeStage, speed: float, own: Float[np.ndarray, " n"], low: float, top: float
) -> tuple[Float[np.ndarray, " k"], Float[np.ndarray, " k"]]:
    """K and ω of all places from low to top, rad/s, where an eigenvalue crosses the negative real axis."""
    edges = np.concatenate([[0.0], (own[1:] + own[:-1]) / 2, [np.inf]])
    anchor = np.repeat(own, 2)
    starts, ends = (
        np.clip(np.column_stack(pair).ravel(), low, top) - anchor for pair in ((edges[:-1], own), (own, edges[1:]))
    )

    def eigenvalues(anchor: np.ndarray, offset: np.ndarray) -> np.ndarray:
        return np.linalg.eigvals(_response(stage, speed, anchor, offset)[0])

    anchor, middle, half, value = smooth_cells(eigenvalues, anchor, starts, ends)
    size = np.max(np.abs(value), axis=1)
    coefficients = np.einsum("kp,cpm->kcm", POWERS, value)
    # The sum of a polynomial's other coefficients bounds how far it goes beyond its middle.
    further = np.sum(np.abs(coefficients[1:].real), axis=0), np.sum(np.abs(coefficients[1:].imag), axis=0)
    may = (coefficients[0].real < further[0]) & (np.abs(coefficients[0].imag) <= further[1] * (1 + _BEYOND))
    cell, branch = np.nonzero(may & (size > _NOTHING * np.max(size)))
    gains, places = [], []
    for c, b in zip(cell, branch, strict=True):
        polynomial = coefficients[:, c, b]
        root = np.polynomial.polynomial.polyroots(polynomial.imag)
        place = root.real[(np.abs(root.imag) < _REAL) & (np.abs(root.real) <= 1 + _BEYOND)]
        real = np.polynomial.polynomial.polyval(place, polynomial.real)
        gains.append(-1 / real[real < 0])
        places.append(anchor[c] + middle[c] + half[c] * place[real < 0])
    return np.concatenate([np.empty(0), *gains]), np.concatenate([np.empty(0), *places])


def _vectors(
    stage: WholeStage, speed: float, omega: float, gain: float
) -> tuple[Complex[np.ndarray, " N"], Complex[np.ndarray, " N"]]:
    """Left and right, xᵀ y = 1, of the eigenvalue next to −1/K."""
    matrix = _response(stage, speed, np.array([omega]), np.zeros((1, 1)))[0][0, 0]
    values, right = np.linalg.eig(matrix)
    mine = np.argmin(np.abs(values + 1 / gain)) if np.isfinite(gain) else 0
    return np.linalg.inv(right)[mine], right[:, mine]


def _settled(
    stage: WholeStage,
    speed: Float[AnyArray, " s"],
    omega: Float[np.ndarray, " s"],
    left: Complex[np.ndarray, "s N"],
    right: Complex[np.ndarray, "s N"],
) -> tuple[Float[AnyArray, " s"], Float[AnyArray, " s"]]:
    """K and ω from ω beside them: to the second order in how far that is, and with first derivatives."""
    lib = namespace(stage, speed)
    parts = _response(stage, speed, omega, np.zeros((len(omega), 1)))
    value, rate = (lib.einsum("sn,snm,sm->s", left, part[:, 0], right) for part in parts)
    step = -value.imag / rate.imag
    return -1 / (value + step * rate).real, omega + step
