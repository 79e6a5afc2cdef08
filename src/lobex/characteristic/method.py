"""The method ``CharacteristicRoots``: dominant multipliers of constant coefficients without any operator."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Complex, Float, Int

from lobex import _checks
from lobex._batches import in_one_size
from lobex._compiled import compiled_quickly
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex.characteristic.closed_loop import doubt
from lobex.characteristic.function import Contact, by_blocks, by_poles
from lobex.characteristic.grid import Structure, rightmost_at_points, rightmost_roots
from lobex.processes.process import Process, check_process
from lobex.systems.delays import Spread
from lobex.systems.form import by_form
from lobex.systems.one_force import one_force
from lobex.systems.system import DelaySystem
from lobex.systems.traits import followers

# Speeds at which the model is asked together.
_SPEEDS = 64
# Of the largest gain, those at which it is asked how the gain enters.
_SHARES = np.array([0.0, 0.382, 1.0])
_ROUNDING = 1e-12
# Every wave of each is looked at.
_MOST_DELAYS = 8
# The largest blocks whose characteristic polynomials keep their digits.
_SMALL = 2
_OTHERWISE = (
    "whose delayed force is not proportional to the gain, whose present one is not affine, or whose structure or delay "
    "follows it; give an operator"
)


@pytree()
class CharacteristicRoots:
    """The rightmost root s of 1 − (P C + Σ Q e^{−sτ} D) (sI − A)⁻¹ E = 0, and with it the multiplier μ = e^{sT}.

    For constant coefficients with one force and constant delays, which need not be the period: ``Rub``, ``Turning``,
    ``Scalar``, and an equation of one's own in which the force sees any number of outputs, now and up to eight delays
    ago, such as displacement and velocity; forces that act in one direction of the state are one. The delayed forces
    are proportional to the gain; the present one is affine in it, and need not vanish without.

    No operator is built and nothing is discretised. At every point the roots to the right of a line are counted by the
    argument principle, with the response between delayed and present force as a rational function whose bounds decide
    every part of the line (``line``), and roots are sought until those in hand are as many as were counted (``climb``;
    over large grids for strips of neighbouring gains at once: ``loci``). So no root is missed, whatever the number of
    waves per delay, the damping and the gain; with several delays the line is divided along with their waves
    (``several_delays``). Multipliers are good to rounding, times |sT|.
    """

    def over_grid(
        self, process: Process, speeds: Float[Any, " n"], gains: Float[Any, " m"]
    ) -> tuple[Complex[Any, "n m"], Float[Any, "n m"], Float[Any, "n m"], Bool[Any, "n m"]]:
        """The dominant multiplier at every point of a grid. Call it in the scope of float64.

        Args:
            process: of constant coefficients with one force and constant delays.
            speeds: Hz, increasing, shape (n,).
            gains: increasing, of either sign, shape (m,).

        Returns:
            The dominant multiplier with Im μ ≥ 0, the chatter frequency |Im s|/2π in Hz, the relative error of |μ| by
            rounding, and whether the count proves the point, each of shape (n, m). Where it does not, all are NaN.

        Raises:
            ValueError: for a process of another kind.
        """
        speeds, gains = np.asarray(speeds, dtype=float), np.asarray(gains, dtype=float)
        everywhere = _everywhere(len(speeds), len(gains))
        sound, structure, contact = contacts(process, speeds, float(np.max(np.abs(gains))))
        if not np.any(sound):
            return everywhere
        root: Any = np.full((len(structure.delay), len(gains)), np.nan + 0j)
        error, proven = np.full(root.shape, np.nan), np.zeros(root.shape, dtype=bool)
        acting, free = np.flatnonzero(gains), np.flatnonzero(gains == 0)
        if len(acting):
            results = rightmost_roots(structure, contact, gains[acting])
            root[:, acting], error[:, acting], proven[:, acting] = results
        if len(free):
            alone, rounding = _without_gain(structure)
            root[:, free], error[:, free], proven[:, free] = alone[:, None], rounding[:, None], True
        everywhere = _everywhere(len(speeds), len(gains))
        for target, result in zip(
            everywhere, _results(root, error, proven, structure, np.arange(len(structure.delay))[:, None]), strict=True
        ):
            target[sound] = result
        return everywhere

    def at_points(
        self, process: Process, speeds: Float[Any, " p"], gains: Float[Any, " p"]
    ) -> tuple[Complex[Any, " p"], Float[Any, " p"], Float[Any, " p"], Bool[Any, " p"]]:
        """As ``over_grid`` at the points (speeds[i], gains[i]), each of shape (p,)."""
        unique, row = np.unique(np.asarray(speeds, dtype=float), return_inverse=True)
        gains = np.asarray(gains, dtype=float)
        everywhere = _everywhere(len(gains))
        if not len(gains):
            return everywhere
        sound, structure, contact = contacts(process, unique, float(np.max(np.abs(gains))))
        index = np.flatnonzero(sound[row])
        if not len(index):
            return everywhere
        row, gain = (np.cumsum(sound) - 1)[row[index]], gains[index]
        alone, rounding = _without_gain(structure)
        root, error, proven = alone[row] + 0j, rounding[row], np.ones(len(row), dtype=bool)
        acting = np.flatnonzero(gain)
        if len(acting):
            results = rightmost_at_points(structure, contact, row[acting], gain[acting])
            root[acting], error[acting], proven[acting] = results
        for target, result in zip(everywhere, _results(root, error, proven, structure, row), strict=True):
            target[index] = result
        return everywhere

    def refuses(self, process: Process, speed: float) -> str | None:
        """Why it does not serve a process, in words, or None where it does."""
        why = _shape_refused(process)
        if why is None:
            systems = [process.system(speed, 2.0 * share) for share in _SHARES]
            structure, present, delayed = jax.tree.map(lambda *one: np.stack(one), *map(_parts, systems))
            why = _OTHERWISE if _strays(structure, present, delayed, 2.0) else None
            apart = one_force(systems[-1], present[-1] - present[0], delayed[-1]).apart
            why = _several(systems[-1]) if why is None and apart else why
        return why

    def resolved_radians(self, system: DelaySystem) -> float:
        """Any number: nothing is sampled over the delay."""
        return np.inf


def contacts(process: Process, speeds: np.ndarray, largest: float) -> tuple[np.ndarray, Structure, Contact]:
    """The structure of a process, with what forces it without gain, and its contacts at a gain of one with the speeds
    as lanes.

    Returns:
        Which speeds are sound, (n,): at the others the model itself fails, and they are left out of the rest; the
        structure; and the contacts.

    Raises:
        ValueError: for periodic coefficients, several forces, delays that vary, or coefficients that follow the gain in
            another way up to ``largest``.
    """
    _require(_shape_refused(process), process)
    whole = in_one_size(lambda speeds: _contacts(process, speeds, largest or 1.0), (speeds,), _SPEEDS)
    sound = np.logical_and.reduce([np.isfinite(a.reshape(len(a), -1)).all(axis=1) for a in jax.tree.leaves(whole)])
    structure, polynomials, stray, apart, held = jax.tree.map(lambda a: a[sound], whole)
    _require(_OTHERWISE if np.any(stray) else None, process)
    _require(_several(process.system(speeds[0], largest)) if np.any(apart) else None, process)
    if polynomials is None or np.any(held):
        parts = by_poles(structure.alone(), structure.delay, doubt(structure.drift) * structure.delay)
    else:
        numerator, denominator = (np.ascontiguousarray(np.moveaxis(a, 0, -1)) for a in polynomials)
        parts = numerator, denominator, np.concatenate([np.abs(denominator), np.ones_like(denominator[:, :1])], axis=1)
    lag = None if structure.lag is None else structure.lag.T
    return sound, structure, Contact(*parts, structure.present.T, structure.delayed.T, lag)


def _everywhere(
    *shape: int,
) -> tuple[
    Complex[Any, " *shape"],
    Float[Any, " *shape"],
    Float[Any, " *shape"],
    Bool[Any, " *shape"],
]:
    """Multiplier, frequency, error and proof of points of which nothing is known yet."""
    return np.full(shape, np.nan + 0j), np.full(shape, np.nan), np.full(shape, np.nan), np.zeros(shape, dtype=bool)


def _without_gain(structure: Structure) -> tuple[Complex[Any, " n"], Float[Any, " n"]]:
    """The rightmost pole at each speed, (n,), and its rounding."""
    place = np.linalg.eigvals(structure.drift) * structure.delay[:, None] + 0j
    foremost = np.argmax(place.real, axis=1)[:, None]
    return np.take_along_axis(place, foremost, axis=1)[:, 0], np.finfo(float).eps * np.max(np.abs(place), axis=1)


def _results(
    root: Complex[Any, " *points"],
    error: Float[Any, " *points"],
    proven: Bool[Any, " *points"],
    structure: Structure,
    row: Int[Any, "..."],
) -> tuple[
    Complex[Any, " *points"],
    Float[Any, " *points"],
    Float[Any, " *points"],
    Bool[Any, " *points"],
]:
    """Multipliers over the period, frequencies, errors and proofs from roots in sτ, of the speeds of given numbers."""
    root = np.where(proven, root.real + 1j * np.abs(root.imag), np.nan)
    delay, delays = structure.delay[row], (structure.period / structure.delay)[row]
    # Of what grows beyond all numbers within a period.
    with np.errstate(over="ignore", invalid="ignore"):
        value: Any = np.exp(root * delays)
    multiplier = value.real + 1j * np.abs(value.imag)
    return multiplier, root.imag / (2 * np.pi * delay), np.where(proven, error * delays, np.nan), proven


def _parts(
    system: DelaySystem,
) -> tuple[tuple[Any, ...], Float[Any, "e r"], Float[Any, "*k e m"]]:
    """What is to stay as the gain changes; and the forces per unit of each output, now and a delay ago, (e, r)."""
    present, delayed = system.at(np.zeros(1))
    shares = (delay.shares(np.zeros(1), system.period) for delay in system.delays)
    structure = system.blocks, system.inputs, system.outputs, system.recalled, system.period, *shares
    every = [part[0] for part in delayed]
    return structure, present[0], every[0] if len(every) == 1 else namespace(every).stack(every)


@compiled_quickly
def _contacts(
    process: Process, speeds: Float[Any, " n"], largest: Any
) -> tuple[Structure, Any, Bool[Any, " n"], Bool[Any, " n"], Float[Any, "n e r"]]:
    """Structures; H's polynomials of small blocks; whether the gain enters otherwise than told, and forces act in
    several directions; and what forces without gain.
    """

    def one(speed: Float[Any, ""]) -> tuple[Structure, Any, Bool[Any, ""], Bool[Any, ""], Float[Any, "e r"]]:
        system = process.system(speed, largest)
        parts = jax.vmap(lambda share: _parts(process.system(speed, largest * share)))(_SHARES)
        held = parts[1][0]
        present, delayed = ((part[-1] - part[0]) / largest for part in parts[1:])
        force = one_force(system, present, delayed)
        lag, longest, count = None, None, len(system.delays)
        if count > 1:
            lags = jnp.concatenate(system.lags(jnp.zeros(1)))
            longest = jnp.max(lags)
            outputs = jnp.concatenate([force.present[None], force.delayed])
            present, delayed = jnp.eye(1, 1 + count)[0], jnp.concatenate([jnp.zeros(1), jnp.ones(count)])
            lag = jnp.concatenate([jnp.ones(1), lags / longest])
        elif system.force_size == system.output_size == 1 and system.remembered is None:
            outputs, present, delayed = system.output_matrix(), present[0], delayed[0]
        else:
            # What is seen now and a delay ago, as the two outputs of the force.
            outputs = jnp.stack([force.present, force.delayed])
            present, delayed = jnp.array([1.0, 0.0]), jnp.array([0.0, 1.0])
        period = jnp.asarray(system.period)
        delay = (system.lags(jnp.zeros(1))[0][0] if longest is None else longest) * period
        structure = Structure(
            drift=system.drift() + system.input_matrix() @ held @ system.output_matrix(),
            inputs=force.inputs,
            outputs=outputs,
            present=present,
            delayed=delayed,
            delay=delay,
            period=period,
            lag=lag,
        )
        shape = np.shape(system.blocks)[:2]
        inputs, seen = force.inputs.reshape(shape), outputs.reshape(-1, *shape).swapaxes(0, 1)
        polynomials = by_blocks(system.blocks, inputs, seen, delay) if shape[1] <= _SMALL else None
        return structure, polynomials, _strays(*parts, largest), force.apart, held

    return jax.vmap(one)(speeds)


def _strays(
    structure: tuple[Float[Any, "shares ..."], ...],
    present: Float[Any, "shares e r"],
    delayed: Float[Any, "shares *k e m"],
    largest: Any,
) -> np.bool_ | Bool[Any, ""]:
    """Whether the gain enters otherwise than told, of ``_parts`` at its shares."""

    lib = namespace(structure, present, delayed, largest)

    def off(part: Float[Any, "..."], line: Float[Any, "..."]) -> np.bool_ | Bool[Any, ""]:
        return lib.any(lib.abs(part - line) > _ROUNDING * lib.max(lib.abs(part), axis=0))

    def line(part: Float[Any, "shares a b"]) -> Float[Any, "shares a b"]:
        return part[0] + (_SHARES * largest).reshape(-1, *(1,) * (part.ndim - 1)) * ((part[-1] - part[0]) / largest)

    return (
        lib.any(lib.stack([off(part, part[:1]) for part in structure]))
        | off(present, line(present))
        | off(delayed, line(delayed))
        | lib.any(delayed[0] != 0)
    )


def _shape_refused(process: Process) -> str | None:
    """Why the characteristic equation of a process is none of one contact with constant coefficients, if so."""
    check_process(process)
    with jax.enable_x64(True):
        return _form_refused(process)


@by_form
def _form_refused(made: Any, shapes: tuple[Any, ...], number: Any) -> str | None:
    def lags(
        numbers: Any, speed: Float[Any, ""], gain: Float[Any, ""], phase: Float[Any, "1"]
    ) -> tuple[Float[Any, "1"], ...]:
        return made(numbers).system(speed, gain).lags(phase)

    system = jax.eval_shape(lambda numbers, speed, gain: made(numbers).system(speed, gain), shapes, number, number)
    if not all(term.coefficient.constant for term in system.feedback):
        return "which has periodic coefficients; give constant ones, such as those of lobex.Rub"
    if len(system.delays) > 1 and any(isinstance(delay, Spread) for delay in system.delays):
        return "which has a distributed delay; give an operator"
    if not 0 < len(system.delays) <= _MOST_DELAYS:
        return f"which has {len(system.delays)} delays; give an operator"
    if any(followers(jax.make_jaxpr(lags)(shapes, number, number, jax.ShapeDtypeStruct((1,), number.dtype)).jaxpr)):
        return "whose delay varies; give an operator"
    return None


def _several(system: DelaySystem) -> str:
    return f"which has {system.force_size} contact directions; give modes with one"


def _require(why: str | None, process: Process) -> None:
    if why:
        raise ValueError(f"CharacteristicRoots does not serve process = {_checks.brief(process)}, {why}")
