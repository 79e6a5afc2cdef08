"""The method ``CharacteristicRoots``: dominant multipliers of constant coefficients without any operator."""

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from lobex import _checks
from lobex._pytree import pytree
from lobex.characteristic.function import Contact, contact
from lobex.characteristic.grid import dominant_roots
from lobex.characteristic.roots import find_poles
from lobex.processes.feedback import ConstantFeedback
from lobex.processes.process import Process, check_process
from lobex.processes.system import DelaySystem

Array = Any


@pytree()
class CharacteristicRoots:
    """The dominant root s of 1 − (P + Q e^{−sτ}) C (sI − A)⁻¹ E = 0, and with it the multiplier μ = e^{sτ}.

    For constant coefficients that are proportional to the gain, with one contact direction: ``Rub``, ``Turning``,
    ``Scalar``. No operator is built and nothing is discretised: Newton's method on the equation itself, so that
    multipliers are good to rounding, times |sτ|. At every speed a line Re s = σ is chosen with a root beyond it at
    every gain; all roots that ever pass it are found by D-subdivision on that line (Neimark, 1949) and are
    followed along the gain. A point is settled where, at the nodes of log K around it, the roots at hand are as many
    as the line has let pass, so that none is missing there and none can enter in between unseen; where Newton's
    method has converged at the point itself; and where no rival came too close to tell apart.

    What is sampled and not proven: that arg L along the line turns by less than π between samples that show less
    than π/2, that two paths do not exchange their roots without either being lost (which would do no harm), and that
    between two nodes a path behind the first three does not overtake what they reach there.
    """

    def over_grid(self, process: Process, speeds: Array, gains: Array) -> tuple[Array, Array, Array]:
        """The dominant multiplier at every point of a grid. Call it in the scope of float64.

        Args:
            process: of constant coefficients, proportional to the gain, and one contact direction.
            speeds: Hz, increasing, shape (n,).
            gains: increasing, of either sign, shape (m,).

        Returns:
            The dominant multiplier with Im μ ≥ 0, the chatter frequency |Im s|/2π in Hz, and whether the point is
            settled, each of shape (n, m). What is not settled is NaN: compute it with an operator.

        Raises:
            ValueError: for a process of another kind.
        """
        speeds, gains = np.asarray(speeds, dtype=float), np.asarray(gains, dtype=float)
        sound, made, blocks, delay = contacts(process, speeds, float(np.max(np.abs(gains))))
        root: Array = np.full((len(delay), len(gains)), np.nan + 0j)
        settled = np.zeros(root.shape, dtype=bool)
        for sign in (1, -1):
            columns = np.nonzero(sign * gains > 0)[0][::sign]
            if len(columns):
                one = Contact(made.numerator, made.denominator, sign * made.current, sign * made.delayed)
                found = dominant_roots(one, find_poles(one, blocks), sign * gains[columns])
                root[:, columns], settled[:, columns] = found
        free = np.nonzero(gains == 0)[0]
        if len(free):
            place = np.linalg.eigvals(blocks).reshape(len(delay), -1) + 0j
            root[:, free] = np.take_along_axis(place, np.argmax(place.real, axis=1)[:, None], axis=1)
            settled[:, free] = True
        root.imag = np.abs(root.imag)
        value: Array = np.exp(root)
        results = value.real + 1j * np.abs(value.imag), root.imag / (2 * np.pi * delay[:, None]), settled
        nothing = np.full((len(speeds), len(gains)), np.nan + 0j), np.full((len(speeds), len(gains)), np.nan)
        everywhere = (*nothing, np.zeros((len(speeds), len(gains)), dtype=bool))
        for target, result in zip(everywhere, results, strict=True):
            target[sound] = result
        return everywhere

    def resolved_radians(self, system: DelaySystem) -> float:
        """Any number: nothing is sampled over the delay."""
        return np.inf


def contacts(
    process: Process, speeds: np.ndarray, largest: float
) -> tuple[np.ndarray, Contact, np.ndarray, np.ndarray]:
    """The contacts of a process at a gain of one, with the speeds as lanes.

    Returns:
        Which speeds are sound, (n,): at the others the model itself fails, and they are left out of the rest. The
        contacts; the matrices τA, (b, n, s, s); and the delays τ, (b,), s.

    Raises:
        ValueError: for periodic coefficients, several contact directions, or coefficients that are not proportional
            to the gain up to ``largest``.
    """
    _check(process)
    whole = jax.tree.map(np.asarray, _contacts(process, speeds, largest))
    sound = np.logical_and.reduce([np.isfinite(a.reshape(len(a), -1)).all(axis=1) for a in jax.tree.leaves(whole)])
    made, blocks, delay, others = jax.tree.map(lambda a: a[sound], whole)
    _check_proportional(process, made, others, largest)
    return sound, jax.tree.map(lambda a: np.ascontiguousarray(np.moveaxis(a, 0, -1)), made), blocks, delay


def suits(process: Process, speed: float) -> bool:
    """Whether the characteristic roots of a process can be followed: see ``CharacteristicRoots``."""
    with jax.enable_x64(True):
        number = jax.ShapeDtypeStruct((), np.float64)
        system = jax.eval_shape(process.system, number, number)
    if not isinstance(system.feedback, ConstantFeedback) or system.output_size != 1:
        return False
    feedbacks: Any = [process.system(speed, gain).feedback for gain in (0.0, 1.0, 2.0)]
    none, one, two = (np.ravel([feedback.current, feedback.delayed]) for feedback in feedbacks)
    return bool(np.all(none == 0) and np.allclose(two, 2 * one, rtol=1e-12, atol=0.0))


@jax.jit
def _contacts(process: Process, speeds: Array, largest: Any) -> tuple[Contact, Array, Array, Array]:
    """The contacts at a gain of one, the matrices τA and the delays τ, each with the speeds first.

    And P and Q at a gain of zero and at the largest, (n, 2, 2).
    """

    def coefficients(speed: Array, gain: Array) -> Array:
        feedback: Any = process.system(speed, gain).feedback
        return jnp.stack([feedback.current[0, 0], feedback.delayed[0, 0]])

    def one(speed: Array) -> tuple[Contact, Array, Array, Array]:
        system = process.system(speed, jnp.ones_like(speed))
        others = jax.vmap(partial(coefficients, speed))(jnp.stack([jnp.zeros_like(largest), largest]))
        return *contact(system), jnp.asarray(system.delay), others

    return jax.vmap(one)(speeds)


def _check(process: Process) -> None:
    check_process(process)
    number = jax.ShapeDtypeStruct((), np.float64)
    system = jax.eval_shape(process.system, number, number)
    if not isinstance(system.feedback, ConstantFeedback):
        raise ValueError(f"{_named(process)} has periodic coefficients; give constant ones, such as lobex.Rub")
    if system.output_size != 1:
        raise ValueError(f"{_named(process)} has {system.output_size} contact directions; give modes with one")


def _check_proportional(process: Process, made: Contact, others: Array, largest: float) -> None:
    unit = np.stack([made.current, made.delayed], axis=-1)
    if np.any(others[:, 0]) or not np.allclose(others[:, 1], largest * unit, rtol=1e-12, atol=0.0):
        raise ValueError(f"{_named(process)} has coefficients that are not proportional to the gain; give an operator")


def _named(process: Process) -> str:
    return f"process = {_checks.brief(process)}"
