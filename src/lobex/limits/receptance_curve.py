"""What is asked of a receptance along the frequency axis, of modes or of samples."""

from typing import Protocol, runtime_checkable

from jaxtyping import Bool, Complex, Float, Int

from lobex._namespace import namespace
from lobex._shapes import AnyArray, Number


@runtime_checkable
class ReceptanceCurve(Protocol):
    """G along the frequency axis, in rows: a frequency is an anchor, ω of its row, plus an offset.

    Offsets keep their digits beside a resonance much sharper than the rounding of ω.
    """

    anchor: Float[AnyArray, " rows"]

    @property
    def turn(self) -> Number:
        """Turns by which the phase of the delay is ahead: of a wave that travels from blade to blade."""
        ...

    @property
    def open_ended(self) -> bool:
        """Whether the last row goes on to infinite frequency."""
        ...

    @property
    def most_breaks(self) -> int | None:
        """Largest number of zeros of one of the functions that bracketing looks at; None for one per interval."""
        ...

    def grid(self) -> tuple[Int[AnyArray, " points"], Float[AnyArray, " points"]]:
        """Rows and offsets of points, sorted, so dense that intervals hold one such zero at most, each (p,)."""
        ...

    def at(
        self, row: Int[AnyArray, " *points"], offset: Float[AnyArray, " *points"]
    ) -> tuple[Complex[AnyArray, " *points"], Complex[AnyArray, " *points"], Complex[AnyArray, " *points"]]:
        """G and its first and second derivative by ω, each of the shape of ``offset``."""
        ...

    def undamped_at(
        self, row: Int[AnyArray, " *points"], offset: Float[AnyArray, " *points"]
    ) -> Bool[AnyArray, " *points"]:
        """Whether the point is the pole of a mode without damping."""
        ...


def clustered(
    width: Float[AnyArray, "rows 1"], reach: Float[AnyArray, "rows 1"], steps: Float[AnyArray, " steps"]
) -> Float[AnyArray, "rows steps"]:
    """Offsets up to ``reach``, evenly spaced up to about ``width`` and geometrically beyond; ``steps`` in (0, 1]."""
    lib = namespace(width, reach)
    return lib.minimum(width * lib.sinh(steps * lib.arcsinh(reach / width)), reach)
