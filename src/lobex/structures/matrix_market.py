"""A matrix from a Matrix Market file (Boisvert, Pozo and Remington, NISTIR 5935, 1996)."""

import os
from typing import Any

import numpy as np
import scipy.io
from scipy import sparse

from lobex import _checks


def read_matrix_market(path: str | os.PathLike[str]) -> sparse.csc_array:
    """The real square matrix of a file, as scipy's sparse array: ``Modes.from_matrices`` takes it.

    Args:
        path: of the file, a ``.mtx``, or ``.mtx.gz``.

    Raises:
        ValueError: for a file that cannot be read or is no Matrix Market, and a matrix that is complex or not square.
    """
    place = _checks.place("path", path)
    try:
        matrix: Any = scipy.io.mmread(place, spmatrix=False)
    except OSError as error:
        raise ValueError(f"path = {str(path)!r} cannot be read ({error.strerror or error}); give a .mtx file") from None
    except (ValueError, OverflowError, EOFError) as error:
        why = str(error).splitlines()[0]
        raise ValueError(f"path = {str(path)!r} is no Matrix Market ({why}); give one that begins so") from None
    if np.iscomplexobj(matrix):
        raise ValueError(f"path = {str(path)!r} has a complex matrix; give a real one")
    if len(set(matrix.shape)) != 1:
        raise ValueError(f"path = {str(path)!r} has a matrix of shape {matrix.shape}; give a square one")
    return sparse.csc_array(matrix, dtype=float)
