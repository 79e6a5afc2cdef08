"""The dominant multiplier at many points, with as many nodes at each as its estimated error asks for."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import jax
import numpy as np
from jaxtyping import Array, Float, Inexact, Int
from tqdm import tqdm

from lobex._batches import FirstAlone, over_few, side_by_side, together
from lobex._shapes import AnyArray, Number
from lobex.floquet import dense, power
from lobex.floquet.chatter import carrier_frequency
from lobex.floquet.power import Pair, as_complex, as_pair
from lobex.grids.dominant import Dominant
from lobex.operators.duhamel import Duhamel
from lobex.operators.elimination import inverse, pivoted_inverse
from lobex.operators.response import quickness, samples_in_flight, tail_bound
from lobex.processes.process import Process
from lobex.systems.mesh import mesh_of
from lobex.systems.traits import Traits, traits_of

# Nodes per piece: a few sizes, since each is compiled for itself.
_SIZES = (6, 10, 16, 26, 42, 68, 110)
# And for few pieces through which a mode turns a hundred times, as long as forces are not more.
_LARGE, _MOST_FORCES = (178, 288, 466), 700
# Of the tolerance, what the error at a point may be for its neighbours to meet it too.
_MARGIN = 0.1
# Work per point, lightest first: squarings of the operator, or 0 for the dense solver.
_EFFORTS = (9, 16, 24, 0)
# The same after so long a period, in delays, that its end has forgotten all but the dominant multiplier.
_LONG, _EFFORTS_AFTER_LONG = 4, (5, *_EFFORTS)
# The pair is settled where it misses the discrete equations by less.
_SETTLED = 1e-11
_CHUNK_BYTES = 1e6
# What points that are computed together may need, and the fewest of them.
_CACHE_BYTES, _TOGETHER = 5e5, 8
SPEEDS = 32
"""Structures prepared at a time."""
# Rows of the operators of all pieces up to which these are small.
_SMALL = 64
MANY = 20_000
# Radians over half a piece that coefficients add to those of the first mode, for the first guess alone.
_BY_COEFFICIENTS = 1.5


def refined_over_grid(
    process: Process, speeds: np.ndarray, gains: np.ndarray, method: Duhamel, progress: bool
) -> Dominant:
    """Over the grid of speeds (n,) and gains (m,), shape (n, m); call in the scope of float64."""
    shape = (len(speeds), len(gains))
    row, column = (index.ravel() for index in np.indices(shape))
    result = _Refinement(process, method).run(speeds, row, gains[column], progress)
    return Dominant(*(part.reshape(shape) for part in result))


def refined_at_points(
    process: Process, speeds: np.ndarray, gains: np.ndarray, method: Duhamel, every_mode: bool = False
) -> Dominant:
    """At the points (speeds[i], gains[i]), shape (p,); begun with nodes for the first mode, or for ``every_mode``."""
    unique, row = np.unique(speeds, return_inverse=True)
    return _Refinement(process, method, every_mode).run(unique, row, gains, progress=False)


def enough_nodes(found: Dominant, tolerance: float) -> int:
    """Nodes with which all of the points found, and others near them, are well within the tolerance."""
    near = found.nodes[found.error > _MARGIN * tolerance]
    enough = np.max(found.nodes)
    return int(next((size for size in _SIZES if size > np.max(near, initial=0) and size >= enough), enough))


class _Refinement:
    """One process and method at points."""

    def __init__(self, process: Process, method: Duhamel, every_mode: bool = False) -> None:
        self.process, self.method, self.traits = process, method, traits_of(process)
        self.followed = np.max if every_mode else np.min
        self.sizes: tuple[int, ...] = ()
        self.in_flight = 0
        self.programs = FirstAlone()

    def run(self, speeds: np.ndarray, row: np.ndarray, gain: np.ndarray, progress: bool) -> Dominant:
        """Compute all points, slab by slab of speeds, on every core."""
        multiplier = np.full(len(row), np.nan, dtype=np.complex128)
        frequency, error = np.full(len(row), np.nan), np.full(len(row), np.nan)
        nodes = np.zeros(len(row), dtype=int)
        densely = np.zeros(len(row), dtype=bool)
        if not len(row):
            return Dominant(multiplier, frequency, error, nodes, densely)
        order = np.argsort(row, kind="stable")
        first = _shares(len(speeds))
        edges = np.searchsorted(row[order], first)
        self.sizes, start, last = self._plan(speeds, len(row))
        self.in_flight = samples_in_flight(self.process.system(np.min(speeds), 0.0))

        def work(number: int) -> tuple[np.ndarray, _Slab]:
            mine = order[edges[number] : edges[number + 1]]
            here = slice(first[number], first[number + 1])
            slab = _Slab(self, speeds[here], row[mine] - here.start, gain[mine], number)
            slab.run(start[row[mine]], last[row[mine]])
            return mine, slab

        with tqdm(total=len(row), unit="pt", unit_scale=True, disable=not progress, leave=False) as bar:
            if len(row) >= MANY:
                calls = self._rehearsals(start, speeds[0], gain[0])
                list(side_by_side(lambda number: calls[number](), len(calls), first_alone=False))
            for mine, slab in side_by_side(work, len(edges) - 1, first_alone=False):
                multiplier[mine], frequency[mine], error[mine] = slab.multiplier, slab.frequency, slab.whole_error
                nodes[mine] = np.asarray(self.sizes)[slab.size]
                densely[mine] = slab.densely
                bar.update(len(mine))
        return Dominant(multiplier, frequency, error, nodes, densely)

    def _rehearsals(self, start: np.ndarray, speed: float, gain: float) -> list[Callable[[], object]]:
        """Calls that compile, side by side, what many points need: the sizes begun with, or the one and the next."""
        wanted = np.unique(start)
        if len(wanted) == 1:
            wanted = np.arange(wanted[0], min(wanted[0] + 2, len(self.sizes)))
        methods = [replace(self.method, nodes=self.sizes[i]) for i in wanted]

        def prepare(method: Duhamel) -> object:
            speeds = np.full(SPEEDS, speed)
            return prepared_at(self.process, method, speeds, gain, SPEEDS, self.traits, self.in_flight)

        def evaluate(method: Duhamel) -> object:
            shapes = jax.eval_shape(
                partial(prepared_at, traits=self.traits, in_flight=self.in_flight),
                self.process,
                method,
                np.full(SPEEDS, speed),
                gain,
                SPEEDS,
            )
            prepared = jax.tree.map(lambda part: np.zeros(part.shape, part.dtype), shapes)
            slab = _Slab(self, np.full(SPEEDS, speed), np.zeros(1, dtype=int), np.full(1, gain))
            return slab.evaluate(prepared, np.zeros(1, dtype=int), method, _EFFORTS[0])

        return [partial(call, method) for method in methods for call in (evaluate, prepare)]

    def _plan(self, speeds: np.ndarray, points: int) -> tuple[tuple[int, ...], np.ndarray, np.ndarray]:
        """The sizes in turn, and the indices of those to begin and to end with per speed: from how far a mode turns."""
        if self.method.nodes is not None:
            return (self.method.nodes,), np.zeros(len(speeds), dtype=int), np.zeros(len(speeds), dtype=int)
        ends = speeds[[0, -1]]
        # Turning is a power of the speed, or nearly, unless what is called speed is something else.
        half = np.exp(np.interp(np.log(speeds), np.log(ends), np.log([self._turn(speed) for speed in ends])))
        system = self.process.system(ends[0], 0.0)
        pieces = mesh_of(system).pieces
        sizes = _SIZES + tuple(size for size in _LARGE if size * pieces * system.force_size <= _MOST_FORCES)
        coarse = tail_bound(half[:, None] + _BY_COEFFICIENTS, np.array(sizes)) > np.sqrt(self.method.tolerance)
        # Where the finest would not do either, it is not tried.
        last = np.where(coarse[:, -1], len(_SIZES), len(sizes)) - 1
        first = np.minimum(np.sum(coarse, axis=1), last)
        # Of few points it is quicker to compute some too finely than to compile one more size, unless pieces are many.
        apart = points >= MANY or pieces > _LONG
        return sizes, first if apart else np.minimum(first.max(), last), last

    def _turn(self, speed: float) -> float:
        """Radians that the mode to follow turns through in half of the widest piece in contact."""
        system = self.process.system(speed, 0.0)
        rate = float(self.followed(quickness(np.asarray(system.blocks))))
        widest = float(np.max(mesh_of(system).length))
        return max(np.nan_to_num(rate * float(system.period) * widest / 2), np.finfo(float).tiny)


def _shares(speeds: int) -> np.ndarray:
    """Where slabs of up to SPEEDS speeds begin, and the end: an even number of equal ones, whatever the cores."""
    slabs = -(-speeds // SPEEDS)
    return np.linspace(0, speeds, min(slabs + slabs % 2, speeds) + 1).astype(int)


class _Slab:
    """Points of a few speeds, and what is known about each: results, defect, and the size that they have."""

    def __init__(
        self, whole: _Refinement, speeds: np.ndarray, row: np.ndarray, gain: np.ndarray, number: int = 0
    ) -> None:
        self.whole, self.speeds, self.row, self.gain = whole, speeds, row, gain
        # Each device has programs of its own.
        self.device = number % len(jax.local_devices())
        self.multiplier = np.full(len(row), np.nan, dtype=np.complex128)
        self.frequency, self.error, self.rounding, self.defect = (np.full(len(row), np.nan) for _ in range(4))
        self.size = np.zeros(len(row), dtype=int)
        self.densely = np.zeros(len(row), dtype=bool)

    def run(self, start: np.ndarray, last: np.ndarray) -> None:
        """Compute every point with the size that ``start`` gives it, and with the next, up to ``last``, while it is too
        coarse.
        """
        waiting = start
        for index, nodes in enumerate(self.whole.sizes):
            points = np.flatnonzero(waiting == index)
            if len(points):
                self.size[points] = index
                self._settle(points, replace(self.whole.method, nodes=nodes))
                # A point that failed, NaN, fails with more nodes as well.
                coarse = points[(self.error[points] > self.whole.method.tolerance) & (index < last[points])]
                waiting[coarse] = index + 1

    @property
    def whole_error(self) -> np.ndarray:
        """By nodes, of which more help, and by rounding, where none do."""
        return self.error + self.rounding

    def _settle(self, points: np.ndarray, method: Duhamel) -> None:
        """Compute points with the nodes of ``method``, with more effort where the pair does not settle."""
        system = self.whole.process.system(self.speeds[0], self.gain[0])
        mesh = mesh_of(system)
        # A large operator is made for no more speeds than there are, or nearly; a small one for as many as ever, since
        # each number of them is compiled for itself.
        small = mesh.pieces * method.size(system) <= _SMALL
        many = SPEEDS if small else 2 ** int(np.ceil(np.log2(len(self.speeds))))
        prepare = partial(
            prepared_at,
            self.whole.process,
            method,
            np.resize(self.speeds, many),
            self.gain[0],
            len(self.speeds),
            self.whole.traits,
            self.whole.in_flight,
        )
        prepared = self.whole.programs.call((self.device, method.nodes, many), prepare)
        for effort in _EFFORTS_AFTER_LONG if mesh.pieces >= _LONG * mesh.history else _EFFORTS:
            self.densely[points] = effort == 0
            self.evaluate(prepared, points, method, effort)
            settled = (self.defect[points] < _SETTLED) & (self.rounding[points] < self.whole.method.tolerance)
            points = points[~settled]
            if not len(points):
                return

    def evaluate(self, prepared: Any, points: np.ndarray, method: Duhamel, effort: int) -> None:
        """Put the results of points in their places, a batch at a time, the last filled up with repeats."""
        densely = effort == 0
        size, several = self._batch(prepared, method)
        targets = (self.multiplier, self.frequency, self.error, self.rounding, self.defect)
        for begin in range(0, len(points), size):
            part = points[begin : begin + size]
            filled = np.resize(part, size)
            row = self.row[filled]
            compute = partial(
                _with_errors,
                self.whole.process,
                prepared,
                row,
                self.speeds[row],
                self.gain[filled],
                method,
                effort,
                len(part),
                densely,
                several,
            )
            results = self.whole.programs.call((self.device, method.nodes, densely, size), compute)
            for target, result in zip(targets, results, strict=True):
                target[part] = np.asarray(result)[: len(part)]

    def _batch(self, prepared: Any, method: Duhamel) -> tuple[int, int]:
        """How many points a call takes, and how many of them are computed together.

        On a CPU these are so few that what they need stays in a core's cache; on a GPU all.
        """
        system = self.whole.process.system(self.speeds[0], self.gain[0])
        rows, forces = method.size(system), system.force_size * method.count * mesh_of(system).pieces
        size = int(max(_CHUNK_BYTES / (8 * rows**2), _TOGETHER))
        if jax.default_backend() != "cpu":
            return size, size
        numbers = sum(part.size / len(part) for part in jax.tree.leaves(prepared)) + rows * (forces + rows)
        several = max(2 ** round(np.log2(_CACHE_BYTES / (8 * numbers))), _TOGETHER)
        return several * -(-size // several), several


@partial(jax.jit, static_argnames=("traits", "in_flight"))
def prepared_at(
    process: Process,
    method: Duhamel,
    speeds: Float[AnyArray, " speeds"],
    gain: Number,
    count: Number,
    traits: Traits,
    in_flight: int,
) -> Any:
    """What of the operators is the same for all gains at each of the first ``count`` speeds; None where nothing is."""
    if traits.structure_by_gain:
        return None

    def at(speed: Number) -> Any:
        return method.prepare(process.system(speed, gain), not traits.present_by_gain, in_flight)

    return over_few(at, together(len(speeds), _TOGETHER), count, speeds)


@partial(jax.jit, static_argnames=("densely", "several"))
def _with_errors(
    process: Process,
    prepared: Any,
    row: Int[AnyArray, " p"],
    speed: Float[AnyArray, " p"],
    gain: Float[AnyArray, " p"],
    method: Duhamel,
    squarings: int | Int[Array, ""],
    count: Number,
    densely: bool,
    several: int,
) -> tuple[Inexact[Array, " p"], ...]:
    """Dominant multipliers, chatter frequencies, estimated errors by nodes and by rounding, and defects, at the first
    ``count`` points.
    """

    def point(row: Int[Array, ""], speed: Float[Array, ""], gain: Float[Array, ""]) -> tuple[Inexact[Array, ""], ...]:
        system = process.system(speed, gain)
        mine = method.prepare(system) if prepared is None else jax.tree.map(lambda part: part[row], prepared)
        forces = method.forces(system)
        pieces = method.respond(mine, system, pivoted_inverse if densely else inverse, forces)
        matrix = method.assemble(pieces, system)
        if densely:
            value, vector = dense.pair_by_eigensolver(matrix)
            pair = Pair(*map(as_pair, (value, vector, dense.left_vector(matrix, value, vector))))
        else:
            pair = power.pair_by_squaring(matrix, squarings)
        motion = method.motion(mine, pieces, system, pair, forces)
        frequency = carrier_frequency(motion.phase, motion.weight, motion.output, system.period, pair.value)
        return as_complex(pair.value), frequency, motion.error, motion.rounding, motion.defect

    return over_few(point, several, count, row, speed, gain)
