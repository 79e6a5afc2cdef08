"""``orbits``: what the periodic motion does over a grid of speeds and gains, where it is stable."""

from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex import _checks
from lobex._batches import in_batches, over_few, together
from lobex._compiled import compiled_for
from lobex._float64 import at_once, widened
from lobex._shapes import AnyArray, Number
from lobex._timing import timed
from lobex.grids.choice import AUTO, Auto, chosen_method
from lobex.grids.evaluation import dominant_over_grid
from lobex.motions.cut_along import OverPeriod, furthest_of, left_at, over_period, toothed, walls
from lobex.motions.forced_motion import (
    Wanted,
    check_forced,
    check_forced_motion,
    heights_of,
    of_call,
    status_of,
    traced_motion,
    warn_of,
)
from lobex.motions.periodic import followed, highest_of, repeating
from lobex.motions.refined import Seen, refined, seen, sizes_for
from lobex.operators.duhamel import Duhamel
from lobex.operators.elimination import inverse
from lobex.operators.response import gauss_nodes
from lobex.processes.process import Process, fine_enough
from lobex.results.codes import OrbitStatus
from lobex.results.orbit_map import CuttingMap, OrbitMap
from lobex.systems.forced import as_feedback

# Gains at a speed that share what depends on the speed alone, speeds with as many of one call, and of them those that
# are computed side by side, which stay in a core's cache.
_COLUMNS, _ROWS, _TOGETHER = 16, 8, 2


def orbits(process: Process, speed: Any, gain: Any, method: Duhamel | Auto = AUTO, *, height: Any = None) -> OrbitMap:
    """What the periodic motion of a forced process does over a grid of speeds and gains, where it is stable.

    Stability is that of a chart, to its tolerance; the motion is that of ``orbit``, of which the extremes are kept,
    the wall that teeth leave, and torque and power. Differentiable as ``orbit`` is.

    Args:
        process: a process with a forcing, such as ``Milling(…, feed_per_tooth=1e-4)``.
        speed: speeds in Hz (revolutions per second), increasing, (n,).
        gain: gains, increasing, (m,).
        method: as of ``orbit``.
        height: as of ``orbit``: heights of the finished wall that its location error is taken over.

    Returns:
        An ``OrbitMap``, a ``CuttingMap`` of a process with teeth, NaN where it is unstable or failed.

    Raises:
        ValueError: as ``orbit``, and for speeds and gains that do not increase.

    Warns:
        SweepWarning: as ``orbit``, but for unstable points, of which a map has many.
        LobexWarning: for numbers that can hardly be meant: speeds in rpm, damping in per cent, depths in mm.
    """
    traced = _checks.is_traced((process, speed, gain))
    speeds, gains = _axis("speed", speed, "Hz"), _axis("gain", gain, "")
    chosen = check_forced_motion(process, speeds[:, None], gains, method)
    wanted = Wanted(np.zeros(1), heights_of(process, height))
    with timed() as spent:
        if traced:
            parts = _of_orbit(traced_motion(process, speeds[:, None], gains, chosen, wanted), speeds)
        else:
            with at_once():
                model = fine_enough(widened(process), speeds, gains, chosen.tolerance)
                parts = _over_grid(model, speeds, gains, chosen, wanted)
    made = CuttingMap if toothed(process) else OrbitMap
    return made(
        **parts,
        speed=speeds,
        gain=gains,
        **of_call(process, chosen, spent, traced),
    )


def _axis(name: str, values: Any, unit: str) -> Any:
    """Numbers that increase, or that JAX traces, in one row."""
    values = _checks.as_array(values, name)
    return jnp.ravel(values) if _checks.is_traced(values) else _checks.grid(name, values, unit)


class _Cells(NamedTuple):
    """Of every point: the motion, y at the walls alone being asked for, what is left there, and what the period asks of
    the spindle; of a process without teeth no more than the motion.
    """

    seen: Seen
    left: Float[AnyArray, "*lanes teeth h"] | None
    over: OverPeriod | None


def _over_grid(
    process: Process, speeds: np.ndarray, gains: np.ndarray, method: Duhamel, wanted: Wanted
) -> dict[str, Any]:
    """The fields of an ``OrbitMap``; call in the scope of float64."""
    check_forced(process.system(speeds[0], gains[0]))
    operator = chosen_method(Duhamel(tolerance=method.tolerance) if toothed(process) else AUTO, process, speeds[0])
    radius = np.abs(dominant_over_grid(process, speeds, gains, operator, progress=False).multiplier)
    row, column = np.nonzero(radius < 1)

    def at(nodes: int, lanes: np.ndarray) -> _Cells:
        return _at_cells(process, replace(method, nodes=nodes), wanted.height, speeds, gains, row[lanes], column[lanes])

    def put(part: np.ndarray) -> np.ndarray:
        whole = np.full((*radius.shape, *part.shape[1:]), np.nan)
        whole[row, column] = part
        return whole

    if not len(row):
        row, column = np.zeros((2, 1), dtype=int)
    sizes = sizes_for(process, np.min(speeds), method, many=True)
    known, error = refined(at, lambda found: found.seen, sizes, method.tolerance, len(row))
    pulled = None if known.over is None else np.max(known.over.pulled, axis=-1)
    status = np.full(radius.shape, OrbitStatus.UNSTABLE, dtype=np.int8)
    status[~np.isfinite(radius)] = OrbitStatus.FAILED
    status[row, column] = status_of(known.seen.largest, radius[row, column], error, pulled, method.tolerance, np)
    told = np.isin(status, (OrbitStatus.UNSTABLE, OrbitStatus.FAILED), invert=True)[row, column]
    parts = {
        "peak": np.maximum(-known.seen.lowest, known.seen.highest),
        "error": error,
        **_of_cut(known.left, known.over, speeds[row], np),
    }
    warn_of(status, put(pulled) if pulled is not None else None, method.tolerance, OrbitStatus.UNSTABLE)
    found = {
        name: put(np.where(told.reshape(-1, *[1] * (part.ndim - 1)), part, np.nan)) for name, part in parts.items()
    }
    return {"spectral_radius": radius, "status_code": status, **found}


def _of_cut(left: Any, over: Any, speed: Any, lib: Any) -> dict[str, Any]:
    """Those fields of a ``CuttingMap``, by lane."""
    if left is None:
        return {}
    return {
        "location_error": furthest_of(left, lib),
        "mean_power": 2 * np.pi * speed * over.mean_torque,
        "highest_torque": over.highest_torque,
        "pulled": lib.max(over.pulled, axis=-1),
    }


def _of_orbit(parts: dict[str, Any], speeds: Float[AnyArray, " n"]) -> dict[str, Any]:
    """The same from the fields of an ``Orbit`` over the grid, traced."""
    names = "spectral_radius", "error", "status_code"
    found = {name: parts[name] for name in names}
    found["peak"] = jnp.maximum(-parts["lowest"], parts["highest"])
    if "pulled" not in parts:
        return found
    over = OverPeriod(*(parts[name] for name in OverPeriod._fields))
    return found | _of_cut(parts["surface_location_error"], over, speeds[:, None], jnp)


def _at_cells(
    process: Process,
    method: Duhamel,
    height: Float[AnyArray, " h"],
    speeds: np.ndarray,
    gains: np.ndarray,
    row: np.ndarray,
    column: np.ndarray,
) -> _Cells:
    """At the points (speeds[row], gains[column]), those of a speed a few at a time, on every core."""
    # Points of a speed in turn, which are filled up with the last of them.
    order = np.lexsort((column, row))
    place = np.arange(len(row)) - np.searchsorted(row[order], row[order])
    first = np.flatnonzero(place % _COLUMNS == 0)
    count = np.diff(np.r_[first, len(row)])
    index = first[:, None] + np.minimum(np.arange(_COLUMNS), count[:, None] - 1)
    own_speed, own_gain = speeds[row[order][first]], gains[column[order][index]]

    at_rows = partial(_at_rows, process, method, height, together(_ROWS, _TOGETHER))
    found = in_batches(at_rows, (own_speed, own_gain), _ROWS)
    filled = (np.arange(_COLUMNS) < count[:, None]).ravel()
    back = np.empty_like(order)
    back[order] = np.arange(len(order))

    return jax.tree.map(lambda part: np.concatenate(part)[filled][back], found)


@compiled_for("several")
def _at_rows(
    process: Process,
    method: Duhamel,
    height: Float[AnyArray, " h"],
    several: int,
    count: Number,
    speed: Float[AnyArray, " rows"],
    gain: Float[AnyArray, "rows columns"],
) -> _Cells:
    points = gauss_nodes(method.count)[0]

    def at_speed(speed: Float[Array, ""], gain: Float[Array, " columns"]) -> _Cells:
        return jax.vmap(partial(at_point, speed))(gain)

    def at_point(speed: Float[Array, ""], gain: Float[Array, ""]) -> _Cells:
        system = process.system(speed, gain)
        closed = as_feedback(system)
        prepared = method.prepare(closed)
        pieces = method.respond(prepared, closed, inverse)
        _, held, rounding = repeating(system, method.assemble(pieces, closed))
        path, r = followed(system, method, pieces, held), system.output_size
        at_walls = path.at(walls(process, gain, height))[:, :r]
        terms = path.terms[..., :r]
        motion = seen(system, at_walls, -highest_of(-terms), highest_of(terms), rounding)
        if not toothed(process):
            return _Cells(motion, None, None)
        return _Cells(motion, left_at(process, gain, at_walls, height), over_period(process, speed, gain, path, points))

    return over_few(at_speed, several, count, speed, gain)
