"""The structure's exact response over a piece to a force that is a polynomial through Gauss points."""

from functools import lru_cache
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex._namespace import namespace
from lobex._shapes import AnyArray, Number, Numbers
from lobex.operators.exponential import exponential
from lobex.operators.kernel import kernel_over
from lobex.operators.moments import cell_phases, exponential_moments, legendre_values
from lobex.systems.coefficients import gauss_nodes
from lobex.systems.mesh import mesh_of
from lobex.systems.system import DelaySystem

# Samples of a piece without force.
_FEWEST, _MOST = 16, 2048

# Legendre terms of a Lagrange polynomial over one cell between nodes, which holds half a wave of it: the next
# term is below 1e-15.
_TERMS = 14

# Decimals to which widths of cells, in pieces, are the same.
_DIGITS = 14

# Samples of a kernel, and what they may leave of it.
_SAMPLES, _LAST = (10, 14, 18, 22, 26, 30), 1e-15

# Of a wave that is followed the nodes miss less.
_FOLLOWED = 1e-2
# Of a block of many states: its 32nd power.
_SQUARINGS = 5


class PieceResponse(NamedTuple):
    """What a piece makes of its start state and of the forces at its q nodes; it depends on the speed alone.

    Attributes:
        free: outputs at the nodes from the start state, (q·r, d).
        forced: outputs at the nodes from the forces there, (q·r, q·e).
        through: end state from the start state, (d, d).
        push: end state from the forces, (d, q·e).
        recalled: what is remembered at points, from start state and forces side by side, (p·m, d + q·e).
        missed: how much of each mode's vibration the nodes cannot follow, (n,), from 0 to 1.
    """

    free: Float[Array, "qr d"]
    forced: Float[Array, "qr qe"]
    through: Float[Array, "d d"]
    push: Float[Array, "d qe"]
    recalled: Float[Array, "pm d+qe"]
    missed: Float[AnyArray, " n"]


@lru_cache(maxsize=32)
def _cells(nodes: int, points: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """The edges 0, the points and 1 of the cells, and the Legendre coefficients of the Lagrange basis on each cell.

    Shapes (points + 2,) and (points + 1, terms, nodes).
    """
    places, weights = gauss_nodes(nodes)
    edges = np.r_[0.0, points, 1.0]
    width = np.diff(edges)
    terms = min(_TERMS, nodes)
    local, local_weights = gauss_nodes(2 * terms)
    inside = edges[:-1, None] + width[:, None] * local
    # Lagrange from the discrete Legendre transform, to which Gauss quadrature is exact.
    order = np.arange(nodes)
    basis = legendre_values(inside.ravel(), nodes) @ (
        (2 * order + 1)[:, None] * (weights[:, None] * legendre_values(places, nodes)).T
    )
    analysis = (2 * np.arange(terms) + 1)[:, None] * (local_weights[:, None] * legendre_values(local, terms)).T
    return edges, np.einsum("kl,clj->ckj", analysis, basis.reshape(len(width), len(local), nodes))


class _OverCells(NamedTuple):
    """The modes at points of a piece and at its end, from its start and from the forces at its q nodes."""

    points: np.ndarray
    by_start: Float[Array, "p+1 n s s"]
    by_force: Float[Array, "p+1 n s q e"]

    def seen(
        self, outputs: Float[AnyArray, "n r s"], points: np.ndarray
    ) -> tuple[Float[Array, "pr d"], Float[Array, "pr qe"]]:
        """Outputs at some of the points, of the start state and of the forces."""
        _, n, s, nodes, e = jnp.shape(self.by_force)
        rows = len(points) * jnp.shape(outputs)[1]
        index = np.searchsorted(self.points, points)
        if np.array_equal(index, np.arange(len(self.points))):
            index = slice(len(self.points))
        free = jnp.einsum("nrs,qnsa->qrna", outputs, self.by_start[:-1][index]).reshape(rows, n * s)
        return free, jnp.einsum("nrs,qnsje->qrje", outputs, self.by_force[:-1][index]).reshape(rows, nodes * e)

    def end(self) -> tuple[Float[Array, "n s s"], Float[Array, "d qe"]]:
        """The end state, of the start state mode by mode, and of the forces."""
        _, n, s, nodes, e = jnp.shape(self.by_force)
        return self.by_start[-1], self.by_force[-1].reshape(n * s, nodes * e)


def forced_response(
    system: DelaySystem, length: Number, nodes: int, recalled: np.ndarray | None = None, samples: int | None = None
) -> PieceResponse:
    """The response over a piece, exact for forces that are polynomials of degree below ``nodes``.

    Args:
        system: the delay system.
        length: of the piece, in periods.
        nodes: q.
        recalled: points of the piece, in order, where what is remembered is wanted; the nodes where None.
        samples: of the structure's kernel, ``kernel_samples``, over which it turns by little; None for any turn.
    """
    n, s, _ = jnp.shape(system.inputs)
    own = gauss_nodes(nodes)[0]
    duration = system.period * length
    if samples is None:
        points = own if recalled is None else np.union1d(own, recalled)
        solved = _over_cells(system, duration, nodes, points)
    else:
        solved = kernel_over(system.blocks, system.inputs, duration, nodes, samples)
    free, forced = solved.seen(system.outputs, own)
    if recalled is None and system.remembered is None:
        memory = free, forced
    else:
        memory = solved.seen(system.recalled, own if recalled is None else recalled)
    through, push = solved.end()
    through = jnp.einsum("nab,nm->namb", through, jnp.eye(n, dtype=push.dtype)).reshape(n * s, n * s)
    missed = tail_bound(quickness(jnp.asarray(system.blocks)) * duration / 2, nodes)
    return PieceResponse(free, forced, through, push, jnp.concatenate(memory, axis=1), missed)


def _over_cells(system: DelaySystem, duration: Number, nodes: int, points: np.ndarray) -> _OverCells:
    """Duhamel's integral, marched from point to point: over each cell the modes fly freely, and the force's Legendre
    terms act by the moments of the exponential.
    """
    blocks, inputs = system.blocks, system.inputs
    n, s, e = jnp.shape(inputs)
    edges, coefficients = _cells(nodes, tuple(points))
    count = len(points)
    # The points lie symmetrically: cells that are as wide as each other share all but their forces.
    widths, alike = np.unique(np.round(np.diff(edges), _DIGITS), return_inverse=True)
    # One exponential for all: to the points and the end, over the cells, and at the samples within them.
    samples = cell_phases(widths)
    phases = np.concatenate([edges[1:], widths, samples.T.ravel()])
    flights = exponential((duration * phases)[:, None, None, None] * blocks)
    by_start, flight, samples = jnp.split(flights, [count + 1, count + 1 + len(widths)])
    samples = samples.reshape(-1, len(widths), n, s, s)
    spans = (duration * widths)[:, None, None, None]
    moments = exponential_moments(spans * blocks, flight, samples, coefficients.shape[1])
    moments = (spans * moments @ inputs)[:, alike]
    added = jnp.einsum("kcnae,ckj->cnaje", moments, coefficients)

    def over_cell(
        state: Float[Array, "n s q e"], cell: tuple[Float[Array, "n s s"], Float[Array, "n s q e"]]
    ) -> tuple[Float[Array, "n s q e"], Float[Array, "n s q e"]]:
        propagator, increment = cell
        state = jnp.einsum("nab,nb...->na...", propagator, state) + increment
        return state, state

    start = jnp.zeros((n, s, nodes, e), jnp.result_type(added))
    _, by_force = jax.lax.scan(over_cell, start, (flight[alike], added))
    return _OverCells(points, by_start, by_force)


def kernel_samples(turn: float) -> int | None:
    """How many samples, of few numbers, tell the structure's kernel over a piece to the last digits, where its modes
    turn by ±x radians; None where that is too much.
    """
    return next((count for count in _SAMPLES if tail_bound(turn, count) < _LAST), None)


def tail_bound(turn: Numbers, nodes: Any) -> Float[AnyArray, "..."]:
    """The Legendre terms from degree q on of a wave that turns through ±x are below (e x/2q)^q (DLMF 10.14.4)."""
    return namespace(turn).minimum(np.e / 2 * turn / nodes, 1.0) ** nodes


def followed_turn(nodes: int) -> float:
    """Radians on either side of the middle that a wave may turn through in a piece for its nodes to follow it."""
    return 2 / np.e * nodes * _FOLLOWED ** (1 / nodes)


def quickness(blocks: Float[AnyArray, "n s s"]) -> Float[AnyArray, " n"]:
    """How fast free motions of each block (n, s, s) turn or end, rad/s, shape (n,): ω_n of a mode while it vibrates.

    Of two states the root mean square of |λ|. Of more a bound of the largest |λ| which is close to it, ‖B^k‖^{1/k}
    with k = 32 (Gelfand's formula): one fast mode among many slow ones counts as it does alone.
    """
    lib = namespace(blocks)
    if jnp.shape(blocks)[-1] != 2:
        return _largest_eigenvalue(blocks)
    trace = blocks[:, 0, 0] + blocks[:, 1, 1]
    determinant = blocks[:, 0, 0] * blocks[:, 1, 1] - blocks[:, 0, 1] * blocks[:, 1, 0]
    return lib.sqrt(lib.maximum(determinant, trace**2 / 2 - determinant))


def _largest_eigenvalue(blocks: Float[AnyArray, "n s s"]) -> Float[AnyArray, " n"]:
    """A bound of |λ| over the eigenvalues of each block, by squaring, (n,)."""
    lib = namespace(blocks)
    bound: Any = 1.0
    power: Any = blocks
    for doubled in range(_SQUARINGS + 1):
        norm = lib.sqrt(lib.sum(power**2, axis=(1, 2)))
        bound = bound * norm ** (0.5**doubled)
        power = power / lib.where(norm > 0, norm, 1.0)[:, None, None]
        power = power @ power
    return bound


def samples_in_flight(system: DelaySystem) -> int:
    """How many Gauss points in a piece without force tell the frequencies of all modes apart: few sizes, by fours.

    Gauss points are π/2 times as far apart in the middle as on average; two a wave are enough, and a tenth more and
    two waves are for the frequencies that stand beside a mode's own.
    """
    gap = mesh_of(system).gap
    widest = 0.0 if gap is None else float(np.max(gap))
    waves = np.nan_to_num(np.max(quickness(np.asarray(system.blocks))) * float(system.period) / (2 * np.pi))
    needed = np.pi * widest * (1.1 * waves + 2)
    return int(min(4 ** np.ceil(np.log2(max(needed, _FEWEST)) / 2), _MOST))


def free_response(
    system: DelaySystem, length: Number, points: np.ndarray
) -> tuple[Float[Array, "q r d"], Float[Array, "d d"]]:
    """Outputs at points of [0, 1] of a piece without force, (q, r, d), and the end state, (d, d)."""
    n, s, _ = jnp.shape(system.inputs)
    phases = np.r_[points, 1.0]
    steps = exponential((system.period * length * phases)[:, None, None, None] * system.blocks)
    outputs = jnp.einsum("nrs,qnsa->qrna", system.outputs, steps[:-1]).reshape(len(points), -1, n * s)
    unit = jnp.eye(n, dtype=jnp.result_type(steps))
    return outputs, jnp.einsum("nab,nm->namb", steps[-1], unit).reshape(n * s, n * s)
