"""``orbit``: the periodic motion of forced processes, with as many nodes at each point as its error asks for."""

from dataclasses import replace
from functools import partial
from operator import attrgetter
from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, Real

from lobex import _checks
from lobex._batches import in_batches, over_few, together
from lobex._broadcast import over_points
from lobex._compiled import compiled, compiled_for
from lobex._float64 import at_once, in_float64, widened
from lobex._missing import where_there
from lobex._shapes import AnyArray, ArrayLike, Number
from lobex._timing import Stopwatch, spare_programs, timed
from lobex._warnings import SweepWarning, warn
from lobex.grids.choice import AUTO, Auto
from lobex.grids.evaluation import dominant_at_points
from lobex.motions.cut_along import CutAlong, cut_along, toothed, walls
from lobex.motions.periodic import periodic
from lobex.motions.refined import Seen, apart, judging, refined, seen, sizes_for
from lobex.operators.duhamel import Duhamel
from lobex.processes.declared import check_system
from lobex.processes.plausible import warn_of_implausible
from lobex.processes.process import (
    Process,
    check_gain,
    check_process,
    check_speed,
    differentiable,
    fine_enough,
    lanes_shape,
)
from lobex.processes.quantity import quantity_of
from lobex.processes.teeth_at_work import Toothed
from lobex.results.codes import OrbitStatus
from lobex.results.cutting_orbit import CuttingOrbit
from lobex.results.description import describe
from lobex.results.orbit import Orbit
from lobex.systems.system import DelaySystem

# Of derivatives, where nothing tells before how many are needed.
_TRACED = 20
_SAMPLES = 257
# Of the depth of cut, heights at which helical edges are told of.
_HEIGHTS = 9
BATCH = 16
"""Points of one call, where there are as many."""
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
    speed, gain = _checks.as_array(speed, "speed"), _checks.as_array(gain, "gain")
    chosen = check_forced_motion(process, speed, gain, method)
    lanes = lanes_shape(speed, gain)
    phases = _checks.as_numbers("phase", np.linspace(0, 1, _SAMPLES) if phase is None else phase)
    if phases is None or phases.ndim != 1 or not phases.size:
        raise ValueError(f"phase = {_checks.brief(phase)} must be a list of phases t/T")
    heights = heights_of(process, height)
    traced = _checks.is_traced((process, speed, gain))
    with timed() as spent:
        if traced:
            parts = traced_motion(process, speed, gain, chosen, Wanted(phases, heights))
        else:
            with at_once():
                speeds, gains = (np.broadcast_to(np.asarray(one, dtype=float), lanes).ravel() for one in (speed, gain))
                model = fine_enough(widened(process), speeds, gains, chosen.tolerance)
                parts = _settled(model, speeds, gains, chosen, Wanted(phases, heights))
                parts = {name: part.reshape((*lanes, *part.shape[1:])) for name, part in parts.items()}
    made, own = (CuttingOrbit, {"height": heights}) if toothed(process) else (Orbit, {})
    return made(
        **parts,
        **own,
        phase=phases,
        **of_call(process, chosen, spent, traced),
    )


def of_call(process: Process, method: Duhamel, spent: Stopwatch, traced: bool) -> dict[str, Any]:
    """What results say of the call that made them."""
    return {
        "quantity": quantity_of(process),
        "speed_unit": process.speed_unit,
        "process": {"type": type(process).__name__} if traced else describe(process),
        "method": describe(method),
        "seconds": spent.seconds,
        "compiling": spent.compiling,
    }


def check_moves(process: Any) -> None:
    """Require a process of which a motion is known."""
    if why := getattr(process, "without_motion", None):
        raise ValueError(f"process = {type(process).__name__} {why}")


def check_forced_motion(process: Process, speed: Any, gain: Any, method: Any) -> Duhamel:
    """What is checked of every call that asks for motions; the method to find them by."""
    check_process(process)
    check_moves(process)
    spare_programs()
    if not isinstance(method, Auto | Duhamel):
        raise ValueError(f"method = {_checks.brief(method)} makes no orbit; give lobex.Duhamel() or leave it out")
    check_speed(process, speed)
    check_gain(process, gain)
    lanes = lanes_shape(speed, gain)
    if 0 in lanes:
        raise ValueError(f"speed and gain have no values, shape {lanes}; give at least one")
    check_system(process, speed, gain)
    warn_of_implausible(process, speed, gain)
    return Duhamel() if isinstance(method, Auto) else method


def heights_of(process: Process, height: Any) -> np.ndarray:
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
    """Of every lane: the motion, y at the walls included, what the cut does, if it is one of teeth, the dominant
    multiplier, (2,), by how much that misses its equation, and T.
    """

    seen: Seen
    cut: CutAlong | None
    multiplier: Float[AnyArray, "*lanes 2"]
    residual: Float[AnyArray, " *lanes"]
    period: Float[AnyArray, " *lanes"]


class Wanted(NamedTuple):
    """Phases t/T at which the motion is wanted, (S,), and heights of the finished wall, (h,)."""

    phase: Float[AnyArray, " S"]
    height: Float[AnyArray, " h"]


def _lane(process: Process, method: Duhamel, wanted: Wanted, speed: Number, gain: Number) -> _Lanes:
    system = process.system(speed, gain)
    phases = jnp.concatenate([jnp.asarray(wanted.phase), walls(process, gain, wanted.height)])
    found, path = periodic(system, method, phases)
    cut = None
    if toothed(process):
        at_walls, nodes = found.output[len(wanted.phase) :], method.count
        cut = cut_along(process, speed, gain, system, path, wanted.phase, at_walls, wanted.height, nodes)
    motion = seen(system, found.output, found.lowest, found.highest, found.rounding)
    return _Lanes(motion, cut, found.multiplier, found.residual, jnp.asarray(system.period))


def _settled(
    process: Process, speeds: np.ndarray, gains: np.ndarray, method: Duhamel, wanted: Wanted
) -> dict[str, Any]:
    """The fields of an ``Orbit`` by lane; call in the scope of float64."""
    check_forced(process.system(speeds[0], gains[0]))

    # The same for all sizes, of which the last may be asked for by few.
    several = 1 if len(speeds) < BATCH else BATCH

    def at(nodes: int, lanes: np.ndarray) -> _Lanes:
        evaluate = partial(_at_points, process, replace(method, nodes=nodes), wanted, together(several))
        return in_batches(evaluate, (speeds[lanes], gains[lanes]), several)

    sizes = sizes_for(process, np.min(speeds), method)
    known, error = refined(at, attrgetter("seen"), sizes, method.tolerance, len(speeds))
    radius = np.linalg.norm(known.multiplier, axis=-1)
    unknown = np.flatnonzero(~(known.residual < _SETTLED))
    if len(unknown):
        again = dominant_at_points(process, speeds[unknown], gains[unknown], Duhamel(tolerance=method.tolerance))
        radius[unknown] = np.abs(again.multiplier)
    parts = _fields(known, radius, error, method.tolerance, wanted, np)
    warn_of(parts["status_code"], parts.get("pulled"), method.tolerance)
    return {"speed": speeds, "gain": gains, **parts}


@in_float64
@compiled
def traced_motion(
    process: Process,
    speed: Real[AnyArray, "..."],
    gain: Real[AnyArray, "..."],
    method: Duhamel,
    wanted: Wanted,
) -> dict[str, Any]:
    """The same for traced numbers."""
    nodes = method.nodes or _TRACED
    # Of several forms, which differ where an immersion is full alone, one.
    (*_, (_, process)) = differentiable(process)

    def point(speed: Real[Array, ""], gain: Real[Array, ""]) -> dict[str, Any]:
        check_forced(process.system(speed, gain))
        now = _lane(process, replace(method, nodes=nodes), wanted, speed, gain)
        still = jax.lax.stop_gradient((process, speed, gain))
        finer = _lane(still[0], replace(method, nodes=judging(nodes)), wanted, *still[1:])
        radius = jnp.sqrt(jnp.sum(now.multiplier**2))
        one, other = jax.tree.map(lambda part: part[None], (now.seen, finer.seen))
        error = apart(one, other, jnp)[0]
        return {"speed": speed, "gain": gain, **_fields(now, radius, error, method.tolerance, wanted, jnp)}

    return over_points(point, speed, gain)


@compiled_for("several")
def _at_points(
    process: Process,
    method: Duhamel,
    wanted: Wanted,
    several: int,
    count: Number,
    speed: Float[AnyArray, " p"],
    gain: Float[AnyArray, " p"],
) -> _Lanes:
    return over_few(partial(_lane, process, method, wanted), several, count, speed, gain)


def check_forced(system: DelaySystem) -> None:
    """Require a forcing."""
    if not system.forcing:
        raise ValueError(
            "process has no forcing, without which its only orbit is rest; give it one, such as feed_per_tooth of "
            "lobex.Milling or forcing of lobex.LinearDelay"
        )


def _fields(
    lanes: _Lanes,
    radius: Float[AnyArray, " *lanes"],
    error: Float[AnyArray, " *lanes"],
    tolerance: float,
    wanted: Wanted,
    lib: Any,
) -> dict[str, Any]:
    """Those of an ``Orbit`` that are found; motions that nothing comes to are none."""
    pulled = None if lanes.cut is None else lib.max(lanes.cut.pulled, axis=-1)
    status = status_of(lanes.seen.largest, radius, error, pulled, tolerance, lib)
    told = (status != OrbitStatus.UNSTABLE) & (status != OrbitStatus.FAILED)

    def where_told(part: Float[AnyArray, "..."]) -> Float[AnyArray, "..."]:
        return where_there(told.reshape(told.shape + (1,) * (part.ndim - told.ndim)), part)

    motion = {
        "displacement": lanes.seen.output[..., : len(wanted.phase), :],
        "lowest": lanes.seen.lowest,
        "highest": lanes.seen.highest,
        "error": error,
        **({} if lanes.cut is None else lanes.cut._asdict()),
    }
    return {
        "period": lanes.period,
        "spectral_radius": radius,
        "status_code": status,
        **{name: where_told(part) for name, part in motion.items()},
    }


def status_of(
    largest: Float[AnyArray, " *lanes"],
    radius: Float[AnyArray, " *lanes"],
    error: Float[AnyArray, " *lanes"],
    pulled: Float[AnyArray, " *lanes"] | None,
    tolerance: float,
    lib: Any,
) -> Int[AnyArray, " *lanes"]:
    """What became of motions, of several things the worst: of their largest displacement, the radius of the motion
    about them, their error, and the share of a chip at which a tooth is pulled."""
    good = lib.where(error <= tolerance, int(OrbitStatus.GOOD), int(OrbitStatus.ABOVE_TOLERANCE))
    if pulled is not None:
        leaves = (good == OrbitStatus.GOOD) & (pulled > tolerance)
        good = lib.where(leaves, int(OrbitStatus.TOOTH_LEAVES_THE_CUT), good)
    status = lib.where(radius < 1, good, int(OrbitStatus.UNSTABLE))
    known = lib.isfinite(largest) & lib.isfinite(radius)
    return lib.where(known, status, int(OrbitStatus.FAILED)).astype("int8")


def warn_of(status: np.ndarray, pulled: np.ndarray | None, tolerance: float, *known: OrbitStatus) -> None:
    """Warn of motions by their status, of each in one line, less of what is ``known``."""
    leaving = status == OrbitStatus.TOOTH_LEAVES_THE_CUT
    most = 100 * np.max(pulled[leaving]) if pulled is not None and leaving.any() else 0.0
    for code, words in (
        (
            OrbitStatus.TOOTH_LEAVES_THE_CUT,
            f"have a tooth that leaves the cut, which for up to {most:.2g} % of its chip is pushed as if it pulled",
        ),
        (OrbitStatus.UNSTABLE, "are unstable: no motion comes to their orbit, which is NaN"),
        (OrbitStatus.FAILED, "failed and are NaN"),
        (OrbitStatus.ABOVE_TOLERANCE, f"have an estimated error above {tolerance:g}"),
    ):
        if code not in known and (count := int(np.sum(status == code))):
            warn(f"{count} of {status.size} points {words}", SweepWarning)
