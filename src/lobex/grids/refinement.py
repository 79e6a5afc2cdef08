"""The dominant multiplier at many points, with as many nodes at each as its estimated error asks for."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import jax
import numpy as np
from tqdm import tqdm

from lobex._batches import FirstAlone, side_by_side
from lobex._memory import available_memory, check_memory
from lobex.grids.dominant import Dominant
from lobex.grids.node_counts import MANY, node_counts, turn_of
from lobex.grids.one_size import FEWEST, coefficients_at, few_of_each, prepared_at, with_errors
from lobex.operators.duhamel import Duhamel
from lobex.operators.prepared import bytes_between
from lobex.operators.response import kernel_samples, samples_in_flight
from lobex.processes.process import Process
from lobex.systems.mesh import mesh_of
from lobex.systems.system import Forces
from lobex.systems.traits import traits_of

# The growth per period that most points are beyond, for the first guess alone.
_GROWTH = 1e-3
# Work per point, lightest first: squarings of the operator, or 0 for the dense solver.
_EFFORTS = (9, 16, 24, 0)
# The same after so long a period, in delays, that its end has forgotten all but the dominant multiplier.
_LONG, _EFFORTS_AFTER_LONG = 4, (5, *_EFFORTS)
# The pair is settled where it misses the discrete equations by less, or by so little of the error that is allowed.
_SETTLED, _OF_ERROR = 1e-11, 1e-3
# From about so many points of each speed a slab of many learns which of the others better begin with more nodes, and
# with how many squarings, up to a number, most of them settle.
_SOME, _GROUPS, _TOO_MANY = 4, 24, 1 / 3
_FURTHER, _MOSTLY = 12, 0.9
_CHUNK_BYTES = 1e6
# Points of a call on a CPU, which computes few of them at a time.
_CALL = 128
# What points that are computed together may need.
_CACHE_BYTES = 5e5
SPEEDS = 32
"""Structures prepared at a time."""
# The fewest gains of which coefficients are shared.
_COLUMNS = 16
# Rows of the operators of all pieces up to which these are small.
_SMALL = 400
# Gains at which the pieces are looked at, and how much longer they may be between.
_LOOKS, _BETWEEN = 5, 1.1


class Refinement:
    """One process and method at points."""

    def __init__(
        self,
        process: Process,
        method: Duhamel,
        every_mode: bool = False,
        of_growth: float = 0.0,
        quickly: bool = False,
    ) -> None:
        self.process, self.method, self.traits = process, method, traits_of(process)
        self.prepared_at, self.with_errors = prepared_at[quickly], with_errors[quickly]
        self.coefficients_at = coefficients_at[quickly]
        self.followed = np.max if every_mode else np.min
        self.of_growth = of_growth
        self.sizes: tuple[int, ...] = ()
        self.in_flight = 0
        self.samples: int | None = None
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
        accuracy = max(self.method.tolerance, self.of_growth * _GROWTH)
        points = np.bincount(row, minlength=len(speeds))
        self.sizes, start, last = node_counts(self.process, self.method, speeds, points, self.followed, accuracy)
        start, last = self._in_memory(start, last, speeds[0], gain[0])
        self.in_flight = samples_in_flight(self.process.system(np.min(speeds), 0.0))
        if self.traits.structure_by_gain:
            self.samples = samples_at(self.process, speeds, gain)

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

    def _in_memory(
        self, start: np.ndarray, last: np.ndarray, speed: float, gain: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """The sizes to begin and to end with, of those for which there is memory.

        Raises:
            ValueError: where there is none for a single point of the least of them.
        """
        system = self.process.system(speed, gain)
        needed = [bytes_between(system, nodes) for nodes in self.sizes]
        least = int(np.min(start))
        pieces = mesh_of(system).pieces
        what = f"nodes = {self.sizes[least]} in each of the {pieces} pieces of a period"
        check_memory(what, needed[least], "give fewer by lobex.Duhamel(nodes=…), or angles that repeat within a turn")
        most = max(int(np.sum(np.array(needed) <= available_memory())) - 1, least)
        return np.minimum(start, most), np.minimum(last, most)

    def _rehearsals(self, start: np.ndarray, speed: float, gain: float) -> list[Callable[[], object]]:
        """Calls that compile, side by side, what many points need: the sizes begun with, or the one and the next."""
        wanted = np.unique(start)
        if len(wanted) == 1:
            wanted = np.arange(wanted[0], min(wanted[0] + 2, len(self.sizes)))
        methods = [replace(self.method, nodes=self.sizes[i]) for i in wanted]

        def prepare(method: Duhamel) -> object:
            speeds = np.full(SPEEDS, speed)
            return self.prepared_at(self.process, method, speeds, gain, 1, self.traits, self.in_flight)

        def evaluate(method: Duhamel) -> object:
            shapes = jax.eval_shape(
                partial(self.prepared_at, traits=self.traits, in_flight=self.in_flight),
                self.process,
                method,
                np.full(SPEEDS, speed),
                gain,
                1,
            )
            prepared = jax.tree.map(lambda part: np.zeros(part.shape, part.dtype), shapes)
            slab = _Slab(self, np.full(SPEEDS, speed), np.zeros(1, dtype=int), np.full(1, gain))
            slab.shared = slab.coefficients(slab.gain, method)
            batch = slab.batch(prepared, method)
            return slab.evaluate(prepared, np.zeros(1, dtype=int), method, _EFFORTS[0], batch)

        return [partial(call, method) for method in methods for call in (evaluate, prepare)]


def samples_at(process: Process, speeds: np.ndarray, gains: np.ndarray) -> int | None:
    """How often the structure's kernel is sampled over pieces that follow the gain; None where modes turn too far."""
    some = np.unique(np.quantile(gains, np.linspace(0, 1, _LOOKS)))
    ends = np.unique([np.min(speeds), np.max(speeds)])
    return kernel_samples(_BETWEEN * max(turn_of(process, speed, gain, np.max) for speed in ends for gain in some))


def _shares(speeds: int) -> np.ndarray:
    """Where slabs of up to SPEEDS speeds begin, and the end: an even number of equal ones, whatever the cores."""
    slabs = -(-speeds // SPEEDS)
    return np.linspace(0, speeds, min(slabs + slabs % 2, speeds) + 1).astype(int)


class _Slab:
    """Points of a few speeds, and what is known about each: results, defect, and the size that they have."""

    def __init__(
        self, whole: Refinement, speeds: np.ndarray, row: np.ndarray, gain: np.ndarray, number: int = 0
    ) -> None:
        self.whole, self.speeds, self.row, self.gain = whole, speeds, row, gain
        # Each device has programs of its own.
        self.device = number % len(jax.local_devices())
        self.multiplier = np.full(len(row), np.nan, dtype=np.complex128)
        self.frequency, self.error, self.rounding, self.defect = (np.full(len(row), np.nan) for _ in range(4))
        self.size = np.zeros(len(row), dtype=int)
        # Of each speed among those that are prepared.
        self.place = np.zeros(len(speeds), dtype=int)
        self.densely = np.zeros(len(row), dtype=bool)
        # Gains, and the coefficients at each, where these are the same for all speeds.
        self.shared: tuple[np.ndarray, Forces] | None = None

    def run(self, start: np.ndarray, last: np.ndarray) -> None:
        """Compute every point with the size that ``start`` gives it, and with the next, up to ``last``, while it is too
        coarse: mostly as a few points of its speed tell, before the others are computed.
        """
        waiting = start
        for index, nodes in enumerate(self.whole.sizes):
            points = np.flatnonzero(waiting == index)
            if not len(points):
                continue
            method = replace(self.whole.method, nodes=nodes)
            prepared, (first, *heavier) = self._prepared(points, method)
            self.shared = self.coefficients(self.gain[points], method)
            batch = self.batch(prepared, method)
            some = points
            if len(points) >= _GROUPS * batch[1]:
                some = points[few_of_each(self.row[points], _SOME)]
            self.evaluate(prepared, some, method, first, batch)
            told = some[self._settled(some)]
            failing = np.bincount(self.row[told], self._coarse(told) - _TOO_MANY, len(self.speeds)) > 0
            early = ~np.isin(points, told) & failing[self.row[points]] & (index < last[points])
            waiting[points[early]] = index + 1
            points = points[~early]
            self.size[points], self.densely[points] = index, False
            rest = np.setdiff1d(points, some)
            self.evaluate(prepared, rest, method, self._squarings(some, first) if len(rest) else first, batch)
            for effort in heavier:
                again = points[~self._settled(points)]
                self.densely[again] = effort == 0
                self.evaluate(prepared, again, method, effort, batch)
            waiting[points[self._coarse(points) & (index < last[points])]] = index + 1

    def _coarse(self, points: np.ndarray) -> np.ndarray:
        """Whether more nodes are wanted. A point that failed, NaN, fails with more as well."""
        return self.error[points] > self._allowed(points)

    def _allowed(self, points: np.ndarray) -> np.ndarray:
        """The errors that are small enough at points."""
        with np.errstate(divide="ignore"):
            growth = np.abs(np.log(np.abs(self.multiplier[points])))
        return np.maximum(self.whole.method.tolerance, self.whole.of_growth * growth)

    @property
    def whole_error(self) -> np.ndarray:
        """By nodes, of which more help, and by rounding, where none do."""
        return self.error + self.rounding

    def _prepared(self, points: np.ndarray, method: Duhamel) -> tuple[Any, tuple[int, ...]]:
        """What is the same for all gains at the speeds of points, and the efforts that these take in turn."""
        system = self.whole.process.system(self.speeds[0], self.gain[0])
        mesh = mesh_of(system)
        rows = np.unique(self.row[points])
        self.place[rows] = np.arange(len(rows))
        # A large operator is made for no more speeds than there are, or nearly; a small one for as many as ever, since
        # each number of them is compiled for itself.
        small = mesh.pieces * method.size(system) <= _SMALL
        many = SPEEDS if small else 2 ** int(np.ceil(np.log2(len(self.speeds))))
        prepare = partial(
            self.whole.prepared_at,
            self.whole.process,
            method,
            np.resize(self.speeds[rows], many),
            self.gain[0],
            len(rows),
            self.whole.traits,
            self.whole.in_flight,
        )
        prepared = self.whole.programs.call((self.device, method.nodes, many), prepare)
        return prepared, _EFFORTS_AFTER_LONG if mesh.pieces >= _LONG * mesh.history else _EFFORTS

    def coefficients(self, gain: np.ndarray, method: Duhamel) -> tuple[np.ndarray, Forces] | None:
        """What points of gains share over all speeds; None where that is nothing, or takes no time."""
        if self.whole.traits.coefficients_by_speed:
            return None
        gains = np.unique(gain)
        # So many that few programs serve.
        many = max(2 ** int(np.ceil(np.log2(len(gains)))), _COLUMNS)
        make = self.whole.coefficients_at
        compute = partial(make, self.whole.process, method, self.speeds[0], np.resize(gains, many), len(gains))
        return gains, self.whole.programs.call((self.device, method.nodes, "coefficients", many), compute)

    def _settled(self, points: np.ndarray) -> np.ndarray:
        """Whether the pairs at points are."""
        allowed = self._allowed(points)
        return (self.defect[points] < np.maximum(_SETTLED, _OF_ERROR * allowed)) & (self.rounding[points] < allowed)

    def _squarings(self, points: np.ndarray, done: int) -> int:
        """How many settle most points, by what pairs miss after those ``done``: each more squares that."""
        least = np.log(np.maximum(_SETTLED, _OF_ERROR * self._allowed(points)))
        with np.errstate(divide="ignore", invalid="ignore"):
            more = np.log2(least / np.log(self.defect[points]))
        most = np.quantile(np.where(np.isnan(more), np.inf, more), _MOSTLY, method="higher")
        return done + int(np.clip(np.ceil(most), 0, max(_FURTHER - done, 0)))

    def evaluate(self, prepared: Any, points: np.ndarray, method: Duhamel, effort: int, batch: tuple[int, int]) -> None:
        """Put the results of points in their places, a batch at a time, the last filled up with repeats."""
        densely = effort == 0
        size, several = batch
        targets = (self.multiplier, self.frequency, self.error, self.rounding, self.defect)
        for begin in range(0, len(points), size):
            part = points[begin : begin + size]
            filled = np.resize(part, size)
            row = self.row[filled]
            place, shared = self.place[row], None
            if self.shared is not None:
                shared = self.shared[1], np.searchsorted(self.shared[0], self.gain[filled])
            compute = partial(
                self.whole.with_errors,
                self.whole.process,
                prepared,
                place,
                self.speeds[row],
                self.gain[filled],
                method,
                effort,
                len(part),
                densely,
                several,
                self.whole.samples,
                not self.whole.of_growth,
                shared,
            )
            results = self.whole.programs.call((self.device, method.nodes, densely, size), compute)
            for target, result in zip(targets, results, strict=True):
                target[part] = np.asarray(result)[: len(part)]

    def batch(self, prepared: Any, method: Duhamel) -> tuple[int, int]:
        """How many points a call takes, and how many of them are computed together.

        On a CPU these are so few that what they need stays in a core's cache; on a GPU all.
        """
        system = self.whole.process.system(self.speeds[0], self.gain[0])
        rows, forces = method.size(system), system.force_size * method.count * mesh_of(system).pieces
        size = int(max(_CHUNK_BYTES / (8 * rows**2), FEWEST))
        if jax.default_backend() != "cpu":
            return size, size
        numbers = sum(part.size / len(part) for part in jax.tree.leaves(prepared)) + rows * (forces + rows)
        several = max(2 ** round(np.log2(_CACHE_BYTES / (8 * numbers))), FEWEST)
        return several * -(-max(size, _CALL) // several), several
