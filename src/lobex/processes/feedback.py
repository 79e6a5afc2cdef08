"""Feedback coefficients P and Q over one period: constant, harmonic, or with jumps.

The phase t/τ runs over [0, 1). A feedback names the pieces of a period within which it is smooth, so that
a method can end its intervals at the jumps.
"""

from typing import Any, ClassVar, NamedTuple, Protocol

import jax.numpy as jnp

from lobex._namespace import namespace
from lobex._pytree import pytree

Array = Any


class Piece(NamedTuple):
    """A part of the period in which P and Q are smooth; ``idle`` where they are zero throughout.

    ``idle`` is True or False where that is known before tracing, else a traced truth value.
    """

    start: Array
    length: Array
    idle: Any


class Feedback(Protocol):
    """What a method asks of P and Q, each of shape (k, r, r) for k phases."""

    constant: ClassVar[bool]

    def pieces(self) -> tuple[Piece, ...]:
        """The smooth pieces of one period, in order; the first may start anywhere."""
        ...

    def within(self, index: int, phase: Array) -> tuple[Array, Array]:
        """P and Q at phases (k,) of piece ``index``, its ends taken from inside."""
        ...

    def at(self, phase: Array) -> tuple[Array, Array]:
        """P and Q at any phases (k,), jumps included."""
        ...

    def mean(self, start: Array, stop: Array) -> tuple[Array, Array]:
        """Exact averages of P and Q over the intervals [start, stop], each of shape (k,)."""
        ...


@pytree()
class ConstantFeedback:
    """Constant P and Q, each of shape (r, r)."""

    current: Array
    delayed: Array

    constant: ClassVar[bool] = True

    def pieces(self) -> tuple[Piece, ...]:
        return (Piece(0.0, 1.0, False),)

    def at(self, phase: Array) -> tuple[Array, Array]:
        lib = namespace(self)
        shape = (jnp.shape(phase)[0], *jnp.shape(self.current))
        return lib.broadcast_to(self.current, shape), lib.broadcast_to(self.delayed, shape)

    def within(self, index: int, phase: Array) -> tuple[Array, Array]:
        return self.at(phase)

    def mean(self, start: Array, stop: Array) -> tuple[Array, Array]:
        return self.at(start)


@pytree()
class HarmonicFeedback:
    """P(t) = −amplitude · cos(2π t/τ) and constant Q, for one output."""

    amplitude: Array
    delayed: Array

    constant: ClassVar[bool] = False

    def pieces(self) -> tuple[Piece, ...]:
        return (Piece(0.0, 1.0, False),)

    def at(self, phase: Array) -> tuple[Array, Array]:
        return self._pair(jnp.cos(2 * jnp.pi * phase))

    def within(self, index: int, phase: Array) -> tuple[Array, Array]:
        return self.at(phase)

    def mean(self, start: Array, stop: Array) -> tuple[Array, Array]:
        turn = 2 * jnp.pi
        return self._pair((jnp.sin(turn * stop) - jnp.sin(turn * start)) / (turn * (stop - start)))

    def _pair(self, cosine: Array) -> tuple[Array, Array]:
        current = -self.amplitude * cosine
        return current[:, None, None], jnp.broadcast_to(self.delayed, jnp.shape(current))[:, None, None]


@pytree()
class WholeStateFeedback:
    """The d×d feedback E P C and E Q C of a system whose delay is taken to act on its whole state."""

    inner: Feedback
    input_matrix: Array
    output_matrix: Array

    constant: ClassVar[bool] = False

    def pieces(self) -> tuple[Piece, ...]:
        return self.inner.pieces()

    def at(self, phase: Array) -> tuple[Array, Array]:
        return self._expand(self.inner.at(phase))

    def within(self, index: int, phase: Array) -> tuple[Array, Array]:
        return self._expand(self.inner.within(index, phase))

    def mean(self, start: Array, stop: Array) -> tuple[Array, Array]:
        return self._expand(self.inner.mean(start, stop))

    def _expand(self, pair: tuple[Array, Array]) -> tuple[Array, Array]:
        current, delayed = (self.input_matrix @ matrix @ self.output_matrix for matrix in pair)
        return current, delayed
