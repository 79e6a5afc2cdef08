"""The forces of straight teeth as Fourier series over their period, each tooth with its delay."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Complex, Float, Int

from lobex._float64 import in_float64
from lobex._shapes import AnyArray
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

    def coupling(self, order: Int[np.ndarray, " lines"]) -> Complex[np.ndarray, "teeth lines lines r r"]:
        """H_{k−l} of each tooth, of the harmonics k and l in ``order``."""
        apart = order[:, None] - order
        known = self.harmonics[:, np.abs(apart)]
        return np.where((apart < 0)[..., None, None], np.conj(known), known)


def orders_up_to(top: float, passing: float) -> Int[np.ndarray, " lines"]:
    """Harmonics of a vibration, of which ``passing`` couples those up to ``top``, both rad/s: k of ω + kω_T."""
    most = max(int(np.ceil(top / passing)), 1)
    return np.arange(-most, most)


def harmonics_of(process: Milling, most: int) -> ToothHarmonics:
    """Of the teeth of a process, with harmonics up to ``most``."""
    teeth = list(teeth_of(process, 1.0))
    share = np.array([1.0 if tooth.share is None else float(tooth.share) for tooth in teeth])
    return ToothHarmonics(np.stack([_harmonics(tooth, most) for tooth in teeth]), share)


@in_float64
def _harmonics(tooth: Tooth, most: int) -> Complex[np.ndarray, "k r r"]:
    order = np.arange(most + 1)
    total: Any = 0
    for phase, force in in_the_cut(tooth, most):
        wave = np.exp(-2j * np.pi * order[:, None] * np.asarray(phase))
        total = total + np.einsum("kp,pij->kij", wave, np.asarray(force))
    return total


def in_the_cut(tooth: Tooth, most: int) -> Iterator[tuple[Float[AnyArray, " p"], Float[AnyArray, "p r r"]]]:
    """Phases of the period, and the force of a tooth there per depth of cut, N/m², times Gauss' weights.

    One for each piece in which the force is smooth, so many that each sees less than a wave of the harmonic ``most``.
    """
    nodes, weights = np.polynomial.legendre.leggauss(24 + 4 * most)
    for piece in tooth.force.pieces():
        if piece.idle is not True:
            phase = piece.start + piece.length * (nodes + 1) / 2
            force = tooth.force.within(jnp.asarray(piece.start + piece.length / 2), phase)
            yield phase, (weights * piece.length / 2)[:, None, None] * force
