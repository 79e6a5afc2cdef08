"""The stability boundary as curves: contour lines of a map, every vertex polished, islands included."""

import warnings
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from jaxtyping import Array, Float, Int

from lobex import _checks
from lobex._batches import in_batches, over_few, together
from lobex._compiled import compiled_for
from lobex._float64 import at_once, widened
from lobex._shapes import AnyArray
from lobex._timing import timed
from lobex.grids.choice import AUTO, AnyMethod, Auto, operator_of, tolerance_of
from lobex.grids.evaluation import dominant_at_points
from lobex.grids.node_counts import enough_nodes
from lobex.grids.sweep import SweepWarning, sweep
from lobex.limits.contour import GrowthMap, contours, doubled, on_curve, refined, with_hidden_lines
from lobex.limits.contour_vertices import Evaluation
from lobex.limits.coverage import MOST_WAVES, waves_per_cell
from lobex.limits.growth import growth_and_gradient
from lobex.operators.duhamel import Duhamel
from lobex.operators.operator import Method
from lobex.processes.process import Process, check_process, fine_enough
from lobex.results.boundary import Boundary, BoundaryCurve
from lobex.results.chart import Chart
from lobex.results.codes import Kind
from lobex.results.rebuild import rebuild

# Every vertex that is kept leaves log max|μ| below this.
_POLISHED = 1e-8
_USABLE_RESIDUAL = 1e-8
# Times that the map is halved where a chord between two vertices does not lead along the curve.
_DOUBLINGS = 4
# Few points are left after the first steps: small batches waste little.
_BATCH = 32


def boundary(
    source: Chart | Process,
    speed: Any = None,
    gain: Any = None,
    method: AnyMethod = AUTO,
    *,
    progress: bool = False,
) -> Boundary:
    """The curves max|μ| = 1 in the plane of speed and gain, closed ones and islands included.

    A map of log max|μ| is swept, or taken from a ``Chart``; its contour lines are ordered polylines with a vertex on
    each grid line that they cross. Newton's method along the gradient, by speed and gain, moves every vertex onto the
    curve, all side by side and within its cell; where that fails, at a kink between two multipliers, the root is
    bracketed on the vertex' own grid line, at whose ends the map has both signs. Where the middle of a chord finds no
    curve to lead along, the map is halved, up to four times. Further vertices are put in where a chord is off the curve
    by more than a hundredth of a cell. All vertices are then computed once more and those that leave
    |log max|μ|| > 1e-8 are dropped and counted.

    What is not missed: every curve that separates two grid points. Grid lines are added where the slopes of the map
    point across zero between two grid points and a sample there agrees. ``Boundary.waves_per_cell`` tells how
    much of a lobe a cell spans, for the fastest mode that can chatter: 1/4 or less puts four columns into every
    lobe. Islands within one cell that the slopes do not tell, and which of two curves that meet within one cell goes
    on to which, are up to the map: take it finer. ``Boundary.unresolved`` counts the chords left that cut a sharp
    corner or may join two curves.

    Args:
        source: a ``Chart``, or a process, such as ``Rub(modes)``, with the grid and method of a chart.
        speed: increasing speeds, Hz (revolutions per second), (n,), n ≥ 2; of a process only.
        gain: increasing gains, (m,), m ≥ 2; of a process only.
        method: of the map, as ``sweep`` takes it; of a process only. Vertices are
            polished with it, or, where it chooses its nodes or has no operator, with ``Duhamel`` of as many nodes as
            the map's own curves need.
        progress: show a progress bar on standard error.

    Returns:
        A ``Boundary``: polylines with chatter frequency and kind at every vertex.

    Raises:
        ValueError: for a chart with a grid or method beside it, a chart whose process is not one of lobex's own,
            grids of fewer than two values, and whatever ``sweep`` refuses.

    Warns:
        SweepWarning: when vertices were dropped or have too large an estimated error, when a cell spans more than a
            quarter of a lobe, and as ``sweep``.
    """
    with timed() as spent:
        if isinstance(source, Chart):
            own = None if isinstance(method, Auto) else method
            for name, value in (("speed", speed), ("gain", gain), ("method", own)):
                if value is not None:
                    raise ValueError(f"{name} = {_checks.brief(value)} beside a chart, which has its own; leave it out")
            chart, process, chosen = source, rebuild(source.process), rebuild(source.method)
        else:
            if speed is None or gain is None:
                raise ValueError("source is a process: give the speeds and gains of the map to trace from, too")
            check_process(source)
            _checks.untraced("boundary", source=source, speed=speed, gain=gain)
            process, chosen = source, method
            chart = sweep(process, speed, gain, method, progress=progress)
        if min(chart.spectral_radius.shape) < 2:
            raise ValueError(
                f"a chart of shape {chart.spectral_radius.shape} has no contours; take two or more of each"
            )
        with at_once():
            process = fine_enough(widened(process), chart.speed, chart.gain, tolerance_of(chosen))
            chosen = _of_fixed_size(chosen, process, chart)
            waves, fastest, where = waves_per_cell(process, chart.speed, float(np.abs(chart.gain).max()))
            curves, residual, dropped, unresolved, coarse = _trace(process, chosen, chart)
    if waves > MOST_WAVES:
        warnings.warn(
            f"near speed = {where:.6g} Hz a cell spans {waves:.2g} of a lobe of the mode at {fastest:.6g} Hz, "
            f"whose lobes may be missed; take {waves / MOST_WAVES:.2g} times as many speeds there",
            SweepWarning,
            stacklevel=2,
        )
    if dropped:
        warnings.warn(
            f"{dropped} vertices were dropped, at which max|μ| = 1 could not be met to {_POLISHED:g}; "
            "take a finer map or method",
            SweepWarning,
            stacklevel=2,
        )
    if coarse:
        warnings.warn(
            f"{coarse} vertices have an estimated error above the tolerance {tolerance_of(chosen):g}; "
            "give a chart of a method with more nodes",
            SweepWarning,
            stacklevel=2,
        )
    return Boundary(
        curves=curves,
        residual=residual,
        dropped=dropped,
        unresolved=unresolved,
        waves_per_cell=waves,
        fastest_frequency=fastest,
        bounds=(float(chart.speed[0]), float(chart.speed[-1]), float(chart.gain[0]), float(chart.gain[-1])),
        quantity=chart.quantity,
        speed_unit=chart.speed_unit,
        process=chart.process,
        method=chart.method,
        seconds=spent.seconds,
        compiling=spent.compiling,
    )


def _of_fixed_size(method: AnyMethod, process: Process, chart: Chart) -> Method:
    """An operator whose values at neighbouring points are those of one smooth function."""
    operator = operator_of(method)
    if not isinstance(operator, Duhamel) or operator.nodes is not None:
        return operator
    lines = contours(GrowthMap(chart.speed, chart.gain, _log(chart.multiplier)))
    if not lines:
        return replace(operator, nodes=operator.count)
    at = np.concatenate([line.place for line in lines])
    found = dominant_at_points(process, at[:, 0], at[:, 1], operator)
    return replace(operator, nodes=enough_nodes(found, operator.tolerance))


def _trace(process: Process, method: Method, chart: Chart) -> tuple[tuple[BoundaryCurve, ...], float, int, int, int]:
    """Curves, the largest growth left on them, and how much is amiss.

    That is vertices dropped, chords that do not lead along a curve, and vertices of too large an estimated error.
    """

    def sample(speed: np.ndarray, gain: np.ndarray) -> np.ndarray:
        return _log(dominant_at_points(process, speed, gain, method).multiplier)

    grid = with_hidden_lines(GrowthMap(chart.speed, chart.gain, _log(chart.multiplier)), sample)
    evaluate = _evaluation(process, method)
    lines = contours(grid)
    traced = on_curve(grid, lines, evaluate)
    for _ in range(_DOUBLINGS):
        lost = refined(grid, traced, evaluate, rounds=1)[1]
        if not lost.size:
            break
        grid = doubled(grid, lost, sample)
        lines = contours(grid)
        traced = on_curve(grid, lines, evaluate)
    (every, _, number), lost = refined(grid, traced, evaluate)
    found = dominant_at_points(process, every[:, 0], every[:, 1], method)
    left = np.abs(_log(found.multiplier))
    good = left <= _POLISHED
    curves = []
    for i, line in enumerate(lines):
        part = np.flatnonzero(good & (number == i))
        if part.size < 2:
            continue
        closed = line.closed
        # A closed curve that lost its first vertex, which is its last as well, is closed at the next one.
        if closed and part.size > 2 and np.any(every[part[0]] != every[part[-1]]):
            part = np.r_[part, part[0]]
        curves.append(_curve(every[part], found.frequency[part], found.multiplier[part], closed))
    curves.sort(key=lambda c: -len(c.speed))
    coarse = int(np.sum(good & (found.error > tolerance_of(method))))
    return tuple(curves), float(np.max(left[good], initial=0.0)), int(np.sum(~good)), len(lost), coarse


def _curve(place: np.ndarray, frequency: np.ndarray, multiplier: np.ndarray, closed: bool) -> BoundaryCurve:
    real = np.abs(np.imag(multiplier)) <= 1e-9 * np.abs(multiplier)
    kind = np.where(real, np.where(np.real(multiplier) < 0, Kind.FLIP, Kind.FOLD), Kind.HOPF).astype(np.int8)
    return BoundaryCurve(place[:, 0], place[:, 1], frequency, kind, closed)


def _log(multiplier: np.ndarray) -> np.ndarray:
    """log |μ|, a vanishing multiplier as far below 0."""
    with np.errstate(divide="ignore"):
        return np.maximum(np.log(np.abs(multiplier)), -1e3)


def _evaluation(process: Process, method: Method) -> Evaluation:
    # A finer map has most vertices of the coarser one, and Newton's steps from them are the same.
    known: dict[tuple[float, float], tuple[float, ...]] = {}

    def evaluate(speed: np.ndarray, gain: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        points = list(zip(speed.tolist(), gain.tolist(), strict=True))
        new = [point for point in dict.fromkeys(points) if point not in known]
        if new:
            at = np.array(new)
            results = in_batches(partial(_gradients, process, method, together(_BATCH)), (at[:, 0], at[:, 1]), _BATCH)
            known.update(zip(new, zip(*(r.tolist() for r in results), strict=True), strict=True))
        growth, by_speed, by_gain, residual = np.array([known[point] for point in points]).T
        return growth, by_speed, by_gain, residual < _USABLE_RESIDUAL

    return evaluate


@compiled_for("several")
def _gradients(
    process: Process,
    method: Method,
    several: int,
    count: Int[Array, ""],
    speed: Float[AnyArray, " p"],
    gain: Float[AnyArray, " p"],
) -> tuple[Float[Array, " p"], Float[Array, " p"], Float[Array, " p"], Float[Array, " p"]]:
    """At the first ``count`` of points (p,), ``several`` at a time."""
    return over_few(partial(growth_and_gradient, process, method), several, count, speed, gain)
