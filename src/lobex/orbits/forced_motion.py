"""``orbit``: the periodic motion of forced processes, with as many nodes at each point as its error asks for."""

from dataclasses import replace
from functools import partial
from operator import itemgetter
from typing import Any, NamedTuple

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
from lobex.orbits.periodic import Periodic, largest, periodic
from lobex.processes.declared import check_system
from lobex.processes.plausible import warn_of_implausible
from lobex.processes.process import Process, check_gain, check_process, check_speed, lanes_shape
from lobex.processes.quantity import quantity_of
from lobex.results.codes import OrbitStatus
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
) -> Orbit:
    """The periodic motion that a forced stable process comes to: (I − U)⁻¹ b where a period maps x to U x + b.

    Exact in the structure, spectrally accurate between the jumps, and differentiable with respect to speed, gain and
    every number in ``process``. Between the nodes the motion is that of the structure under the forces found.

    Args:
        process: a process with a forcing, such as ``Milling(…, feed_per_tooth=1e-4)`` or
            ``LinearDelay(…, forcing=…)``.
        speed: speeds in Hz (revolutions per second), any shape.
        gain: gains, broadcast against ``speed``; the broadcast shape is that of the lanes.
        method: ``Auto()`` or ``Duhamel()`` choose the nodes by the tolerance of the displacement, relative to the
            largest; ``Duhamel(nodes=…)`` does not. Where JAX traces an argument, ``Auto()`` takes 20.
        phase: phases t/T at which y is wanted, (samples,); by default 257 in equal steps from 0 to 1.

    Returns:
        An ``Orbit``; of concrete arguments with float64 NumPy arrays, under ``jit``, ``grad`` or ``vmap`` with JAX
        arrays that follow the precision of its inputs.

    Raises:
        ValueError: for a process without forcing, methods other than ``Duhamel``, NaN, infinite or non-positive speeds
            and gains that the process cannot have.

    Warns:
        SweepWarning: for points that are unstable or failed, whose motion is NaN, and for estimated errors above the
            tolerance.
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
    chosen = Duhamel() if isinstance(method, Auto) else method
    traced = _checks.is_traced((process, speed, gain))
    with timed() as spent:
        if traced:
            parts = _traced(process, speed, gain, chosen, phases)
        else:
            with at_once():
                speeds, gains = (np.broadcast_to(np.asarray(one, dtype=float), lanes).ravel() for one in (speed, gain))
                parts = _settled(widened(process), speeds, gains, chosen, phases)
                parts = {name: part.reshape((*lanes, *part.shape[1:])) for name, part in parts.items()}
    return Orbit(
        **parts,
        phase=phases,
        quantity=quantity_of(process),
        speed_unit=process.speed_unit,
        process={"type": type(process).__name__} if traced else describe(process),
        method=describe(chosen),
        seconds=spent.seconds,
        compiling=spent.compiling,
    )


class _Lanes(NamedTuple):
    """Of every lane: what ``periodic`` finds, the sizes of outputs, (r,), the largest displacement in them, and T."""

    found: Periodic
    sizes: Float[AnyArray, "*lanes r"]
    largest: Float[AnyArray, " *lanes"]
    period: Float[AnyArray, " *lanes"]


def _lane(system: DelaySystem, method: Duhamel, phases: Float[AnyArray, " S"]) -> _Lanes:
    found = periodic(system, method, phases)
    return _Lanes(found, sizes_of(system.outputs), largest(found, system), jnp.asarray(system.period))


def _settled(
    process: Process, speeds: np.ndarray, gains: np.ndarray, method: Duhamel, phases: np.ndarray
) -> dict[str, Any]:
    """The fields of an ``Orbit`` by lane; call in the scope of float64."""
    _check_forced(process.system(speeds[0], gains[0]))
    lanes, error = np.arange(len(speeds)), np.full(len(speeds), np.inf)

    def at(nodes: int) -> _Lanes:
        several = 1 if len(lanes) < _BATCH else _BATCH
        evaluate = partial(_at_points, process, replace(method, nodes=nodes), phases, together(several))
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
    parts = _fields(known, radius, error, method.tolerance, np)
    for code, words in (
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
    phases: Float[AnyArray, " S"],
) -> dict[str, Any]:
    """The same for traced numbers."""
    nodes = method.nodes or _TRACED

    def point(speed: Real[Array, ""], gain: Real[Array, ""]) -> dict[str, Any]:
        system = process.system(speed, gain)
        _check_forced(system)
        now = _lane(system, replace(method, nodes=nodes), phases)
        finer = _lane(jax.lax.stop_gradient(system), replace(method, nodes=_judging(nodes)), phases)
        radius = jnp.sqrt(jnp.sum(now.found.multiplier**2))
        one, other = jax.tree.map(lambda part: part[None], (now, finer))
        error = _error(one, other, jnp)[0]
        return {"speed": speed, "gain": gain, **_fields(now, radius, error, method.tolerance, jnp)}

    return over_points(point, speed, gain)


@partial(jax.jit, static_argnames="several")
def _at_points(
    process: Process,
    method: Duhamel,
    phases: Float[AnyArray, " S"],
    several: int,
    count: Number,
    speed: Float[AnyArray, " p"],
    gain: Float[AnyArray, " p"],
) -> _Lanes:
    def point(speed: Number, gain: Number) -> _Lanes:
        return _lane(process.system(speed, gain), method, phases)

    return over_few(point, several, count, speed, gain)


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
    lanes: _Lanes, radius: Float[AnyArray, " *lanes"], error: Float[AnyArray, " *lanes"], tolerance: float, lib: Any
) -> dict[str, Any]:
    """Those of an ``Orbit`` that are found; motions that nothing comes to are none."""
    good = lib.where(error <= tolerance, int(OrbitStatus.GOOD), int(OrbitStatus.ABOVE_TOLERANCE))
    status = lib.where(radius < 1, good, int(OrbitStatus.UNSTABLE))
    status = lib.where(lib.isfinite(lanes.largest) & lib.isfinite(radius), status, int(OrbitStatus.FAILED))
    told = status <= int(OrbitStatus.ABOVE_TOLERANCE)

    def where_told(part: Float[AnyArray, "..."]) -> Float[AnyArray, "..."]:
        return lib.where(told.reshape(told.shape + (1,) * (part.ndim - told.ndim)), part, lib.nan)

    return {
        "period": lanes.period,
        "displacement": where_told(lanes.found.output),
        "lowest": where_told(lanes.found.lowest),
        "highest": where_told(lanes.found.highest),
        "spectral_radius": radius,
        "error": where_told(error),
        "status_code": status.astype("int8"),
    }
