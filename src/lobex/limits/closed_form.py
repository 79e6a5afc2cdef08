"""Whether the stability limit of a process has a closed form, by what its equations are, and what the form takes."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from lobex import _checks
from lobex._float64 import at_once
from lobex._namespace import namespace
from lobex._shapes import AnyArray, Number
from lobex.limits.receptance import Receptance
from lobex.limits.sections import Sections, sections_of_blocks
from lobex.limits.sections_of_poles import sections_of_poles
from lobex.limits.track_product import Uncoupled
from lobex.limits.tracks_form import Families, is_of_tracks, tracks_of
from lobex.limits.whole_stage import WholeStage
from lobex.processes.process import Process
from lobex.structures.modes import Modes
from lobex.systems.form import by_form
from lobex.systems.one_force import one_force
from lobex.systems.system import DelaySystem, dense_outputs
from lobex.systems.traits import followers

# At what a system is looked at that does not follow its speed.
_SPEED = 1e-3
_ROUNDING = 1e-12
_GOLDEN = (5**0.5 - 1) / 2
# Of a damping ratio beside which eigenvalues of a receptance keep too few digits.
_UNDAMPED = 1e-9
_FREE = "has several contact directions, and a mode without damping"
# In the place of a measurement.
_ONE = Modes(np.ones(1), np.full(1, 0.1), np.ones((1, 1)))


class Regeneration(NamedTuple):
    """A force −K κ [y − y(t − τ)] with the receptance G that y has to it, τ the period.

    Attributes:
        receptance: G.
        stiffness: κ, of a gain of one.
        turn: by how many turns the phase of the delay is ahead, of a wave that travels from blade to blade.
    """

    receptance: Sections | Receptance
    stiffness: Number
    turn: Number = 0.0


class Contacts(NamedTuple):
    """Several forces −K [y − y(t − τ)] with the receptance matrix G, τ the period."""

    receptance: Sections


class Rate(NamedTuple):
    """ż = a z + K b z(t − τ) of a single state, τ the period, b > 0.

    Attributes:
        own: a, 1/s.
        delayed: b, 1/s per unit of gain.
    """

    own: Number
    delayed: Number


class _Numbers(NamedTuple):
    """What the numbers of a process say: why there is no closed form; whether it is that of a single state, or of
    several forces; whether blocks of two states are the structure's; and whether its velocities are seen.
    """

    why: str | None
    single: bool = False
    several: bool = False
    blocks: bool = False
    rates: bool = False


Form = Regeneration | Contacts | Uncoupled | Families | WholeStage | Rate


def closed_form(process: Process) -> Form | str:
    """What the closed form of a limit takes, or in words why there is none.

    It needs constant coefficients, one delay that is the period, which is one revolution, and a structure that follows
    neither speed nor gain: then D-subdivision (Neimark, 1949) of a force K [y − y(t − τ)], or of several with each
    displacement in its own track, or Hayes' limits (1950) of a single state.
    Or several forces −K [yⱼ − yⱼ₋₁(t − τⱼ)], each in the track of another, whose delays add up to one revolution.
    Of numbers that JAX traces others are looked at in their place, which no coincidence would make regenerative.
    """
    found = closed_forms([process])
    return found if isinstance(found, str) else found[0]


def closed_forms(processes: Sequence[Process]) -> list[Any] | str:
    """Those of processes that differ in the numbers of their structure alone: what the first is, all are."""
    process = processes[0]
    measured = [leaf for leaf in jax.tree.leaves(process, is_leaf=_is_measured) if _is_measured(leaf)]
    modal: Any = jax.tree.map(lambda leaf: _ONE if _is_measured(leaf) else leaf, process, is_leaf=_is_measured)
    with jax.enable_x64(True):
        tracks = is_of_tracks(modal)
        why = None if tracks else _form_refused(modal)
    if why:
        return why
    traced = _checks.is_traced(modal)
    with at_once():
        known = _others(modal) if traced else modal
        found = _Numbers(None) if tracks else _of_numbers(known, bool(measured))
    if found.why:
        return found.why

    def made(process: Any) -> Form | str:
        if tracks:
            return tracks_of(process, known if traced else process, _SPEED)
        return _made(modal if measured else process, found, measured)

    if traced or _checks.is_traced(measured):
        forms = [made(process) for process in processes]
    else:
        with at_once():
            # A float64 JAX array falls back to float32 in the first operation outside the scope.
            forms = [
                form if isinstance(form := made(one), str) else jax.tree.map(np.asarray, form) for one in processes
            ]
    return next((form for form in forms if isinstance(form, str)), forms)


def _made(process: Process, found: _Numbers, measured: list[Receptance]) -> Regeneration | Contacts | Rate | str:
    system = process.system(_SPEED, 1.0)
    held, present, delayed = _feedback(process)
    if measured:
        return Regeneration(measured[0], -present[0, 0])
    force = one_force(system, present, delayed)
    if found.single:
        own = system.blocks[0] + system.input_matrix() @ held @ system.output_matrix()
        return Rate(own[0, 0], force.inputs[0] * force.delayed[0])
    inputs, seen = force.inputs, -force.present
    if found.several:
        inputs, seen = _of_full_rank(system.input_matrix(), -present @ system.output_matrix())
    if found.blocks:
        sections = _by_blocks(system, inputs, seen, found.rates)
    elif _checks.is_traced((system, held, inputs, seen)):
        return "has a structure without modes, which JAX traces"
    else:
        drift = np.asarray(system.drift() + system.input_matrix() @ held @ system.output_matrix())
        sections = sections_of_poles(drift, np.asarray(inputs), np.asarray(seen))
        if not isinstance(sections, str) and found.several and np.any(sections.damping_ratio <= _UNDAMPED):
            sections = _FREE
    if isinstance(sections, str):
        return sections
    return Contacts(sections) if found.several else Regeneration(sections, 1.0)


@by_form
def _form_refused(made: Any, shapes: tuple[Any, ...], number: Any) -> str | None:
    system = jax.eval_shape(lambda numbers, speed, gain: made(numbers).system(speed, gain), shapes, number, number)
    if not all(term.coefficient.constant for term in system.feedback):
        return "has periodic coefficients"
    if not system.repeats or len(system.delays) != 1:
        return "has other delays than its period"

    def parts(numbers: Any, speed: Number, gain: Number) -> tuple[Any, Any]:
        system = made(numbers).system(speed, gain)
        return (system.blocks, system.inputs, system.outputs, system.recalled), system.at(np.zeros(1))

    by_gain = jax.make_jaxpr(lambda numbers, speed, gain: parts(numbers, speed, gain)[0])(shapes, number, number)
    by_speed = jax.make_jaxpr(lambda numbers, gain, speed: parts(numbers, speed, gain))(shapes, number, number)
    if any(followers(by_gain.jaxpr)) or any(followers(by_speed.jaxpr)):
        return "has coefficients that follow the speed, or a structure that follows the gain"
    return None


def _feedback(process: Process) -> tuple[Float[AnyArray, "e r"], Float[AnyArray, "e r"], Float[AnyArray, "e r"]]:
    """Of each force and output the present one without gain, and the present and the delayed one per unit of gain."""
    (held, _), (present, delayed) = (_forces(process, gain) for gain in (0.0, 1.0))
    return held, present - held, delayed


def _forces(process: Process, gain: float) -> tuple[Float[AnyArray, "e r"], Float[AnyArray, "e r"]]:
    present, (delayed,) = process.system(_SPEED, gain).at(np.zeros(1))
    return present[0], delayed[0]


def _of_numbers(process: Process, measured: bool) -> _Numbers:
    system = process.system(_SPEED, 1.0)
    held, present, delayed = map(np.asarray, _feedback(process))
    twice, none = _forces(process, 2.0), _forces(process, 0.0)[1]
    lines = (held + 2 * present, 2 * delayed)
    straight = all(np.allclose(a, b, rtol=_ROUNDING, atol=0.0) for a, b in zip(twice, lines, strict=True))
    if np.any(none) or not straight:
        return _Numbers("has forces that are not proportional to the gain")
    speeds = _SPEED * np.array([1.0, 1 + _GOLDEN])
    turns = [speed * float(process.system(speed, 1.0).period) for speed in speeds]
    if not np.allclose(turns, 1.0, rtol=0.0, atol=_ROUNDING):
        return _Numbers("has another period than one revolution")
    inputs, now, then, apart = one_force(system, present, delayed)
    if apart and measured:
        return _Numbers(f"has {system.force_size} contact directions")
    if apart:
        inputs = system.input_matrix()
        now, then = present @ system.output_matrix(), delayed @ dense_outputs(system.recalled)
    if system.state_size == 1 and not np.any(now):
        positive = bool(inputs @ then > 0)
        return _Numbers(None if positive else "has a delayed gain of another sign", single=True)
    acting, before = (inputs @ now, inputs @ then) if apart else (now, then)
    if not np.any(now) and not np.any(then):
        return _Numbers("has a force that meets nothing that moves")
    if not np.any(now) or not np.allclose(acting, -before, rtol=0.0, atol=_ROUNDING * np.max(np.abs(acting))):
        return _Numbers("has a force that is not one of what is now less what was a period ago")
    if measured and np.any(present > 0):
        return _Numbers("has a force along what is measured, and not against it")
    blocks = np.asarray(system.blocks)
    small = blocks.shape[1] == 2 and not np.any(held)
    still = small and not np.any(_by_block(now.T, inputs))
    if small:
        determinant, trace = np.linalg.det(blocks), np.trace(blocks, axis1=1, axis2=2)
        if np.any(determinant <= 0) or np.any(trace > 0):
            return _Numbers("has a structure that is not stable by itself")
        if apart and np.any(-trace <= _UNDAMPED * np.sqrt(determinant)):
            return _Numbers(_FREE)
    return _Numbers(None, several=bool(apart), blocks=small, rates=not still)


def _by_block(seen: Float[AnyArray, "..."], inputs: Float[AnyArray, "..."]) -> Float[AnyArray, "..."]:
    """Of blocks of two states what each force does at once to what each output sees, (n,) or (n, m, m)."""
    if np.ndim(inputs) == 1:
        return np.sum((seen * inputs).reshape(-1, 2), axis=1)
    return np.einsum("nio,nif->nof", *(part.reshape(-1, 2, part.shape[1]) for part in (seen, inputs)))


def _of_full_rank(
    inputs: Float[AnyArray, "..."], seen: Float[AnyArray, "..."]
) -> tuple[Float[AnyArray, "..."], Float[AnyArray, "..."]]:
    """E, (d, m), and C, (m, d), with the product of those that are given, and no more forces than it takes."""
    if _checks.is_traced((inputs, seen)):
        return inputs, seen
    left, size, right = np.linalg.svd(np.asarray(inputs) @ np.asarray(seen))
    rank = int(np.sum(size > _ROUNDING * size[0]))
    if rank == np.shape(inputs)[1]:
        return inputs, seen
    return left[:, :rank] * size[:rank], right[:rank]


def _by_blocks(
    system: DelaySystem, inputs: Float[AnyArray, "..."], seen: Float[AnyArray, "..."], rates: bool
) -> Sections:
    """G of blocks of two states, of a force (d,) and what it sees, (d,), or of several, (d, m) and (m, d)."""
    a = namespace(system.blocks).asarray(system.blocks)
    if np.ndim(inputs) == 1:
        return sections_of_blocks(a, inputs.reshape(-1, 2), seen.reshape(-1, 2), rates)
    lib = namespace(inputs, seen)
    acting = lib.stack([lib.asarray(inputs)[start::2, None, :] for start in (0, 1)], axis=-1)
    outputs = lib.stack([lib.asarray(seen).T[start::2, :, None] for start in (0, 1)], axis=-1)
    return sections_of_blocks(a, acting, outputs, rates)


def _others(process: Process) -> Any:
    """The process of other numbers, no two of them alike."""
    leaves, tree = jax.tree.flatten(process)
    sizes = [int(np.prod(np.shape(leaf))) for leaf in leaves]
    numbers = np.split(1 + np.arange(1, sum(sizes) + 1) * _GOLDEN % 1, np.cumsum(sizes)[:-1])
    filled = [part.reshape(np.shape(leaf)) for part, leaf in zip(numbers, leaves, strict=True)]
    return jax.tree.unflatten(tree, filled)


def _is_measured(leaf: Any) -> bool:
    return isinstance(leaf, Receptance)
