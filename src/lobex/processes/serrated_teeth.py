"""The force of serrated teeth on what one of the teeth ahead has left.

At every height a tooth meets now the tooth ahead and now another one, so that as a whole the force bends at as many
angles as there are heights: too many for pieces to end there. Each height is integrated over its own angles exactly,
into the polynomial that is nearest to the force over a piece. What that leaves is orthogonal to all that the nodes hold
of a motion, so that multipliers miss the product of what both leave.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Real

from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import Number
from lobex.processes.teeth import Teeth
from lobex.processes.wave_cells import Lines, angles_met, bends, cells_up_to, waves_for
from lobex.systems.coefficients import Jumps, Piece, gauss_nodes, pieces_between

_TURN = 2 * np.pi
# Of the polynomial of which a mean over a step is taken.
_MEAN = 6
# Heights between bends, and one more for every second node.
_LEAST = 6


class _Edges(NamedTuple):
    """Beginnings and ends of what teeth meet at heights: of a whole wave and of what is left above the last one.

    Attributes:
        angle: rad, (2, n, k, 4).
        height: above the beginning of the wave, m, (2, n, k).
        weight: m, (2, n, k).
        wave: which of the two, and at what height it begins, m, and how often it counts, (w,) each.
    """

    angle: Float[Array, "2 n k 4"]
    height: Float[Array, "2 n k"]
    weight: Float[Array, "2 n k"]
    wave: tuple[np.ndarray, Float[Array, " w"], Float[Array, " w"]]


@pytree(static=("ahead", "bends"))
class SerratedTeeth(Teeth):
    """The force H(t) of n teeth on what those ``ahead`` of them by so many pitches have left.

    Attributes:
        before: how far ahead each is at t = 0, in periods, (n,).
        wave_length: λ, m.
        twist: by which edges lag behind their tips, rad/m; None of straight ones.
        lines: what each may meet.
        ahead: by how many pitches.
        bends: how many places of ``wave_cells.bends`` there are at most; None where that is not known.
    """

    wave_length: Number
    twist: Number | None
    lines: Lines
    ahead: int
    bends: int | None

    def jumps(self) -> Jumps:
        """Where a tip enters, and a straight edge leaves as well."""
        lib = namespace(self.entry, self.exit, self.before)
        ends = (self.entry, self.exit) if self.twist is None else (self.entry,)
        place = [angle * self.teeth / _TURN - lib.asarray(self.before) for angle in ends]
        return Jumps(lib.concatenate(place), np.repeat(np.arange(len(ends)) > 0, self._count))

    def pieces(self) -> tuple[Piece, ...]:
        return pieces_between(self.jumps().phase)

    def acts(self, phase: Real[Any, " k"]) -> Bool[Any, " k"]:
        """Whether some tooth is in the cut, whatever it meets there."""
        tip = _TURN / self.teeth * (phase[:, None, None] + self._order() + self._ahead)
        lag = 0.0 if self.twist is None else self.twist * self.depth
        return jnp.any(jnp.mod(tip - self.entry, _TURN) < self.exit - self.entry + lag, axis=(1, 2))

    def within(self, inside: Real[Any, "..."], phase: Real[Any, " k"]) -> Float[Any, "k e r"]:
        return self.at(phase)

    def at(self, phase: Real[Any, " k"]) -> Float[Any, "k e r"]:
        """At phases by themselves: a sum over heights, which is off by as much as one of them."""
        edges = self._edges(1)

        def one(phase: Number) -> Float[Any, "1 e r"]:
            return self._over(edges, phase, 0.0, 1)

        return jax.lax.map(one, jnp.asarray(phase, dtype=jnp.result_type(float)))[:, 0]

    def mean(self, start: Real[Any, " k"], stop: Real[Any, " k"]) -> Float[Any, "k e r"]:
        edges, weights = self._edges(_MEAN), gauss_nodes(_MEAN)[1]

        def one(ends: tuple[Number, Number]) -> Float[Any, "e r"]:
            return jnp.tensordot(weights, self._over(edges, ends[0], ends[1] - ends[0], _MEAN), 1)

        return jax.lax.map(one, (jnp.asarray(start), jnp.asarray(stop)))

    def nearest(self, start: Number, length: Number, nodes: int) -> Float[Any, "q e r"]:
        """At Gauss' nodes of a piece: of each factor that follows the heights the nearest polynomial through them."""
        return self._over(self._edges(nodes), start, length, nodes)

    @property
    def _ahead(self) -> Float[Any, " n"]:
        """``before`` of each."""
        return jnp.asarray(self.before)

    @property
    def _count(self) -> int:
        """n."""
        return np.shape(self.lines.feed)[0]

    def _order(self) -> Float[np.ndarray, "teeth 1"]:
        """Of teeth that are alike, all around the cutter."""
        return np.arange(float(self.teeth))[:, None]

    def _edges(self, nodes: int) -> _Edges:
        """Of all heights in the cut, as many as motions ask for that so many nodes hold."""
        place: Any = bends(self.lines, (jnp.sin(self.entry), jnp.sin(self.exit), 1.0))
        if self.bends is not None:
            # Of other numbers than those that they were counted of there may be more: no number, then.
            most = place.shape[1] - self.bends
            place = jnp.where(jnp.any(place[:, :most] > 0), jnp.nan, place[:, most:])
        # As many whole waves as there are in the depth, whatever rounding makes of it.
        count = jnp.floor(jax.lax.stop_gradient(self.depth / self.wave_length))
        above: Any = self.depth - count * self.wave_length
        parts = [cells_up_to(place, end, _LEAST + nodes // 2) for end in (_TURN, above * _TURN / self.wave_length)]
        angle = [angles_met(self.lines, part.turned, self.ahead, self.entry, self.exit) for part in parts]
        unit: Any = self.wave_length / _TURN
        if self.twist is None:
            number, often = jnp.zeros(1), count[None]
        else:
            number, often = waves_for(count)
        kind = np.append(np.zeros(len(number), dtype=int), 1)
        begins: Any = self.wave_length * jnp.append(number, count)
        return _Edges(
            jnp.stack(angle),
            jnp.stack([unit * part.turned for part in parts]),
            jnp.stack([unit * part.weight for part in parts]),
            (kind, begins, jnp.append(often, 1.0)),
        )

    def _over(self, edges: _Edges, start: Number, length: Number, nodes: int) -> Float[Any, "q e r"]:
        """H at Gauss' nodes of a piece, or of no length at one phase."""
        points = gauss_nodes(nodes)[0]
        parts = self._moments(edges, start, length, nodes)
        synthesis = np.polynomial.legendre.legvander(2 * points - 1, nodes - 1) * (np.arange(nodes) + 0.5)
        still, *turning = jnp.moveaxis(parts @ synthesis.T, 2, 0)
        tip = _TURN / self.teeth * (start + length * points + self._order()[..., None] + self._ahead[:, None])
        tip = jnp.swapaxes(tip, 0, 1)
        along, across, between = (self.law.at(self, jnp.asarray(angle)) for angle in (0.0, np.pi / 2, np.pi / 4))
        # A force of a chip has a mean and parts with cos 2φ and sin 2φ.
        mean = (along + across) / 2
        cosine, sine = jnp.cos(2 * tip) * still, jnp.sin(2 * tip) * still
        if turning:
            cosine, sine = (
                jnp.cos(2 * tip) * turning[0] + jnp.sin(2 * tip) * turning[1],
                jnp.sin(2 * tip) * turning[0] - jnp.cos(2 * tip) * turning[1],
            )
        factors = (mean, (along - across) / 2, between - mean)
        entries = sum(
            force[:, None] * jnp.sum(part, axis=(0, 1))
            for force, part in zip(factors, (still, cosine, sine), strict=True)
        )
        return self._shaped(1.0, entries)

    def _moments(self, edges: _Edges, start: Number, length: Number, nodes: int) -> Float[Array, "n teeth w q"]:
        """Integrals over the heights and, from −1 to 1, over the piece of what is met, times each of 1 and, with a
        twist κ, cos 2κz and sin 2κz, and times each of q Legendre polynomials.
        """
        wide = jnp.where(length > 0, length, 1.0)
        sign = np.array([1.0, -1.0, 1.0, -1.0])
        kind, begins, often = edges.wave

        def of_wave(wave: tuple[Any, Number, Number]) -> Float[Array, "n teeth w q"]:
            which, begin, times = wave
            angle, height, weight = edges.angle[which], edges.height[which] + begin, times * edges.weight[which]
            factors = [weight]
            if self.twist is not None:
                lag = self.twist * height
                angle = angle + lag[..., None]
                factors += [weight * jnp.cos(2 * lag), weight * jnp.sin(2 * lag)]
            factor = (jnp.stack(factors, axis=1)[..., None] * sign).reshape(len(weight), len(factors), -1)
            place = (angle * self.teeth / _TURN - self._ahead[:, None, None]).reshape(len(weight), -1)
            place = place[:, None] - self._order()
            # The next after the start, of all that there are in turns.
            after = jnp.mod(place - start, float(self.teeth))
            passed = jnp.round((start + after - place) / self.teeth)
            inside = jnp.where(after < length, 2 * after / wide - 1, 1.0)

            def step(
                pair: tuple[Float[Array, "n teeth k"], Float[Array, "n teeth k"]], order: Float[Array, ""]
            ) -> tuple[tuple[Float[Array, "n teeth k"], Float[Array, "n teeth k"]], Float[Array, "n teeth w"]]:
                before, now = pair
                after = ((2 * order + 1) * inside * now - order * before) / (order + 1)
                return (now, after), jnp.einsum("nok,nwk->now", (before - after) / (2 * order + 1), factor)

            first = jnp.einsum("nok,nwk->now", 2 * passed + 1 - inside, factor)[..., None]
            if nodes == 1:
                return first
            begun = jnp.ones_like(inside), inside
            rest = jax.lax.scan(step, begun, jnp.arange(1.0, nodes))[1]
            return jnp.concatenate([first, jnp.moveaxis(rest, 0, -1)], axis=-1)

        size = self._count, self.teeth, 1 if self.twist is None else 3, nodes

        def add(total: Float[Array, "n teeth w q"], wave: Any) -> tuple[Float[Array, "n teeth w q"], None]:
            return total + of_wave(wave), None

        return jax.lax.scan(add, jnp.zeros(size), (jnp.asarray(kind), begins, often))[0]
