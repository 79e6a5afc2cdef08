"""The forces of straight teeth as Fourier series over their period, each tooth with its delay."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Complex, Float

from lobex._float64 import in_float64
from lobex.processes.milling import Milling
from lobex.processes.tooth import Tooth, teeth_of


class ToothHarmonics(NamedTuple):
    """Of the teeth of a period.

    Attributes:
        harmonics: H_k of each per depth of cut, N/m², k = 0, 1, …, (teeth, k, r, r); H_{−k} is the conjugate.
        share: of each its delay, in periods, (teeth,).
    """

    harmonics: Complex[np.ndarray, "teeth k r r"]
    share: Float[np.ndarray, " teeth"]

    @property
    def alike(self) -> bool:
        """Whether the period is the one delay."""
        return len(self.share) == 1

    @property
    def mean(self) -> Complex[np.ndarray, "r r"]:
        """H₀ of all together."""
        return np.sum(self.harmonics[:, 0], axis=0)


def harmonics_of(process: Milling, most: int) -> ToothHarmonics:
    """Of the teeth of a process, with harmonics up to ``most``."""
    teeth = list(teeth_of(process, 1.0))
    share = np.array([1.0 if tooth.share is None else float(tooth.share) for tooth in teeth])
    return ToothHarmonics(np.stack([_harmonics(tooth, most) for tooth in teeth]), share)


@in_float64
def _harmonics(tooth: Tooth, most: int) -> Complex[np.ndarray, "k r r"]:
    order = np.arange(most + 1)
    total = 0
    for piece in tooth.force.pieces():
        start, length = float(piece.start), float(piece.length)
        # Each node sees less than a wave.
        nodes, weights = np.polynomial.legendre.leggauss(24 + 4 * most)
        phase = start + length * (nodes + 1) / 2
        force = np.asarray(tooth.force.within(np.asarray(start + length / 2), phase))
        wave = np.exp(-2j * np.pi * order[:, None] * phase) * weights * length / 2
        total = total + (0 if piece.idle is True else np.einsum("kp,pij->kij", wave, force))
    return np.asarray(total)
