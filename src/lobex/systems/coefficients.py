"""Coefficients of a force over one period: constant, harmonic, or any function that says where it jumps.

The phase t/T runs over [0, 1) and goes on beyond. A coefficient names the pieces of a period within which it is smooth,
so that a method can end its intervals at the jumps.
"""

from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple, Protocol, runtime_checkable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number

# Gauss points that give the mean over a smooth part of a step, which is short.
_POINTS = 6
AS_ONE = 1e-9
"""Of the period, how far apart jumps may be that are at one place."""
# Of a piece, so far from a jump that rounding does not reach it.
_INSIDE = 1e-12


class Piece(NamedTuple):
    """A part of the period in which coefficients are smooth; ``idle`` where they are zero throughout.

    ``idle`` is True or False where that is known before tracing, else a traced truth value.
    """

    start: Number
    length: Number
    idle: Any


@runtime_checkable
class Coefficient(Protocol):
    """A matrix (e, r) over the period: what a method asks of it, at k phases (k, e, r)."""

    constant: ClassVar[bool]

    def pieces(self) -> tuple[Piece, ...]:
        """The smooth pieces of one period, in order; the first may start anywhere. None where it has no jumps."""
        ...

    def within(self, inside: Number, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        """At phases (k,) of the piece that holds the phase ``inside``, its ends taken from there."""
        ...

    def at(self, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        """At any phases (k,), jumps included."""
        ...

    def mean(self, start: Float[AnyArray, " k"], stop: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        """Averages over the intervals [start, stop], each (k,) and shorter than a period."""
        ...


class Jumps(NamedTuple):
    """Where a coefficient jumps.

    Attributes:
        phase: phases t/T, (b,), in any order.
        ends: whether a force ends there, and does not begin, (b,).
    """

    phase: Float[AnyArray, " b"]
    ends: np.ndarray


def jumps_of(coefficient: "Coefficient") -> Jumps | None:
    """Where a coefficient jumps, as it says itself by ``jumps``, or as the first of its pieces begins what others end;
    None where it does not.
    """
    inner = coefficient.inner if isinstance(coefficient, Framed) else coefficient
    own = getattr(inner, "jumps", None)
    if own is not None:
        return own()
    starts = [piece.start for piece in inner.pieces()]
    lib = namespace(starts)
    if not starts:
        return None
    place = lib.stack([lib.asarray(start, dtype=lib.result_type(float)) for start in starts])
    return Jumps(place, np.arange(len(starts)) > 0)


@runtime_checkable
class Bending(Protocol):
    """A coefficient that bends, or jumps a little, at more places within a piece than could end one."""

    def nearest(self, start: Number, length: Number, nodes: int) -> Float[AnyArray, "q e r"]:
        """At Gauss' nodes of a piece: of the polynomial through as many that is nearest to it all along."""
        ...

    def acts(self, phase: Float[AnyArray, " k"]) -> Bool[AnyArray, " k"]:
        """Whether it may be other than zero at phases, (k,), or near them."""
        ...


@runtime_checkable
class OneChip(Protocol):
    """A coefficient that is, where ``single``, a force on one number that is made of outputs, such as a chip."""

    @property
    def single(self) -> bool:
        """Whether it is."""
        ...

    def factors(
        self, inside: Number, phase: Float[AnyArray, " k"]
    ) -> tuple[Float[AnyArray, "k e 1"], Float[AnyArray, "k 1 r"]]:
        """The force per chip and the chip per output: their product is ``within`` of the same phases."""
        ...


@pytree()
class Constant:
    """The same matrix (e, r) at all times."""

    value: Float[AnyArray, "e r"]

    constant: ClassVar[bool] = True

    def pieces(self) -> tuple[Piece, ...]:
        return ()

    def at(self, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        return namespace(self).broadcast_to(self.value, (jnp.shape(phase)[0], *jnp.shape(self.value)))

    def within(self, inside: Number, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        return self.at(phase)

    def mean(self, start: Float[AnyArray, " k"], stop: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        return self.at(start)


@pytree()
class Harmonic:
    """amplitude · cos(2π t/T), with an amplitude of (e, r)."""

    amplitude: Float[AnyArray, "e r"]

    constant: ClassVar[bool] = False

    def pieces(self) -> tuple[Piece, ...]:
        return ()

    def at(self, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        return self.amplitude * jnp.cos(2 * jnp.pi * phase)[:, None, None]

    def within(self, inside: Number, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        return self.at(phase)

    def mean(self, start: Float[AnyArray, " k"], stop: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        turn = 2 * jnp.pi
        cosine = (jnp.sin(turn * stop) - jnp.sin(turn * start)) / (turn * (stop - start))
        return self.amplitude * cosine[:, None, None]


@pytree()
class Framed:
    """left · inner · right: a coefficient seen by other forces and outputs."""

    left: Float[AnyArray, "f e"]
    inner: Coefficient
    right: Float[AnyArray, "r o"]

    @property
    def constant(self) -> bool:
        return self.inner.constant

    @property
    def breaks(self) -> Any:
        """Those of the inner one, by which coefficients that share them are known."""
        return getattr(self.inner, "breaks", self.inner)

    def pieces(self) -> tuple[Piece, ...]:
        return self.inner.pieces()

    def at(self, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k f o"]:
        return self.left @ self.inner.at(phase) @ self.right

    def within(self, inside: Number, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k f o"]:
        return self.left @ self.inner.within(inside, phase) @ self.right

    def mean(self, start: Float[AnyArray, " k"], stop: Float[AnyArray, " k"]) -> Float[AnyArray, "k f o"]:
        return self.left @ self.inner.mean(start, stop) @ self.right


@pytree()
class Following:
    """A coefficient that jumps and bends where others of its system do, which say so: it ends no piece itself."""

    inner: Coefficient

    constant: ClassVar[bool] = False

    def pieces(self) -> tuple[Piece, ...]:
        return ()

    def at(self, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        return self.inner.at(phase)

    def within(self, inside: Number, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        return self.inner.within(inside, phase)

    def mean(self, start: Float[AnyArray, " k"], stop: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        return self.inner.mean(start, stop)


@pytree()
class Function:
    """A matrix (e, r) as a function of time t, s, and of speed and gain, which repeats with the period.

    Attributes:
        function: in pure JAX, of (t, speed, gain).
        speed, gain: of the point.
        period: T, s.
        breaks: phases t/T at which it jumps, (b,).
    """

    function: Callable[..., Float[AnyArray, "e r"]]
    speed: Number
    gain: Number
    period: Number
    breaks: Float[AnyArray, " b"]

    constant: ClassVar[bool] = False

    def pieces(self) -> tuple[Piece, ...]:
        return pieces_between(self.breaks) if jnp.shape(self.breaks)[0] else ()

    def at(self, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        def one(phase: Number) -> Float[AnyArray, "e r"]:
            return self.function(jnp.mod(phase, 1.0) * self.period, self.speed, self.gain)

        return jax.vmap(one)(phase)

    def within(self, inside: Number, phase: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        if not jnp.shape(self.breaks)[0]:
            return self.at(phase)
        # On a jump the function itself says which side it takes: a little way inside there is no choice.
        before, after = (jnp.min(jnp.mod(side, 1.0)) for side in (inside - self.breaks, self.breaks - inside))
        return self.at(jnp.clip(phase, inside - (1 - _INSIDE) * before, inside + (1 - _INSIDE) * after))

    def mean(self, start: Float[AnyArray, " k"], stop: Float[AnyArray, " k"]) -> Float[AnyArray, "k e r"]:
        return mean_by_quadrature(self, start, stop)


def gauss_nodes(nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Legendre nodes and weights on [0, 1]."""
    points, weights = np.polynomial.legendre.leggauss(nodes)
    return (points + 1) / 2, weights / 2


def at_nodes(coefficient: Coefficient, start: Number, length: Number, nodes: int) -> Float[AnyArray, "q e r"]:
    """A coefficient at Gauss' nodes of a piece, (q, e, r): what stands for it all along."""
    if isinstance(coefficient, Framed):
        return coefficient.left @ at_nodes(coefficient.inner, start, length, nodes) @ coefficient.right
    if isinstance(coefficient, Following):
        return at_nodes(coefficient.inner, start, length, nodes)
    if isinstance(coefficient, Bending):
        return coefficient.nearest(start, length, nodes)
    return coefficient.within(start + length / 2, start + length * gauss_nodes(nodes)[0])


def bending_of(coefficient: Coefficient) -> Bending | None:
    """What bends within pieces of a coefficient; None where nothing does."""
    while isinstance(coefficient, Framed | Following):
        coefficient = coefficient.inner
    return coefficient if isinstance(coefficient, Bending) else None


def in_period(phase: Float[AnyArray, "..."]) -> Float[AnyArray, "..."]:
    """Phases in [0, 1), or below it by what rounding leaves of 0."""
    return namespace(phase).mod(phase + AS_ONE / 2, 1.0) - AS_ONE / 2


def spans_between(
    breaks: Float[AnyArray, " b"], rank: np.ndarray | None = None
) -> tuple[Float[AnyArray, " b"], Float[AnyArray, " b"]]:
    """Starts and lengths of the pieces between jumps at phases (b,), in any order; of those that are at one place, in
    the order of their ``rank``, (b,), by which derivatives know what is between them once they move.
    """
    lib = namespace(breaks)
    place = in_period(lib.asarray(breaks, dtype=lib.result_type(float)))
    rank = np.zeros(len(place)) if rank is None else rank
    place = place[lib.lexsort((rank, lib.round(place / AS_ONE)))]
    return place, lib.concatenate([place[1:], place[:1] + 1]) - place


def pieces_between(breaks: Float[AnyArray, " b"]) -> tuple[Piece, ...]:
    """The same one by one."""
    return tuple(Piece(start, length, False) for start, length in zip(*spans_between(breaks), strict=True))


def mean_by_quadrature(
    coefficient: Coefficient, start: Float[AnyArray, " k"], stop: Float[AnyArray, " k"]
) -> Float[Array, "k e r"]:
    """Averages over intervals [start, stop], (k,), by Gauss' rule between the jumps that lie in each."""
    points, weights = np.polynomial.legendre.leggauss(_POINTS)
    jumps = jnp.stack([jnp.mod(piece.start, 1.0) for piece in coefficient.pieces()] or [jnp.zeros(())])
    # The first of each at or after the start.
    place = start[:, None] + jnp.mod(jumps - start[:, None], 1.0)
    edges = jnp.sort(jnp.clip(place, start[:, None], stop[:, None]), axis=1)
    edges = jnp.concatenate([start[:, None], edges, stop[:, None]], axis=1)
    width = jnp.diff(edges, axis=1)
    middle = (edges[:, 1:] + edges[:, :-1]) / 2
    phase = middle[..., None] + width[..., None] / 2 * points
    share = width[..., None] * weights / 2 / (stop - start)[:, None, None]
    values = coefficient.at(phase.ravel())
    return jnp.einsum("kpg,kpgab->kab", share, values.reshape(*phase.shape, *jnp.shape(values)[1:]))
