"""One eigenvalue of a matrix, with its vectors, and how it moves with the matrix."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Complex, Inexact
from scipy.linalg import eig


class SimpleEigenvalue(NamedTuple):
    """λ with M v = λ v, w M = λ w and w v = 1."""

    value: complex
    right: Complex[np.ndarray, " n"]
    left: Complex[np.ndarray, " n"]


def next_to(wanted: complex, matrix: Inexact[np.ndarray, "n n"]) -> SimpleEigenvalue:
    """The eigenvalue of a matrix that is next to ``wanted``."""
    found: Any = eig(matrix, left=True, right=True)
    values, left, right = found
    mine = int(np.argmin(np.abs(values - wanted)))
    vector, other = right[:, mine], np.conj(left[:, mine])
    return SimpleEigenvalue(complex(values[mine]), vector, other / (other @ vector))


def moved_by(
    found: SimpleEigenvalue,
    matrix: Inexact[np.ndarray, "n n"],
    slope: Inexact[np.ndarray, "n n"],
    bend: Inexact[np.ndarray, "n n"],
) -> tuple[complex, complex]:
    """λ′ = w M′ v and λ″ = w (M″ v + 2 M′ v′), of a matrix with its derivatives.

    v′ is that of the vector which keeps its share along w, w v′ = 0: (λ − M) v′ = M′ v − λ′ v.
    """
    size = len(matrix)
    pushed = slope @ found.right
    first = found.left @ pushed
    # Bordered by both vectors it has an inverse.
    bordered = np.zeros((size + 1, size + 1), complex)
    bordered[:size, :size] = found.value * np.eye(size) - matrix
    bordered[:size, size], bordered[size, :size] = found.right, found.left
    along = np.linalg.solve(bordered, np.append(pushed - first * found.right, 0.0))[:size]
    return complex(first), complex(found.left @ (bend @ found.right + 2 * slope @ along))
