"""The periodic motion of one forced delay system, in pure JAX: the fixed point of the affine map of a period."""

from dataclasses import replace
from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from lobex._shapes import AnyArray
from lobex.floquet import power
from lobex.operators.chebyshev import chebyshev_points, chebyshev_polynomials
from lobex.operators.duhamel import Duhamel
from lobex.operators.elimination import pivoted_inverse
from lobex.operators.over_pieces import Pieces
from lobex.systems.forced import as_feedback
from lobex.systems.mesh import mesh_of
from lobex.systems.system import DelaySystem

# Squarings of the map: what is left of other multipliers than the largest is told by the residual.
_SQUARINGS = 12
# Samples for each Chebyshev term, among which extremes are sought, and steps of Newton's method from the nearest.
_DENSE, _STEPS = 3, 4
# Of a piece, so far from a jump that rounding does not reach it.
_ASIDE = 1e-12


class Periodic(NamedTuple):
    """The periodic motion.

    Attributes:
        output: y at the phases asked for, (S, r).
        lowest, highest: its extremes over the period, wherever they are, (r,).
        multiplier: the dominant one of the motion about it, real and imaginary part, (2,).
        residual: by how much that misses its equation.
        rounding: what rounding leaves unknown of the motion, relative to its largest displacement.
    """

    output: Float[Array, "*lanes S r"]
    lowest: Float[Array, "*lanes r"]
    highest: Float[Array, "*lanes r"]
    multiplier: Float[Array, "*lanes 2"]
    residual: Float[Array, " *lanes"]
    rounding: Float[Array, " *lanes"]


def affine_map(matrix: Float[Array, "L L"], system: DelaySystem) -> tuple[Float[Array, "N N"], Float[Array, " N"]]:
    """U and b of state ← U state + b, (N, N) and (N,), from the map of ``as_feedback``."""
    d, s = system.state_size, np.shape(system.blocks)[1]
    kept = np.r_[:d, d + s : jnp.shape(matrix)[0]]
    rows = matrix[kept]
    return rows[:, kept], rows[:, d]


class Path(NamedTuple):
    """A periodic motion as a polynomial over every piece of the period.

    Attributes:
        terms: Chebyshev terms of y, and of w where that is another, (M, terms, r + m).
        start, length: of the pieces, in periods, (M,).
    """

    terms: Float[Array, "M terms watched"]
    start: Float[AnyArray, " M"]
    length: Float[AnyArray, " M"]

    def at(self, phase: Float[AnyArray, " *S"]) -> Float[Array, "*S watched"]:
        """y and w at phases t/T."""
        piece, inside = self._place(jnp.ravel(phase))
        values = chebyshev_polynomials(2 * inside - 1, jnp.shape(self.terms)[1])
        return jnp.einsum("sk,skr->sr", values, self.terms[piece]).reshape(*jnp.shape(phase), jnp.shape(self.terms)[-1])

    def aside(self, phase: Float[AnyArray, " S"]) -> Float[Array, " S"]:
        """The same phases, those on a jump a little beside it, on the side that ``at`` takes."""
        piece, inside = self._place(phase)
        place = self.start[piece] + self.length[piece] * jnp.clip(inside, _ASIDE, 1 - _ASIDE)
        return place + jnp.round(phase - place)

    def _place(self, phase: Float[AnyArray, " S"]) -> tuple[Int[Array, " S"], Float[Array, " S"]]:
        """In which piece each phase is, and where in it, from 0 to 1."""
        start, length = jnp.asarray(self.start), jnp.asarray(self.length)
        place = start[0] + jnp.mod(phase - start[0], 1.0)
        piece: Any = jnp.sum(place[:, None] >= start[1:], axis=1)
        return piece, (place - start[piece]) / jnp.where(length[piece] > 0, length[piece], 1.0)


def periodic(system: DelaySystem, method: Duhamel, phase: Float[AnyArray, " S"]) -> tuple[Periodic, Path]:
    """(I − U)⁻¹ b, and the motion over the period that follows it, by the structure's exact response.

    Args:
        system: a forced delay system.
        method: with its nodes chosen.
        phase: phases t/T where y is wanted, (S,).
    """
    closed = as_feedback(system)
    pieces = method.respond(method.prepare(closed), closed, pivoted_inverse)
    shift, held, rounding = repeating(system, method.assemble(pieces, closed))
    path = followed(system, method, pieces, held)
    terms = path.terms[..., : system.output_size]
    pair = power.pair_by_squaring(jax.lax.stop_gradient(shift), _SQUARINGS)
    found = Periodic(
        output=path.at(phase)[..., : system.output_size],
        lowest=-highest_of(-terms),
        highest=highest_of(terms),
        multiplier=pair.value,
        residual=power.residual(shift, pair),
        rounding=rounding,
    )
    return found, path


def repeating(
    system: DelaySystem, matrix: Float[Array, "L L"]
) -> tuple[Float[Array, "N N"], Float[Array, " L"], Float[Array, ""]]:
    """From the map of ``as_feedback``, (L, L): U, the state that repeats with the 1 in it, (L,), and what rounding
    leaves unknown of it, relative to its largest displacement.
    """
    shift, push = affine_map(matrix, system)
    size, d, s = len(push), system.state_size, np.shape(system.blocks)[1]
    # One more right side tells how much (I − U)⁻¹ makes of rounding.
    noise = jnp.asarray(np.random.default_rng(3).standard_normal(size) / np.sqrt(size), dtype=push.dtype)
    fixed, amplified = jnp.linalg.solve(jnp.eye(size, dtype=push.dtype) - shift, jnp.stack([push, noise], axis=1)).T
    held = jnp.concatenate([fixed[:d], jnp.eye(1, s, dtype=push.dtype)[0], fixed[d:]])
    return shift, held, jnp.finfo(push.dtype).eps * jnp.sqrt(jnp.sum(amplified**2) * size)


def followed(
    system: DelaySystem,
    method: Duhamel,
    pieces: Pieces,
    held: Float[Array, " L"],
) -> Path:
    """The motion of a system over the period after a state, from what ``method`` makes of it as feedback."""
    closed, r = as_feedback(system), system.output_size
    if system.remembered is not None:
        closed = replace(closed, outputs=jnp.concatenate([closed.outputs, closed.recalled], axis=1))
    terms, mesh = method.path(pieces, closed, held), mesh_of(closed)
    # Without the output that is 1 at all times.
    return Path(jnp.concatenate([terms[..., :r], terms[..., r + 1 :]], axis=-1), mesh.start, mesh.length)


def highest_of(terms: Float[AnyArray, "M terms r"]) -> Float[Array, " r"]:
    """The largest value of each output over all pieces, (r,), from Chebyshev terms (M, terms, r)."""
    count = jnp.shape(terms)[1]
    grid = 2 * chebyshev_points(_DENSE * count) - 1
    slope = np.pad(np.polynomial.chebyshev.chebder(np.eye(count)), ((0, 1), (0, 0)))
    values = jnp.einsum("xk,mkr->rmx", np.polynomial.chebyshev.chebvander(grid, count - 1), terms)

    def of_one(values: Float[Array, "M points"], terms: Float[Array, "M terms"]) -> Float[Array, ""]:
        piece, point = jnp.unravel_index(jnp.argmax(values), jnp.shape(values))
        # The height, its slope and how it bends.
        derivatives = jnp.stack([terms[piece], slope @ terms[piece], slope @ slope @ terms[piece]], axis=1)

        def step(x: Float[Array, ""], _step: None) -> tuple[Float[Array, ""], None]:
            _, rise, bend = chebyshev_polynomials(x, count) @ derivatives
            return jnp.clip(x - cast(Array, jnp.where(bend < 0, rise / bend, 0.0)), low, high), None

        low, start, high = (jnp.asarray(grid)[jnp.clip(point + k, 0, len(grid) - 1)] for k in (-1, 0, 1))
        found = jax.lax.scan(step, start, None, length=_STEPS)[0]
        # Where it is highest, its height does not follow the place: so are derivatives.
        return chebyshev_polynomials(jax.lax.stop_gradient(found), count) @ terms[piece]

    return jax.vmap(of_one)(values, jnp.moveaxis(terms, 2, 0))
