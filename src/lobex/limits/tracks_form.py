"""Whether a process is that of blades, each in the track of the one before it, and what its exact limit takes."""

from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from lobex import _checks
from lobex._namespace import namespace
from lobex._shapes import AnyArray, Number
from lobex.limits.parts_of_stage import (
    COUPLED,
    SHARED,
    Part,
    are_alike,
    blades_alone,
    of_all,
    owners,
    waves_of_blades,
)
from lobex.limits.sections import Sections
from lobex.limits.several_contacts import numbers_of
from lobex.limits.track_product import Uncoupled
from lobex.limits.whole_stage import WholeStage
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


def tracks_of(process: Process, known: Process, speed: float) -> Uncoupled | Families | WholeStage | str:
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
    if not np.all(np.any(system.outputs, axis=(0, 2))):
        return "has a contact that meets nothing that moves"
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
    known_part, part = Part(system.blocks, system.inputs, system.outputs), Part(traced.blocks, inputs, outputs)
    owner, count = owners(known_part), len(order)
    alone = not np.any(owner == SHARED)
    if alone:
        found = blades_alone(part, owner, order, rates)
    else:
        found = waves_of_blades(known_part, part, order, rates) if even else COUPLED
    if isinstance(found, str) and found == COUPLED:
        return _whole(of_all(known_part, part, order), traced, order, speed)
    if isinstance(found, str):
        return found
    if refused := _damped(found):
        return refused
    # Of numbers that JAX traces none are alike.
    if alone and (process is not known or not are_alike(found)):
        return Uncoupled(found)
    return Families(found, -np.arange(count) / count, even)


def _whole(
    found: tuple[Sections, np.ndarray] | str, system: DelaySystem, order: list[int], speed: float
) -> WholeStage | str:
    if isinstance(found, str):
        return found
    receptance, mode = found
    if refused := _damped(receptance):
        return refused
    lib = namespace(system)
    acting = np.einsum("kjj->kj", np.asarray(_forces(numbers_of(system)))) != 0
    lags = [
        lib.asarray(term.delay.shares(np.zeros(1), system.period))[0]
        for term in system.feedback
        if term.delay is not None
    ]
    lag = lib.sum(lib.where(acting, lib.stack(lags)[:, None], 0.0), axis=0)
    return WholeStage(receptance, lag[np.array(order)] * system.period * speed, mode)


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


def _damped(sections: Sections) -> str | None:
    """Why the structure has no limit, of numbers that are known."""
    if _checks.is_traced(sections):
        return None
    own, ratio = np.asarray(sections.angular_frequency), np.asarray(sections.damping_ratio)
    if not np.all(np.isfinite(own)) or np.any(ratio < 0):
        return "has a structure that is not stable by itself"
    return "has several contacts, and a mode without damping" if np.any(ratio <= _UNDAMPED) else None
