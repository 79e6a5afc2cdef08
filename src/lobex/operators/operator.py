"""What a method makes of a delay system at one point."""

from typing import Any, Protocol

from lobex._pytree import pytree
from lobex.processes.system import DelaySystem

Array = Any


@pytree()
class MonodromyOperator:
    """The map of the history of one delay onto the next, and the motion that a state stands for.

    Attributes:
        matrix: the map, (N, N); its eigenvalues are the Floquet multipliers.
        phase: sampling phases t/τ of the motion, (S,), in [start, start + 1].
        weight: quadrature weights of the samples, (S,), summing to 1.
        motion: y at the samples, over the period after a state, as a linear map of that state, (S, r, N).
    """

    matrix: Array
    phase: Array
    weight: Array
    motion: Array


class Method(Protocol):
    """A way to discretise a delay system: a frozen pytree of static sizes."""

    def operator(self, system: DelaySystem) -> MonodromyOperator:
        """The monodromy operator of one delay system, in pure JAX."""
        ...

    def size(self, system: DelaySystem) -> int:
        """N, from the shapes of ``system`` alone."""
        ...

    def resolved_radians(self, system: DelaySystem) -> float:
        """Largest ω τ (rad of oscillation per delay) that the method's samples can follow."""
        ...
