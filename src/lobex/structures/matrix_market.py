"""A matrix from a Matrix Market file (Boisvert, Pozo and Remington, NISTIR 5935, 1996)."""

import bz2
import gzip
import os
import re
import zlib
from io import BytesIO
from typing import Any

import numpy as np
import scipy.io
from scipy import sparse

from lobex import _checks

_OPENERS = {".gz": gzip.open, ".bz2": bz2.open}
_BODY = re.compile(rb"^[ \t]*[^%\s]", re.MULTILINE)
_STRANGE = re.compile(rb"[^0-9+\-.eE\s]\S*")


def read_matrix_market(path: str | os.PathLike[str]) -> sparse.csc_array:
    """The real square matrix of a file, as scipy's sparse array: ``Modes.from_matrices`` takes it.

    Exponents may be those of Fortran's double precision, 1.5D+03.

    Args:
        path: of the file, a ``.mtx``, or ``.mtx.gz``.

    Raises:
        ValueError: for a file that cannot be read, is no Matrix Market, has what is no finite number, or says of itself
            that it is larger than memory, and a matrix that is complex, without numbers or not square, or
            has two entries of one place.
    """
    place = _checks.place("path", path)
    try:
        with _OPENERS.get(place.suffix, open)(place, "rb") as file:
            text = file.read()
    except (OSError, EOFError, zlib.error) as error:
        why = getattr(error, "strerror", None) or error
        raise ValueError(f"path = {str(path)!r} cannot be read ({why}); give a .mtx file") from None
    begins = _BODY.search(text)
    start = len(text) if begins is None else begins.start()
    # Of what follows a number in its field scipy says nothing.
    body = text[start:].replace(b"D", b"E").replace(b"d", b"e")
    try:
        matrix: Any = scipy.io.mmread(BytesIO(text[:start] + body), spmatrix=False)
    except (ValueError, OverflowError, MemoryError) as error:
        why = str(error).splitlines()[0]
        raise ValueError(f"path = {str(path)!r} is no Matrix Market ({why}); give one that begins so") from None
    if strange := _STRANGE.search(body):
        line = 1 + text[:start].count(b"\n") + body[: strange.start()].count(b"\n")
        word = strange[0].decode(errors="replace")
        raise ValueError(f"path = {str(path)!r}, line {line}: {word!r} is no number, or part of none; give finite ones")
    if b"pattern" in text[:start].splitlines()[0].lower().split():
        raise ValueError(f"path = {str(path)!r} has a pattern without numbers; give a real matrix")
    if np.iscomplexobj(matrix):
        raise ValueError(f"path = {str(path)!r} has a complex matrix; give a real one")
    if len(set(matrix.shape)) != 1:
        raise ValueError(f"path = {str(path)!r} has a matrix of shape {matrix.shape}; give a square one")
    once = sparse.csc_array(matrix, dtype=float)
    if sparse.issparse(matrix) and once.nnz < matrix.nnz:
        raise ValueError(
            f"path = {str(path)!r} has two entries of a row and column; give one, of one triangle if symmetric"
        )
    return once
