"""Milling with straight teeth that are not equally spaced: one delay a tooth."""

from typing import Any, ClassVar, NamedTuple

import jax.numpy as jnp
import numpy as np

from lobex import _checks
from lobex._float64 import at_once, in_float64
from lobex._pytree import pytree
from lobex.processes.milling import (
    check_cutting,
    cutting_angles,
    feed_force,
)
from lobex.processes.process import check_point
from lobex.processes.quantity import DEPTH_OF_CUT, Quantity
from lobex.processes.tooth_force import RunoutForce, ToothForce
from lobex.structures.modes import Modes
from lobex.systems.delays import Share
from lobex.systems.mesh import places_that_matter
from lobex.systems.system import DelaySystem, Places, modal_system
from lobex.systems.terms import Forcing, Regenerative, Term

Array = Any

_TURN = 2 * np.pi


class Layout(NamedTuple):
    """Where pieces end, as ``mesh.places_that_matter`` says, and the shortest and longest delay in revolutions."""

    places: Places | None = None
    shortest: float = 0.0
    longest: float = 1.0


@pytree(static=("direction", "speed_unit", "layout"))
class VariablePitch:
    """Milling with straight teeth at any pitch angles; the period is one revolution.

    Tooth j is at the angle 2π t/T + θ_j from the feed-normal axis and meets what tooth j + 1, which runs ahead of it by
    its pitch angle, has left: the force on the tool is −b Σ H_j(t) [y(t) − y(t − τ_j)] with τ_j = pitch_j/Ω (Budak, An
    analytical design method for milling cutters with nonconstant pitch to increase stability, J. Manuf. Sci. Eng. 125,
    2003). H and the angles of the cut are those of ``Milling``.

    Attributes:
        modes: the tool's modes, r = 1 (along the feed) or r = 2 directions.
        pitch: the angle from each tooth to the next, rad, (teeth,); they make one turn together.
        tangential, normal, radial_immersion, direction, speed_unit: as of ``Milling``.
        feed_per_tooth: the mean of all teeth, m, as of ``Milling``: each takes its share by its pitch angle.
        runout: what the radius of each tooth has above the nominal one, m, (teeth,): the chip is thicker by what it has
            above that of the tooth ahead. No tooth leaves the cut for it. None where there is none.
        layout: where pieces end, and the range of the delays, found from the numbers; leave it out.

    The gain is the axial depth of cut b, m.
    """

    modes: Modes
    pitch: Array
    tangential: Array
    normal: Array
    radial_immersion: Array
    direction: str = "down"
    speed_unit: str = "rpm"
    layout: Layout = Layout()
    feed_per_tooth: Array | None = None
    runout: Array | None = None

    gain: ClassVar[Quantity] = DEPTH_OF_CUT

    def __post_init__(self) -> None:
        check_cutting(self)
        _checks.positive("pitch", self.pitch, "rad")
        if np.ndim(self.pitch) != 1:
            raise ValueError(f"pitch has shape {np.shape(self.pitch)}; give one angle a tooth")
        if self.runout is not None:
            _checks.as_numbers("runout", self.runout, "m")
            if np.shape(self.runout) != np.shape(self.pitch):
                raise ValueError(f"runout has shape {np.shape(self.runout)}; give one number a tooth")
        if _checks.is_traced(self.pitch):
            return
        turn = float(np.sum(np.asarray(self.pitch)))
        if abs(turn - _TURN) > 1e-6:
            hint = "; they are in degrees: use numpy.deg2rad" if abs(turn - 360) < 1e-3 else ""
            raise ValueError(f"pitch sums to {turn:.6g} rad; give angles that make one turn, 2π{hint}")
        share = np.asarray(self.pitch, dtype=float) / turn
        object.__setattr__(self, "pitch", _TURN * share)
        object.__setattr__(self, "layout", Layout(shortest=float(share.min()), longest=float(share.max())))
        if not _checks.is_traced((self.radial_immersion, self.tangential, self.normal, self.modes)):
            with at_once():
                places = places_that_matter(self.system(1.0, 1.0))
            object.__setattr__(self, "layout", self.layout._replace(places=places))

    @property
    def passes(self) -> int:
        """Tooth passes per revolution."""
        return np.shape(self.pitch)[0]

    @in_float64
    def system(self, speed: Array, gain: Array) -> DelaySystem:
        """The delay system at one spindle speed (revolutions per second) and one depth of cut (m)."""
        check_point(self, speed, gain)
        entry, exit_ = cutting_angles(self.radial_immersion, self.direction)
        share = jnp.asarray(self.pitch) / _TURN
        before = jnp.cumsum(share) - share
        cuts = [
            Regenerative(
                ToothForce(gain, self.tangential, self.normal, entry, exit_, before[tooth], self.modes.directions),
                Share(share[tooth]),
            )
            for tooth in range(self.passes)
        ]
        teeth: list[Any] = [cut.coefficient for cut in cuts]
        terms: list[Term] = [*cuts]
        if self.feed_per_tooth is not None:
            feeds = self.feed_per_tooth * self.passes * share
            terms += [feed_force(tooth, feeds[number]) for number, tooth in enumerate(teeth)]
        if self.runout is not None:
            steps = jnp.asarray(self.runout) - jnp.roll(jnp.asarray(self.runout), -1)
            terms += [Forcing(RunoutForce(tooth, steps[number])) for number, tooth in enumerate(teeth)]
        return modal_system(self.modes, 1 / speed, tuple(terms), **self.layout._asdict())
