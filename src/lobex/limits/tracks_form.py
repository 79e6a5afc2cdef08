"""Whether a process is that of blades, each in the track of the one before it, and what its exact limit takes."""

from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from lobex import _checks
from lobex._namespace import namespace
from lobex._shapes import AnyArray, Number
from lobex.limits.sections import Sections, sections_of_blocks
from lobex.limits.track_product import Uncoupled
from lobex.processes.process import Process
from lobex.systems.delays import ConstantDelay, Share, WholePeriod
from lobex.systems.form import by_form
from lobex.systems.system import DelaySystem
from lobex.systems.terms import Regenerative
from lobex.systems.traits import followers

_ROUNDING = 1e-12
# Of a revolution, by which delays may miss it.
_TURN = 1e-9
_UNDAMPED = 1e-9
_COUPLED = "has blades that more than their tracks couple, and that are not all alike and evenly spaced"


class Families(NamedTuple):
    """Blades that are all alike, −K [yⱼ − yⱼ₋₁(t − τ)], as one contact for each number of waves around the disc.

    With yⱼ ~ e^{−2πi k j/N} it is 1 + K Gₖ (1 − e^{−iωT/N + 2πi k/N}) = 0.

    Attributes:
        receptance: Gₖ, its fields of the shape (N, n), k = 0 … N − 1.
        turn: by how many turns each phase is shifted, −k/N, (N,).
        even: whether the blades are evenly spaced, so that k is a number of nodal diameters.
    """

    receptance: Sections
    turn: Float[AnyArray, " N"]
    even: bool

    @property
    def blades(self) -> int:
        """N."""
        return np.shape(self.turn)[0]


@by_form
def is_of_tracks(made: Any, shapes: tuple[Any, ...], number: Any) -> bool:
    """Whether constant forces act on several outputs, each of them on one, that others left a constant time ago, and
    neither structure nor forces follow the speed, nor the structure the gain.
    """
    system = jax.eval_shape(lambda numbers, speed, gain: made(numbers).system(speed, gain), shapes, number, number)
    if system.remembered is None or not system.feedback or system.force_size != system.output_size:
        return False
    for term in system.feedback:
        if not isinstance(term, Regenerative) or not term.coefficient.constant:
            return False
        if not isinstance(term.delay, WholePeriod | Share | ConstantDelay):
            return False

    def structure(system: DelaySystem) -> tuple[Any, ...]:
        return system.blocks, system.inputs, system.outputs, system.recalled

    def by_gain(numbers: Any, speed: Number, gain: Number) -> Any:
        system = made(numbers).system(speed, gain)
        return structure(system), system.period, system.lags(np.zeros(1))

    def by_speed(numbers: Any, gain: Number, speed: Number) -> Any:
        system = made(numbers).system(speed, gain)
        return structure(system), system.at(np.zeros(1))

    traced = (jax.make_jaxpr(function)(shapes, number, number) for function in (by_gain, by_speed))
    return not any(any(followers(one.jaxpr)) for one in traced)


def tracks_of(process: Process, known: Process, speed: float) -> Uncoupled | Families | str:
    """What the exact limit takes, or in words why there is none, of a process for which ``is_of_tracks``.

    Args:
        process: whose numbers JAX may trace; ``known`` is the same with numbers, those of ``process`` if they are.
        speed: at which it is looked at, Hz.
    """
    system = jax.tree.map(np.asarray, known.system(speed, 1.0))
    forces, doubled = (np.asarray(_forces(one)) for one in (system, known.system(speed, 2.0)))
    if not np.allclose(2 * forces, doubled, rtol=_ROUNDING, atol=0.0):
        return "has forces that are not proportional to the gain"
    acting = np.einsum("kjj->kj", forces)
    total = np.sum(acting, axis=0)
    alone = np.all(np.sum(acting != 0, axis=0) == 1) and np.count_nonzero(forces) == np.count_nonzero(acting)
    if not alone or np.any(total <= 0):
        return "has forces that are not one on each of its outputs, against it"
    order = _order(system)
    if order is None:
        return "has outputs that are not each in the track of one other, all around"
    lag = np.sum(np.where(acting != 0, [np.asarray(part)[0] for part in _lags(system)], 0.0), axis=0)
    if abs(float(np.sum(lag) * system.period) * speed - 1) > _TURN:
        return "has delays that do not add up to one revolution"
    even = bool(np.allclose(lag, lag[0], rtol=0.0, atol=_TURN))
    traced = process.system(speed, 1.0)
    lib = namespace(traced)
    weight = lib.sqrt(lib.einsum("kjj->j", _forces(traced)))
    inputs, outputs = lib.asarray(traced.inputs) * weight, lib.asarray(traced.outputs) * weight[:, None]
    # Whether a force acts at once on what is seen.
    rates = bool(np.any(np.einsum("nsj,njs->nj", system.inputs, system.outputs)))
    owner, count = _owners(system), len(order)
    if owner is not None:
        found = _alone(traced, inputs, outputs, owner, order, rates)
    else:
        found = _around(system, traced, inputs, outputs, order, rates) if even else _COUPLED
    if isinstance(found, str):
        return found
    if refused := _damped(found):
        return refused
    # Of numbers that JAX traces none are alike.
    if owner is not None and (process is not known or not _alike(found)):
        return Uncoupled(found)
    return Families(found, -np.arange(count) / count, even)


def _forces(system: DelaySystem) -> Float[AnyArray, "k N N"]:
    """The coefficient of each term."""
    lib = namespace(system)
    return lib.stack([lib.asarray(term.coefficient.at(np.zeros(1)))[0] for term in system.feedback])


def _lags(system: DelaySystem) -> list[Float[np.ndarray, " k"]]:
    """Of each term, at a phase."""
    return [
        np.asarray(term.delay.shares(np.zeros(1), system.period)) for term in system.feedback if term.delay is not None
    ]


def _order(system: DelaySystem) -> list[int] | None:
    """The outputs around the disc, each after the one whose track it is in; None if they make no circle."""
    now, before = (np.moveaxis(np.asarray(part), 1, 0) for part in (system.outputs, system.recalled))
    same = np.array([[np.array_equal(one, other) for other in now] for one in before])
    if np.shape(same)[0] != np.shape(same)[1] or np.any(np.sum(same, axis=1) != 1):
        return None
    leader, order = np.argmax(same, axis=1), [0]
    while (after := int(np.flatnonzero(leader == order[-1])[0]) if order[-1] in leader else 0) != 0:
        order.append(after)
    return order if len(order) == len(leader) else None


def _owners(system: DelaySystem) -> np.ndarray | None:
    """The output that each block belongs to, (n,); None where some serve several."""
    touched = np.any(np.asarray(system.outputs) != 0, axis=2) | np.any(np.asarray(system.inputs) != 0, axis=1)
    if np.any(np.sum(touched, axis=1) > 1):
        return None
    # One that no force touches is anybody's.
    return np.where(np.any(touched, axis=1), np.argmax(touched, axis=1), -1)


def _alone(
    system: DelaySystem,
    inputs: Float[AnyArray, "n s N"],
    outputs: Float[AnyArray, "n N s"],
    owner: np.ndarray,
    order: list[int],
    rates: bool,
) -> Sections | str:
    """Gⱼ of blades that are not coupled, in their order, with fields of the shape (N, modes)."""
    if np.shape(system.blocks)[1] != 2:
        return "has blades whose modes are not known apart"
    index = [np.flatnonzero(owner == blade) for blade in order]
    if len({len(own) for own in index}) != 1:
        return "has blades of different numbers of modes"
    rows, blade = np.stack(index), np.array(order)[:, None]
    return sections_of_blocks(
        namespace(system.blocks).asarray(system.blocks)[rows],
        inputs[rows, :, blade],
        outputs[rows, blade, :],
        rates,
    )


def _around(
    known: DelaySystem,
    system: DelaySystem,
    inputs: Float[AnyArray, "n s N"],
    outputs: Float[AnyArray, "n N s"],
    order: list[int],
    rates: bool,
) -> Sections | str:
    """Gₖ of blades that are all alike and coupled to both sides alike, with fields of the shape (N, modes)."""
    count, groups = len(order), np.shape(known.blocks)[0]
    if np.shape(known.blocks)[1] != 2 * count:
        return _COUPLED

    def by_blade(system: Any, inputs: Any, outputs: Any) -> tuple[Any, Any, Any]:
        lib = namespace(system.blocks, inputs)
        blocks = lib.asarray(system.blocks).reshape(groups, count, 2, count, 2)[:, order][:, :, :, order]
        acting = lib.asarray(inputs).reshape(groups, count, 2, count)[:, order][:, :, :, order]
        seen = lib.asarray(outputs).reshape(groups, count, count, 2)[:, order][:, :, order]
        return blocks, acting, seen

    blocks, acting, seen = by_blade(known, np.asarray(known.inputs), np.asarray(known.outputs))
    if not (_turns_into_itself(blocks, 1, 3) and _turns_into_itself(acting, 1, 3) and _turns_into_itself(seen, 1, 2)):
        return _COUPLED
    beside = blocks[:, 0].swapaxes(1, 2)
    one_sided = not np.allclose(beside[:, 1:], beside[:, :0:-1], rtol=_ROUNDING, atol=0.0)
    if one_sided or np.any(acting[:, 0, :, 1:]) or np.any(seen[:, 0, 1:]):
        return _COUPLED
    blocks, acting, seen = by_blade(system, inputs, outputs)
    lib, wave = namespace(blocks), np.cos(2 * np.pi * np.outer(np.arange(count), np.arange(count)) / count)
    of_wave = lib.einsum("kj,gajb->kgab", wave, blocks[:, 0])
    return sections_of_blocks(of_wave, acting[:, 0, :, 0], seen[:, 0, 0], rates)


def _turns_into_itself(part: Float[np.ndarray, "..."], first: int, second: int) -> bool:
    """Whether it is the same from every blade, whose numbers are along two of its axes."""
    turned = np.roll(np.roll(part, 1, axis=first), 1, axis=second)
    return bool(np.allclose(turned, part, rtol=_ROUNDING, atol=0.0))


def _alike(sections: Sections) -> bool:
    fields = map(np.asarray, jax.tree.leaves(sections))
    return all(np.allclose(part, part[:1], rtol=_ROUNDING, atol=0.0) for part in fields)


def _damped(sections: Sections) -> str | None:
    """Why the structure has no limit, of numbers that are known."""
    if _checks.is_traced(sections):
        return None
    own, ratio = np.asarray(sections.angular_frequency), np.asarray(sections.damping_ratio)
    if not np.all(np.isfinite(own)) or np.any(ratio < 0):
        return "has a structure that is not stable by itself"
    return "has several contacts, and a mode without damping" if np.any(ratio <= _UNDAMPED) else None
