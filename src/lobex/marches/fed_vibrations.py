"""What the steps of a march must resolve: the waves of every vibration that the contact can feed.

With the receptance G of the structure and a contact force of at most κ per displacement, now and a delay ago together,
no vibration of frequency ω keeps itself alive unless κ |G(jω)| ≥ 1: a root in the right half plane needs a loop gain
of 1 (the small gain theorem). The highest ω at which it is, stiffened by the contact as it may be, is the fastest
that matters; modes above it only ring down, which a march that is exact in free vibration does not get wrong.
"""

import numpy as np

from lobex.systems.system import DelaySystem

STEPS_PER_WAVE = 8
# Points of the search over frequency: between the slowest mode and the highest, and within resonances: none at their
# middle, which is a pole without damping.
_BETWEEN, _WITHIN = 400, 40
# Of the natural frequency, the least half-width of a resonance.
_NARROW = 1e-6


def fastest_fed(system: DelaySystem, stiffness: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """ω of the first mode and of the fastest vibration that the contact can feed, rad/s, (lanes,) each.

    Args:
        system: of all lanes, each leaf with lanes first.
        stiffness: κ, the largest contact force per displacement, now and a delay ago together, (lanes,).
    """
    blocks, inputs, outputs = (np.asarray(a) for a in (system.blocks, system.inputs, system.outputs))
    if all((a == a[:1]).all() for a in (blocks, inputs, outputs)):
        blocks, inputs, outputs = blocks[:1], inputs[:1], outputs[:1]
    roots = np.linalg.eigvals(blocks)
    first = np.min(np.max(np.imag(roots), axis=-1), axis=-1)
    fed = np.zeros(len(stiffness))
    for lane in range(len(blocks)):
        own = slice(None) if len(blocks) == 1 else slice(lane, lane + 1)
        omega, loop = _receptance(roots[lane].ravel(), blocks[lane], inputs[lane], outputs[lane], stiffness[own].max())
        fed[own] = np.max(np.where(stiffness[own, None] * loop >= 1, omega, 0.0), axis=1)
    return np.broadcast_to(first, fed.shape), fed


def check_cells(name: str, cells: int, bumps: int, width: float) -> None:
    """Require as many cells in a casing's bump, of a width in pitches, as steps in a wave."""
    needed = int(np.ceil(STEPS_PER_WAVE * bumps / min(width, 1.0)))
    if cells < needed:
        raise ValueError(
            f"{name} = {cells} is too few for {bumps} nodal diameters; give {needed} or more, {STEPS_PER_WAVE} cells "
            "per bump"
        )


def _receptance(
    roots: np.ndarray, blocks: np.ndarray, inputs: np.ndarray, outputs: np.ndarray, most: float
) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies up to where no stiffness of up to ``most`` feeds a vibration, and |G| there, each (m,)."""

    def size(omega: np.ndarray) -> np.ndarray:
        shifted = 1j * omega[:, None, None, None] * np.eye(blocks.shape[-1]) - blocks
        moved = np.linalg.solve(shifted, np.broadcast_to(inputs + 0j, (len(omega), *inputs.shape)))
        return np.linalg.norm(np.sum(outputs @ moved, axis=1), 2, axis=(1, 2))

    scale = np.abs(roots[np.abs(roots) > 0])
    if not scale.size or most == 0:
        return np.zeros(1), np.zeros(1)
    top = 2 * scale.max()
    # |G| falls at least as 1/ω beyond all modes.
    while most * size(np.array([top]))[0] >= 1:
        top *= 2
    modes = roots[np.imag(roots) > 0]
    width = np.maximum(-np.real(modes), _NARROW * np.abs(modes))
    within = np.imag(modes)[:, None] + width[:, None] * np.linspace(-5, 5, _WITHIN)
    omega = np.r_[np.geomspace(scale.min() / 10, top, _BETWEEN), within[within > 0]]
    return omega, size(omega)
