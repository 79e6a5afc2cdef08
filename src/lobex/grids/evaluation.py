"""The dominant multiplier at many points by any method: in chunks by matrix products, the rest by the dense solver."""

from functools import partial
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float, Int
from tqdm import tqdm

from lobex._batches import in_batches, over_few, side_by_side, together
from lobex._broadcast import over_points
from lobex._compiled import compiled_for
from lobex._shapes import AnyArray, Number
from lobex.characteristic.method import CharacteristicRoots
from lobex.floquet import dense, power
from lobex.grids.dominant import Dominant
from lobex.grids.over_forms import refined_at_points, refined_over_grid
from lobex.operators.duhamel import Duhamel
from lobex.operators.operator import Method
from lobex.processes.process import Process

# The operators of one chunk: a few megabytes stay in cache, and larger chunks measured up to twice slower.
_CHUNK_BYTES = 4e6
# So many times fewer of them at once, which stay in a core's cache.
_GROUPS = 8
# Gains that share what depends on the speed alone.
_COLUMNS = 16
# Below this residual the iterated |μ| agrees with the dense solver to 1e-9 (tests/test_sweep.py).
_TRUSTED_RESIDUAL = 1e-11
_BATCH = 128
# Points left open by characteristic roots that one size of the operator serves.
_FEW = 256
# Work per point, lightest first: squarings of the operator, or 0 for the dense solver.
_EFFORTS = (8, 16, 24, 0)


def dominant_over_grid(
    process: Process,
    speeds: np.ndarray,
    gains: np.ndarray,
    method: Method | CharacteristicRoots,
    progress: bool,
    of_growth: float = 0.0,
    quickly: bool = False,
) -> Dominant:
    """Over the grid of speeds (n,) and gains (m,), shape (n, m); call in the scope of float64.

    Where a method chooses its nodes an error of so much ``of_growth``, log |μ|, is enough as well as its tolerance, and
    frequencies are NaN then, which nobody asks for; its programs are compiled ``quickly`` if they take longer for that
    than to run.
    """
    if isinstance(method, CharacteristicRoots):
        return _by_roots(process, method.over_grid(process, speeds, gains), speeds[:, None], gains)
    if isinstance(method, Duhamel):
        return refined_over_grid(process, speeds, gains, method, progress, of_growth, quickly)
    *chunk, several = _chunk_shape(process, method, speeds[0], gains[0])
    shape = (len(speeds), len(gains))
    multiplier = np.full(shape, np.nan, dtype=np.complex128)
    frequency, residual = np.full(shape, np.nan), np.full(shape, np.inf)
    starts = [(i, j) for i in range(0, shape[0], chunk[0]) for j in range(0, shape[1], chunk[1])]

    def work(number: int) -> tuple[Any, list[np.ndarray]]:
        # Filled up with repeats, so that one shape serves every grid.
        part = tuple(
            np.arange(start, min(start + size, whole))
            for start, whole, size in zip(starts[number], shape, chunk, strict=True)
        )
        row, column = (np.resize(index, size) for index, size in zip(part, chunk, strict=True))
        result = _over_chunk(process, method, _EFFORTS[0], several, len(part[0]), speeds[row], gains[column])
        return np.ix_(*part), [np.asarray(values)[: len(part[0]), : len(part[1])] for values in result]

    with tqdm(total=multiplier.size, unit="pt", unit_scale=True, disable=not progress, leave=False) as bar:
        for part, results in side_by_side(work, len(starts)):
            for target, values in zip((multiplier, frequency, residual), results, strict=True):
                target[part] = values
            bar.update(results[0].size)
    doubtful = np.nonzero(_untrusted(multiplier, residual))
    again = _at_points(process, speeds[doubtful[0]], gains[doubtful[1]], method, _EFFORTS[1:])
    multiplier[doubtful], frequency[doubtful] = again.multiplier, again.frequency
    densely = np.zeros(shape, dtype=bool)
    densely[doubtful] = again.again
    return Dominant(multiplier, frequency, np.full(shape, np.nan), np.zeros(shape, dtype=int), densely)


def _by_roots(process: Process, found: tuple[np.ndarray, ...], speeds: np.ndarray, gains: np.ndarray) -> Dominant:
    """What characteristic roots gave, which discretise nothing, and what they leave open by an operator."""
    multiplier, frequency, error, proven = found
    nodes = np.zeros(proven.shape, dtype=int)
    left = np.nonzero(~proven)
    speeds, gains = (np.broadcast_to(a, proven.shape)[left] for a in (speeds, gains))
    # Of a few points it is quicker to compute them too finely than to compile one size after the other.
    again = refined_at_points(process, speeds, gains, Duhamel(), every_mode=len(speeds) < _FEW)
    for target, result in zip((multiplier, frequency, error, nodes), again[:4], strict=True):
        target[left] = result
    return Dominant(multiplier, frequency, error, nodes, ~proven)


def dominant_at_points(
    process: Process,
    speeds: np.ndarray,
    gains: np.ndarray,
    method: Method | CharacteristicRoots,
    every_mode: bool = False,
    of_growth: float = 0.0,
    quickly: bool = False,
) -> Dominant:
    """At the points (speeds[i], gains[i]), shape (p,); call in the scope of float64.

    With ``every_mode`` a method that chooses its nodes begins, at few points, with enough for every mode; ``of_growth``
    and ``quickly`` as over a grid.
    """
    if isinstance(method, CharacteristicRoots):
        return _by_roots(process, method.at_points(process, speeds, gains), speeds, gains)
    if isinstance(method, Duhamel):
        every_mode = every_mode and len(speeds) < _FEW
        return refined_at_points(process, speeds, gains, method, every_mode, of_growth, quickly)
    return _at_points(process, speeds, gains, method, _EFFORTS)


def _at_points(
    process: Process, speeds: np.ndarray, gains: np.ndarray, method: Method, efforts: tuple[int, ...]
) -> Dominant:
    multiplier = np.full(len(speeds), np.nan, dtype=np.complex128)
    frequency, residual = np.full(len(speeds), np.nan), np.full(len(speeds), np.inf)
    doubtful, densely = np.arange(len(speeds)), np.zeros(len(speeds), dtype=bool)
    for effort in efforts:
        if not len(doubtful):
            break
        densely[doubtful] = effort == 0
        evaluate = partial(_over_batch, process, method, effort, effort == 0, together(_BATCH))
        results = in_batches(evaluate, (speeds[doubtful], gains[doubtful]), _BATCH)
        multiplier[doubtful], frequency[doubtful], residual[doubtful] = results
        doubtful = np.flatnonzero(_untrusted(multiplier, residual))
    nothing = np.full(len(speeds), np.nan)
    return Dominant(multiplier, frequency, nothing, np.zeros(len(speeds), dtype=int), densely)


def _untrusted(multiplier: np.ndarray, residual: np.ndarray) -> np.ndarray:
    return ~(residual < _TRUSTED_RESIDUAL) | ~np.isfinite(multiplier)


def _chunk_shape(process: Process, method: Method, speed: float, gain: float) -> tuple[int, int, int]:
    """Speeds and gains of a chunk, and how many speeds are computed together: whatever the grid, so that a method of a
    process is compiled once for all.
    """
    size = method.size(process.system(speed, gain))
    points = max(int(_CHUNK_BYTES / (8 * size**2)), 1)
    columns = min(points, _COLUMNS)
    rows = points // columns
    several = together(rows, max(rows // _GROUPS, 1))
    return several * (rows // several), columns, several


@compiled_for("several")
def _over_chunk(
    process: Process,
    method: Method,
    squarings: int | Int[Array, ""],
    several: int,
    count: Number,
    speeds: Float[AnyArray, " speeds"],
    gains: Float[AnyArray, " gains"],
) -> tuple[Complex[Array, "speeds gains"], Float[Array, "speeds gains"], Float[Array, "speeds gains"]]:
    """As ``_evaluated`` over all gains at the first ``count`` speeds, ``several`` at a time."""

    def row(speed: Number) -> tuple[Complex[Array, " gains"], Float[Array, " gains"], Float[Array, " gains"]]:
        return over_points(partial(_evaluated, process, method, squarings, False), speed, gains)

    return over_few(row, several, count, speeds)


@compiled_for("densely", "several")
def _over_batch(
    process: Process,
    method: Method,
    squarings: int | Int[Array, ""],
    densely: bool,
    several: int,
    count: Number,
    speed: Float[AnyArray, " p"],
    gain: Float[AnyArray, " p"],
) -> tuple[Complex[Array, " p"], Float[Array, " p"], Float[Array, " p"]]:
    """As ``_evaluated`` at the first ``count`` points, ``several`` at a time."""
    return over_few(partial(_evaluated, process, method, squarings, densely), several, count, speed, gain)


def _evaluated(
    process: Process, method: Method, squarings: int | Int[Array, ""], densely: bool, speed: Number, gain: Number
) -> tuple[Complex[Array, ""], Float[Array, ""], Float[Array, ""]]:
    """Dominant multiplier, chatter frequency and residual, by the dense solver if ``densely``."""
    system = process.system(speed, gain)
    operator = method.operator(system)
    if densely:
        value, vector = dense.pair_by_eigensolver(operator.matrix)
        residual = jnp.zeros(())
    else:
        pair = power.pair_by_squaring(operator.matrix, squarings)
        value, vector, residual = *map(power.as_complex, pair[:2]), power.residual(operator.matrix, pair)
    return value, operator.chatter_frequency(system.period, value, vector), residual
