"""Whether the steps of a wear march are fine enough: for its bumps, for what contacts feed, and to be stable."""

from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from lobex._compiled import compiled
from lobex._shapes import AnyArray
from lobex.contact.laws import ContactLaw
from lobex.marches.arrangement import Arrangement
from lobex.marches.bodies import Structure
from lobex.marches.central_difference import highest_frequency
from lobex.marches.fed_vibrations import check_cells
from lobex.marches.march_lanes import check_steps
from lobex.processes.regenerative import Rub
from lobex.structures.contact_shapes import SHAPES, together
from lobex.structures.modes import Modes, unchecked


def check_resolution(
    arranged: Arrangement, profiles: Float[np.ndarray, "tracks cells"], closing: float, slowest: float
) -> None:
    """Require steps that resolve the bumps and, at the lowest speed and against the stiffest contact that the casing
    leads to, what the contact feeds, and with which central differences are stable.

    Args:
        profiles: of the tracks, m.
        closing: by how much the casing comes closer, m.
        slowest: speed, Hz.
    """
    steps = profiles.shape[1]
    for casing in arranged.casings:
        if casing.surface is None:
            check_cells("steps_per_revolution", steps, casing.nodal_diameters, float(casing.bump_width))
    stiffness = np.array(
        [_steepest(law, profiles[track], closing) for law, track in zip(arranged.laws, arranged.track, strict=True)]
    )
    for blade in range(arranged.blades.blades if arranged.structure is not None else 1):
        modes = _together(arranged, blade, slowest)
        highest = highest_frequency(modes, stiffness)
        needed = int(highest / (2 * slowest)) + 1
        if steps < needed:
            raise ValueError(
                f"steps_per_revolution = {steps} is too few at speed = {slowest:.6g} Hz, where central differences are "
                f"stable from {needed} on (highest frequency {highest / (2 * np.pi):.6g} Hz, in contact)"
            )
        most = float(stiffness.max())
        system = jax.tree.map(lambda leaf: np.asarray(leaf)[None], Rub(modes).system(slowest, most))
        check_steps("steps_per_revolution", system, np.array([most]), np.array([slowest]), steps)
        _check_rate(arranged, modes, slowest, steps)


def _together(arranged: Arrangement, blade: int, speed: float) -> Modes:
    """A blade's modes, the fastest of its kind, and those of the casing, at the contacts of a blade."""
    contacts, blades = arranged.place.shape
    own = _at_contacts(arranged.blades, speed, range(contacts))
    own = replace(own, angular_frequency=_fastest(arranged.blades, own))
    if arranged.structure is None:
        return own
    casing = _at_contacts(arranged.structure, speed, range(blade, contacts * blades, blades))
    return unchecked(
        **dict(
            zip(("angular_frequency", "damping_ratio", *SHAPES), together([(own, 1.0), (casing, -1.0)]), strict=True)
        )
    )


def _at_contacts(structure: Structure, speed: float, directions: range) -> Modes:
    modes = structure.at(speed)
    own = list(directions)
    sides = {name: getattr(modes, name) for name in SHAPES}
    return unchecked(
        angular_frequency=modes.angular_frequency,
        damping_ratio=modes.damping_ratio,
        **{name: None if side is None else np.asarray(side)[:, own] for name, side in sides.items()},
    )


def _fastest(structure: Structure, modes: Modes) -> Float[np.ndarray, " modes"]:
    """The highest frequency of each mode among the blades, of neighbours that move against each other."""
    omega = np.asarray(modes.angular_frequency)
    mistuning = getattr(structure.given, "mistuning", None)
    if mistuning is not None:
        omega = omega * (1 + np.max(np.asarray(mistuning).reshape(structure.blades, -1), axis=0))
    coupling = getattr(structure.given, "coupling", None)
    return omega if coupling is None else np.sqrt(omega**2 + 4 * (2 * np.pi * np.asarray(coupling)) ** 2)


def _check_rate(arranged: Arrangement, modes: Modes, speed: float, steps: int) -> None:
    """Require steps in which what a law adds by its rate does not swing: it is extrapolated from the last two."""
    if not any(getattr(law, "follows_rate", False) for law in arranged.laws):
        return
    laws = arranged.laws
    viscosity = np.array([float(_viscosity(law)) if getattr(law, "follows_rate", False) else 0.0 for law in laws])
    taken = np.max(np.abs(np.linalg.eigvals((np.asarray(modes.shape).T @ np.asarray(modes.loading)) * viscosity)))
    needed = int(taken / speed) + 1
    if steps < needed:
        raise ValueError(
            f"steps_per_revolution = {steps} is too few at speed = {speed:.6g} Hz for a law that follows the rate; "
            f"give {needed} or more"
        )


@compiled
def _viscosity(law: Any) -> Float[AnyArray, ""]:
    return jax.grad(lambda rate: law.force(jnp.ones(()), jnp.zeros(()), rate))(jnp.ones(()))


def _steepest(law: ContactLaw, profile: Float[np.ndarray, " cells"], closing: float) -> float:
    """The stiffest that a contact gets, N/m."""
    deepest = max(float(-profile.min()), float(np.ptp(profile))) + closing
    if deepest <= 0:
        return 0.0
    return float(np.asarray(_slopes(law, np.linspace(0, deepest, 65)[1:])).max())


@compiled
def _slopes(law: ContactLaw, penetration: Float[AnyArray, " depths"]) -> Float[AnyArray, " depths"]:
    rest: tuple[Any, ...] = (jnp.zeros(()),) * (2 if getattr(law, "follows_rate", False) else 1)
    return jax.vmap(jax.grad(lambda h: law.force(h, *rest)))(penetration)
