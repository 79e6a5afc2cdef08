"""What a cut does along the periodic motion of its tool: force, torque, chips, and the wall that it leaves."""

from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex._shapes import AnyArray, Number
from lobex.motions.periodic import Path, highest_of
from lobex.operators.prepared import points_between
from lobex.operators.response import gauss_nodes
from lobex.processes.teeth_at_work import AtWork, Toothed
from lobex.systems.system import DelaySystem

# A piece of less than this, in periods, is rounding.
_NOTHING = 1e-12


class CutAlong(NamedTuple):
    """What the cut does over the period.

    Attributes:
        force: on the structure, at the phases asked for, (S, e).
        torque: there, N m, (S,).
        chip_thickness: of each tooth there, m, (S, teeth).
        pulled: of the chip that each tooth takes in a turn, the share that is below zero, (teeth,).
        surface_location_error: material that each tooth leaves at heights of the finished wall, m, (teeth, h).
        highest_torque: of the period, N m.
        mean_torque: of the period, N m.
    """

    force: Float[AnyArray, "*lanes S e"]
    torque: Float[AnyArray, "*lanes S"]
    chip_thickness: Float[AnyArray, "*lanes S teeth"]
    pulled: Float[AnyArray, "*lanes teeth"]
    surface_location_error: Float[AnyArray, "*lanes teeth h"]
    highest_torque: Float[AnyArray, " *lanes"]
    mean_torque: Float[AnyArray, " *lanes"]


class OverPeriod(NamedTuple):
    """What of ``CutAlong`` a period has as a whole."""

    pulled: Float[AnyArray, "*lanes teeth"]
    highest_torque: Float[AnyArray, " *lanes"]
    mean_torque: Float[AnyArray, " *lanes"]


def toothed(process: Any) -> bool:
    """Whether a process knows the teeth that cut."""
    return isinstance(process, Toothed) and process.tells_of_teeth


def walls(process: Any, gain: Number, height: Float[AnyArray, " h"]) -> Float[Array, " teeth_h"]:
    """When teeth pass the finished wall, as phases in one row; none where a process knows no teeth."""
    return jnp.ravel(process.left_standing(gain, height)[0]) if toothed(process) else jnp.zeros(0)


def cut_along(
    process: Any,
    speed: Number,
    gain: Number,
    system: DelaySystem,
    path: Path,
    phase: Float[AnyArray, " S"],
    at_walls: Float[Array, "teeth_h r"],
    height: Float[AnyArray, " h"],
    nodes: int,
) -> CutAlong:
    """What the cut of a process with teeth does.

    Args:
        process, speed, gain: that makes the system.
        system: the forced delay system.
        path: its periodic motion.
        phase: phases t/T, (S,).
        at_walls: y where teeth pass the finished wall, at the phases of ``walls``.
        height: heights there as shares of the depth of cut, (h,).
        nodes: of each piece.
    """
    points = points_between(nodes)
    inside, beside = _phases(path, points), path.aside(phase)
    work: AtWork = process.at_work(speed, gain, jnp.concatenate([inside, beside]), path.at)
    over, sampled = _apart(work, len(inside))
    return CutAlong(
        force=force_at(system, path, beside),
        torque=sampled.torque,
        chip_thickness=sampled.thickness,
        surface_location_error=left_at(process, gain, at_walls, height),
        **_summed(over, path, points)._asdict(),
    )


def over_period(process: Any, speed: Number, gain: Number, path: Path, points: np.ndarray) -> OverPeriod:
    """What the cut of a process with teeth does in a period, by Gauss' points of each piece, from 0 to 1."""
    return _summed(process.at_work(speed, gain, _phases(path, points), path.at), path, points)


def left_at(
    process: Any, gain: Number, at_walls: Float[Array, "teeth_h r"], height: Float[AnyArray, " h"]
) -> Float[AnyArray, "teeth h"]:
    """Material that each tooth leaves at heights of the wall, m, from y there, as ``cut_along`` is given it."""
    passes, weights = process.left_standing(gain, height)
    return (at_walls[:, : len(weights)] @ weights).reshape(jnp.shape(passes))


def furthest_of(left: Float[AnyArray, "*lanes teeth h"], lib: Any) -> Float[AnyArray, " *lanes"]:
    """Of what all teeth leave at all heights that which is furthest from none, with its sign."""
    walls = left.reshape(*left.shape[:-2], -1)
    furthest = lib.argmax(lib.abs(walls), axis=-1)
    return lib.take_along_axis(walls, furthest[..., None], axis=-1)[..., 0]


def _phases(path: Path, points: np.ndarray) -> Float[AnyArray, " M_p"]:
    """Points of every piece as phases."""
    return (path.start[:, None] + path.length[:, None] * points).ravel()


def _summed(over: AtWork, path: Path, points: np.ndarray) -> OverPeriod:
    """What teeth do at Gauss' points of every piece, as what they do in the period."""
    length = jnp.asarray(path.length)
    weight = (length[:, None] * gauss_nodes(len(points))[1]).ravel()
    torque = over.torque.reshape(len(length), -1)
    # What nobody knows on a jump, which a piece of rounding stands on, is what is known on the longest one.
    known = jnp.where((length > _NOTHING)[:, None], torque, torque[jnp.argmax(length)])
    cut, pulled = (weight @ part for part in (over.chip + 2 * over.pulled, over.pulled))
    terms = jnp.einsum("tp,mp->mt", _terms(points), known)
    return OverPeriod(
        pulled=jnp.where(cut > 0, pulled / jnp.where(cut > 0, cut, 1.0), 0.0),
        highest_torque=highest_of(terms[..., None])[0],
        mean_torque=weight @ over.torque,
    )


def _apart(work: AtWork, count: int) -> tuple[AtWork, AtWork]:
    """The first ``count`` phases, and the others."""
    return AtWork(*(part[:count] for part in work)), AtWork(*(part[count:] for part in work))


def force_at(system: DelaySystem, path: Path, phase: Float[AnyArray, " S"]) -> Float[Array, "S e"]:
    """f of all terms of a system, at phases t/T, (S,)."""
    forces, m = system.at(phase), jnp.shape(system.recalled)[1]
    places = jnp.stack([phase, *(phase - lag for lag in system.lags(phase))])
    now, *before = path.at(places)
    # What is remembered comes last.
    total = jnp.einsum("ser,sr->se", forces.present, now[:, : system.output_size])
    for coefficient, outputs in zip(forces.delayed, before, strict=True):
        total += jnp.einsum("sem,sm->se", coefficient, outputs[:, -m:])
    for term in system.forcing:
        total += term.coefficient.at(phase)[..., 0]
    return total


def _terms(points: np.ndarray) -> np.ndarray:
    """From samples at points of [0, 1] to Chebyshev terms."""
    return np.linalg.inv(np.polynomial.chebyshev.chebvander(2 * points - 1, len(points) - 1))
