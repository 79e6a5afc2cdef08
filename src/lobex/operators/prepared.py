"""The structure's part of an operator over one period: what pieces make of their start, whatever the coefficients.

A piece starts with z and has what the past brings to its nodes; it ends with z, and leaves to the pieces after it what
delays bring there. All of it the structure makes of z at the start and of the forces at the nodes: exactly, so that
what is remembered is known between the nodes as well as at them.
"""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Shaped

from lobex._pytree import pytree
from lobex._shapes import AnyArray
from lobex.operators.lookup import look_up, pieces_back
from lobex.operators.moments import legendre_values
from lobex.operators.response import PieceResponse, forced_response, free_response, gauss_nodes
from lobex.systems.mesh import Mesh, mesh_of
from lobex.systems.system import DelaySystem

# What is remembered is sampled so much more finely than the force: its waves are the force's and the structure's own.
_FINER, _MORE = 2, 8


@pytree(static=("state",))
class Prepared:
    """M pieces with q nodes each: what they make of z at their start and of the forces at their nodes, side by side.

    Attributes:
        state: d.
        made: outputs at the nodes, and z at the end of the piece, (M, q·r + d, d + q·e).
        flown: z at the start of the next, (M, d, d + q·e); None where that is z at the end.
        left: what delays bring of it to the nodes of later pieces, by each of ``Mesh.links``: one or every one of K,
            (L, K, q·m, d + q·e).
        chips: and the chips that are due of it there, (L, q, d + q·e), where these are the same whatever the gain;
            ``left`` is None then.
        recent: and to its own nodes, where a delay may be that short, (M, K, q·m, d + q·e); or None.
        missed: how much of each mode's vibration the nodes cannot follow, (M, n), from 0 to 1.
        flights: outputs at samples of the gap after each piece from z at its start, (M, samples, r, d), or None.
        resolvent: from the forces at the nodes without those that they themselves bring about to all of them,
            (M, q·e, q·e), where the coefficients that it takes are the same whatever the gain.
    """

    state: int
    made: Float[Array, "M qrd dqe"]
    flown: Float[Array, "M d dqe"] | None
    left: Float[Array, "L K qm dqe"] | None
    recent: Float[Array, "M K qm dqe"] | None
    missed: Float[AnyArray, "M n"]
    flights: Float[Array, "M samples r d"] | None
    resolvent: Float[Array, "M qe qe"] | None = None
    chips: Float[Array, "L q dqe"] | None = None

    @property
    def seen(self) -> Float[Array, "M qr dqe"]:
        """Outputs at the nodes."""
        return self.made[:, : -self.state]

    @property
    def onward(self) -> Float[Array, "M d dqe"]:
        """z at the start of the next piece."""
        return self.made[:, -self.state :] if self.flown is None else self.flown


def prepare(system: DelaySystem, nodes: int, in_flight: int, samples: int | None = None) -> Prepared:
    """The structure's part, with q = ``nodes``, free vibrations sampled ``in_flight`` times, and the structure's kernel
    over pieces ``samples`` times, as ``forced_response`` says.
    """
    mesh = mesh_of(system)
    fine = None if mesh.to_nodes else points_between(nodes)
    # Of pieces as long as each other one, where that is known.
    first, same = np.unique(mesh.as_long_as, return_inverse=True)
    response = jax.vmap(lambda length: forced_response(system, length, nodes, fine, samples))(mesh.length[first])
    if len(first) < mesh.pieces:
        response = jax.tree.map(lambda part: part[same], response)
    landed = jnp.concatenate([response.through, response.push], axis=2)
    flights = flown = None
    if mesh.gap is not None:
        flights, gap = jax.vmap(lambda length: free_response(system, length, gauss_nodes(in_flight)[0]))(mesh.gap)
        flown = gap @ landed
    if mesh.to_nodes:
        left, recent = response.recalled[np.array([link.piece for link in mesh.links])][:, None], None
    else:
        left, recent = _looked_up(system, mesh, response, nodes)
    return Prepared(
        state=system.state_size,
        made=jnp.concatenate([jnp.concatenate([response.free, response.forced], axis=2), landed], axis=1),
        flown=flown,
        left=left,
        recent=recent,
        missed=response.missed,
        flights=flights,
    )


def _looked_up(
    system: DelaySystem, mesh: Mesh, response: PieceResponse, nodes: int
) -> tuple[Float[Array, "L K qm dqe"], Float[Array, "M K qm dqe"] | None]:
    """What every piece leaves to those after it, and to itself."""
    count, history = mesh.pieces, mesh.history
    size = jnp.shape(response.push)[1] + jnp.shape(response.push)[2]
    m = jnp.shape(system.recalled)[1]
    recalled = response.recalled.reshape(count, -1, m, size)
    synthesis = _synthesis(len(points_between(nodes)))

    def at_piece(piece: tuple[Shaped[Array, "..."], ...]) -> Float[Array, "H+1 K qm dqe"]:
        slot, inside, order = piece
        weights = jnp.tensordot(_legendre(2 * inside - 1, len(synthesis)), synthesis, ((0,), (0,)))
        # One product for all pieces of the past, of which each delay takes its own: to gather these takes more memory.
        chosen = (jnp.arange(history + 1) == slot[..., None])[..., None] * weights[:, :, None]
        made = jnp.einsum("kqhf,hfmx->hkqmx", chosen, recalled[order])
        return made.reshape(history + 1, len(system.delays), nodes * m, size)

    order = pieces_back(mesh)
    slot, inside = look_up(system, mesh, gauss_nodes(nodes)[0])
    brought = jax.lax.map(at_piece, (slot, inside, jnp.asarray(order)))
    # The piece j later finds it j pieces back.
    later = np.arange(1, history + 1)
    left = brought[(np.arange(count)[:, None] + later) % count, history - later]
    return left.reshape(-1, *jnp.shape(left)[2:]), brought[:, history] if mesh.recent else None


def bytes_between(system: DelaySystem, nodes: int) -> int:
    """What delays bring between nodes takes at one point, at least, in bytes; none where they bring nodes to nodes."""
    mesh = mesh_of(system)
    if mesh.to_nodes:
        return 0
    brought = nodes * np.shape(system.recalled)[1] * (system.state_size + nodes * system.force_size)
    return 8 * mesh.pieces * (mesh.history + 1) * len(system.delays) * brought


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
