"""Checks at the public edge: one-line ``ValueError``s that name the argument, its value and the remedy.

Values that JAX traces cannot be looked at and pass unchecked. Nothing here imports JAX, so that a shell
command can refuse bad input before the slow import.
"""

import cmath
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

# Of revolutions, steps, speeds: what is longer ends in no lifetime, or in no memory.
_MOST = 1_000_000
_PLAIN = (np.ndarray, np.float64, float, int, bool)
# Beyond these no quantity lies, in whatever units, and squares overflow or vanish.
_LARGEST, _LEAST = 1e100, 1e-100


def is_traced(value: Any) -> bool:
    """Whether JAX traces ``value``, or a number within it, so that it is not known."""
    jax = sys.modules.get("jax")
    # Most are plain, and to look for leaves takes longer than a small array's arithmetic.
    if jax is None or type(value) in _PLAIN:
        return False
    return any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree.leaves(value))


def untraced(verb: str, **arguments: Any) -> None:
    """Require arguments whose numbers are known, for a verb that decides by them."""
    for name, value in arguments.items():
        if is_traced(value):
            raise ValueError(
                f"{name} is traced by JAX; {verb} runs outside jit, grad and vmap of it: give plain numbers"
            )


def as_array(value: Any, name: str = "") -> Any:
    """A list of numbers as one array, of JAX where it traces any of them; everything else as it is."""
    if not isinstance(value, list | tuple):
        return value
    if is_traced(value):
        return sys.modules["jax"].numpy.asarray(value)
    try:
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        called = f"{name} = " if name else ""
        raise ValueError(f"{called}{brief(value)} is no list of numbers; give real numbers in equal rows") from None


def as_numbers(name: str, value: Any, unit: str = "") -> np.ndarray | None:
    """``value`` as a float array of finite real numbers up to 1e100, or None where it is traced."""
    if _is_complex(value):
        # A cast to float would drop the imaginary parts with no more than a warning.
        shown = "" if is_traced(value) else f" = {_show(np.asarray(value))}"
        raise ValueError(f"{name}{shown} is complex; give {_in(unit, 'real numbers')}")
    if is_traced(value):
        return None
    if np.ma.is_masked(value):
        raise ValueError(f"{name} = {brief(value)} has masked values; give finite numbers alone")
    try:
        # What NumPy would take for 1, 0, NaN or a number is none, such as True, None or '100'.
        kind = np.asarray(value).dtype.kind
        if kind in "bSUMm" or (kind == "O" and any(part is None for part in np.asarray(value).flat)):
            raise TypeError
        numbers = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{name} = {value!r} is not a number; give {_in(unit, 'a real number')}") from None
    if not np.all(np.isfinite(numbers)):
        raise ValueError(f"{name} = {_show(numbers)} has NaN or infinite values; give finite numbers")
    if np.any(np.abs(numbers) > _LARGEST):
        raise ValueError(f"{name} = {_show(numbers)} is beyond any quantity; give {_in(unit, 'at most 1e100')}")
    return numbers


def positive(name: str, value: Any, unit: str = "") -> None:
    """Require every value to be finite, above zero and at least 1e-100."""
    numbers = as_numbers(name, value, unit)
    if numbers is not None and np.any(numbers <= 0):
        raise ValueError(f"{name} = {_show(numbers)} must be positive; give {_in(unit, 'a number above 0')}")
    _not_vanishing(name, numbers, unit)


def not_negative(name: str, value: Any, unit: str = "") -> None:
    """Require every value to be finite and at least zero; what is nearly zero is as good as that."""
    numbers = as_numbers(name, value, unit)
    if numbers is not None and np.any(numbers < 0):
        raise ValueError(f"{name} = {_show(numbers)} must not be negative; give {_in(unit, '0 or more')}")


def scalar(name: str, value: Any) -> None:
    """Require a single number."""
    if np.ndim(value) != 0:
        raise ValueError(f"{name} has shape {np.shape(value)}; give one number")


def integer(name: str, value: Any, least: int, most: int = _MOST) -> int:
    """Return ``value`` as an int from ``least`` to ``most``, above which nobody can mean it."""
    number = value if isinstance(value, int | np.integer) and not isinstance(value, bool) else None
    if number is None or number < least:
        raise ValueError(f"{name} = {brief(value)} must be a whole number of at least {least}")
    if number > most:
        raise ValueError(f"{name} = {brief(value)} is more than can be computed; give at most {most}")
    return int(number)


def choice(name: str, value: Any, allowed: Sequence[Any]) -> None:
    """Require one of the ``allowed`` values."""
    if not any(value == a and type(value) is type(a) for a in allowed):
        raise ValueError(f"{name} = {value!r} is unknown; choose one of {', '.join(repr(a) for a in allowed)}")


def grid(name: str, value: Any, unit: str = "") -> np.ndarray:
    """Return a strictly increasing one-dimensional grid of finite numbers as float64."""
    numbers = as_numbers(name, value, unit)
    if numbers is None:
        raise ValueError(f"{name} is traced by JAX; a sweep runs outside jit, grad and vmap: give plain numbers")
    if numbers.ndim != 1:
        raise ValueError(f"{name} has shape {numbers.shape}; give a one-dimensional grid")
    if numbers.size == 0:
        raise ValueError(f"{name} is empty; give at least one value")
    if np.any(np.diff(numbers) <= 0):
        raise ValueError(f"{name} = {_show(numbers)} is not strictly increasing; sort it and drop repeats")
    return numbers


def place(name: str, path: Any, what: str = "a file") -> Path:
    """Require text, or what stands for it, that can be the path of a file or folder, whether there is one or not."""
    try:
        text = os.fspath(path)
    except TypeError:
        text = None
    if not isinstance(text, str):
        raise ValueError(f"{name} = {brief(path)} is no path; give the path of {what} as text")
    try:
        os.stat(text)
    except (FileNotFoundError, NotADirectoryError):
        pass
    # Such as a name that is too long, or that has a character of code 0.
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise ValueError(f"{name} = {brief(text)} cannot be used ({why}); give the path of {what}") from None
    return Path(text)


def writable(name: str, path: str | os.PathLike[str]) -> Path:
    """Require that a file can be written at ``path``: its folder exists and accepts new files."""
    target = place(name, path)
    folder = target.parent
    if target.suffix.lower() == ".zarr" and os.path.lexists(target):
        raise ValueError(f"{name} = {str(path)!r} exists, and no Zarr takes its place; remove it or give another name")
    if not str(path) or target.is_dir():
        raise ValueError(f"{name} = {str(path)!r} is not a file name; give the path of a file")
    if not folder.is_dir():
        raise ValueError(f"{name} = {str(path)!r}: there is no folder {str(folder)!r}; create it first")
    try:
        probe = folder / f".{target.name}.{os.getpid()}.probe"
        probe.touch(exist_ok=False)
        probe.unlink()
    except OSError as error:
        why = error.strerror or str(error)
        raise ValueError(f"{name} = {str(path)!r} cannot be written ({why}); choose another folder") from None
    if target.exists() and not os.access(target, os.W_OK):
        raise ValueError(f"{name} = {str(path)!r} is write-protected; choose another name")
    return target


def brief(value: Any) -> str:
    """A value for a message of one line: itself if it is short, else its type."""
    text = repr(value)
    return text if len(text) <= 60 and "\n" not in text else f"a {type(value).__name__}"


def _is_complex(value: Any) -> bool:
    try:
        return np.iscomplexobj(value)
    except (TypeError, ValueError):  # No array at all.
        return False


def _not_vanishing(name: str, numbers: np.ndarray | None, unit: str) -> None:
    if numbers is not None and np.any((numbers > 0) & (numbers < _LEAST)):
        raise ValueError(
            f"{name} = {_show(numbers)} is too small for any quantity; give {_in(unit, 'at least 1e-100')}"
        )


def _in(unit: str, what: str) -> str:
    return f"{what} in {unit}" if unit else what


def _show(numbers: np.ndarray) -> str:
    if numbers.ndim == 0:
        return f"{numbers.item():.6g}"
    shown = ", ".join("nan" if cmath.isnan(x) else f"{x:.6g}" for x in numbers.ravel()[:4])
    return f"[{shown}{', …' if numbers.size > 4 else ''}]"
