"""Responses of named arrays: which is the frequency, which the response."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from lobex import _checks
from lobex.measured.column_roles import samples_of
from lobex.measured.response_units import frequency_scale, response_unit
from lobex.measured.samples import Samples
from lobex.measured.text_table import TextTable

ROLES = ("frequency", "complex", "coherence")
_NAMES = {
    "frequency": r"f|freq|frequency|frequencies|hz|f_hz|freq_hz|omega|w|omega_rad",
    "complex": r"frf|frfs|h|g|response|receptance|compliance|mobility|accelerance|inertance",
    "coherence": r"coh|coherence|gamma2",
}
_RADIANS = r"omega|w|omega_rad"


def samples_of_arrays(arrays: Mapping[str, np.ndarray], columns: Any, path: Path) -> Samples:
    """The responses of a file of arrays: frequency (n,), response (n,), (n, r) or (n, r, p), coherence as many.

    Args:
        arrays: by name; one of n rows alone is a table.
        columns: roles by name, or of the columns of a table, or None for what names say.
        path: named in messages.

    Raises:
        ValueError: where the names do not say what is what, or lengths do not agree.
    """
    numbers = {name: value for name, value in arrays.items() if value.dtype.kind in "fiuc" and value.size > 1}
    if len(numbers) == 1:
        (name, only), *_ = numbers.items()
        if only.ndim == 2 and min(only.shape) >= 2:
            return _of_matrix(only, None if isinstance(columns, Mapping) and name in columns else columns, path)
    roles = _roles(numbers, columns, path)
    frequency, place = _axis(numbers[roles["frequency"]], roles["frequency"], path)
    value = _over(numbers[roles["complex"]], len(frequency), roles["complex"], path).astype(complex)
    if not np.iscomplexobj(numbers[roles["complex"]]):
        raise ValueError(
            f"path = {str(path)!r} has {roles['complex']!r} without imaginary part; save complex numbers, or a table "
            "of real and imaginary columns"
        )
    coherence = None
    if "coherence" in roles:
        coherence = _over(numbers[roles["coherence"]], len(frequency), roles["coherence"], path)
        if coherence.shape != value.shape:
            raise ValueError(f"path = {str(path)!r} has coherence of shape {coherence.shape}, response {value.shape}")
    words = [str(np.ravel(text)[0]) for text in arrays.values() if text.dtype.kind == "U" and text.size]
    unit = next((found for word in words if (found := response_unit(word)) is not None), None)
    said = next((scale for word in words if (scale := frequency_scale(word)) is not None), None)
    scale = said if place is None else place
    note = f"{roles['frequency']!r} is the frequency, {roles['complex']!r} the response"
    return Samples(frequency, value, (), (), coherence, unit, scale, (note,))


def _of_matrix(matrix: np.ndarray, columns: Any, path: Path) -> Samples:
    """A table of numbers without head."""
    matrix = matrix.T if matrix.shape[0] < matrix.shape[1] else matrix
    if not np.iscomplexobj(matrix):
        rows = tuple(range(1, len(matrix) + 1))
        return samples_of(TextTable(matrix.astype(float), rows, (), "", "", "point"), columns, path)
    if matrix.shape[1] != 2 or np.any(np.imag(matrix[:, 0])):
        raise ValueError(
            f"path = {str(path)!r} has complex numbers of shape {matrix.shape}; give columns of frequency and "
            "response, (n, 2), or a .npz of both"
        )
    note = "the first column is the frequency, the second the response"
    return Samples(np.real(matrix[:, 0]), matrix[:, 1, None, None], notes=(note,))


def _roles(numbers: Mapping[str, np.ndarray], columns: Any, path: Path) -> dict[str, str]:
    """The name of each role."""
    if not numbers:
        raise ValueError(
            f"path = {str(path)!r} has no arrays of numbers by themselves; save those of a structure each by its name, "
            "in MATLAB by save(file, '-struct', 'name')"
        )
    has = f"path = {str(path)!r} has {', '.join(map(repr, numbers))}"
    remedy = "give columns={'name': 'frequency', 'other name': 'complex'}"
    if columns is None:
        found = {
            role: [name for name in numbers if re.fullmatch(pattern, name, re.IGNORECASE)]
            for role, pattern in _NAMES.items()
        }
    elif isinstance(columns, Mapping):
        for name, role in columns.items():
            _checks.choice("columns", role, ROLES)
            if name not in numbers:
                raise ValueError(f"columns names {name!r}; {has}")
        found = {role: [name for name, own in columns.items() if own == role] for role in ROLES}
    else:
        raise ValueError(f"columns = {_checks.brief(columns)} is for one table; {has}: {remedy}")
    for role in ROLES[:2]:
        if len(found[role]) != 1:
            several = " and ".join(map(repr, found[role])) or "none"
            raise ValueError(f"{has}, of which {several} can be the {role} array; {remedy}")
    return {role: names[0] for role, names in found.items() if names}


def _axis(values: np.ndarray, name: str, path: Path) -> tuple[np.ndarray, float | None]:
    flat = np.squeeze(values)
    if flat.ndim != 1 or np.iscomplexobj(flat):
        raise ValueError(f"path = {str(path)!r} has frequencies {name!r} of shape {values.shape}; give real ones, (n,)")
    radians = re.fullmatch(_RADIANS, name, re.IGNORECASE)
    return flat.astype(float), frequency_scale("rad/s") if radians else None


def _over(values: np.ndarray, count: int, name: str, path: Path) -> np.ndarray:
    """An array as (n, responses, references), n being its one axis of that length."""
    axes = [i for i, size in enumerate(values.shape) if size == count]
    if len(axes) != 1 or values.ndim > 3:
        raise ValueError(
            f"path = {str(path)!r} has {name!r} of shape {values.shape} for {count} frequencies; give (n,), (n, r) of "
            "r responses, or (n, r, p) to p references"
        )
    first = np.moveaxis(values, axes[0], 0)
    return first.reshape(count, *first.shape[1:], *(1,) * (3 - first.ndim))
