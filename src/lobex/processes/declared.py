"""A system held against what it declares, once, before anything is computed with it.

By its form while JAX traces it, which costs nothing a second time, and by its numbers at the ends of the speeds and
gains that are asked for.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from lobex import _checks
from lobex._compiled import compiled_quickly
from lobex._float64 import at_once, widened
from lobex._pytree import is_measured
from lobex._shapes import AnyArray
from lobex.processes.process import Process
from lobex.processes.undeclared import JUMP, STRAY, STRAYS, Jump, is_own, jumps_unnamed, strays_of
from lobex.systems.coefficients import Coefficient, Function
from lobex.systems.delays import Delay, WholePeriod, varies
from lobex.systems.system import DelaySystem, Forces
from lobex.systems.terms import Forcing, Term

_PHASES = np.arange(32) / 32
_LAG_PHASES = np.arange(256) / 256
# Weights of speed and gain: in a plane of both, the outermost points along these directions.
_DIRECTIONS = ((1, 1), (1, -1))
_POINTS = 2 * len(_DIRECTIONS)
# Of a delay in periods.
_ROUNDING = 1e-9


class Numbers(NamedTuple):
    """What is looked at of the systems at k points.

    Attributes:
        period: T, s, (k,).
        breaks: phases t/T at which functions jump, (k, b).
        lag: every delay, in periods, at phases, (k, delays, phases).
        declared: whether each is in the range that was said.
        delay_range: the range, in periods, (k, 2).
        force: the largest force per unit of output, now and remembered, at any phase, (k,).
        sizes: the mean size of each coefficient of present and remembered outputs, (k, e, r) and (k, e, m) each.
        finite: whether the structure is, and the forces at every phase, (k, 2).
        steady: whether each delay that is not known to vary does not, and that of the whole period is 1, (k, delays).
        jumps: the largest jump of each function of time that no break names, (k, f) each.
        strays: by how much coefficients of another's class contradict themselves, (k, c, 5).
    """

    period: Float[AnyArray, " *k"]
    breaks: Float[AnyArray, "*k b"]
    lag: Float[AnyArray, "*k delays phases"]
    declared: Bool[AnyArray, "*k delays phases"]
    delay_range: Float[AnyArray, "*k 2"]
    force: Float[AnyArray, " *k"]
    sizes: Forces
    finite: Bool[AnyArray, "*k 2"]
    steady: Bool[AnyArray, "*k delays"]
    jumps: Jump
    strays: Float[AnyArray, "*k c 5"]


def check_system(process: Process, speed: Any, gain: Any = None, *, finite: bool = True) -> None:
    """Require a system that is what it declares; of nothing where JAX traces a part of the call.

    Args:
        process: a process, whose form is checked.
        speed, gain: arrays that broadcast, at whose ends its numbers are; no gain for a verb that asks at none.
        finite: whether one that is nowhere finite is refused: a part of a study counts its points.

    Raises:
        ValueError: for a system that JAX cannot trace, matrices and functions of a wrong shape, a period that is not
            above zero, breaks outside of it, jumps that no break names, coefficients that contradict themselves, and
            delays that are not above zero and in their range, in one line each.
    """
    measured = any(map(is_measured, jax.tree.leaves(process, is_leaf=is_measured)))
    if measured or _checks.is_traced((process, speed, gain)):
        return
    with at_once():
        if gain is None or not np.size(speed) or not np.size(gain):
            _in_one_line(process, partial(jax.eval_shape, _numbers), np.ones(_POINTS), np.ones(_POINTS))
            return
        speeds, gains = _ends(np.asarray(speed, dtype=float), np.asarray(gain, dtype=float))
        found = jax.tree.map(np.asarray, _in_one_line(process, _numbers, speeds, gains))
    if wrong := _wrong(found, finite):
        index, what, right = wrong
        place = f"at speed = {speeds[index]:.6g}, gain = {gains[index]:.6g}"
        raise ValueError(f"process = {type(process).__name__}: {what.format(place)}; {right}")


def largest_force(process: Process, speed: float, gain: float) -> float:
    """Per unit of output, now and remembered, at any phase of a system that was checked."""
    return float(np.asarray(_numbers(process, np.full(_POINTS, speed), np.full(_POINTS, gain)).force)[0])


def mean_sizes(process: Process, speed: float, gain: float) -> Forces:
    """Of each coefficient over the period of a system that was checked, (e, r) and (e, m) each."""
    found = _numbers(process, np.full(_POINTS, speed), np.full(_POINTS, gain)).sizes
    return jax.tree.map(lambda part: np.asarray(part)[0], found)


@compiled_quickly
def _numbers(process: Process, speed: Float[AnyArray, " k"], gain: Float[AnyArray, " k"]) -> Numbers:
    def at(speed: Float[AnyArray, ""], gain: Float[AnyArray, ""]) -> Numbers:
        system = process.system(speed, gain)
        _check_form(type(process).__name__, system)
        functions = [node for node in jax.tree.leaves(system, is_leaf=_is_function) if _is_function(node)]
        delays = [term.delay for term in system.feedback if term.delay is not None] or [WholePeriod()]
        lag = jnp.stack([delay.shares(_LAG_PHASES, system.period) for delay in delays])
        steady = [_steady(*pair) for pair in zip(delays, lag, strict=True)]
        forces = system.at(_PHASES)
        structure = system.blocks, system.inputs, system.outputs, system.recalled
        return Numbers(
            period=jnp.asarray(system.period),
            breaks=jnp.concatenate([jnp.zeros(0), *(jnp.ravel(node.breaks) for node in functions)]),
            lag=lag,
            declared=system.declared(lag),
            delay_range=jnp.array([system.shortest, system.longest]),
            force=jnp.max(sum(jnp.linalg.norm(part, axis=(1, 2)) for part in (forces.present, *forces.delayed))),
            sizes=jax.tree.map(lambda part: jnp.mean(jnp.abs(part), axis=0), forces),
            finite=jnp.stack([_all_finite(structure), _all_finite(forces)]),
            steady=jnp.stack(steady),
            jumps=jax.tree.map(lambda *parts: jnp.stack(parts), Jump(*jnp.zeros(2)), *jumps_unnamed(system)),
            strays=jnp.stack([jnp.zeros(len(STRAYS)), *strays_of(system)]),
        )

    return jax.vmap(at)(speed, gain)


def _steady(delay: Any, lag: Float[Array, " phases"]) -> Bool[Array, ""]:
    """Whether a delay of another's class is as constant, or as long, as that says."""
    if varies(delay) or not is_own(delay):
        return jnp.ones((), dtype=bool)
    said = 1.0 if isinstance(delay, WholePeriod) else lag[0]
    return jnp.all(jnp.abs(lag - said) <= _ROUNDING * jnp.abs(said)) | ~jnp.all(jnp.isfinite(lag))


def _all_finite(parts: Any) -> Bool[Array, ""]:
    return jnp.all(jnp.array([jnp.all(jnp.isfinite(part)) for part in jax.tree.leaves(parts)]))


def _check_form(name: str, system: Any) -> None:
    """Require the shapes that the parts of a system have together, of values that JAX traces."""
    if not isinstance(system, DelaySystem):
        raise ValueError(f"process = {name}: its system is {_checks.brief(system)}; return a DelaySystem")
    for index, term in enumerate(system.terms):
        delay = getattr(term, "delay", None)
        for part, kind, right in (
            (term, Term, "a Present, Delayed, Regenerative, Distributed or Forcing"),
            (getattr(term, "coefficient", term), Term | Coefficient, "a coefficient, such as Constant of a matrix"),
            (delay, Delay | None, "a delay, such as ConstantDelay of seconds"),
        ):
            if not isinstance(part, kind):
                raise ValueError(f"process = {name}: its terms[{index}] has a {type(part).__name__}; give {right}")
    shape = np.shape(system.blocks)
    if len(shape) != 3 or shape[1] != shape[2]:
        raise ValueError(f"process = {name}: its blocks have the shape {shape}; give (n, s, s)")
    n, s = shape[:2]
    e, r, m = (
        np.shape(part)[axis] if np.ndim(part) == 3 else -1
        for part, axis in ((system.inputs, 2), (system.outputs, 1), (system.recalled, 1))
    )
    asked = {
        "inputs": (system.inputs, (n, s, e), "(n, s, e)"),
        "outputs": (system.outputs, (n, r, s), "(n, r, s)"),
        "remembered": (system.recalled, (n, m, s), "(n, m, s)"),
        "period": (system.period, (), "one number"),
    }
    for index, term in enumerate((*system.feedback, *system.forcing)):
        delay = None if isinstance(term, Forcing) else term.delay
        columns = 1 if isinstance(term, Forcing) else r if delay is None else m
        part = f"terms[{index}]"
        asked[f"{part}.coefficient"] = (term.coefficient.at(_PHASES[:1])[0], (e, columns), f"({e}, {columns})")
        if delay is not None:
            asked[f"{part}.delay"] = (delay.shares(_PHASES[:1], system.period)[0], (), "one number")
    for what, (value, right, words) in asked.items():
        if np.shape(value) != right:
            where = f" where blocks have {shape}" if words.startswith("(n") else ""
            raise ValueError(f"process = {name}: its {what} has the shape {np.shape(value)}{where}; give {words}")
    for what, value in (("blocks", system.blocks), *((what, value) for what, (value, _, _) in asked.items())):
        kind = jnp.result_type(value)
        if np.ndim(value) and not jnp.issubdtype(kind, jnp.floating):
            raise ValueError(f"process = {name}: its {what} is of the type {kind}; give real numbers, such as 1.0")
    bounds = system.shortest, system.longest
    if not system.feedback or not 0 <= bounds[0] <= bounds[1] < np.inf or bounds[1] <= 0:
        raise ValueError(
            f"process = {name}: its system has {len(system.feedback)} terms that answer the motion, and shortest = "
            f"{bounds[0]!r} and longest = {bounds[1]!r} periods; give one at least, and the shortest delay first"
        )


def _in_one_line(
    process: Process, ask: Callable[..., Numbers], speeds: Float[np.ndarray, " k"], gains: Float[np.ndarray, " k"]
) -> Numbers:
    """What is found of a process, or what its code raises while JAX traces it as one line."""
    try:
        return ask(widened(process), speeds, gains)
    except Exception as error:
        lines = str(error).splitlines() or [""]
        if isinstance(error, ValueError) and len(lines) == 1:
            raise
        raise ValueError(
            f"process = {type(process).__name__}: its system cannot be traced by JAX "
            f"({type(error).__name__}: {lines[0]}); write it with jax.numpy, of the shapes of a DelaySystem"
        ) from error


def _wrong(found: Numbers, finite: bool) -> tuple[int, str, str] | None:
    """At which point there is what, with a gap for the point, and what would be right; None where all is right."""
    bad = ~(np.isfinite(found.period) & (found.period > 0))
    if bad.any():
        point = int(np.argmax(bad))
        return point, f"its period is {found.period[point]:.6g} s {{}}", "give a finite one above 0"
    bad = ~((found.breaks >= 0) & (found.breaks <= 1))
    if bad.any():
        point, index = np.argwhere(bad)[0]
        return point, f"one of its breaks is {found.breaks[point, index]:.6g} {{}}", "give phases t/T from 0 to 1"
    # Where some points have numbers, the others fail by themselves.
    for index, what in enumerate(("structure", "force")):
        if finite and not found.finite[:, index].any():
            return 0, f"its {what} has values that are not finite {{}}", "give finite matrices and functions"
    least, most = found.delay_range[0]
    for bad, right in (
        (~(found.lag > 0), "give one above 0"),
        (~found.declared, f"that is not between the shortest, {least:.6g}, and the longest, {most:.6g}, as declared"),
    ):
        if bad.any():
            point, index, phase = np.argwhere(bad)[0]
            lag = f"the delay of delayed[{index}] is {found.lag[point, index, phase]:.6g} periods"
            return point, f"{lag} {{}}, t/T = {_LAG_PHASES[phase]:.6g}", right
    if not found.steady.all():
        point, index = np.argwhere(~found.steady)[0]
        return point, f"the delay of delayed[{index}] is not what its class says {{}}", "give lobex' Varying"
    # One that is constant and says so wrongly may not jump.
    for index, (what, right) in enumerate(STRAYS):
        bad = found.strays[:, :, index] > STRAY
        if bad.any():
            return int(np.argwhere(bad)[0][0]), f"one of its coefficients {what} {{}}", right
    bad = found.jumps.size > JUMP
    if bad.any():
        point, index = np.argwhere(bad)[0]
        size, phase = (float(part[point, index]) for part in (found.jumps.size, found.jumps.phase))
        right = "name it in breaks, or give the period with which all repeats"
        return point, f"what follows the time jumps by {100 * size:.3g} % at t/T = {round(phase, 6) % 1:g} {{}}", right
    return None


def _ends(speed: np.ndarray, gain: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of the points of two arrays that broadcast the outermost, (k,) each."""
    speeds, gains = (part.ravel() for part in np.broadcast_arrays(speed, gain))
    height, width = speeds / np.max(speeds), gains / (np.max(np.abs(gains)) or 1.0)
    sides = [right * height + up * width for right, up in _DIRECTIONS]
    found = [index for side in sides for index in (np.argmin(side), np.argmax(side))]
    return speeds[found], gains[found]


def _is_function(node: Any) -> bool:
    return isinstance(node, Function)
