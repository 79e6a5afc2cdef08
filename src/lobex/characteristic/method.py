"""The method ``CharacteristicRoots``: dominant multipliers of constant coefficients without any operator."""

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from lobex import _checks
from lobex._pytree import pytree
from lobex.characteristic.function import Contact, contact
from lobex.characteristic.grid import Structure, rightmost_at_points, rightmost_roots
from lobex.characteristic.lanes import few
from lobex.processes.process import Process, check_process
from lobex.systems.form import by_form
from lobex.systems.system import DelaySystem

Array = Any

# Speeds at which the model is asked at the least.
_SPEEDS = 32
_NOT_PROPORTIONAL = "whose coefficients are not proportional to the gain; give an operator"


@pytree()
class CharacteristicRoots:
    """The rightmost root s of 1 − (P + Q e^{−sτ}) C (sI − A)⁻¹ E = 0, and with it the multiplier μ = e^{sτ}.

    For constant coefficients that are proportional to the gain, with one contact direction: ``Rub``, ``Turning``,
    ``Scalar``. No operator is built and nothing is discretised. At every point the roots to the right of a line are
    counted by the argument principle, with the response between delayed and present output as a rational function whose
    bounds decide every part of the line (``line``), and roots are sought until those in hand are as many as were
    counted (``climb``; over large grids for strips of neighbouring gains at once: ``loci``). So no root is missed,
    whatever the number of waves per delay, the damping and the gain. Multipliers are good to rounding, times |sτ|.
    """

    def over_grid(self, process: Process, speeds: Array, gains: Array) -> tuple[Array, Array, Array, Array]:
        """The dominant multiplier at every point of a grid. Call it in the scope of float64.

        Args:
            process: of constant coefficients, proportional to the gain, and one contact direction.
            speeds: Hz, increasing, shape (n,).
            gains: increasing, of either sign, shape (m,).

        Returns:
            The dominant multiplier with Im μ ≥ 0, the chatter frequency |Im s|/2π in Hz, the relative error of |μ| by
            rounding, and whether the count proves the point, each of shape (n, m). Where it does not, all are NaN.

        Raises:
            ValueError: for a process of another kind.
        """
        speeds, gains = np.asarray(speeds, dtype=float), np.asarray(gains, dtype=float)
        sound, structure, contact = contacts(process, speeds, float(np.max(np.abs(gains))))
        root: Array = np.full((len(structure.delay), len(gains)), np.nan + 0j)
        error, proven = np.full(root.shape, np.nan), np.zeros(root.shape, dtype=bool)
        acting, free = np.flatnonzero(gains), np.flatnonzero(gains == 0)
        if len(acting):
            results = rightmost_roots(structure, contact, gains[acting])
            root[:, acting], error[:, acting], proven[:, acting] = results
        if len(free):
            alone, rounding = _without_gain(structure)
            root[:, free], error[:, free], proven[:, free] = alone[:, None], rounding[:, None], True
        everywhere = _everywhere(len(speeds), len(gains))
        for target, result in zip(everywhere, _results(root, error, proven, structure.delay[:, None]), strict=True):
            target[sound] = result
        return everywhere

    def at_points(self, process: Process, speeds: Array, gains: Array) -> tuple[Array, Array, Array, Array]:
        """As ``over_grid`` at the points (speeds[i], gains[i]), each of shape (p,)."""
        unique, row = np.unique(np.asarray(speeds, dtype=float), return_inverse=True)
        gains = np.asarray(gains, dtype=float)
        everywhere = _everywhere(len(gains))
        if not len(gains):
            return everywhere
        sound, structure, contact = contacts(process, unique, float(np.max(np.abs(gains))))
        index = np.flatnonzero(sound[row])
        row, gain = (np.cumsum(sound) - 1)[row[index]], gains[index]
        alone, rounding = _without_gain(structure)
        root, error, proven = alone[row] + 0j, rounding[row], np.ones(len(row), dtype=bool)
        acting = np.flatnonzero(gain)
        if len(acting):
            results = rightmost_at_points(structure, contact, row[acting], gain[acting])
            root[acting], error[acting], proven[acting] = results
        for target, result in zip(everywhere, _results(root, error, proven, structure.delay[row]), strict=True):
            target[index] = result
        return everywhere

    def refuses(self, process: Process, speed: float) -> str | None:
        """Why it does not serve a process, in words, or None where it does."""
        why = _shape_refused(process)
        if why is None:
            none, one, two = (np.ravel(_coefficients(process, speed, gain)) for gain in (0.0, 1.0, 2.0))
            proportional = np.all(none == 0) and np.allclose(two, 2 * one, rtol=1e-12, atol=0.0)
            why = None if proportional else _NOT_PROPORTIONAL
        return why

    def resolved_radians(self, system: DelaySystem) -> float:
        """Any number: nothing is sampled over the delay."""
        return np.inf


def contacts(process: Process, speeds: np.ndarray, largest: float) -> tuple[np.ndarray, Structure, Contact]:
    """The structure of a process, and its contacts at a gain of one with the speeds as lanes.

    Returns:
        Which speeds are sound, (n,): at the others the model itself fails, and they are left out of the rest; the
        structure; and the contacts.

    Raises:
        ValueError: for periodic coefficients, several contact directions, or coefficients that are not proportional
            to the gain up to ``largest``.
    """
    _require(_shape_refused(process), process)
    filled = np.resize(speeds, few(max(len(speeds), _SPEEDS)))
    whole = jax.tree.map(lambda a: np.asarray(a)[: len(speeds)], _contacts(process, filled, largest))
    sound = np.logical_and.reduce([np.isfinite(a.reshape(len(a), -1)).all(axis=1) for a in jax.tree.leaves(whole)])
    structure, made, others = jax.tree.map(lambda a: a[sound], whole)
    _check_proportional(process, made, others, largest)
    return sound, structure, jax.tree.map(lambda a: np.ascontiguousarray(np.moveaxis(a, 0, -1)), made)


def _everywhere(*shape: int) -> tuple[Array, Array, Array, Array]:
    """Multiplier, frequency, error and proof of points of which nothing is known yet."""
    return np.full(shape, np.nan + 0j), np.full(shape, np.nan), np.full(shape, np.nan), np.zeros(shape, dtype=bool)


def _without_gain(structure: Structure) -> tuple[Array, Array]:
    """The rightmost pole at each speed, (n,), and its rounding."""
    place = np.linalg.eigvals(structure.drift) * structure.delay[:, None] + 0j
    foremost = np.argmax(place.real, axis=1)[:, None]
    return np.take_along_axis(place, foremost, axis=1)[:, 0], np.finfo(float).eps * np.max(np.abs(place), axis=1)


def _results(root: Array, error: Array, proven: Array, delay: Array) -> tuple[Array, Array, Array, Array]:
    root = np.where(proven, root.real + 1j * np.abs(root.imag), np.nan)
    value: Array = np.exp(root)
    multiplier = value.real + 1j * np.abs(value.imag)
    return multiplier, root.imag / (2 * np.pi * delay), np.where(proven, error, np.nan), proven


def _coefficients(process: Process, speed: Array, gain: Array) -> tuple[Array, Array]:
    """Constant P and Q, (1, 1, 1) each."""
    present, (delayed,) = process.system(speed, gain).at(np.zeros(1))
    return present, delayed


@jax.jit
def _contacts(process: Process, speeds: Array, largest: Any) -> tuple[Structure, Contact, Array]:
    """The structures and the contacts at a gain of one, and P and Q at a gain of zero and the largest, (n, 2, 2)."""

    def coefficients(speed: Array, gain: Array) -> Array:
        return jnp.stack([part[0, 0, 0] for part in _coefficients(process, speed, gain)])

    def one(speed: Array) -> tuple[Structure, Contact, Array]:
        system = process.system(speed, jnp.ones_like(speed))
        others = jax.vmap(partial(coefficients, speed))(jnp.stack([jnp.zeros_like(largest), largest]))
        made = contact(system)
        structure = Structure(
            drift=system.drift(),
            inputs=system.input_matrix()[:, 0],
            outputs=system.output_matrix()[0],
            present=made.current,
            delayed=made.delayed,
            delay=jnp.asarray(system.period),
        )
        return structure, made, others

    return jax.vmap(one)(speeds)


def _check_proportional(process: Process, made: Contact, others: Array, largest: float) -> None:
    unit = np.stack([made.current, made.delayed], axis=-1)
    if np.any(others[:, 0]) or not np.allclose(others[:, 1], largest * unit, rtol=1e-12, atol=0.0):
        _require(_NOT_PROPORTIONAL, process)


def _shape_refused(process: Process) -> str | None:
    """Why the characteristic equation of a process is none of one contact with constant coefficients, if so."""
    check_process(process)
    with jax.enable_x64(True):
        return _form_refused(process)


@by_form
def _form_refused(made: Any, shapes: tuple[Any, ...], number: Any) -> str | None:
    system = jax.eval_shape(lambda numbers, speed, gain: made(numbers).system(speed, gain), shapes, number, number)
    if not all(term.coefficient.constant for term in system.terms):
        return "which has periodic coefficients; give constant ones, such as those of lobex.Rub"
    if not system.repeats or len(system.delays) != 1 or system.remembered is not None:
        return "which has other delays than its period; give an operator"
    if not system.output_size == system.force_size == 1:
        return f"which has {system.output_size} contact directions; give modes with one"
    return None


def _require(why: str | None, process: Process) -> None:
    if why:
        raise ValueError(f"CharacteristicRoots does not serve process = {_checks.brief(process)}, {why}")
