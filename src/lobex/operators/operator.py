"""What a method makes of a delay system at one point."""

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

import jax.numpy as jnp
from jaxtyping import Array, Complex, Float

from lobex import _checks
from lobex._pytree import check_pytree, pytree
from lobex._shapes import AnyArray, Number
from lobex.floquet.chatter import carrier_frequency
from lobex.floquet.power import as_pair
from lobex.systems.system import DelaySystem, whole_state

# Per piece: the eigenvalues of a dense operator of so many nodes take minutes at one point.
MOST_NODES = 2000


@pytree()
class MonodromyOperator:
    """The map of a history onto the one a period later, and the motion that a state stands for.

    Attributes:
        matrix: the map, (N, N); its eigenvalues are the Floquet multipliers.
        phase: sampling phases t/T of the motion, (S,), in [start, start + 1].
        weight: quadrature weights of the samples, (S,), summing to 1.
        motion: y at the samples, over the period after a state, as a linear map of that state, (S, r, N).
    """

    matrix: Float[Array, "N N"]
    phase: Float[AnyArray, " S"]
    weight: Float[Array, " S"]
    motion: Float[Array, "S r N"]

    def chatter_frequency(
        self, period: Number, value: Complex[Array, ""], vector: Complex[Array, " N"]
    ) -> Float[Array, ""]:
        """The carrier frequency of the motion that a multiplier and its state, both complex, stand for, Hz."""
        motion = jnp.einsum("srn,np->srp", self.motion, as_pair(vector))
        return carrier_frequency(self.phase, self.weight, motion, period, as_pair(value))


def in_form(build: Callable[[DelaySystem], MonodromyOperator], system: DelaySystem, full: bool) -> MonodromyOperator:
    """An operator on the history of what is remembered, or, if ``full``, on that of the whole state (C = I)."""
    if not full:
        return build(system)
    if not system.repeats or system.remembered is not None:
        raise ValueError(
            "full = True takes systems that remember what acts now and whose only delay is the period; leave it out"
        )
    operator = build(whole_state(system))
    motion = jnp.einsum("ra,san->srn", system.output_matrix(), operator.motion)
    return MonodromyOperator(operator.matrix, operator.phase, operator.weight, motion)


@runtime_checkable
class Method(Protocol):
    """A way to discretise a delay system: a frozen pytree of static sizes."""

    def operator(self, system: DelaySystem) -> MonodromyOperator:
        """The monodromy operator of one delay system, in pure JAX."""
        ...

    def size(self, system: DelaySystem) -> int:
        """N, from the shapes of ``system`` alone."""
        ...

    def finer(self) -> "Method":
        """The same method with more samples, to estimate the error of this one by."""
        ...

    def resolved_radians(self, system: DelaySystem) -> float:
        """Largest ω T (rad of oscillation per period) that the method's samples can follow."""
        ...


def check_method(method: Any) -> None:
    """Require something that makes a monodromy operator."""
    if isinstance(method, type) or not callable(getattr(method, "operator", None)):
        raise ValueError(
            f"method = {_checks.brief(method)} is no method; give such as lobex.Duhamel() or lobex.Chebyshev()"
        )
    check_pytree("method", method)
