"""The structure's part of an operator over one period: what pieces make of the past, whatever the coefficients.

The past that a piece sees is z at the start of the oldest piece that is remembered, and the forces at the nodes of all
pieces since. All else, what was and what is, the structure makes of these: exactly, so that what is remembered is known
between the nodes as well as at them.
"""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, Shaped

from lobex._pytree import pytree
from lobex._shapes import AnyArray
from lobex.operators.lookup import look_up, pieces_back
from lobex.operators.moments import legendre_values
from lobex.operators.response import PieceResponse, forced_response, free_response, gauss_nodes
from lobex.systems.mesh import Mesh, mesh_of
from lobex.systems.system import DelaySystem

# What is remembered is sampled so much more finely than the force: its waves are the force's and the structure's own.
_FINER, _MORE = 2, 8


@pytree(static=("sizes",))
class Prepared:
    """M pieces with q nodes each, of a past of size N = d + H·q·e.

    Few and tall matrices, since in a batch each product costs more than its arithmetic.

    Attributes:
        past: what a piece has of its past, (M, rows, N): outputs at the nodes, what each of K delays brings there,
            z at its start and its end, and z at the start of the second oldest piece.
        force: what the forces at its nodes add to that, (M, rows, q·e): to the outputs, to z at the end, and to what
            delays bring that may be shorter than a piece.
        missed: how much of each mode's vibration the nodes cannot follow, (M, n), from 0 to 1.
        flights: outputs at samples of the gap after each piece from z at its start, (M, samples, r, d), or None.
        sizes: q·r, K, q·m and d.
        resolvent: from the forces at the nodes without those that they themselves bring about to all of them,
            (M, q·e, q·e), where the coefficients that it takes are the same whatever the gain.
    """

    past: Float[Array, "M rows N"]
    force: Float[Array, "M driven qe"]
    missed: Float[AnyArray, "M n"]
    flights: Float[Array, "M samples r d"] | None
    sizes: tuple[int, int, int, int]
    resolvent: Float[Array, "M qe qe"] | None = None

    @property
    def starts(self) -> tuple[int, int, int, int]:
        """Where the rows of ``past`` after the first begin."""
        outputs, delays, memory, state = self.sizes
        first = outputs + delays * memory
        return outputs, first, first + state, first + 2 * state

    @property
    def free(self) -> Float[Array, "M qr N"]:
        """Outputs at the nodes from the past, (M, q·r, N)."""
        return self.past[:, : self.starts[0]]

    @property
    def remembered(self) -> Float[Array, "M K qm N"]:
        """What each delay brings from the past, (M, K, q·m, N)."""
        _, delays, memory, _ = self.sizes
        rows = self.past[:, self.starts[0] : self.starts[1]]
        return rows.reshape(jnp.shape(rows)[0], delays, memory, -1)

    @property
    def advance(self) -> Float[Array, "M d N"]:
        """z at the start of the second oldest piece from the past, (M, d, N)."""
        return self.past[:, self.starts[3] :]

    @property
    def forced(self) -> Float[Array, "M qr qe"]:
        """Outputs at the nodes from the forces there, (M, q·r, q·e)."""
        return self.force[:, : self.sizes[0]]

    @property
    def recent(self) -> Float[Array, "M K qm qe"] | None:
        """What each delay brings from the forces of the same piece, (M, K, q·m, q·e), if it may be that short."""
        outputs, delays, memory, state = self.sizes
        rows = self.force[:, outputs + state :]
        return rows.reshape(jnp.shape(rows)[0], delays, memory, -1) if jnp.shape(rows)[1] else None


def prepare(system: DelaySystem, nodes: int, in_flight: int) -> Prepared:
    """The structure's part, with q = ``nodes`` and free vibrations sampled ``in_flight`` times."""
    mesh = mesh_of(system)
    fine = None if mesh.repeats else points_between(nodes)
    response = jax.vmap(lambda length: forced_response(system, length, nodes, fine))(mesh.length)
    flights, through, push = None, response.through, response.push
    if mesh.gap is not None:
        flights, gap = jax.vmap(lambda length: free_response(system, length, gauss_nodes(in_flight)[0]))(mesh.gap)
        through, push = gap @ through, gap @ push
    d, count, history = system.state_size, mesh.pieces, mesh.history
    width = nodes * system.force_size
    size = d + history * width
    # The pieces of the past of each piece, oldest first.
    before = pieces_back(mesh)[:, :-1]

    def past(order: Int[Array, " H"]) -> Float[Array, "H+1 d N"]:
        """z at the start of every piece of the past, and now, (H + 1, d, N)."""
        first = jnp.eye(d, size, dtype=through.dtype)

        def over(
            state: Float[Array, "d N"], piece: tuple[Float[Array, "d d"], Float[Array, "d qe"], Int[Array, ""]]
        ) -> tuple[Float[Array, "d N"], Float[Array, "d N"]]:
            passed, pushed, column = piece
            state = jax.lax.dynamic_update_slice_in_dim(passed @ state, pushed, column, axis=1)
            return state, state

        pieces = through[order], push[order], jnp.asarray(d + width * np.arange(history))
        return jnp.concatenate([first[None], jax.lax.scan(over, first, pieces)[1]])

    states = jax.vmap(past)(jnp.asarray(before))
    now = states[:, -1]
    if mesh.repeats:
        # What acts lies in the oldest piece, at the same nodes.
        recalled = response.recalled[before[:, 0]]
        remembered, recent = jnp.pad(recalled, ((0, 0), (0, 0), (0, size - d - width)))[:, None], None
    else:
        remembered, recent = _looked_up(system, mesh, response, states, nodes)
    delays = jnp.shape(remembered)[1]
    past_rows = [response.free @ now, remembered.reshape(count, -1, size), now, response.through @ now, states[:, 1]]
    force_rows = [response.forced, response.push, *([] if recent is None else [recent.reshape(count, -1, width)])]
    return Prepared(
        past=jnp.concatenate(past_rows, axis=1),
        force=jnp.concatenate(force_rows, axis=1),
        missed=response.missed,
        flights=flights,
        sizes=(nodes * system.output_size, delays, jnp.shape(remembered)[2], d),
    )


def _looked_up(
    system: DelaySystem, mesh: Mesh, response: PieceResponse, states: Float[Array, "M H d N"], nodes: int
) -> tuple[Float[Array, "M K qm N"], Float[Array, "M K qm qe"] | None]:
    """What every delay brings to the nodes of every piece, from the past and from the forces of the same piece."""
    d, size = system.state_size, jnp.shape(states)[-1]
    count, history = mesh.pieces, mesh.history
    width = nodes * system.force_size
    m = jnp.shape(system.recalled)[1]
    recalled = response.recalled.reshape(count, -1, m, d + width)
    synthesis = _synthesis(len(points_between(nodes)))

    def at_piece(piece: tuple[Shaped[Array, "..."], ...]) -> tuple[Float[Array, "K qm N"], Float[Array, "K qm qe"]]:
        slot, inside, order, states = piece
        weights = jnp.tensordot(_legendre(2 * inside - 1, len(synthesis)), synthesis, ((0,), (0,)))
        # One product for all pieces of the past, of which each delay takes its own: to gather these takes more memory.
        chosen = (jnp.arange(history + 1) == slot[..., None])[..., None] * weights[:, :, None]
        made = jnp.einsum("kqhf,hfmx->kqmhx", chosen, recalled[order])
        whole = jnp.einsum("kqmhd,hdN->kqmN", made[..., :d], states)
        columns = made[..., :history, d:].reshape(*jnp.shape(whole)[:3], history * width)
        whole = whole + jnp.pad(columns, ((0, 0), (0, 0), (0, 0), (d, 0)))
        rows = len(system.delays), nodes * m
        return whole.reshape(*rows, size), made[..., history, d:].reshape(*rows, width)

    order = jnp.asarray(pieces_back(mesh))
    slot, inside = look_up(system, mesh, gauss_nodes(nodes)[0])
    remembered, recent = jax.lax.map(at_piece, (slot, inside, order, states))
    return remembered, recent if mesh.recent else None


def points_between(nodes: int) -> np.ndarray:
    """Where what happens between ``nodes`` is sampled, as places from 0 to 1."""
    return gauss_nodes(_FINER * nodes + _MORE)[0]


def _synthesis(count: int) -> np.ndarray:
    """Legendre terms from samples at Gauss points, (terms, points)."""
    points, weights = gauss_nodes(count)
    return (2 * np.arange(count) + 1)[:, None] * (weights[:, None] * legendre_values(points, count)).T


def _legendre(x: Float[Array, " *lanes"], count: int) -> Float[Array, " {count} *lanes"]:
    """P_0 … P_{count−1}, along a new first axis; in a loop, since XLA would begin anew for every one of them."""

    def step(
        pair: tuple[Float[Array, " *lanes"], Float[Array, " *lanes"]], order: Float[Array, ""]
    ) -> tuple[tuple[Float[Array, " *lanes"], Float[Array, " *lanes"]], Float[Array, " *lanes"]]:
        before, now = pair
        return (now, ((2 * order + 1) * x * now - order * before) / (order + 1)), now

    return jax.lax.scan(step, (jnp.zeros_like(x), jnp.ones_like(x)), jnp.arange(float(count)))[1]
