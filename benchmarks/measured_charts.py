"""The charts that are measured: process, speeds, gains, and what rivals are given."""

from typing import Any, ClassVar, NamedTuple

import numpy as np

import lobex
from lobex._pytree import pytree

TOOL = lobex.Modes.single(frequency=146.5, damping_ratio=0.0032, mass=2.573)
MILL = lobex.Milling(TOOL, teeth=1, tangential=5.5e8, normal=2e8, radial_immersion=0.5, direction="down")
CUTTER = lobex.Modes.single(frequency=922.0, damping_ratio=0.011, mass=0.03993)
PLANE = lobex.Milling(
    lobex.Modes.plane(x=CUTTER, y=CUTTER), teeth=2, tangential=6e8, normal=2e8, radial_immersion=0.05, direction="down"
)
ROD = lobex.Rub(lobex.Rod(5).modes(0.03))


@pytree()
class MathieuOverDelta:
    """The delayed Mathieu equation with δ + 2 in the place of the speed: a process is whatever has a ``system``."""

    epsilon: Any = 1.0
    damping: Any = 0.1

    gain: ClassVar[Any] = lobex.DelayedMathieu.gain
    speed_unit: ClassVar[str] = "Hz"

    def system(self, speed: Any, gain: Any) -> Any:
        """The delay system at δ = speed − 2, with T = τ = 2π."""
        one = lobex.DelayedMathieu(delta=speed - 2.0, epsilon=self.epsilon, damping=self.damping)
        return one.system(1 / (2 * np.pi), gain)


class Problem(NamedTuple):
    """A chart.

    Attributes:
        process, speeds, gains: its arguments.
        own: lobex' methods for it, the default one first.
        rival: the coarsest operator that holds the tolerance over the whole grid, for NumPy's eigenvalues.
        reference: the operator that errors are measured against.
    """

    process: Any
    speeds: np.ndarray
    gains: np.ndarray
    own: tuple[Any, ...]
    rival: lobex.Duhamel
    reference: lobex.Chebyshev


PROBLEMS = {
    "Appendix B, rub, 351×401, n = 5": Problem(
        ROD,
        np.linspace(50, 400, 351),
        np.linspace(4.5e4, 4.5e6, 401),
        (lobex.CharacteristicRoots(), lobex.Duhamel()),
        lobex.Duhamel(nodes=46),
        lobex.Chebyshev(100),
    ),
    "§3.4, milling, 301×301": Problem(
        MILL,
        np.linspace(2000, 25000, 301) / 60,
        np.linspace(0, 5e-3, 301),
        (lobex.Duhamel(),),
        lobex.Duhamel(nodes=12),
        lobex.Chebyshev(60),
    ),
    "2-DoF milling, a_D = 0.05, 256×128": Problem(
        PLANE,
        np.linspace(5000, 25000, 256) / 60,
        np.linspace(0, 5e-3, 128),
        (lobex.Duhamel(),),
        lobex.Duhamel(nodes=10),
        lobex.Chebyshev(40),
    ),
    "Mathieu, δ × b, 100×100": Problem(
        MathieuOverDelta(),
        np.linspace(-1, 5, 100) + 2,
        np.linspace(-2, 1.5, 100),
        (lobex.Duhamel(tolerance=1e-10), lobex.Duhamel()),
        lobex.Duhamel(nodes=20),
        lobex.Chebyshev(60),
    ),
}
