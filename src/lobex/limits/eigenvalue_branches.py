"""The eigenvalues of a receptance of several contacts along the frequency axis, as branches that are smooth in cells.

A contact with every force −K [y − y(t − τ)] has 1 + K λ(ω)(1 − e^{−jωτ}) = 0 for an eigenvalue λ of G(ω): what is
asked of the receptance of one contact is asked of each of them. In a cell of the axis every eigenvalue is a polynomial
of the frequency, interpolated at Chebyshev's points, and a cell is divided until their last coefficients say that
nothing of them is left out. Eigenvalues that pass each other need no name that lasts beyond their cell; where they
all but meet, the place in between is looked at too.
"""

from collections.abc import Callable
from typing import Any, cast

import jax
import numpy as np
from jaxtyping import Array, Bool, Complex, Float, Int

from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray
from lobex.characteristic.lanes import few
from lobex.limits.sections import Sections, modal_response

_DEGREE = 10
# Of the last coefficients, in units of the largest value of the branch, and of any.
_RESOLVED, _NOISE = 1e-11, 1e-14
# Eigenvalues that are smaller, in units of the largest, are rounding.
_NOTHING = 1e-12
# Two branches that come so near to each other are looked at there.
_NEAR = 0.1
_ROUNDS = 60
# A cell that is no wider than so many units of rounding is taken as it is.
_NARROWEST = 64
# Of the highest frequency: beyond it the structure is a mass.
_REACH = 100.0
# By how much a cell overlaps the next, of its width, and in how many parts it is looked at.
_OVERLAP = 1e-9
_PARTS = 4
# The fewest rows: programs are compiled for their number.
_ROWS = 768

Eigenvalues = Callable[[np.ndarray, np.ndarray], np.ndarray]

_ANGLE = np.pi * np.arange(_DEGREE + 1) / _DEGREE
_PLACE = -np.cos(_ANGLE)
POWERS = np.linalg.inv(np.vander(_PLACE, increasing=True))
"""From values at the points of a cell to coefficients of powers."""
_CHEBYSHEV = np.linalg.inv(np.polynomial.chebyshev.chebvander(_PLACE, _DEGREE))


@pytree()
class EigenvalueBranches:
    """Eigenvalues of G along the frequency axis: a row is one of them in one cell.

    Attributes:
        anchor: the frequency that offsets of a row are from, (rows,), rad/s.
        middle: the offset of the middle of its cell, (rows,).
        half: half its width, (rows,).
        coefficients: of powers of (offset − middle)/half, (degree + 1, rows), complex.
    """

    anchor: Float[AnyArray, " rows"]
    middle: Float[AnyArray, " rows"]
    half: Float[AnyArray, " rows"]
    coefficients: Complex[AnyArray, "terms rows"]

    turn = 0.0
    open_ended = False
    most_breaks = None

    def grid(self) -> tuple[Int[AnyArray, " points"], Float[AnyArray, " points"]]:
        lib = namespace(self)
        along = (1 + _OVERLAP) * lib.linspace(-1.0, 1.0, _PARTS + 1)
        offset = self.middle[:, None] + self.half[:, None] * along
        return lib.repeat(lib.arange(len(self.anchor)), _PARTS + 1), offset.ravel()

    def at(
        self, row: Int[AnyArray, " *points"], offset: Float[AnyArray, " *points"]
    ) -> tuple[Complex[AnyArray, " *points"], Complex[AnyArray, " *points"], Complex[AnyArray, " *points"]]:
        half = self.half[row]
        place = (offset - self.middle[row]) / half

        def add(
            sums: tuple[Complex[AnyArray, " *points"], Complex[AnyArray, " *points"], Complex[AnyArray, " *points"]],
            coefficient: Complex[AnyArray, " *points"],
        ) -> tuple[
            tuple[Complex[AnyArray, " *points"], Complex[AnyArray, " *points"], Complex[AnyArray, " *points"]], None
        ]:
            value, slope, bend = sums
            return (value * place + coefficient, slope * place + value, bend * place + 2 * slope), None

        # By a loop: one program for all of them takes long to compile.
        none = 0j * place
        (value, slope, bend), _ = jax.lax.scan(add, (none, none, none), self.coefficients[:, row], reverse=True)
        return value, slope / half, bend / half**2

    def undamped_at(
        self, row: Int[AnyArray, " *points"], offset: Float[AnyArray, " *points"]
    ) -> Bool[AnyArray, " *points"]:
        return namespace(offset).zeros(np.shape(offset), dtype=bool)


def eigenvalue_branches(sections: Sections, highest: float) -> EigenvalueBranches:
    """The branches with a real part below zero from ω = 0 on, in NumPy.

    Args:
        sections: G of m contacts, with damping.
        highest: up to which frequency past the structure's own, rad/s.
    """
    order = np.argsort(sections.angular_frequency)
    anchors: Any = np.asarray(sections.angular_frequency)[order]
    edges = np.concatenate([[0.0], (anchors[1:] + anchors[:-1]) / 2, [_REACH * anchors[-1] + highest]])
    anchor = np.repeat(anchors, 2)
    low: Any = np.column_stack([edges[:-1] - anchors, 0 * anchors]).ravel()
    high: Any = np.column_stack([0 * anchors, edges[1:] - anchors]).ravel()
    return _of_rows(*smooth_cells(lambda *at: _eigenvalues(sections, *at), anchor, low, high))


def smooth_cells(
    eigenvalues: Eigenvalues,
    anchor: Float[np.ndarray, " c"],
    low: Float[np.ndarray, " c"],
    high: Float[np.ndarray, " c"],
) -> tuple[
    Float[np.ndarray, " cells"],
    Float[np.ndarray, " cells"],
    Float[np.ndarray, " cells"],
    Complex[np.ndarray, "cells points m"],
]:
    """Cells in which eigenvalues are polynomials: the anchor, the offset of the middle, half the width, and the values
    at Chebyshev's points, in an order that is smooth.

    Args:
        eigenvalues: of offsets (c, p) from anchors (c,), (c, p, m).
        anchor: of the cells to begin with, rad/s, and
        low, high: the offsets of their ends; those of no width are left out.
    """
    anchor, low, high = (part[high > low] for part in (anchor, low, high))
    done: list[tuple[np.ndarray, ...]] = []
    for _ in range(_ROUNDS):
        middle, half = (low + high) / 2, (high - low) / 2
        value = _followed(eigenvalues(anchor, middle[:, None] + half[:, None] * _PLACE), _PLACE)
        good = _resolved(eigenvalues, anchor, middle, half, value)
        good |= half <= _NARROWEST * np.finfo(float).eps * np.maximum(np.abs(low), np.abs(high))
        done.append((anchor[good], middle[good], half[good], value[good]))
        left = ~good
        if not left.any():
            break
        anchor, low, middle, high = (part[left] for part in (anchor, low, middle, high))
        anchor, low, high = (np.concatenate(pair) for pair in ((anchor, anchor), (low, middle), (middle, high)))
    else:
        raise ValueError(
            "the receptance of the contacts has eigenvalues that no polynomials follow; give critical_gain"
        )
    anchor, middle, half, value = (np.concatenate(part) for part in zip(*done, strict=True))
    return anchor, middle, half, value


def _of_rows(
    anchor: Float[np.ndarray, " c"],
    middle: Float[np.ndarray, " c"],
    half: Float[np.ndarray, " c"],
    value: Complex[np.ndarray, "c points m"],
) -> EigenvalueBranches:
    """What of cells (c,) with values (c, points, m) may be a limit, filled up with what is none."""
    size = np.max(np.abs(value), axis=1)
    coefficients = np.einsum("kp,cpm->kcm", POWERS, value)
    # The sum of a polynomial's other coefficients bounds how far it goes beyond its middle.
    lowest = coefficients[0].real - np.sum(np.abs(coefficients[1:].real), axis=0)
    cell, branch = np.nonzero((size > _NOTHING * np.max(size, axis=1, keepdims=True)) & (lowest < 0))
    spare = few(max(len(cell), _ROWS)) - len(cell)
    nothing = np.zeros((_DEGREE + 1, spare), dtype=complex)
    nothing[0] = 1.0
    return EigenvalueBranches(
        anchor=np.pad(anchor[cell], (0, spare), constant_values=1.0),
        middle=np.pad(middle[cell], (0, spare)),
        half=np.pad(half[cell], (0, spare), constant_values=1.0),
        coefficients=np.concatenate([coefficients[:, cell, branch], nothing], axis=1),
    )


def _eigenvalues(
    sections: Sections, anchor: Float[np.ndarray, " c"], offset: Float[AnyArray, "c p"]
) -> Complex[np.ndarray, "c p m"]:
    """Of G at anchors (c,) and offsets (c, p), (c, p, m)."""
    distance = (sections.angular_frequency - anchor[:, None])[:, None] - offset[..., None]
    return np.linalg.eigvals(modal_response(sections, distance, anchor[:, None] + offset)[0])


def along(
    sections: Sections, omega: Float[AnyArray, " n"]
) -> tuple[Float[np.ndarray, " points"], Complex[np.ndarray, " points"]]:
    """The eigenvalues at ω, (n,), rad/s, one after the other with a gap between them: ω and λ, (m (n + 1),)."""
    value = _followed(_eigenvalues(sections, np.zeros(1), omega[None]), omega)[0]
    gap = np.full((1, value.shape[1]), np.nan)
    return np.tile(np.append(omega, np.nan), value.shape[1]), np.concatenate([value, gap]).T.ravel()


def _followed(value: Complex[np.ndarray, "c p m"], place: Float[AnyArray, " p"]) -> Complex[np.ndarray, "c p m"]:
    """Eigenvalues (c, p, m) in an order that is smooth along the points (p,) of each cell."""
    value = value.copy()
    for k in range(1, value.shape[1]):
        expected = value[:, k - 1]
        if k > 1:
            ratio = (place[k] - place[k - 1]) / (place[k - 1] - place[k - 2])
            expected = expected + ratio * (expected - value[:, k - 2])
        value[:, k] = np.take_along_axis(value[:, k], _matched(expected, value[:, k]), axis=1)
    return value


def _matched(expected: Complex[np.ndarray, "c m"], found: Complex[np.ndarray, "c m"]) -> Int[np.ndarray, "c m"]:
    """Which of the numbers found, (c, m), is each of those expected, (c, m): the nearest, or those nearest in sum."""
    apart = np.abs(expected[:, :, None] - found[:, None, :])
    index = np.argmin(apart, axis=2)
    twice = np.flatnonzero(np.any(np.sort(index, axis=1) != np.arange(index.shape[1]), axis=1))
    if len(twice):
        # Imported here, as that takes longer than limits of one contact.
        from scipy.optimize import linear_sum_assignment

        for cell in twice:
            index[cell] = linear_sum_assignment(apart[cell])[1]
    return index


def _resolved(
    eigenvalues: Eigenvalues,
    anchor: Float[np.ndarray, " c"],
    middle: Float[np.ndarray, " c"],
    half: Float[np.ndarray, " c"],
    value: Complex[np.ndarray, "c points m"],
) -> Bool[np.ndarray, " c"]:
    """Whether polynomials through the values (c, points, m) are the eigenvalues in cells (c,)."""
    size = np.max(np.abs(value), axis=1)
    allowed = np.maximum(_RESOLVED * size, _NOISE * np.max(size, axis=1, keepdims=True))
    last = np.abs(np.einsum("kp,cpm->ckm", _CHEBYSHEV[-3:], value))
    good = np.all(np.max(last, axis=1) <= allowed, axis=1)
    first, second = np.triu_indices(value.shape[2], 1)
    cell = np.flatnonzero(good)
    between = value[cell][:, :, first] - value[cell][:, :, second]
    slope = np.einsum("qp,cpm->cqm", _SLOPES, between)
    # From the nearest of the points to where the two come nearest.
    nearest = np.argmin(np.abs(between), axis=1)[:, None]
    here, steep = (cast(Array, np.take_along_axis(part, nearest, axis=1)[:, 0]) for part in (between, slope))
    with np.errstate(all="ignore"):
        step = -(here * steep.conj()).real / np.abs(steep) ** 2
        place = np.clip(_PLACE[nearest[:, 0]] + np.where(np.isfinite(step), step, 0.0), -1.0, 1.0)
    near = np.abs(here + step * steep) < _NEAR * np.minimum(size[cell][:, first], size[cell][:, second])
    row, pair = np.nonzero(near)
    if len(row):
        index, place = cell[row], place[row, pair]
        powers = place[:, None] ** np.arange(_DEGREE + 1)
        expected = np.einsum("rk,kp,rpm->rm", powers, POWERS, value[index])
        found = eigenvalues(anchor[index], (middle[index] + half[index] * place)[:, None])[:, 0]
        found = np.take_along_axis(found, _matched(expected, found), axis=1)
        wrong = np.any(np.abs(found - expected) > 10 * allowed[index], axis=1)
        good[index[wrong]] = False
    return good


# From values at the points to slopes there.
_SLOPES = np.vander(_PLACE, _DEGREE, increasing=True) @ (np.arange(1, _DEGREE + 1)[:, None] * POWERS[1:])
