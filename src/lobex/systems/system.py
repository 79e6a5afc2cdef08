"""The one model that everything shares: a structure, a period, and a sum of forces, some of them delayed."""

from collections.abc import Callable
from dataclasses import replace
from functools import reduce
from itertools import chain
from operator import add
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.structures.modes import Modes, check_modes
from lobex.systems.coefficients import Coefficient, Framed, OneChip, at_nodes, bending_of
from lobex.systems.delays import Delay, WholePeriod
from lobex.systems.links import Link
from lobex.systems.terms import Distributed, Feedback, Forcing, Regenerative, Term

# Of a delay, what single precision leaves.
_ROUNDING = 1e-6


class Forces(NamedTuple):
    """The coefficients of all terms at k phases.

    Attributes:
        present: P, of y(t), (k, e, r).
        delayed: Q, of w(t − τ), for each of ``DelaySystem.delays``, (k, e, m) each.
    """

    present: Float[AnyArray, "k e r"]
    delayed: tuple[Float[AnyArray, "k e m"], ...]


class Closed(NamedTuple):
    """Places that every delay that acts carries to one another.

    Attributes:
        places: of each the jump that it comes from, and how often each of ``DelaySystem.delays`` carries it, in order.
        parts: into how many equal pieces each part of the period that begins at them is cut.
        links: which of these pieces leave what acts in which.
    """

    places: tuple[tuple[int, tuple[int, ...]], ...]
    parts: tuple[int, ...]
    links: tuple[Link, ...]


class Places(NamedTuple):
    """What is known of where pieces end.

    Attributes:
        kept: of the places at which they may, those that matter.
        reach: how many pieces hold the longest delay.
        complete: whether nothing else bends a force.
        closed: places that take all of it in, if there are few.
        jumps: how many of the places are jumps, the first ones.
    """

    kept: tuple[int, ...]
    reach: int
    complete: bool
    closed: Closed | None = None
    jumps: int = 0

    @property
    def open(self) -> "Places":
        """For what looks up at every point of a piece, whether a force acts there or not."""
        return self._replace(closed=None)

    @property
    def as_they_move(self) -> "Places":
        """For derivatives by what moves them: jumps at one place part then, and what is closed opens."""
        kept = tuple(sorted({*range(self.jumps), *self.kept}))
        return self.open._replace(kept=kept, reach=self.reach + len(kept) - len(self.kept))


@pytree(static=("longest", "shortest", "places"))
class DelaySystem:
    """ż = A z + E f,  f = Σ P(t) y + Σ Q(t) w(t − τ(t)) + Σ ∫ Q(t, s) w(t − s) ds + g(t),  y = C z,  w = D z.

    All coefficients have the period T.
    A is block-diagonal with n blocks of size s (s = 2 for a vibration mode), so the state size is d = n·s.

    Attributes:
        blocks: the diagonal blocks of A, shape (n, s, s), 1/s.
        inputs: the rows of E per block, shape (n, s, e).
        outputs: the columns of C per block, shape (n, r, s): what acts now.
        period: T, s.
        terms: the forces; distributed ones become point delays.
        remembered: the columns of D per block, shape (n, m, s): what acts later. None where it is y.
        longest: the longest delay, in periods, or more: so far back a method remembers.
        shortest: the shortest delay, in periods, or less.
        places: where pieces have to end, of all places where they may, see ``known_places``; None for all.
    """

    blocks: Float[AnyArray, "n s s"]
    inputs: Float[AnyArray, "n s e"]
    outputs: Float[AnyArray, "n r s"]
    period: Number
    terms: tuple[Term, ...]
    remembered: Float[AnyArray, "n m s"] | None = None
    longest: float = 1.0
    shortest: float = 1.0
    places: Places | None = None

    def __post_init__(self) -> None:
        terms = (term.points() if isinstance(term, Distributed) else (term,) for term in self.terms)
        object.__setattr__(self, "terms", tuple(chain.from_iterable(terms)))

    @property
    def state_size(self) -> int:
        """d, the size of z."""
        return np.shape(self.blocks)[0] * np.shape(self.blocks)[1]

    @property
    def force_size(self) -> int:
        """e, the size of f."""
        return np.shape(self.inputs)[2]

    @property
    def output_size(self) -> int:
        """r, the size of y."""
        return np.shape(self.outputs)[1]

    @property
    def recalled(self) -> Float[AnyArray, "*lanes n m s"]:
        """The columns of D per block, (n, m, s)."""
        return self.outputs if self.remembered is None else self.remembered

    @property
    def feedback(self) -> tuple[Feedback, ...]:
        """The terms that answer the motion: what multipliers are made of."""
        return tuple(term for term in self.terms if not isinstance(term, Forcing | Distributed))

    @property
    def forcing(self) -> tuple[Forcing, ...]:
        """The terms that do not."""
        return tuple(term for term in self.terms if isinstance(term, Forcing))

    @property
    def constant(self) -> bool:
        """Whether no coefficient of the feedback changes with time and every delay is the whole period."""
        return all(term.coefficient.constant for term in self.feedback) and self.repeats

    @property
    def repeats(self) -> bool:
        """Whether every delay is the whole period."""
        return all(isinstance(delay, WholePeriod) for delay in self.delays)

    @property
    def closed(self) -> Closed | None:
        """The places that delays carry to one another, where these are known."""
        return None if self.places is None else self.places.closed

    @property
    def delays(self) -> tuple[Delay, ...]:
        """The delays, those of the whole period as one that comes first."""
        return tuple(delay for delay, _ in self._delayed)

    @property
    def _delayed(self) -> tuple[tuple[Delay, tuple[Feedback, ...]], ...]:
        """Each of ``delays`` with the terms that have it."""
        own = [term for term in self.feedback if term.delay is not None]
        whole = tuple(term for term in own if isinstance(term.delay, WholePeriod))
        others = [(term.delay, (term,)) for term in own if not isinstance(term.delay, WholePeriod)]
        return (*[(WholePeriod(), whole)] * bool(whole), *others)

    @property
    def to_nodes(self) -> bool:
        """Whether every delay brings what was at nodes of a piece to nodes of another one, or of itself."""
        return self.repeats or self.closed is not None

    @property
    def bends(self) -> bool:
        """Whether a coefficient of the feedback bends within pieces."""
        return any(bending_of(term.coefficient) is not None for term in self.feedback)

    @property
    def chips(self) -> tuple[OneChip, ...]:
        """Of each of ``delays`` the coefficient, where all of them are of one chip each, met node to node, and forces
        have more than one component; none else.
        """
        terms = [term for term in self.feedback if term.delay is not None]
        terms.sort(key=lambda term: not isinstance(term.delay, WholePeriod))
        found = [term.coefficient for term in terms if isinstance(term.coefficient, OneChip)]
        known = len(found) == len(terms) == len(self.delays) and all(coefficient.single for coefficient in found)
        return tuple(found) if known and self.force_size > 1 and self.to_nodes else ()

    @property
    def regenerative(self) -> bool:
        """Whether all feedback is of what is left by the pass before and met again."""
        return self.remembered is None and all(isinstance(term, Regenerative) for term in self.feedback)

    def lags(self, phase: Float[AnyArray, " k"]) -> tuple[Float[Array, " k"], ...]:
        """Every delay at phases, in periods, of their shape: no number, rather than a wrong one, where it is not above
        zero and in the range that was said.
        """
        shares = tuple(delay.shares(phase, self.period) for delay in self.delays)
        return tuple(jnp.where(self.declared(lag), lag, jnp.nan) for lag in shares)

    def declared(self, lag: Float[AnyArray, "..."]) -> Bool[AnyArray, "..."]:
        """Whether delays, in periods, are above zero and in the range that was said."""
        return (lag > 0) & (lag >= self.shortest * (1 - _ROUNDING)) & (lag <= self.longest * (1 + _ROUNDING))

    def within(self, inside: Number, phase: Float[AnyArray, " k"]) -> Forces:
        """All coefficients at phases (k,) of the piece that holds the phase ``inside``."""
        return self._forces(lambda coefficient: coefficient.within(inside, phase))

    def at_nodes(self, start: Number, length: Number, nodes: int) -> Forces:
        """All coefficients at Gauss' nodes of a piece."""
        return self._forces(lambda coefficient: at_nodes(coefficient, start, length, nodes))

    def acting(self, delay: int, phase: Float[AnyArray, " k"]) -> Bool[AnyArray, " k"]:
        """Whether forces of one of ``delays`` act at phases, (k,)."""
        acting = jnp.zeros(np.shape(phase), dtype=bool)
        for term in self._delayed[delay][1]:
            bending = bending_of(term.coefficient)
            acts = jnp.any(term.coefficient.at(phase) != 0, axis=(1, 2)) if bending is None else bending.acts(phase)
            acting = acting | acts
        return acting

    def at(self, phase: Float[AnyArray, " k"]) -> Forces:
        """All coefficients at any phases (k,), jumps included."""
        return self._forces(lambda coefficient: coefficient.at(phase))

    def mean(self, start: Float[AnyArray, " k"], stop: Float[AnyArray, " k"]) -> Forces:
        """Averages of all coefficients over the intervals [start, stop], each of shape (k,)."""
        return self._forces(lambda coefficient: coefficient.mean(start, stop))

    def mean_forcing(self, start: Float[AnyArray, " k"], stop: Float[AnyArray, " k"]) -> Float[AnyArray, "k e"] | None:
        """Averages of the forcing over the intervals [start, stop], (k, e); None without forcing."""
        parts: list[Any] = [term.coefficient.mean(start, stop)[..., 0] for term in self.forcing]
        return reduce(add, parts) if parts else None

    def drift(self) -> Float[AnyArray, "d d"]:
        """A as a dense matrix, (d, d)."""
        n, s = np.shape(self.blocks)[:2]
        return jnp.einsum("ij,iab->iajb", jnp.eye(n), self.blocks).reshape(n * s, n * s)

    def input_matrix(self) -> Float[AnyArray, "d e"]:
        """E as a dense matrix, (d, e)."""
        return namespace(self.inputs).reshape(self.inputs, (self.state_size, self.force_size))

    def output_matrix(self) -> Float[AnyArray, "r d"]:
        """C as a dense matrix, (r, d)."""
        return dense_outputs(self.outputs)

    def _forces(self, value: Callable[[Coefficient], Float[AnyArray, "k e r"]]) -> Forces:
        """The values of all coefficients, summed by what they act on."""
        present: list[Any] = []
        whole: list[Any] = []
        others: list[Any] = []
        for term in self.feedback:
            now, before = term.parts(value(term.coefficient))
            present += [] if now is None else [now]
            if before is not None:
                (whole if isinstance(term.delay, WholePeriod) else others).append(before)
        if not present:
            shape = jnp.shape((whole + others)[0])[0], self.force_size, self.output_size
            present = [namespace(whole, others).zeros(shape)]
        every = tuple([reduce(add, whole)] if whole else []) + tuple(others)
        return Forces(reduce(add, present), every)


def dense_outputs(outputs: Float[AnyArray, "n r s"]) -> Float[AnyArray, "r d"]:
    """Columns per block (n, r, s) as one matrix, (r, d)."""
    n, r, s = np.shape(outputs)
    return namespace(outputs).swapaxes(outputs, 0, 1).reshape(r, n * s)


def modal_system(modes: Modes, period: Number, terms: tuple[Term, ...], **others: Any) -> DelaySystem:
    """The delay system of vibration modes under contact forces; the state of a mode is (u, u̇/ω)."""
    check_modes(modes)
    lib = namespace(modes)
    omega = lib.asarray(modes.angular_frequency)
    zero, one = lib.zeros_like(omega), lib.ones_like(omega)
    unit = lib.stack([lib.stack([zero, one], -1), lib.stack([-one, -2 * modes.damping_ratio], -1)], -2)
    shape, loading = lib.asarray(modes.shape), lib.asarray(modes.loading)
    none = lib.zeros_like(shape)
    seen, acting = modes.quadrature, modes.force_quadrature
    return DelaySystem(
        blocks=omega[:, None, None] * unit,
        inputs=lib.stack([none if acting is None else acting / omega[:, None], loading / omega[:, None]], axis=1),
        outputs=lib.stack([shape, none if seen is None else lib.asarray(seen)], axis=2),
        period=period,
        terms=terms,
        **others,
    )


def whole_state(system: DelaySystem) -> DelaySystem:
    """The same system with y = w = z: the thesis' form, in which the delay acts on the whole state (3.1)."""
    n, s = np.shape(system.blocks)[:2]
    unit = jnp.eye(n * s, dtype=jnp.result_type(system.blocks)).reshape(n, s, n * s)
    if system.remembered is not None:
        raise ValueError("full = True takes a system that remembers y alone; give full=False")
    left, right = system.input_matrix(), system.output_matrix()
    return replace(
        system,
        inputs=unit,
        outputs=jnp.swapaxes(unit, 1, 2),
        terms=tuple(replace(term, coefficient=Framed(left, term.coefficient, right)) for term in system.feedback),
    )
