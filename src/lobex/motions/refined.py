"""Motions with as many nodes as their error asks for: each size is judged by the one before it."""

from collections.abc import Callable
from operator import itemgetter
from typing import Any, NamedTuple, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from lobex._shapes import AnyArray
from lobex.operators.duhamel import Duhamel
from lobex.operators.estimate import sizes_of
from lobex.operators.response import quickness, tail_bound
from lobex.processes.process import Process
from lobex.systems.forced import as_feedback
from lobex.systems.mesh import mesh_of
from lobex.systems.system import DelaySystem

Found = TypeVar("Found")

# Nodes per piece in turn.
_SIZES = (6, 9, 14, 21, 32, 48, 72, 108)


class Seen(NamedTuple):
    """What of motions sizes are compared by, by lane.

    Attributes:
        output: y at the phases asked for, (S, r).
        lowest, highest: its extremes over the period, (r,).
        rounding: what rounding leaves unknown, relative to the largest displacement.
        size: of each output, (r,).
        largest: the largest displacement of all outputs, each in units of its own size.
    """

    output: Float[AnyArray, "*lanes S r"]
    lowest: Float[AnyArray, "*lanes r"]
    highest: Float[AnyArray, "*lanes r"]
    rounding: Float[AnyArray, " *lanes"]
    size: Float[AnyArray, "*lanes r"]
    largest: Float[AnyArray, " *lanes"]


def seen(
    system: DelaySystem,
    output: Float[AnyArray, "S r"],
    lowest: Float[AnyArray, " r"],
    highest: Float[AnyArray, " r"],
    rounding: Float[AnyArray, ""],
) -> Seen:
    """Of a motion of a system."""
    size = sizes_of(system.outputs)
    return Seen(output, lowest, highest, rounding, size, jnp.max(jnp.maximum(-lowest, highest) / size))


def refined(
    at: Callable[[int, np.ndarray], Found],
    seen_of: Callable[[Found], Seen],
    sizes: tuple[int, ...],
    tolerance: float,
    count: int,
) -> tuple[Found, np.ndarray]:
    """What is found of ``count`` lanes by ``at(nodes, lanes)``, with the first of the sizes that serves each.

    Returns:
        All that was found, and the error of the displacement, relative to the largest, (count,).
    """
    lanes, error = np.arange(count), np.full(count, np.inf)
    first, *others = sizes
    known = at(first, lanes)
    for nodes in others:
        now = at(nodes, lanes)
        error[lanes] = apart(seen_of(now), jax.tree.map(itemgetter(lanes), seen_of(known)), np)
        for target, part in zip(jax.tree.leaves(known), jax.tree.leaves(now), strict=True):
            target[lanes] = part
        lanes = np.flatnonzero(~(error <= tolerance) & np.isfinite(seen_of(known).largest))
        if not len(lanes):
            break
    return known, error


def sizes_for(process: Process, slowest: float, method: Duhamel, many: bool = False) -> tuple[int, ...]:
    """The nodes to try in turn, the first to judge the second by, which follows every mode over the widest piece.

    Unless motions are ``many``, the first does as well: where it is just too coarse, its difference from the second is
    above the tolerance, and a third size is to be compiled.
    """
    if method.nodes is not None:
        return judging(method.nodes), method.nodes
    closed = as_feedback(process.system(slowest, 0.0))
    widest = float(np.max(mesh_of(closed).length))
    turn = np.max(quickness(np.asarray(closed.blocks))) * float(closed.period) * widest / 2
    following = _SIZES[1:-1] if many else _SIZES[:-1]
    enough = tail_bound(np.nan_to_num(turn), np.array(following)) < np.sqrt(method.tolerance)
    return _SIZES[int(np.argmax(enough)) if enough.any() else len(_SIZES) - 2 :]


def judging(nodes: int) -> int:
    """More nodes, to judge some by."""
    return nodes + max(nodes // 4, 2)


def apart(now: Seen, before: Seen, lib: Any) -> Float[AnyArray, " p"]:
    """By how much two sizes differ, with what rounding may add, relative to the largest displacement, by lane."""
    size, largest = now.size[:, None], lib.maximum(now.largest, np.finfo(float).tiny)

    def by(name: str) -> Float[AnyArray, " p"]:
        change = getattr(now, name) - getattr(before, name)
        return lib.max(lib.abs(change.reshape(len(largest), -1, size.shape[-1])) / size, axis=(1, 2), initial=0.0)

    changes = [by(name) for name in ("output", "lowest", "highest")]
    return lib.max(lib.stack(changes), axis=0) / largest + now.rounding
