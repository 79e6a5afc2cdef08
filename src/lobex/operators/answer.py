"""The forces at the nodes of a piece that z at its start and what is due in it bring about."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex._shapes import AnyArray
from lobex.operators.elimination import Inverse
from lobex.operators.prepared import Prepared
from lobex.operators.rows import framed, rows
from lobex.systems.mesh import Mesh
from lobex.systems.system import DelaySystem, Forces


class Answer(NamedTuple):
    """The forces at the nodes of M pieces, in each of which some of G things are due, as ``Mesh.dues`` says.

    Attributes:
        from_start: from z at the start, (M, q·e, d).
        from_due: from what is due, (G, q·e, q·c).
        frame: what is due as a force, (G, q, e, c); None where it is one, c = e.
    """

    from_start: Float[AnyArray, "M qe d"]
    from_due: Float[AnyArray, "G qe qc"]
    frame: Float[AnyArray, "G q e c"] | None


class Chips(NamedTuple):
    """Of K delays that each bring one chip, the force per chip and the chip per output, at the nodes of M pieces."""

    push: Float[AnyArray, "K M q e 1"]
    met: Float[AnyArray, "K M q 1 m"]


def answer_to_forces(prepared: Prepared, system: DelaySystem, mesh: Mesh, forces: Forces, inverse: Inverse) -> Answer:
    """Where forces are due."""
    brought = looped(prepared, forces)
    resolvent = resolvents(brought, inverse) if prepared.resolvent is None else prepared.resolvent
    where = np.array([piece for piece, _ in mesh.dues])
    return Answer(resolvent @ brought[..., : system.state_size], resolvent[where], None)


def answer_to_chips(
    prepared: Prepared, system: DelaySystem, mesh: Mesh, forces: Forces, chips: Chips, inverse: Inverse
) -> Answer:
    """Where chips are due: in pieces with one of them alone, whose force is that of the chip, the chip is found."""
    pieces, kinds = (np.array(part) for part in zip(*mesh.dues, strict=True))
    frame, d = chips.push[kinds, pieces], system.state_size
    count = np.bincount(pieces, minlength=mesh.pieces)
    alone = np.flatnonzero(count == 1) if system.regenerative else np.zeros(0, dtype=int)
    others = np.flatnonzero(count > 1) if system.regenerative else np.arange(mesh.pieces)
    *_, width = jnp.shape(prepared.seen)
    nothing = jnp.zeros((width - d, d), dtype=prepared.seen.dtype)
    start: dict[int, Float[AnyArray, "qe d"]] = dict.fromkeys(map(int, np.flatnonzero(count == 0)), nothing)
    due: dict[int, Float[AnyArray, "qe q"]] = {}
    if len(alone):
        mine = np.searchsorted(pieces, alone)
        push, seen = frame[mine], prepared.seen[alone]
        met = rows(chips.met[kinds[mine], alone], seen)
        # (1 + LN)⁻¹ L = L (1 + NL)⁻¹, which is a half or a third of the size.
        unit = jnp.eye(jnp.shape(met)[1], dtype=met.dtype)
        found = rows(push, jax.vmap(inverse)(unit + framed(met[..., d:], push)))
        start |= dict(zip(map(int, alone), -found @ met[..., :d], strict=True))
        due |= dict(zip(map(int, mine), found, strict=True))
    if len(others):
        brought = rows(forces.present[others], prepared.seen[others])
        resolvent = resolvents(brought, inverse)
        start |= dict(zip(map(int, others), resolvent @ brought[..., :d], strict=True))
        mine = np.flatnonzero(np.isin(pieces, others))
        found = framed(resolvent[np.searchsorted(others, pieces[mine])], frame[mine])
        due |= dict(zip(map(int, mine), found, strict=True))
    by_piece, by_due = (jnp.stack([part[index] for index in sorted(part)]) for part in (start, due))
    return Answer(by_piece, by_due, frame)


def looped(prepared: Prepared, forces: Forces) -> Float[AnyArray, "M qe dqe"]:
    """The forces that z at the start and the forces themselves bring about in the same piece, (M, q·e, d + q·e)."""
    brought = rows(forces.present, prepared.seen)
    if prepared.recent is not None:
        for index, coefficient in enumerate(forces.delayed):
            brought = brought + rows(coefficient, prepared.recent[:, index])
    return brought


def resolvents(brought: Float[AnyArray, "M qe dqe"], inverse: Inverse) -> Float[Array, "M qe qe"]:
    """From the forces at the nodes without those that they themselves bring about to all of them, (M, q·e, q·e)."""
    count = jnp.shape(brought)[1]
    return jax.vmap(inverse)(jnp.eye(count, dtype=brought.dtype) - brought[..., -count:])
