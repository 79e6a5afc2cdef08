"""From the start of a period to its end, piece by piece.

The state is z, and the forces that the past has due at the nodes of the pieces to come. What is due in a piece acts
there, makes with z the forces at its nodes, and these leave to later pieces what is due then.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex._shapes import AnyArray
from lobex.systems.mesh import Mesh

# So many pieces that are alike are written out.
_FEW = 4


class Pieces(NamedTuple):
    """What the pieces of a period do to the state.

    Attributes:
        answer: the forces at the nodes from z at the start and what is due there, (M, q·e, d + q·e).
        onward: z at the start of the next piece from that at the start and the forces, (M, d, d + q·e).
        left: what is due from them by each of ``Mesh.links``, (L, q·e, d + q·e).
    """

    answer: Float[Array, "M qe d+qe"]
    onward: Float[Array, "M d d+qe"]
    left: Float[Array, "L qe d+qe"]


class March(NamedTuple):
    """Of every piece z at its start, (M, d, …), what is due there, (M, q·e, …), and the forces at its nodes,
    (M, q·e, …); and the state at the end of the period, (N, …).
    """

    starts: Float[Array, "M d p"]
    due: Float[Array, "M qe p"]
    forces: Float[Array, "M qe p"]
    end: Float[Array, "N p"]


class _Piece(NamedTuple):
    """One of ``Pieces``, and how many pieces later what it leaves is due."""

    answer: Float[Array, "qe d+qe"]
    onward: Float[Array, "d d+qe"]
    left: Float[Array, "J qe d+qe"]
    later: tuple[int, ...]


# z, and what is due in the pieces to come, None for nothing.
_State = tuple[Float[Array, "d p"], tuple[Float[Array, "qe p"] | None, ...]]


def state_size(mesh: Mesh, start: int, forces: int) -> int:
    """N, of a z of ``start`` numbers and ``forces`` in a piece."""
    return start + forces * sum(_filled(mesh))


def matrix_of(pieces: Pieces, mesh: Mesh) -> Float[Array, "N N"]:
    """The operator's matrix, (N, N)."""
    _, forces, width = jnp.shape(pieces.answer)
    d, dtype = width - forces, pieces.answer.dtype
    size = state_size(mesh, d, forces)
    first, *rest = _one_by_one(pieces, mesh) if _written_out(mesh) else [_nth(pieces, mesh, 0)]
    state = _apart(jnp.eye(size, dtype=dtype), d, forces, mesh)
    # A product with the identity is spared.
    known = d if state[1][0] is None else width
    made = jnp.concatenate([jnp.eye(d, known, dtype=dtype), first.answer[:, :known]])
    state = _left(jnp.pad(_leave(first, made), ((0, 0), (0, size - known))), state, first)
    if _written_out(mesh):
        for piece in rest:
            state = _over(state, piece)[0]
        return _together(state)

    def over(state: _State, piece: Pieces) -> tuple[_State, None]:
        return _over(state, _alike(piece, mesh))[0], None

    stacked = _stacked(pieces, mesh)
    return _together(jax.lax.scan(over, state, jax.tree.map(lambda part: part[1:], stacked))[0])


def marched(pieces: Pieces, mesh: Mesh, state: Float[Array, "N p"]) -> March:
    """March a state over the period."""
    _, forces, width = jnp.shape(pieces.answer)
    begun = _apart(state, width - forces, forces, mesh)

    def over(state: _State, piece: _Piece) -> tuple[_State, tuple[Float[Array, "rows p"], ...]]:
        after, found = _over(state, piece)
        due = jnp.zeros_like(found) if state[1][0] is None else state[1][0]
        return after, (state[0], due, found)

    if not _written_out(mesh):
        end, found = jax.lax.scan(lambda state, piece: over(state, _alike(piece, mesh)), begun, _stacked(pieces, mesh))
        return March(*found, _together(end))
    found = []
    for piece in _one_by_one(pieces, mesh):
        begun, one = over(begun, piece)
        found.append(one)
    return March(*(jnp.stack(part) for part in zip(*found, strict=True)), _together(begun))


def _over(state: _State, piece: _Piece) -> tuple[_State, Float[Array, "qe p"]]:
    """The state after a piece, and the forces in it."""
    start, (due, *_) = state
    known = start if due is None else jnp.concatenate([start, due])
    forces = piece.answer[:, : len(known)] @ known
    return _left(_leave(piece, jnp.concatenate([start, forces])), state, piece), forces


def _leave(piece: _Piece, made: Float[Array, "d+qe p"]) -> Float[Array, "d+Jqe p"]:
    return jnp.concatenate([piece.onward, *piece.left]) @ made


def _left(made: Float[Array, "d+Jqe p"], state: _State, piece: _Piece) -> _State:
    """The state one piece later: what was due is done, and more is due."""
    start, (_, *due) = state
    edges = jnp.shape(start)[0] + jnp.shape(piece.answer)[0] * np.arange(len(piece.later))
    begun, *left = jnp.split(made, edges)
    later: list[Float[Array, "qe p"] | None] = [*due, None]
    for number, part in zip(piece.later, left, strict=True):
        before = later[number - 1]
        later[number - 1] = part if before is None else before + part
    return begun, tuple(later)


def _filled(mesh: Mesh) -> list[bool]:
    """Whether anything from before the period is due in each of the H pieces to come."""
    due = {(link.piece + link.later) % mesh.pieces: 0 for link in mesh.links}
    for link in mesh.links:
        reader = (link.piece + link.later) % mesh.pieces
        due[reader] = max(due[reader], link.later)
    return [due.get(number % mesh.pieces, 0) > number for number in range(mesh.history)]


def _apart(state: Float[Array, "N p"], start: int, forces: int, mesh: Mesh) -> _State:
    filled = _filled(mesh)
    parts = iter(jnp.split(state[start:], max(sum(filled), 1)))
    return state[:start], tuple(next(parts) if here else None for here in filled)


def _together(state: _State) -> Float[Array, "N p"]:
    return jnp.concatenate([state[0], *(due for due in state[1] if due is not None)])


def _written_out(mesh: Mesh) -> bool:
    """Whether every piece has code of its own: where they are few or not alike."""
    return mesh.pieces <= _FEW or not mesh.alike


def _nth(pieces: Pieces, mesh: Mesh, number: int) -> _Piece:
    mine = [index for index, link in enumerate(mesh.links) if link.piece == number]
    left = pieces.left[mine[0] : mine[-1] + 1] if mine else pieces.left[:0]
    return _Piece(pieces.answer[number], pieces.onward[number], left, tuple(mesh.links[index].later for index in mine))


def _one_by_one(pieces: Pieces, mesh: Mesh) -> list[_Piece]:
    return [_nth(pieces, mesh, number) for number in range(mesh.pieces)]


def _stacked(pieces: Pieces, mesh: Mesh) -> Pieces:
    """With what is left along the pieces, which are alike."""
    return pieces._replace(left=pieces.left.reshape(mesh.pieces, -1, *jnp.shape(pieces.left)[1:]))


def _alike(piece: Pieces, mesh: Mesh) -> _Piece:
    return _Piece(*piece, tuple(link.later for link in mesh.links if link.piece == 0))


def rows(coefficient: Float[AnyArray, "*M q e r"], matrix: Float[Array, "*M qr p"]) -> Float[AnyArray, "*M qe p"]:
    """blockdiag(coefficient) · matrix: (…, q, e, r) by (…, q·r, p) → (…, q·e, p)."""
    *lanes, q, e, r = jnp.shape(coefficient)
    return acting(coefficient, matrix.reshape(*lanes, q, r, -1)).reshape(*lanes, q * e, -1)


def acting(coefficient: Float[AnyArray, "*M q e r"], samples: Float[Array, "*M q r p"]) -> Float[AnyArray, "*M q e p"]:
    """(…, q, e, r) times (…, q, r, p): as sums, since XLA is slow at products of a few rows."""
    parts = [coefficient[..., j, None] * samples[..., j, None, :] for j in range(jnp.shape(samples)[-2])]
    return sum(parts[1:], parts[0])
