"""From the start of a period to its end, piece by piece.

The state is z, and what the past has due at the nodes of the pieces to come. What is due in a piece acts there, makes
with z the forces at its nodes, and these leave to later pieces what is due then.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lobex._shapes import AnyArray
from lobex.operators.answer import Answer
from lobex.operators.rows import rows
from lobex.systems.links import Due, due_from_before, links_of
from lobex.systems.mesh import Mesh

# So many pieces that are alike are written out.
_FEW = 4


class Pieces(NamedTuple):
    """What the pieces of a period do to the state.

    Attributes:
        answer: the forces at the nodes.
        onward: z at the start of the next piece from that at the start and the forces, (M, d, d + q·e).
        left: what is due from them by each of ``Mesh.links``, (L, q·c, d + q·e).
    """

    answer: Answer
    onward: Float[Array, "M d dqe"]
    left: Float[AnyArray, "L qc dqe"]


class March(NamedTuple):
    """A march over the period.

    Attributes:
        starts: z at the start of every piece, (M, d, …).
        pushed: the force that is due at its nodes, (M, q·e, …).
        due: squares of what is due, (M,).
        forces: all of the force there, (M, q·e, …).
        end: the state at the end, (N, …).
    """

    starts: Float[Array, "M d p"]
    pushed: Float[Array, "M qe p"]
    due: Float[Array, " M"]
    forces: Float[Array, "M qe p"]
    end: Float[Array, "N p"]


class _Piece(NamedTuple):
    """One of ``Pieces``: what is due in it by its kind, and of what it leaves when and as what that is due."""

    from_start: Float[AnyArray, "qe d"]
    from_due: dict[int, Float[AnyArray, "qe qc"]]
    frame: dict[int, Float[AnyArray, "q e c"]]
    onward: Float[Array, "d dqe"]
    left: dict[Due, Float[AnyArray, "qc dqe"]]


class _State(NamedTuple):
    """z, and what is due in the pieces to come."""

    start: Float[Array, "d p"]
    due: dict[Due, Float[Array, "qc p"]]


def size_of_state(mesh: Mesh, start: int, due: int) -> int:
    """N, of a z of ``start`` numbers and ``due`` of each of what is due."""
    return start + due * len(due_from_before(mesh.links, mesh.pieces))


def matrix_of(pieces: Pieces, mesh: Mesh) -> Float[Array, "N N"]:
    """The operator's matrix, (N, N)."""
    d, width, dtype = jnp.shape(pieces.onward)[1], jnp.shape(pieces.answer.from_due)[2], pieces.onward.dtype
    size = size_of_state(mesh, d, width)
    first, *rest = _one_by_one(pieces, mesh) if _written_out(mesh) else [_nth(pieces, mesh, 0)]
    state = _apart(jnp.eye(size, dtype=dtype), d, mesh)
    # A product with the identity is spared: what is due in the first piece comes first in the state.
    now = [kind for later, kind in state.due if later == 0]
    answer = jnp.concatenate([first.from_start, *(first.from_due[kind] for kind in now)], axis=1)
    known = jnp.shape(answer)[1]
    leaves = _rows_of(first)
    made = leaves[:, d:] @ answer + jnp.pad(leaves[:, :d], ((0, 0), (0, known - d)))
    state = _moved_on(state, first, jnp.pad(made, ((0, 0), (0, size - known))))
    if _written_out(mesh):
        for piece in rest:
            state = _over(state, piece)[0]
        return _together(state)
    stacked = jax.tree.map(lambda part: part[1:], _stacked(pieces, mesh))
    return _together(jax.lax.scan(lambda state, piece: (_over(state, piece)[0], None), state, stacked)[0])


def marched(pieces: Pieces, mesh: Mesh, state: Float[Array, "N p"]) -> March:
    """March a state over the period."""

    def over(state: _State, piece: _Piece) -> tuple[_State, tuple[Float[Array, "..."], ...]]:
        after, forces = _over(state, piece)
        now = {kind: part for (later, kind), part in state.due.items() if later == 0}
        pushed = jnp.zeros_like(forces)
        for kind, part in now.items():
            pushed = pushed + (rows(piece.frame[kind], part) if piece.frame else part)
        return after, (state.start, pushed, sum((jnp.sum(part**2) for part in now.values()), jnp.zeros(())), forces)

    begun = _apart(state, jnp.shape(pieces.onward)[1], mesh)
    if not _written_out(mesh):
        end, (starts, pushed, due, forces) = jax.lax.scan(over, begun, _stacked(pieces, mesh))
        return March(starts, pushed, due, forces, _together(end))
    found = []
    for piece in _one_by_one(pieces, mesh):
        begun, one = over(begun, piece)
        found.append(one)
    starts, pushed, due, forces = (jnp.stack(part) for part in zip(*found, strict=True))
    return March(starts, pushed, due, forces, _together(begun))


def _over(state: _State, piece: _Piece) -> tuple[_State, Float[Array, "qe p"]]:
    """The state after a piece, and the forces in it."""
    now = [kind for later, kind in state.due if later == 0]
    answer = jnp.concatenate([piece.from_start, *(piece.from_due[kind] for kind in now)], axis=1)
    forces = answer @ jnp.concatenate([state.start, *(state.due[0, kind] for kind in now)])
    return _moved_on(state, piece, _rows_of(piece) @ jnp.concatenate([state.start, forces])), forces


def _rows_of(piece: _Piece) -> Float[Array, "rows dqe"]:
    """z at the start of the next piece, and what is left, from z at the start and the forces."""
    return jnp.concatenate([piece.onward, *piece.left.values()])


def _moved_on(state: _State, piece: _Piece, made: Float[Array, "rows p"]) -> _State:
    """The state one piece later: what was due is done, and more is due."""
    start, *left = jnp.split(made, _edges(piece))
    due = {(later, kind): part for (later, kind), part in state.due.items() if later}
    for when, part in zip(piece.left, left, strict=True):
        due[when] = due[when] + part if when in due else part
    return _State(start, {(later - 1, kind): due[later, kind] for later, kind in sorted(due)})


def _edges(piece: _Piece) -> list[int]:
    edges = [jnp.shape(piece.onward)[0]]
    for part in piece.left.values():
        edges.append(edges[-1] + jnp.shape(part)[0])
    return edges[:-1]


def _apart(state: Float[Array, "N p"], start: int, mesh: Mesh) -> _State:
    filled = due_from_before(mesh.links, mesh.pieces)
    return _State(start=state[:start], due=dict(zip(filled, jnp.split(state[start:], len(filled)), strict=True)))


def _together(state: _State) -> Float[Array, "N p"]:
    return jnp.concatenate([state.start, *state.due.values()])


def _written_out(mesh: Mesh) -> bool:
    """Whether every piece has code of its own: where they are few or not alike."""
    return mesh.pieces <= _FEW or not mesh.alike


def _nth(pieces: Pieces, mesh: Mesh, number: int) -> _Piece:
    answer, mine = pieces.answer, {kind: index for index, (piece, kind) in enumerate(mesh.dues) if piece == number}
    return _Piece(
        from_start=answer.from_start[number],
        from_due={kind: answer.from_due[index] for kind, index in mine.items()},
        frame={} if answer.frame is None else {kind: answer.frame[index] for kind, index in mine.items()},
        onward=pieces.onward[number],
        left={(link.later, link.kind): pieces.left[index] for index, link in links_of(mesh.links, number)},
    )


def _one_by_one(pieces: Pieces, mesh: Mesh) -> list[_Piece]:
    return [_nth(pieces, mesh, number) for number in range(mesh.pieces)]


def _stacked(pieces: Pieces, mesh: Mesh) -> _Piece:
    """Pieces that are alike, along a first axis."""
    left = pieces.left.reshape(mesh.pieces, -1, *jnp.shape(pieces.left)[1:])
    laters = [(link.later, link.kind) for _, link in links_of(mesh.links, 0)]
    return _Piece(
        from_start=pieces.answer.from_start,
        from_due={0: pieces.answer.from_due},
        frame={} if pieces.answer.frame is None else {0: pieces.answer.frame},
        onward=pieces.onward,
        left={when: left[:, index] for index, when in enumerate(laters)},
    )
