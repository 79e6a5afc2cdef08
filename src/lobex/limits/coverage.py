"""How well a grid of speeds resolves the lobes of the fastest mode that can chatter."""

import numpy as np

from lobex.processes.process import Process
from lobex.systems.system import DelaySystem

# A lobe is a wave more or less between two passes: with four columns in each, none falls between two.
MOST_WAVES = 0.25
# Frequencies looked at around a mode, up to so many half-widths of its resonance on either side.
_BESIDE, _POINTS = 10.0, 81


def waves_per_cell(process: Process, speeds: np.ndarray, largest_gain: float) -> tuple[float, float, float]:
    """The most that f·τ of the fastest mode changes between two neighbouring speeds, that f in Hz, and where.

    The delay enters through e^{−jωτ} alone, which comes back after one wave: the lobes of a mode of frequency f
    are one wave of f·τ long, so that the change per cell is the part of a lobe that a cell spans.
    """
    system = process.system(speeds[0], largest_gain)
    fastest = _fastest_frequency(system)
    # The delay is proportional to 1/speed.
    change = np.abs(np.diff(speeds[0] / speeds)) * float(np.asarray(system.period))
    worst = int(np.argmax(change))
    return float(fastest * change[worst]), fastest, float(speeds[worst])


def _fastest_frequency(system: DelaySystem) -> float:
    """The natural frequency, Hz, of the fastest mode around which a boundary can lie.

    Where P and Q are constant, jω is a root for some delay only if |(I − G P)⁻¹ G Q| ≥ 1 with G = C (jω − A)⁻¹ E:
    for one regenerative contact that is K ≥ −1/(2 Re G), and grows with the gain. Periodic coefficients couple all
    frequencies, and no mode is ruled out.
    """
    blocks = np.asarray(system.blocks)
    pairs = np.linalg.eigvals(blocks)
    roots = np.take_along_axis(pairs, np.argmax(np.imag(pairs), axis=1)[:, None], axis=1)[:, 0]
    roots = roots[np.imag(roots) > 0]
    if not roots.size:
        return 0.0
    natural = np.abs(roots)
    if not system.constant:
        return float(natural.max()) / (2 * np.pi)
    ratio = np.maximum(-np.real(roots) / natural, 1e-6)
    omega = natural[:, None] * np.maximum(1 + ratio[:, None] * np.linspace(-_BESIDE, _BESIDE, _POINTS), 0.5)
    forces = system.at(np.zeros(1))
    current, delayed = np.asarray(forces.present)[0], np.sum([np.asarray(part)[0] for part in forces.delayed], axis=0)
    inputs, outputs = np.asarray(system.inputs), np.asarray(system.outputs)
    shifted = 1j * omega[:, :, None, None, None] * np.eye(blocks.shape[-1]) - blocks
    response = np.sum(
        outputs @ np.linalg.solve(shifted, np.broadcast_to(inputs + 0j, (*omega.shape, *inputs.shape))), axis=2
    )
    loop = np.linalg.solve(np.eye(len(current)) - response @ current, response @ delayed)
    reached = np.any(np.linalg.norm(loop, 2, axis=(-2, -1)) >= 1, axis=1)
    reached[np.argmin(natural)] = True
    return float(natural[reached].max()) / (2 * np.pi)
