"""``orbit``: the periodic motion of forced processes, with as many nodes at each point as its error asks for."""

from dataclasses import replace
from functools import partial
from operator import itemgetter
from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Real

from lobex import _checks
from lobex._batches import in_batches, over_few, together
from lobex._broadcast import over_points
from lobex._float64 import at_once, in_float64, widened
from lobex._shapes import AnyArray, ArrayLike, Number
from lobex._timing import spare_programs, timed
from lobex._warnings import SweepWarning, warn
from lobex.grids.choice import AUTO, Auto
from lobex.grids.evaluation import dominant_at_points
from lobex.operators.duhamel import Duhamel
from lobex.operators.estimate import sizes_of
from lobex.operators.response import quickness, tail_bound
from lobex.orbits.cut_along import CutAlong, cut_along, toothed, walls
from lobex.orbits.periodic import Periodic, largest, periodic
from lobex.processes.declared import check_system
from lobex.processes.plausible import warn_of_implausible
from lobex.processes.process import Process, check_gain, check_process, check_speed, lanes_shape
from lobex.processes.quantity import quantity_of
from lobex.processes.teeth_at_work import Toothed
from lobex.results.codes import OrbitStatus
from lobex.results.cutting_orbit import CuttingOrbit
from lobex.results.description import describe
from lobex.results.orbit import Orbit
from lobex.systems.forced import as_feedback
from lobex.systems.mesh import mesh_of
from lobex.systems.system import DelaySystem

# Nodes per piece in turn: each size is judged by the one before it.
_SIZES = (6, 9, 14, 21, 32, 48, 72, 108)
# Of derivatives, where nothing tells before how many are needed.
_TRACED = 20
_SAMPLES = 257
# Of the depth of cut, heights at which helical edges are told of.
_HEIGHTS = 9
# Points of one call, where there are as many.
_BATCH = 16
# A residual of the dominant multiplier above which it is sought by what charts have.
_SETTLED = 1e-9


def orbit(
    process: Process,
    speed: ArrayLike,
    gain: ArrayLike,
    method: Duhamel | Auto = AUTO,
    *,
    phase: Any = None,
    height: Any = None,
) -> Orbit:
    """The periodic motion that a forced stable process comes to: (I − U)⁻¹ b where a period maps x to U x + b.

    Exact in the structure, spectrally accurate between the jumps, and differentiable with respect to speed, gain and
    every number in ``process``. Between the nodes the motion is that of the structure under the forces found.

    Of a process that knows its teeth (``Milling``) it tells what they do as well: force, torque and power, the chip of
    each tooth, and the surface that it leaves.

    Args:
        process: a process with a forcing, such as ``Milling(…, feed_per_tooth=1e-4)`` or
            ``LinearDelay(…, forcing=…)``.
        speed: speeds in Hz (revolutions per second), any shape.
        gain: gains, broadcast against ``speed``; the broadcast shape is that of the lanes.
        method: ``Auto()`` or ``Duhamel()`` choose the nodes by the tolerance of the displacement, relative to the
            largest; ``Duhamel(nodes=…)`` does not. Where JAX traces an argument, ``Auto()`` takes 20.
        phase: phases t/T at which y is wanted, (samples,); by default 257 in equal steps from 0 to 1.
        height: of a process with teeth, heights of the finished wall as shares of the depth of cut, from the tip, (h,);
            by default 0 of straight teeth, which leave the same at every height, and 9 from 0 to 1 of helical ones.

    Returns:
        An ``Orbit``, a ``CuttingOrbit`` of a process with teeth; of concrete arguments with float64 NumPy arrays, under
        ``jit``, ``grad`` or ``vmap`` with JAX arrays that follow the precision of its inputs.

    Raises:
        ValueError: for a process without forcing, methods other than ``Duhamel``, NaN, infinite or non-positive speeds
            and gains that the process cannot have.

    Warns:
        SweepWarning: for points that are unstable or failed, whose motion is NaN, for estimated errors above the
            tolerance, and where a tooth leaves the cut, so that the linear motion is not that of the cut.
        LobexWarning: for numbers that can hardly be meant: speeds in rpm, damping in per cent, depths in mm.
    """
    check_process(process)
    spare_programs()
    if not isinstance(method, Auto | Duhamel):
        raise ValueError(f"method = {_checks.brief(method)} makes no orbit; give lobex.Duhamel() or leave it out")
    check_speed(process, speed)
    check_gain(process, gain)
    speed, gain = (_checks.as_array(value) for value in (speed, gain))
    lanes = lanes_shape(speed, gain)
    if 0 in lanes:
        raise ValueError(f"speed and gain have no values, shape {lanes}; give at least one")
    check_system(process, speed, gain)
    warn_of_implausible(process, speed, gain)
    phases = _checks.as_numbers("phase", np.linspace(0, 1, _SAMPLES) if phase is None else phase)
    if phases is None or phases.ndim != 1 or not phases.size:
        raise ValueError(f"phase = {_checks.brief(phase)} must be a list of phases t/T")
    heights = _heights(process, height)
    chosen = Duhamel() if isinstance(method, Auto) else method
    traced = _checks.is_traced((process, speed, gain))
    with timed() as spent:
        if traced:
            parts = _traced(process, speed, gain, chosen, _Wanted(phases, heights))
        else:
            with at_once():
                speeds, gains = (np.broadcast_to(np.asarray(one, dtype=float), lanes).ravel() for one in (speed, gain))
                parts = _settled(widened(process), speeds, gains, chosen, _Wanted(phases, heights))
                parts = {name: part.reshape((*lanes, *part.shape[1:])) for name, part in parts.items()}
    made, own = (CuttingOrbit, {"height": heights}) if toothed(process) else (Orbit, {})
    return made(
        **parts,
        **own,
        phase=phases,
        quantity=quantity_of(process),
        speed_unit=process.speed_unit,
        process={"type": type(process).__name__} if traced else describe(process),
        method=describe(chosen),
        seconds=spent.seconds,
        compiling=spent.compiling,
    )


def _heights(process: Process, height: Any) -> np.ndarray:
    """Of the finished wall, as shares of the depth of cut; none where a process knows no teeth."""
    if not toothed(process):
        if height is not None:
            raise ValueError(f"height = {_checks.brief(height)} is of a process with teeth, such as lobex.Milling")
        return np.zeros(0)
    if height is None:
        return np.zeros(1) if cast(Toothed, process).straight else np.linspace(0, 1, _HEIGHTS)
    heights = _checks.as_numbers("height", height)
    if heights is None or heights.ndim != 1 or not heights.size or np.any((heights < 0) | (heights > 1)):
        raise ValueError(f"height = {_checks.brief(height)} must be a list of shares of the depth of cut, from 0 to 1")
    return heights


class _Lanes(NamedTuple):
    """Of every lane: what ``periodic`` finds, y at the walls included, what the cut does, if it is one of teeth, the
    sizes of outputs, (r,), the largest displacement in them, and T.
    """

    found: Periodic
    cut: CutAlong | None
    sizes: Float[AnyArray, "*lanes r"]
    largest: Float[AnyArray, " *lanes"]
    period: Float[AnyArray, " *lanes"]


class _Wanted(NamedTuple):
    """Phases t/T at which the motion is wanted, (S,), and heights of the finished wall, (h,)."""

    phase: Float[AnyArray, " S"]
    height: Float[AnyArray, " h"]


def _lane(process: Process, method: Duhamel, wanted: _Wanted, speed: Number, gain: Number) -> _Lanes:
    system = process.system(speed, gain)
    phases = jnp.concatenate([jnp.asarray(wanted.phase), walls(process, gain, wanted.height)])
    found, path = periodic(system, method, phases)
    cut = None
    if toothed(process):
        at_walls, nodes = found.output[len(wanted.phase) :], method.count
        cut = cut_along(process, speed, gain, system, path, wanted.phase, at_walls, wanted.height, nodes)
    return _Lanes(found, cut, sizes_of(system.outputs), largest(found, system), jnp.asarray(system.period))


def _settled(
    process: Process, speeds: np.ndarray, gains: np.ndarray, method: Duhamel, wanted: "_Wanted"
) -> dict[str, Any]:
    """The fields of an ``Orbit`` by lane; call in the scope of float64."""
    _check_forced(process.system(speeds[0], gains[0]))
    lanes, error = np.arange(len(speeds)), np.full(len(speeds), np.inf)

    def at(nodes: int) -> _Lanes:
        several = 1 if len(lanes) < _BATCH else _BATCH
        evaluate = partial(_at_points, process, replace(method, nodes=nodes), wanted, together(several))
        return in_batches(evaluate, (speeds[lanes], gains[lanes]), several)

    first, *others = _sizes(process, speeds, method)
    known = at(first)
    for nodes in others:
        now = at(nodes)
        error[lanes] = _error(now, jax.tree.map(itemgetter(lanes), known), np)
        for target, part in zip(jax.tree.leaves(known), jax.tree.leaves(now), strict=True):
            target[lanes] = part
        lanes = np.flatnonzero(~(error <= method.tolerance) & np.isfinite(known.largest))
        if not len(lanes):
            break
    radius = np.linalg.norm(known.found.multiplier, axis=-1)
    unknown = np.flatnonzero(~(known.found.residual < _SETTLED))
    if len(unknown):
        again = dominant_at_points(process, speeds[unknown], gains[unknown], Duhamel(tolerance=method.tolerance))
        radius[unknown] = np.abs(again.multiplier)
    parts = _fields(known, radius, error, method.tolerance, wanted, np)
    leaving = parts["status_code"] == OrbitStatus.TOOTH_LEAVES_THE_CUT
    most = 100 * np.max(parts["pulled"], where=leaving[:, None], initial=0.0) if "pulled" in parts else 0.0
    for code, words in (
        (
            OrbitStatus.TOOTH_LEAVES_THE_CUT,
            f"have a tooth that leaves the cut, which for up to {most:.2g} % of its chip is pushed as if it pulled",
        ),
        (OrbitStatus.UNSTABLE, "are unstable: no motion comes to their orbit, which is NaN"),
        (OrbitStatus.FAILED, "failed and are NaN"),
        (OrbitStatus.ABOVE_TOLERANCE, f"have an estimated error above {method.tolerance:g}"),
    ):
        if count := int(np.sum(parts["status_code"] == code)):
            warn(f"{count} of {len(speeds)} points {words}", SweepWarning)
    return {"speed": speeds, "gain": gains, **parts}


@in_float64
@jax.jit
def _traced(
    process: Process,
    speed: Real[AnyArray, "..."],
    gain: Real[AnyArray, "..."],
    method: Duhamel,
    wanted: _Wanted,
) -> dict[str, Any]:
    """The same for traced numbers."""
    nodes = method.nodes or _TRACED

    def point(speed: Real[Array, ""], gain: Real[Array, ""]) -> dict[str, Any]:
        _check_forced(process.system(speed, gain))
        now = _lane(process, replace(method, nodes=nodes), wanted, speed, gain)
        still = jax.lax.stop_gradient((process, speed, gain))
        finer = _lane(still[0], replace(method, nodes=_judging(nodes)), wanted, *still[1:])
        radius = jnp.sqrt(jnp.sum(now.found.multiplier**2))
        one, other = jax.tree.map(lambda part: part[None], (now, finer))
        error = _error(one, other, jnp)[0]
        return {"speed": speed, "gain": gain, **_fields(now, radius, error, method.tolerance, wanted, jnp)}

    return over_points(point, speed, gain)


@partial(jax.jit, static_argnames="several")
def _at_points(
    process: Process,
    method: Duhamel,
    wanted: _Wanted,
    several: int,
    count: Number,
    speed: Float[AnyArray, " p"],
    gain: Float[AnyArray, " p"],
) -> _Lanes:
    return over_few(partial(_lane, process, method, wanted), several, count, speed, gain)


def _check_forced(system: DelaySystem) -> None:
    if not system.forcing:
        raise ValueError(
            "process has no forcing, without which its only orbit is rest; give it one, such as feed_per_tooth of "
            "lobex.Milling or forcing of lobex.LinearDelay"
        )


def _sizes(process: Process, speeds: np.ndarray, method: Duhamel) -> tuple[int, ...]:
    """The nodes to try in turn, the first to judge the second by: it follows every mode over the widest piece."""
    if method.nodes is not None:
        return _judging(method.nodes), method.nodes
    closed = as_feedback(process.system(np.min(speeds), 0.0))
    widest = float(np.max(mesh_of(closed).length))
    turn = np.max(quickness(np.asarray(closed.blocks))) * float(closed.period) * widest / 2
    enough = tail_bound(np.nan_to_num(turn), np.array(_SIZES[1:-1])) < np.sqrt(method.tolerance)
    return _SIZES[int(np.argmax(enough)) if enough.any() else len(_SIZES) - 2 :]


def _judging(nodes: int) -> int:
    """More nodes, to judge some by."""
    return nodes + max(nodes // 4, 2)


def _error(now: _Lanes, before: _Lanes, lib: Any) -> Float[AnyArray, " p"]:
    """By how much two sizes differ, with what rounding may add, relative to the largest displacement, by lane."""
    sizes, largest = now.sizes[:, None], lib.maximum(now.largest, np.finfo(float).tiny)

    def apart(name: str) -> Float[AnyArray, " p"]:
        change = getattr(now.found, name) - getattr(before.found, name)
        return lib.max(lib.abs(change.reshape(len(largest), -1, sizes.shape[-1])) / sizes, axis=(1, 2))

    changes = [apart(name) for name in ("output", "lowest", "highest")]
    return lib.max(lib.stack(changes), axis=0) / largest + now.found.rounding


def _fields(
    lanes: _Lanes,
    radius: Float[AnyArray, " *lanes"],
    error: Float[AnyArray, " *lanes"],
    tolerance: float,
    wanted: _Wanted,
    lib: Any,
) -> dict[str, Any]:
    """Those of an ``Orbit`` that are found; motions that nothing comes to are none."""
    good = lib.where(error <= tolerance, int(OrbitStatus.GOOD), int(OrbitStatus.ABOVE_TOLERANCE))
    if lanes.cut is not None:
        leaves = (good == OrbitStatus.GOOD) & (lib.max(lanes.cut.pulled, axis=-1) > tolerance)
        good = lib.where(leaves, int(OrbitStatus.TOOTH_LEAVES_THE_CUT), good)
    status = lib.where(radius < 1, good, int(OrbitStatus.UNSTABLE))
    status = lib.where(lib.isfinite(lanes.largest) & lib.isfinite(radius), status, int(OrbitStatus.FAILED))
    told = (status != OrbitStatus.UNSTABLE) & (status != OrbitStatus.FAILED)

    def where_told(part: Float[AnyArray, "..."]) -> Float[AnyArray, "..."]:
        return lib.where(told.reshape(told.shape + (1,) * (part.ndim - told.ndim)), part, lib.nan)

    motion = {
        "displacement": lanes.found.output[..., : len(wanted.phase), :],
        "lowest": lanes.found.lowest,
        "highest": lanes.found.highest,
        "error": error,
        **({} if lanes.cut is None else lanes.cut._asdict()),
    }
    return {
        "period": lanes.period,
        "spectral_radius": radius,
        "status_code": status.astype("int8"),
        **{name: where_told(part) for name, part in motion.items()},
    }
