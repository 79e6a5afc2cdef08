"""Blades of a stage and what they share: their receptances one by one, or those of waves around the disc.

Blades that are all alike and evenly spaced, and what couples them the same from every one of them, move in waves
yⱼ ~ e^{−2πi k j/N}, each of which sees Gₖ = Σⱼ G₀ⱼ e^{−2πi k j/N} of the receptances between the first blade and each.
Where disc or casing couple to both sides alike Gₖ has real coefficients; the waves of a casing that blades run past
travel one way each, and what a wave of blades sees of them has complex ones.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from lobex import _checks
from lobex._namespace import namespace
from lobex._shapes import AnyArray
from lobex.limits.sections import Sections, sections_of_blocks
from lobex.limits.sections_of_poles import sections_of_poles
from lobex.limits.several_contacts import numbers_of

SHARED = -2
"""In the place of the output that a block belongs to, where several see it."""
COUPLED = "has blades that more than their tracks couple, and that are not all alike and evenly spaced"
_ROUNDING = 1e-12
# Of the largest entry, what the shapes of waves at many angles leave of a matrix that is the same from every blade.
_ROUND = 1e-9


class Part(NamedTuple):
    """Blocks of a system, (n, s, s), with what forces do to them, (n, s, N), and what is seen of them, (n, N, s)."""

    blocks: Float[AnyArray, "n s s"]
    inputs: Float[AnyArray, "n s N"]
    outputs: Float[AnyArray, "n N s"]

    def of(self, index: np.ndarray) -> "Part":
        """Some of the blocks."""
        lib = namespace(self)
        return Part(*(lib.asarray(side)[index] for side in self))

    def within(self, states: Sequence[np.ndarray]) -> "Part":
        """Of a single block some of its states, as blocks of their own."""
        lib = namespace(self)
        blocks, inputs, outputs = (lib.asarray(side)[0] for side in self)
        parts = [(blocks[at][:, at], inputs[at], outputs[:, at]) for at in states]
        return Part(*(lib.stack(side) for side in zip(*parts, strict=True)))


def owners(part: Part) -> np.ndarray:
    """The output that each block belongs to, (n,); ``SHARED`` of several, and −1 of one that no force touches, which is
    anybody's.
    """
    touched = np.any(np.asarray(part.outputs) != 0, axis=2) | np.any(np.asarray(part.inputs) != 0, axis=1)
    owner = np.where(np.any(touched, axis=1), np.argmax(touched, axis=1), -1)
    return np.where(np.sum(touched, axis=1) > 1, SHARED, owner)


def blades_alone(part: Part, owner: np.ndarray, order: list[int], rates: bool) -> Sections | str:
    """Gⱼ of blades that nothing couples, in their order, with fields of the shape (N, modes), or why they have none."""
    if np.shape(part.blocks)[1] != 2:
        return "has blades whose modes are not known apart"
    index = [np.flatnonzero(owner == blade) for blade in order]
    if len({len(own) for own in index}) != 1:
        return "has blades of different numbers of modes"
    rows, blade = np.stack(index), np.array(order)[:, None]
    lib = namespace(part)
    blocks, inputs, outputs = map(lib.asarray, part)
    return sections_of_blocks(blocks[rows], inputs[rows, :, blade], outputs[rows, blade, :], rates)


def of_all(known: Part, part: Part, order: list[int]) -> tuple[Sections, np.ndarray] | str:
    """G from every blade to every other, in order, with weights of the shape (n, N, N), and the number from 1 of the
    mode that each section is of, those of a casing after those of the blades; or why there is none.
    """
    if np.shape(part.blocks)[1] == 2:
        owner = owners(known)
        shared = np.cumsum(owner == SHARED) + np.max(np.bincount(owner[owner >= 0]), initial=0)
        own = [np.sum(owner[: k + 1] == one) for k, one in enumerate(owner)]
        return _between(part, order), np.where(owner == SHARED, shared, own)
    if _checks.is_traced(part):
        return "has a structure without modes, which JAX traces"
    found: list[Any] = []
    for blocks, inputs, outputs in zip(*part, strict=True):
        for at in _apart(blocks):
            found.append(sections_of_poles(blocks[at][:, at], inputs[at][:, order], outputs[order][:, at]))
    if why := next((one for one in found if isinstance(one, str)), None):
        return why
    mode = np.repeat(1 + np.arange(len(found)), [len(one.damping_ratio) for one in found])
    return jax.tree.map(lambda *sides: np.concatenate(sides), *found), mode


def are_alike(sections: Sections) -> bool:
    """Whether all blades are."""
    fields = map(np.asarray, jax.tree.leaves(sections))
    return all(np.allclose(side, side[:1], rtol=_ROUNDING, atol=0.0) for side in fields)


def waves_of_blades(known: Part, part: Part, order: list[int], rates: bool) -> Sections | str:
    """Gₖ of blades that are alike and that a disc, or a casing that is round, or both, couple the same from each, with
    fields of the shape (N, modes and waves of the casing), or why there is none.

    Args:
        known: as ``part``, of numbers in the place of those that JAX may trace.
        part: the whole system.
        order: the outputs around the disc, each after the one whose track it is in.
        rates: whether a force acts at once on what is seen.
    """
    count, (blocks, size) = len(order), np.shape(known.blocks)[:2]
    owner = owners(known)
    if size == 2 * count and size > 2 and np.all(owner == SHARED):
        return _coupled(known, part, order, rates)
    # Whether a casing is round its own numbers say, and no others in their place.
    known = numbers_of(part)
    if size == 2:
        mine, common = (np.flatnonzero(which) for which in (owner != SHARED, owner == SHARED))
        blades = _mean(blades_alone(part.of(mine), owner[mine], order, rates))
        waves, known = part.of(common), known.of(common)
    elif blocks == 1:
        states = _apart(known.blocks[0])
        mine, common = ([at for at in states if (len(at) == 2) == small] for small in (False, True))
        if not mine or not common or any(len(at) != 2 * count for at in mine):
            return COUPLED
        blades = _coupled(known.within(mine), part.within(mine), order, rates)
        waves, known = part.within(common), known.within(common)
    else:
        return COUPLED
    casing = _around(known, waves, order)
    if isinstance(blades, str) or isinstance(casing, str):
        return blades if isinstance(blades, str) else casing
    lib = namespace(blades, casing)
    rate = lib.zeros_like(blades.weight) if blades.rate is None else blades.rate
    return Sections(
        lib.concatenate([blades.angular_frequency, casing.angular_frequency], axis=1),
        lib.concatenate([blades.damping_ratio, casing.damping_ratio], axis=1),
        lib.concatenate([blades.weight + 0j, casing.weight], axis=1),
        lib.concatenate([rate + 0j, casing.rate], axis=1),
    )


def _mean(blades: Sections | str) -> Sections | str:
    """Of blades that are alike the mean of all, which is what a wave sees of a change of any of them."""
    if isinstance(blades, str):
        return blades
    if not are_alike(numbers_of(blades)):
        return COUPLED
    lib = namespace(blades)
    return jax.tree.map(lambda side: lib.broadcast_to(lib.mean(side, axis=0), np.shape(side)), blades)


def _coupled(known: Part, part: Part, order: list[int], rates: bool) -> Sections | str:
    """Gₖ of blades that are all alike and coupled to both sides alike, with fields of the shape (N, modes)."""
    count, groups = len(order), np.shape(known.blocks)[0]

    def by_blade(part: Part) -> tuple[Any, Any, Any]:
        lib = namespace(part)
        blocks = lib.asarray(part.blocks).reshape(groups, count, 2, count, 2)[:, order][:, :, :, order]
        acting = lib.asarray(part.inputs).reshape(groups, count, 2, count)[:, order][:, :, :, order]
        seen = lib.asarray(part.outputs).reshape(groups, count, count, 2)[:, order][:, :, order]
        return blocks, acting, seen

    blocks, acting, seen = by_blade(known)
    if not all(_turns(side, 1, last, _ROUNDING) for side, last in ((blocks, 3), (acting, 3), (seen, 2))):
        return COUPLED
    beside = blocks[:, 0].swapaxes(1, 2)
    one_sided = not np.allclose(beside[:, 1:], beside[:, :0:-1], rtol=_ROUNDING, atol=0.0)
    if one_sided or np.any(acting[:, 0, :, 1:]) or np.any(seen[:, 0, 1:]):
        return COUPLED
    blocks, acting, seen = by_blade(part)
    lib, wave = namespace(blocks), np.cos(2 * np.pi * np.outer(np.arange(count), np.arange(count)) / count)
    of_wave = lib.einsum("kj,gajb->kgab", wave, blocks[:, 0])
    return sections_of_blocks(of_wave, acting[:, 0, :, 0], seen[:, 0, 0], rates)


def _around(known: Part, part: Part, order: list[int]) -> Sections | str:
    """What waves of blades see of blocks of two states that all of them share, (N, blocks), each the mean from every
    blade, which is what it changes by if any of them does.
    """
    response = _between(known, order)
    if not all(_turns(np.asarray(side), 1, 2, 0.0) for side in (response.weight, response.rate)):
        return COUPLED
    response, count = _between(part, order), len(order)
    lib, apart = namespace(response), np.arange(count) - np.arange(count)[:, None]
    wave = np.exp(-2j * np.pi / count * np.arange(count)[:, None, None] * apart) / count
    alike = (response.angular_frequency, response.damping_ratio)
    return Sections(
        *(lib.broadcast_to(side, (count, *np.shape(side))) for side in alike),
        *(lib.einsum("wij,kij->kw", side, wave) for side in (response.weight, response.rate)),
    )


def _between(part: Part, order: list[int]) -> Sections:
    """G of blocks of two states from every output to every other, in order, with weights of the shape (n, N, N)."""
    lib = namespace(part)
    blocks, inputs, outputs = map(lib.asarray, part)
    acting = lib.swapaxes(inputs, 1, 2)[:, None, order]
    return sections_of_blocks(blocks, acting, outputs[:, order, None], True)


def _apart(matrix: Float[AnyArray, "d d"]) -> list[np.ndarray]:
    """The states of a block, a pair for each mode or wave, in groups that nothing couples."""
    # Imported here, as that takes longer than limits of one contact.
    from scipy.sparse.csgraph import connected_components

    pairs = np.kron(np.eye(np.shape(matrix)[0] // 2), np.ones((2, 2)))
    count, label = connected_components((np.asarray(matrix) != 0) | (pairs != 0), directed=False)
    return [np.flatnonzero(label == number) for number in range(count)]


def _turns(side: Float[np.ndarray, "..."], first: int, second: int, relative: float) -> bool:
    """Whether it is the same from every blade, whose numbers are along two of its axes."""
    turned = np.roll(np.roll(side, 1, axis=first), 1, axis=second)
    rest = 0.0 if relative else _ROUND * float(np.max(np.abs(side)))
    return bool(np.allclose(turned, side, rtol=relative, atol=rest))
