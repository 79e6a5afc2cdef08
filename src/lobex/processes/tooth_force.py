"""The force of one straight tooth over a revolution, on what it meets and of its runout."""

from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar

import jax.numpy as jnp
import numpy as np

from lobex._pytree import pytree
from lobex.processes.milling import by_thickness, specific_force, specific_work
from lobex.systems.coefficients import Piece

Array = Any

_TURN = 2 * np.pi


@pytree(static=("directions",))
class ToothForce:
    """b H(t) of one tooth over a revolution; it is at the angle 2π (t/T + before)."""

    depth: Array
    tangential: Array
    normal: Array
    entry: Array
    exit: Array
    before: Array
    directions: int

    constant: ClassVar[bool] = False

    def pieces(self) -> tuple[Piece, ...]:
        start, cut = self.entry / _TURN - self.before, (self.exit - self.entry) / _TURN
        return Piece(start, cut, False), Piece(start + cut, 1 - cut, True)

    def at(self, phase: Array) -> Array:
        return self._where(phase, phase)

    def within(self, inside: Array, phase: Array) -> Array:
        return self._where(inside, phase)

    def mean(self, start: Array, stop: Array) -> Array:
        return self._matrix(self.averaged(partial(specific_work, self), start, stop))

    def averaged(self, work: Callable[[Array], Array], start: Array, stop: Array) -> Array:
        """Averages over intervals of what acts in the cut, from its antiderivative over the angle, (entries, k)."""
        first = jnp.mod(_TURN * (start + self.before), _TURN)
        last = first + _TURN * (stop - start)
        done = 0.0
        for turn in (0.0, _TURN):
            ends = (jnp.clip(edge - turn, self.entry, self.exit) for edge in (last, first))
            done = done + work(next(ends)) - work(next(ends))
        return done / (last - first)

    def cutting(self, inside: Array) -> Array:
        """Whether the tooth is in the cut."""
        angle = jnp.mod(_TURN * (inside + self.before), _TURN)
        return (angle >= self.entry) & (angle <= self.exit)

    def _where(self, inside: Array, phase: Array) -> Array:
        """What the tooth does at ``phase`` if it is in the cut at ``inside``."""
        return self._matrix(self.cutting(inside) * specific_force(self, _TURN * (phase + self.before)))

    def _matrix(self, entries: Array) -> Array:
        matrix = self.depth * jnp.moveaxis(entries, 0, -1)
        return matrix.reshape(*jnp.shape(matrix)[:-1], self.directions, self.directions)


@pytree()
class RunoutForce:
    """The force of a tooth that cuts a step more than the one ahead of it, −b (K_t t + K_n n) step, (directions, 1)."""

    tooth: ToothForce
    step: Array

    constant: ClassVar[bool] = False

    @property
    def breaks(self) -> ToothForce:
        """Those of the tooth, by which coefficients that share them are known."""
        return self.tooth

    def pieces(self) -> tuple[Piece, ...]:
        return self.tooth.pieces()

    def at(self, phase: Array) -> Array:
        return self.within(phase, phase)

    def within(self, inside: Array, phase: Array) -> Array:
        angle = _TURN * (phase + self.tooth.before)
        return self._column(self.tooth.cutting(inside) * self._by_thickness(jnp.sin(angle), jnp.cos(angle)))

    def mean(self, start: Array, stop: Array) -> Array:
        def work(angle: Array) -> Array:
            return self._by_thickness(-jnp.cos(angle), jnp.sin(angle))

        return self._column(self.tooth.averaged(work, start, stop))

    def _by_thickness(self, sine: Array, cosine: Array) -> Array:
        return jnp.stack(by_thickness(self.tooth, sine, cosine))

    def _column(self, entries: Array) -> Array:
        return -self.tooth.depth * self.step * jnp.moveaxis(entries, 0, -1)[..., None]
