"""Modes whose coordinates springs couple: blocks of all that are coupled in place of blocks of one mode."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from lobex._namespace import namespace
from lobex._shapes import AnyArray
from lobex.systems.system import DelaySystem


def with_springs(system: DelaySystem, springs: Float[AnyArray, "g N N"]) -> DelaySystem:
    """A modal system, of the modes of g groups of N one after the other, with springs within each group; with further
    modes, all of them in one block.

    Args:
        system: of g·N modes, as ``modal_system`` makes it, and more after them.
        springs: what they add to the squares of frequencies, (g, N, N), rad²/s².
    """
    lib = namespace(system.blocks, springs)
    groups, size = np.shape(springs)[:2]
    more = np.shape(system.blocks)[0] - groups * size
    omega = lib.asarray(system.blocks)[: groups * size, 0, 1].reshape(groups, size, 1)
    scaled = springs / omega
    if more:
        scaled = _in_one_group(scaled, more)
        groups, size = 1, groups * size + more
    blocks = lib.asarray(system.blocks).reshape(groups, size, 2, 2)
    corner = np.zeros((2, 2))
    # The state of a mode is (u, u̇/ω).
    corner[1, 0] = -1.0
    alone = lib.einsum("gjab,jk->gjakb", blocks, np.eye(size))
    between = lib.einsum("gjk,ab->gjakb", scaled, corner)

    def columns(side: Float[AnyArray, "n r s"]) -> Float[AnyArray, "..."]:
        count = np.shape(side)[1]
        parts = lib.asarray(side).reshape(groups, size, count, 2)
        return lib.swapaxes(parts, 1, 2).reshape(groups, count, 2 * size)

    return replace(
        system,
        blocks=(alone + between).reshape(groups, 2 * size, 2 * size),
        inputs=lib.asarray(system.inputs).reshape(groups, 2 * size, -1),
        outputs=columns(system.outputs),
        remembered=None if system.remembered is None else columns(system.remembered),
    )


def _in_one_group(springs: Float[AnyArray, "g N N"], more: int) -> Float[AnyArray, "1 all all"]:
    """The springs of all groups in one, with further modes that have none."""
    lib = namespace(springs)
    groups, size = np.shape(springs)[:2]
    whole = lib.einsum("gh,gjk->gjhk", np.eye(groups), springs).reshape(groups * size, groups * size)
    return lib.pad(whole, ((0, more), (0, more)))[None]
