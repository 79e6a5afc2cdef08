"""The loop that a limit of milling from receptances is of: of its matrix −1/b is an eigenvalue, b being the depth.

Of the harmonics k and l of a vibration at ω + kω_T its blocks are Σᵢ Hᵢ_{k−l} (1 − e^{−j(ω + lω_T)τᵢ}) G(ω + lω_T), i
being the teeth; of the mean force it is that of one frequency alone.
"""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Complex, Int

from lobex.limits.receptance_matrix import MatrixCurve
from lobex.limits.simple_eigenvalue import SimpleEigenvalue, next_to
from lobex.limits.tooth_harmonics import ToothHarmonics, harmonics_of, orders_up_to
from lobex.results.codes import Kind
from lobex.results.limit import Limit

MEAN, ALL = "ZeroOrder", "MultiFrequency"
_ONE = np.zeros(1, dtype=int)


class Loop(NamedTuple):
    """A loop at one speed.

    Attributes:
        forces: of the teeth.
        order: the harmonics k of the vibration that are kept, (lines,).
        passing: ω_T of the period, rad/s.
        waves: ω of the limit, in ω_T.
        wanted: −1/b.
        against: whether the chatter frequency is that of a harmonic below zero.
    """

    forces: ToothHarmonics
    order: Int[np.ndarray, " lines"]
    passing: float
    waves: float
    wanted: complex
    against: bool

    def matrices(
        self, curve: MatrixCurve
    ) -> tuple[Complex[np.ndarray, "n n"], Complex[np.ndarray, "n n"], Complex[np.ndarray, "n n"]]:
        """Its matrix with a receptance, and the first and second derivative of that by ω, at the limit."""
        lines = (self.waves + self.order) * self.passing
        delay = 2j * np.pi * self.forces.share / self.passing
        before = np.exp(-delay * lines[:, None])
        met = (1 - before)[..., None, None], (delay * before)[..., None, None], (-(delay**2) * before)[..., None, None]
        response, slope, bend = (part[:, None] for part in curve.with_slopes(lines))
        cut = (
            met[0] * response,
            met[1] * response + met[0] * slope,
            met[2] * response + 2 * met[1] * slope + met[0] * bend,
        )
        coupling, size = self.forces.coupling(self.order), len(lines) * curve.directions
        first, second, third = (
            np.einsum("tklij,ltjm->kilm", coupling, part, optimize=True).reshape(size, size) for part in cut
        )
        return first, second, third

    def eigenvalue(self, matrix: Complex[np.ndarray, "n n"]) -> SimpleEigenvalue:
        """That of the limit."""
        return next_to(self.wanted, matrix)


def loops_of(limit: Limit, process: Any) -> list[Loop | None]:
    """Of a limit that was found by ``zero_order_limit`` or ``multi_frequency_limit``; None at speeds without one."""
    passing = 2 * np.pi * np.asarray(limit.speed, float) * process.cutter.alike
    mean, top = limit.method["type"] == MEAN, 2 * np.pi * limit.method.get("reach", 0.0)
    forces = harmonics_of(process, 0 if mean else len(orders_up_to(top, float(passing.min()))))
    found: list[Loop | None] = []
    for one, gain, frequency, kind in zip(passing, limit.gain, limit.chatter_frequency, limit.kind_code, strict=True):
        if not np.isfinite(gain):
            found.append(None)
            continue
        waves = float(2 * np.pi * frequency / one)
        if mean:
            found.append(Loop(forces, _ONE, float(one), waves, -1 / gain, False))
            continue
        # The matrix of ω is that of ω + ω_T, and with its conjugate that of −ω.
        part = waves % 1.0
        against = part > 0.5
        held = {Kind.FLIP: 0.5, Kind.FOLD: 0.0}
        part = held.get(Kind(int(kind)), 1 - part if against else part)
        order = orders_up_to(top, float(one))
        order = order[np.abs(part + order) * one <= top]
        found.append(Loop(forces, order, float(one), part, -1 / gain, bool(against)))
    return found
