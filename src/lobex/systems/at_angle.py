"""Coefficients and delays that are given by an angle, of what does not turn evenly within the period."""

from typing import Any, ClassVar, Protocol, runtime_checkable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Real

from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.systems.coefficients import Coefficient, Piece, mean_by_quadrature
from lobex.systems.delays import Delay


@runtime_checkable
class Rotation(Protocol):
    """How something turns within a period; its functions go on beyond it."""

    def turned(self, phase: Float[AnyArray, " *k"]) -> Float[AnyArray, " *k"]:
        """What share of its turning in a period is done at phases t/T: that rises by 1 with the phase."""
        ...

    def since(self, phase: Float[AnyArray, " *k"], share: Float[AnyArray, " *k"]) -> Float[AnyArray, " *k"]:
        """How long before phases it had turned by a share less, in periods."""
        ...

    def pace(self, phase: Float[AnyArray, " *k"]) -> Float[AnyArray, " *k"]:
        """The derivative of ``turned``: the speed over its mean."""
        ...


def _phase_of(rotation: Rotation, turned: Float[AnyArray, " b"]) -> Float[AnyArray, " b"]:
    """The phases at which shares of the turning are done."""
    start = namespace(turned).floor(turned)
    return start - _since(rotation, start, start - turned)


def _since(rotation: Rotation, phase: Float[AnyArray, " *k"], share: Float[AnyArray, " *k"]) -> Float[AnyArray, " *k"]:
    """``Rotation.since``, at hand of numbers that are."""
    if namespace(rotation, phase, share) is jnp:
        return _since_once(rotation, phase, share)
    with jax.ensure_compile_time_eval():
        return np.asarray(_since_once(rotation, phase, share))


@jax.jit
def _since_once(rotation: Rotation, phase: Float[Array, " *k"], share: Float[Array, " *k"]) -> Float[Array, " *k"]:
    """A loop, which JAX is to trace once and not wherever it is asked for."""
    found: Any = rotation.since(phase, share)
    return found


@pytree(static=("repeats",))
class AtAngle:
    """A coefficient that repeats a whole number of times in the period, in equal parts of the turning.

    Attributes:
        inner: over one of its own periods.
        rotation: of what it depends on.
        repeats: how many of its periods make one.
    """

    inner: Coefficient
    rotation: Rotation
    repeats: int

    constant: ClassVar[bool] = False

    def pieces(self) -> tuple[Piece, ...]:
        inner = self.inner.pieces()
        if not inner:
            return ()
        lib = namespace(inner, self.rotation)
        first = lib.stack([lib.asarray(piece.start, dtype=lib.result_type(float)) for piece in inner])
        # Whatever follows the last one ends where the first one starts again.
        turned = ((first + np.arange(self.repeats)[:, None]) / self.repeats).ravel()
        start = _phase_of(self.rotation, lib.concatenate([turned, turned[:1] + 1.0]))
        length = start[1:] - start[:-1]
        idle = [piece.idle for piece in inner] * self.repeats
        return tuple(Piece(*piece) for piece in zip(start[:-1], length, idle, strict=True))

    def at(self, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        return self.inner.at(self._place(phase))

    def within(self, inside: Number, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        return self.inner.within(self._place(jnp.asarray(inside)), self._place(phase))

    def mean(self, start: Float[AnyArray, " k"], stop: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        return mean_by_quadrature(self, start, stop)

    def _place(self, phase: Real[AnyArray, " *k"]) -> Float[AnyArray, " *k"]:
        return self.repeats * self.rotation.turned(phase)


@pytree()
class ByPace:
    """A coefficient over the speed at which something turns, relative to its mean."""

    inner: Coefficient
    rotation: Rotation

    constant: ClassVar[bool] = False

    def pieces(self) -> tuple[Piece, ...]:
        return self.inner.pieces()

    def at(self, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        return self.inner.at(phase) / self.rotation.pace(phase)[:, None, None]

    def within(self, inside: Number, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        return self.inner.within(inside, phase) / self.rotation.pace(phase)[:, None, None]

    def mean(self, start: Float[AnyArray, " k"], stop: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        return mean_by_quadrature(self, start, stop)


@pytree()
class SinceAngle:
    """How long ago something stood where it had turned by less, as a delay of even turning says.

    Attributes:
        inner: that delay, of its own period.
        rotation: of what turns.
        repeats: how many of its periods make one, whole or not where it is the same at all angles.
    """

    inner: Delay
    rotation: Rotation
    repeats: Number

    def shares(self, phase: Float[AnyArray, " *k"], period: Number) -> Float[AnyArray, " *k"]:
        place = self.repeats * self.rotation.turned(phase)
        share = self.inner.shares(place, period / self.repeats) / self.repeats
        return _since(self.rotation, phase, share)

    def carried(self, jumps: Float[AnyArray, " b"]) -> Float[AnyArray, " b"]:
        """The phases at which what happened at ``jumps`` acts, where the delay is the same at all angles."""
        share = self.inner.shares(self.repeats * self.rotation.turned(jumps), 1.0) / self.repeats
        return jumps - _since(self.rotation, jumps, -share)
