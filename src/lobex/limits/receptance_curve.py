"""What is asked of a receptance along the frequency axis, of modes or of samples."""

from typing import Any, Protocol

from lobex._namespace import namespace

Array = Any


class ReceptanceCurve(Protocol):
    """G along the frequency axis, in rows: a frequency is an anchor, ω of its row, plus an offset.

    Offsets keep their digits beside a resonance much sharper than the rounding of ω.
    """

    anchor: Array

    @property
    def open_ended(self) -> bool:
        """Whether the last row goes on to infinite frequency."""
        ...

    @property
    def most_breaks(self) -> int | None:
        """Largest number of zeros of one of the functions that bracketing looks at; None for one per interval."""
        ...

    def grid(self) -> tuple[Array, Array]:
        """Rows and offsets of points, sorted, so dense that intervals hold one such zero at most, each (p,)."""
        ...

    def at(self, row: Array, offset: Array) -> tuple[Array, Array, Array]:
        """G and its first and second derivative by ω, each of the shape of ``offset``."""
        ...

    def undamped_at(self, row: Array, offset: Array) -> Array:
        """Whether the point is the pole of a mode without damping."""
        ...


def clustered(width: Array, reach: Array, steps: Array) -> Array:
    """Offsets up to ``reach``, evenly spaced up to about ``width`` and geometrically beyond; ``steps`` in (0, 1]."""
    lib = namespace(width, reach)
    return lib.minimum(width * lib.sinh(steps * lib.arcsinh(reach / width)), reach)
