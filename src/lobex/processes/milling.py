"""Milling in one or two directions, (3.24)-(3.29), with any pitch and helix."""

from collections.abc import Iterator
from copy import copy
from dataclasses import replace
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Real

from lobex import _checks
from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.processes.cutter import Cutter, as_cutter
from lobex.processes.cutting_force import CuttingForce, of_force
from lobex.processes.edge_points import MOST_POINTS, doubt_of_points, points_for, radians_along
from lobex.processes.engagement import arc_of, cutting_angles
from lobex.processes.feed import with_feed
from lobex.processes.layout import UNKNOWN, Layout, in_octaves, layout_of, layouts_by_depth, places_of
from lobex.processes.process import check_point
from lobex.processes.process_damping import ProcessDamping, check_damping, with_damping
from lobex.processes.quantity import DEPTH_OF_CUT, SPEED_UNITS, Quantity
from lobex.processes.serrated_cuts import check_serrated, serrated_cuts
from lobex.processes.speed_variation import SpeedVariation, check_variation
from lobex.processes.teeth import in_one_piece
from lobex.processes.teeth_at_work import AtWork, Motion, at_work, working_edges
from lobex.processes.tooth import standing, teeth_of
from lobex.structures.modes import check_modes
from lobex.structures.rotating_modes import AnyModes
from lobex.systems.coefficients import Following
from lobex.systems.system import DelaySystem, modal_system

# How far inside full immersion derivatives by it are taken: a power of 2, so that 1 − a is exact.
_INSIDE = 2.0**-40
# Points along an edge where JAX traces what their number would follow.
_POINTS = 6


@pytree(static=("direction", "layout", "speed_unit", "heights"))
class Milling:
    """Milling: each tooth meets the surface left by the one ahead of it.

    The force on the tool is −Σ ∫ H_j(t, z) [y(t) − y(t − τ_j)] dz over the teeth j and the heights z from the tip, 0,
    to the depth of cut b: −b Σ H_j(t) [y(t) − y(t − τ_j)] of straight teeth. With one direction (feed, x) H is K_s(t)
    of (3.25), with two (x along the feed, y across it) the 2×2 matrix of the same forces (Insperger and Stépán,
    Semi-Discretization for Time-Delay Systems, 2011, ch. 5), with three (z along the axis, away from the tip) that with
    the axial force, ``profiled_teeth``. Angles are those of Appendix A: down-milling cuts from
    acos(2a − 1) to π, up-milling from 0 to acos(1 − 2a), with the radial immersion a. Tooth j is at the angle
    2π · speed · t + θ_j and τ_j is the pitch angle to tooth j + 1, which runs ahead, over that speed (Budak, An
    analytical design method for milling cutters with nonconstant pitch to increase stability, J. Manuf. Sci. Eng. 125,
    2003).

    Serrated teeth meet at every height and angle what one of those 1, 2, … pitches ahead left, or nothing, as
    ``wave_cells`` says, for small motions around the chip of the feed.

    The period is what it takes until the teeth repeat: 1/(teeth · speed) where they are alike, a revolution where none
    is like another.

    Attributes:
        modes: the tool's modes, r = 1, 2 or 3 directions; or a measured ``Receptance`` or ``ReceptanceMatrix``, which
            ``zero_order_limit`` and ``multi_frequency_limit`` take.
        cutter: a ``Cutter``, or the number of its teeth, which are straight and at equal angles then.
        tangential: tangential specific cutting force K_t, N/m².
        normal: normal (radial) specific cutting force K_n, N/m².
        radial_immersion: radial depth of cut over tool diameter, in (0, 1]; None where ``angles`` are given. The angles
            that it makes are those at every height, of a corner too; of discs each has its own.
        direction: "down" or "up".
        layout: what is found from the numbers; leave it out.
        speed_unit: as of ``Rub``.
        feed_per_tooth: f_z, m, the mean of all teeth, each of which takes its share by its pitch angle: the chip is
            f_z sin φ thick without vibration, and that of a runout more. It is the forcing of ``orbit``, and has no
            part in multipliers and limits; no tooth leaves the cut for it. None where no motion is asked for. Serrated
            teeth meet one another by it: of them multipliers and limits ask for it, and there is no motion.
        heights: of teeth with a helix angle each, points along the part of each edge in the cut, by Gauss' rule. None
            for as many as the tolerance of a verb's method asks for, at its speeds and depths, or 6 where JAX traces
            these; of a number a warning tells where it may be too few. ``error`` knows of the nodes in time alone.
        process_damping: a ``ProcessDamping`` of every tooth in the cut, of a cutter with a diameter; what ``orbit``
            tells is then displacements, and beside them velocities over the first angular frequency. None for none.
        speed_variation: a ``SpeedVariation`` of the spindle, whose mean speed is that of the process; the table's feed
            is steady. The period is then what it takes until teeth and speed come back together. None for none.
        axial: axial specific cutting force K_a, N/m²: it acts on a third direction, and where the lead angle is less
            than 90 degrees. None for none.
        edge: forces of the edge, tangential, normal and axial, per width of the chip, N/m, (3,): a forcing of
            ``orbit``, as the feed. None for none.
        angles: entry and exit of the cut, rad, (2,), from 0 to π. None where ``radial_immersion`` says.

    The gain is the axial depth of cut b, m.
    """

    modes: AnyModes
    cutter: Cutter
    tangential: Number
    normal: Number
    radial_immersion: Number | None
    direction: str = "down"
    layout: Layout = UNKNOWN
    speed_unit: str = "rpm"
    feed_per_tooth: Number | None = None
    heights: int | None = None
    process_damping: ProcessDamping | None = None
    speed_variation: SpeedVariation | None = None
    axial: Number | None = None
    edge: Real[AnyArray, "3"] | None = None
    angles: Real[AnyArray, "2"] | None = None

    gain: ClassVar[Quantity] = DEPTH_OF_CUT

    def __init__(
        self,
        modes: Any,
        cutter: Cutter | int | None = None,
        tangential: Any = None,
        normal: Any = None,
        radial_immersion: Any = None,
        direction: str = "down",
        layout: Layout = UNKNOWN,
        speed_unit: str = "rpm",
        feed_per_tooth: Number | None = None,
        heights: int | None = None,
        process_damping: ProcessDamping | None = None,
        speed_variation: SpeedVariation | None = None,
        axial: Number | None = None,
        edge: Any = None,
        angles: Any = None,
        *,
        teeth: int | None = None,
        force: CuttingForce | None = None,
        angles_degrees: Any = None,
    ) -> None:
        """As the attributes say.

        Args:
            teeth: number of straight teeth at equal angles, in place of a cutter.
            force: a ``CuttingForce`` in place of tangential, normal, axial and edge.
            angles_degrees: entry and exit of the cut, (2,), in place of a radial immersion.
        """
        if (cutter is None) == (teeth is None):
            raise ValueError(f"cutter = {_checks.brief(cutter)}, teeth = {_checks.brief(teeth)}: give one of them")
        if force is not None:
            tangential, normal, axial, edge = of_force(force, tangential, normal, axial, edge)
        if angles_degrees is not None:
            angles = _checks.as_array(angles_degrees, "angles_degrees") * (np.pi / 180)
        edge, angles = _checks.as_array(edge, "edge"), _checks.as_array(angles, "angles")
        given = locals()
        for name in (
            "modes",
            "tangential",
            "normal",
            "radial_immersion",
            "direction",
            "speed_unit",
            "feed_per_tooth",
            "process_damping",
            "speed_variation",
            "axial",
            "edge",
            "angles",
        ):
            object.__setattr__(self, name, given[name])
        if heights is not None:
            heights = _checks.integer("heights", heights, 1, MOST_POINTS)
        object.__setattr__(self, "heights", heights)
        object.__setattr__(self, "cutter", as_cutter(teeth if cutter is None else cutter))
        arc = _check(self)
        # Anew, whatever layout is given: of numbers that are traced, what was known of others says nothing.
        object.__setattr__(self, "layout", layout_of(self, arc))
        if arc is not None:
            object.__setattr__(self, "layout", self.layout._replace(places=places_of(self)))
        if speed_variation is None:
            object.__setattr__(self, "layout", in_octaves(self.layout))

    @property
    def teeth(self) -> int:
        """Their number."""
        return self.cutter.teeth

    @property
    def straight(self) -> bool:
        """Whether its teeth are."""
        return self.cutter.helix is None

    @property
    def tells_of_teeth(self) -> bool:
        """Whether ``at_work`` knows what they do: of a cylinder that turns about its own axis at a steady speed."""
        cutter = self.cutter
        cylinder = not cutter.shaped and cutter.discs is None and cutter.offset is None
        return cylinder and self.speed_variation is None and self.modes.directions < 3

    @property
    def without_motion(self) -> str | None:
        """Why there is no periodic motion of it, in words; None where there is one."""
        if not self.cutter.serrated:
            return None
        return "has serrated teeth, whose forced motion is not known; ask for limits, or leave the serration out"

    @property
    def passes(self) -> int:
        """Tooth passes per revolution."""
        return self.teeth

    def differentiable(self) -> tuple[tuple[float, "Milling"], ...]:
        """Processes, with weights, from which derivatives by angles and the radial immersion a come out right as well.

        Where whole pitches are in the cut, a period in one piece hides the jump that moves with the immersion; the
        two pieces of any other immersion show it. At full immersion the angle goes with √(1 − a), and in one
        direction the force there with the angle, so that the derivative is D + n/√(1 − a) + O(√(1 − a)) just inside
        the range, with n of the discretisation alone: of two places in the ratio 1 : 4 that term drops out. In two
        directions the force does not vanish there, and the derivative is infinite.
        """
        if not _checks.is_traced((self.radial_immersion, self.angles, self.cutter.pitch)):
            return ((1.0, self),)
        form = self._in_pieces()
        if not _checks.is_traced(self.radial_immersion):
            return ((1.0, form),)
        immersion = jnp.asarray(self.radial_immersion, dtype=jnp.result_type(float))
        object.__setattr__(form, "radial_immersion", immersion)
        if self.modes.directions > 1:
            return ((1.0, form),)
        inside = max(_INSIDE, 8 * float(jnp.finfo(immersion.dtype).eps))

        def at(most: float) -> "Milling":
            beyond = jnp.where((immersion > most) & (immersion <= 1), immersion - most, 0.0)
            return replace(form, radial_immersion=immersion - jax.lax.stop_gradient(beyond))

        return (2.0, at(1 - 4 * inside)), (-1.0, at(1 - inside))

    @property
    def points(self) -> int:
        """Along the part of an edge in the cut."""
        return _POINTS if self.heights is None else self.heights

    def fine_enough(self, speed: Any, gain: Any, tolerance: float) -> "Milling":
        """The same with as many ``heights`` as a tolerance asks for, unless they are given."""
        if self.cutter.one_helix or self.heights is not None:
            return self
        made = copy(self)
        object.__setattr__(made, "heights", points_for(self._radians(speed, gain), tolerance))
        return made

    def doubt(self, speed: Any, gain: Any) -> str | None:
        """What points along edges may leave of the force at known speeds, Hz, and depths, m, in words; None for
        little.
        """
        if self.cutter.one_helix or not np.size(speed) or not np.size(gain):
            return None
        return doubt_of_points(self._radians(speed, gain), self.heights)

    def _radians(self, speed: Any, gain: Any) -> float:
        """As ``radians_along``, at the slowest speed and the largest depth."""
        entry, exit_ = self.engagement
        slowest = float(np.min(speed))
        fastest = np.max(np.asarray(self.modes.at(slowest).angular_frequency)) / slowest
        return radians_along(np.asarray(self.cutter.twist), exit_ - entry, np.max(gain), fastest)

    def with_layout(self, layout: Layout) -> "Milling":
        """The same with what else is known before tracing."""
        made = copy(self)
        object.__setattr__(made, "layout", layout)
        return made

    def by_gain(self, gains: Float[np.ndarray, " p"]) -> Iterator[tuple["Milling", Bool[np.ndarray, " p"]]]:
        """Forms in which more is known of where pieces end, each with the depths, m, that it is for."""
        return ((self.with_layout(layout), served) for layout, served in layouts_by_depth(self, gains))

    def _in_pieces(self) -> "Milling":
        """The same with what a period in one piece hides, and with jumps at one place that may part."""
        places, changes = self.layout.places, {}
        if in_one_piece(self.layout.parts):
            changes = {"parts": None, "places": None}
        elif places is not None:
            changes = {"places": places.as_they_move}
        # What is known before tracing stays so.
        return self.with_layout(self.layout._replace(**changes))

    @property
    def engagement(self) -> tuple[Number, Number]:
        """Entry and exit angles of a tooth, rad."""
        if self.angles is not None:
            return self.angles[0], self.angles[1]
        immersion: Any = self.radial_immersion
        return cutting_angles(immersion, self.direction)

    @in_float64
    def system(self, speed: Number, gain: Number) -> DelaySystem:
        """The delay system at one spindle speed (revolutions per second) and one depth of cut (m)."""
        check_point(self, speed, gain)
        check_modes(self.modes, over_speed=True)
        if self.cutter.serrated:
            cuts, teeth = list(serrated_cuts(self, gain)), []
        else:
            teeth = list(teeth_of(self, gain))
            cuts = [term for tooth in teeth for term in (*tooth.cuts(), *tooth.steps())]
            cuts += standing(self, teeth)
        layout, varied = self.layout, self.speed_variation
        known = {"longest": layout.longest, "shortest": layout.shortest, "places": layout.places}
        turns = layout.repeats, layout.cycles
        system = modal_system(self.modes.at(speed), 1 / (self.cutter.alike * speed), tuple(cuts))
        system = replace(system, **known) if varied is None else varied.acting_on(system, *turns, **known)
        if self.feed_per_tooth is not None and not self.cutter.serrated:
            system = with_feed(system, layout.repeats * len(teeth) * self.feed_per_tooth)
        if self.process_damping is None:
            return system
        per_speed = self.process_damping.per_speed(self.cutter.diameter, speed)
        flank = {"tangential": self.process_damping.friction * per_speed, "normal": per_speed, "axial": None}
        rubbing: Any = [Following(replace(tooth.force, **flank)) for tooth in teeth]
        return with_damping(system, rubbing if varied is None else [varied.per_pace(one, *turns) for one in rubbing])

    def removal_rate(self, speed: Any, gain: Any) -> Any:
        """Volume cut per time, m³/s: axial and radial depth of cut times the feed speed, of speeds (revolutions per
        second) and depths (m) that broadcast.

        Raises:
            ValueError: of a process without a feed, or a cutter without a diameter.
        """
        for name, value in (("feed_per_tooth", self.feed_per_tooth), ("diameter", self.cutter.diameter)):
            if value is None:
                raise ValueError(f"{name} = None where a removal rate is asked for; give it in m")
        feed: Any = self.feed_per_tooth
        diameter: Any = self.cutter.diameter
        width = self.radial_immersion
        if width is None:
            entry, exit_ = self.engagement
            lib = namespace(entry, exit_)
            width = (lib.cos(entry) - lib.cos(exit_)) / 2
        return width * diameter * gain * feed * self.teeth * speed

    def at_work(self, speed: Number, gain: Number, phase: Float[AnyArray, " k"], motion: Motion) -> AtWork:
        """What the teeth do at phases t/T, (k,), along a motion of period T, as ``teeth_at_work.Toothed`` asks."""
        friction, radius = 0.0, None if self.cutter.diameter is None else self.cutter.diameter / 2
        if self.process_damping is not None:
            # What acts is the velocity over the first angular frequency.
            per_speed = self.process_damping.per_speed(self.cutter.diameter, speed)
            friction = self.process_damping.friction * per_speed * self.modes.at(speed).angular_frequency[0]
        edge = 0.0 if self.edge is None else self.edge[0]
        return at_work(working_edges(self, gain).in_cut(phase, motion), self.tangential, edge, friction, radius)

    def left_standing(
        self, gain: Number, height: Float[AnyArray, " h"]
    ) -> tuple[Float[Array, "teeth h"], Float[np.ndarray, " r"]]:
        """When the teeth pass the finished wall, and which outputs then leave material, as ``teeth_at_work.Toothed``
        asks: y of down-milling, at the angle π, and −y of up-milling, at the angle 0; nothing is known of y where modes
        have one direction."""
        angle, side = (np.pi, 1.0) if self.direction == "down" else (0.0, -1.0)
        wall = [np.nan] if self.modes.directions == 1 else [0.0, side]
        return working_edges(self, gain).passes(angle, height), np.array(wall)


def _check(process: Milling) -> float | None:
    """Check modes, coefficients, angles, direction and feed of a milling process; return the arc of the cut if known,
    rad.
    """
    _checks.choice("direction", process.direction, ("down", "up"))
    _checks.choice("speed_unit", process.speed_unit, SPEED_UNITS)
    for name in ("tangential", "normal"):
        check = _checks.positive if name == "tangential" else _checks.not_negative
        check(name, getattr(process, name), "N/m²")
        _checks.scalar(name, getattr(process, name))
    if process.axial is not None:
        _checks.as_numbers("axial", process.axial, "N/m²")
        _checks.scalar("axial", process.axial)
    for name, size, unit in (("edge", 3, "N/m"), ("angles", 2, "rad")):
        if getattr(process, name) is not None:
            _checks.as_numbers(name, getattr(process, name), unit)
            if np.shape(getattr(process, name)) != (size,):
                raise ValueError(f"{name} has shape {np.shape(getattr(process, name))}; give {size} numbers in {unit}")
    if process.feed_per_tooth is not None:
        _checks.positive("feed_per_tooth", process.feed_per_tooth, "m")
        _checks.scalar("feed_per_tooth", process.feed_per_tooth)
    check_damping(process.process_damping, process.cutter.diameter, process.modes)
    check_variation(process.speed_variation)
    check_modes(process.modes, measured=True, over_speed=True)
    check_serrated(process)
    if process.modes.directions not in (1, 2, 3):
        raise ValueError(f"modes has {process.modes.directions} contact directions; milling takes 1, 2 or 3")
    return arc_of(process)
