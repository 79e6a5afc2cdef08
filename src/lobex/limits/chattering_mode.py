"""Which mode chatters at a limit, and with how many waves around the disc."""

from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Float, Int

from lobex import _checks
from lobex._float64 import in_float64
from lobex.limits.closed_form import Contacts, Regeneration, closed_forms
from lobex.limits.receptance import receptance
from lobex.limits.sections import Sections
from lobex.limits.track_product import Uncoupled
from lobex.limits.tracks_form import Families
from lobex.limits.whole_stage import WholeStage
from lobex.processes.at_speeds import at_speed, has_followers
from lobex.processes.declared import mean_sizes
from lobex.processes.process import Process
from lobex.structures.blading import Blading
from lobex.systems.system import DelaySystem, Forces


class Labels(NamedTuple):
    """Of limits (n,).

    Attributes:
        mode: the number of the mode, from 1; 0 where it is not told.
        nodal_diameter: the number of waves of blades around the disc; −1 where there are none.
    """

    mode: Int[np.ndarray, " n"]
    nodal_diameter: Int[np.ndarray, " n"]


def no_labels(count: int) -> Labels:
    """Of limits of which neither is told."""
    return Labels(np.zeros(count, dtype=np.int64), np.full(count, -1))


def labels_of(found: Any, gain: Any, omega: Any) -> Labels:
    """Of limits of a structure in closed form: the mode that takes the largest part in the response G(jω) there, of
    blades that differ in that of the one that moves most.

    Args:
        found: what ``closed_form`` says; or of a structure that follows the speed, fields with a leading axis of them.
        gain, omega: of the limits, (n,), N/m and rad/s, with NaN where there is none.
    """
    none = no_labels(np.size(gain))
    known = isinstance(found, Regeneration | Contacts | Uncoupled | WholeStage)
    if _checks.is_traced((found, gain, omega)) or not known:
        return none
    if not isinstance(found.receptance, Sections):
        return none
    gain, omega = np.asarray(gain, dtype=float), np.asarray(omega, dtype=float)
    there = np.isfinite(gain) & np.isfinite(omega)
    at = np.where(there, omega, 1.0)
    sections = found.receptance
    if isinstance(found, Uncoupled):
        sections = _of_blades(sections, _loudest(found, np.where(there, gain, 1.0), at))
    most = np.argmax(_parts(sections, at), axis=1)
    number = found.mode[most] if isinstance(found, WholeStage) else 1 + most
    return none._replace(mode=np.where(there, number, 0))


@in_float64
def labels_of_process(process: Process, speed: Float[np.ndarray, " n"], gain: Any, frequency: Any) -> Labels:
    """Of limits found otherwise, at frequencies in Hz: by the closed form where there is one, by the blocks of the
    structure else.
    """
    omega = 2 * np.pi * np.asarray(frequency, dtype=float)
    forms = closed_forms([at_speed(process, one) for one in speed] if has_followers(process) else [process])
    if isinstance(forms, str):
        return _labels_by_blocks(process, speed, gain, omega)
    if len(forms) == 1:
        return _labels_of_form(forms[0], speed, gain, omega)
    if isinstance(forms[0], Regeneration):
        return labels_of(jax.tree.map(lambda *leaves: np.stack(leaves), *forms), gain, omega)
    lanes = ((form, *(part[i : i + 1] for part in (speed, gain, omega))) for i, form in enumerate(forms))
    return jax.tree.map(lambda *parts: np.concatenate(parts), *(_labels_of_form(*lane) for lane in lanes))


def _labels_of_form(found: Any, speed: Float[np.ndarray, " n"], gain: Any, omega: Any) -> Labels:
    """Of limits of one structure in closed form, whichever it is."""
    if not isinstance(found, Families):
        return labels_of(found, gain, omega)
    waves = _waves(found, speed, gain, omega) if found.even else np.full(np.size(speed), -1)
    return labels_of_families(found.receptance, waves, gain, omega)


def labels_of_families(receptance: Sections, waves: Int[np.ndarray, " n"], gain: Any, omega: Any) -> Labels:
    """As ``labels_of``, of equal blades with so many waves around the disc at each limit, (n,), −1 for none."""
    if _checks.is_traced((receptance, gain, omega)):
        return no_labels(np.size(gain))
    known = Regeneration(_of_blades(receptance, np.maximum(waves, 0)), 1.0)
    found = labels_of(known, gain, omega)
    return found._replace(nodal_diameter=np.where(found.mode > 0, waves, -1))


def _of_blades(sections: Sections, blade: Int[np.ndarray, " n"]) -> Sections:
    return jax.tree.map(lambda part: np.asarray(part)[blade], sections)


def _parts(sections: Sections, omega: Float[np.ndarray, " n"]) -> Float[np.ndarray, "n modes"]:
    """How large the part of each mode is in G(jω), of one contact or of several together."""
    own, ratio = np.asarray(sections.angular_frequency), np.asarray(sections.damping_ratio)
    weight: Any = np.asarray(sections.weight) + 0j
    rate = 0.0 if sections.rate is None else np.asarray(sections.rate)
    at = omega[:, None]
    denominator = own**2 - at**2 + 2j * ratio * own * at
    if np.ndim(weight) == 3:
        size = np.linalg.norm(weight + 1j * omega[:, None, None, None] * rate, axis=(2, 3))
    else:
        size = np.abs(weight + 1j * at * rate)
    # At the pole of a mode without damping that part is all there is, if the contact sees it.
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(size > 0, size / np.abs(denominator), 0.0)


def _loudest(blades: Uncoupled, gain: Float[np.ndarray, " n"], omega: Float[np.ndarray, " n"]) -> Int[np.ndarray, " n"]:
    """The blade that moves most: yⱼ (1 + K Gⱼ) = K Gⱼ e^{−iωτⱼ} yⱼ₋₁, so that sizes follow from one to the next."""
    count = np.shape(blades.receptance.angular_frequency)[0]
    size = np.ones((len(gain), count))
    for j in range(1, count):
        one = jax.tree.map(lambda part, j=j: np.asarray(part)[j], blades.receptance)
        response = gain * np.asarray(receptance(one, omega))
        size[:, j] = size[:, j - 1] * np.abs(response / (1 + response))
    return np.argmax(size, axis=1)


def _waves(found: Families, speed: Float[np.ndarray, " n"], gain: Any, omega: Any) -> Int[np.ndarray, " n"]:
    """Of each limit the number of waves around the disc whose characteristic equation holds there."""
    turns = omega[:, None] / (2 * np.pi * found.blades * speed[:, None]) + np.asarray(found.turn)
    sources = (jax.tree.map(lambda part, k=k: np.asarray(part)[k], found.receptance) for k in range(found.blades))
    response = np.stack([np.asarray(receptance(one, omega)) for one in sources], axis=1)
    left = np.abs(1 + np.asarray(gain)[:, None] * response * (1 - np.exp(-2j * np.pi * turns)))
    return np.argmin(np.where(np.isfinite(left), left, np.inf), axis=1)


def _labels_by_blocks(process: Process, speed: Float[np.ndarray, " n"], gain: Any, omega: Any) -> Labels:
    """The mode whose block takes the largest part in what the forces do, by the mean size of their coefficients."""
    there = np.flatnonzero(np.isfinite(gain) & np.isfinite(omega))
    labels = no_labels(len(speed))
    structure = getattr(process, "modes", None)
    blades = structure.count if isinstance(structure, Blading) else 0
    if not len(there):
        return labels
    for group in there[:, None] if has_followers(process) else there[None]:
        at = float(speed[group[0]]), float(gain[group[0]])
        system = process.system(*at)
        size = np.shape(system.blocks)[1]
        if size != 2 and not blades:
            return labels
        # A mode of all blades is one block where springs couple them, and one for each blade where not.
        number = np.argmax(_parts_of_blocks(system, mean_sizes(process, *at), omega[group]), axis=1)
        labels.mode[group] = 1 + (number // blades if size == 2 and blades else number)
    return labels


def _parts_of_blocks(
    system: DelaySystem, sizes: Forces, omega: Float[np.ndarray, " n"]
) -> Float[np.ndarray, "n blocks"]:
    """How large the part of each block is in all loops of the system, each coefficient by its mean size."""
    blocks, inputs = np.asarray(system.blocks), np.asarray(system.inputs)
    still = 1j * omega[:, None, None, None] * np.eye(blocks.shape[1]) - blocks
    moved = np.linalg.solve(still, np.broadcast_to(inputs, (len(omega), *inputs.shape)))
    parts = np.zeros((len(omega), len(blocks)))
    for size, seen in ((sizes.present, system.outputs), *((one, system.recalled) for one in sizes.delayed)):
        parts += np.einsum("er,jnre->jn", size, np.abs(np.asarray(seen) @ moved))
    return parts
