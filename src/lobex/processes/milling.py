"""Milling in one or two directions, (3.24)-(3.29), with any pitch and helix."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, ClassVar, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Real

from lobex import _checks
from lobex._float64 import at_once, in_float64
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.processes.cutter import TURN, Cutter, as_cutter
from lobex.processes.cutting_force import CuttingForce, of_force
from lobex.processes.disc_teeth import DiscTeeth
from lobex.processes.edge_points import EdgeDelay, EdgePoint, doubt_of_points, edge_points, radians_along
from lobex.processes.engagement import arc_of, cutting_angles, parts_of
from lobex.processes.feed import with_feed
from lobex.processes.orbiting import OrbitingAxis
from lobex.processes.process import check_point
from lobex.processes.process_damping import ProcessDamping, check_damping, with_damping
from lobex.processes.profiled_teeth import ProfiledTeeth
from lobex.processes.quantity import DEPTH_OF_CUT, SPEED_UNITS, Quantity
from lobex.processes.specific_force import CHIP, EDGE, STEP
from lobex.processes.speed_variation import SpeedVariation, check_variation
from lobex.processes.teeth import WHOLE, HelicalTeeth, Parts, StraightTeeth
from lobex.processes.teeth_at_work import AtWork, Motion, WorkingEdges, at_work
from lobex.structures.modes import Modes, check_modes
from lobex.structures.modes_over_speed import ModesOverSpeed
from lobex.systems.coefficients import Following, Framed
from lobex.systems.delays import Share, WholePeriod
from lobex.systems.mesh import places_by_angle, places_that_matter
from lobex.systems.system import DelaySystem, Places, modal_system
from lobex.systems.terms import Forcing, Regenerative, Term

Edges = StraightTeeth | HelicalTeeth | ProfiledTeeth | DiscTeeth

# How far inside full immersion derivatives by it are taken: a power of 2, so that 1 − a is exact.
_INSIDE = 2.0**-40
_MOST_HEIGHTS = 64


class Layout(NamedTuple):
    """What is known of a period before tracing.

    Attributes:
        parts: of a straight tooth's, in the cut or idle.
        shortest, longest: delay, in periods.
        places: where pieces end, as ``mesh.places_that_matter`` says.
        repeats, cycles: how often the teeth repeat, and in how many variations of the speed, until both come back.
    """

    parts: Parts | None = None
    shortest: float = 0.0
    longest: float = 1.0
    places: Places | None = None
    repeats: int = 1
    cycles: int = 1


_UNKNOWN = Layout()


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

    The period is what it takes until the teeth repeat: 1/(teeth · speed) where they are alike, a revolution where none
    is like another.

    Attributes:
        modes: the tool's modes, r = 1, 2 or 3 directions.
        cutter: a ``Cutter``, or the number of its teeth, which are straight and at equal angles then.
        tangential: tangential specific cutting force K_t, N/m².
        normal: normal (radial) specific cutting force K_n, N/m².
        radial_immersion: radial depth of cut over tool diameter, in (0, 1]; None where ``angles`` are given. The angles
            that it makes are those at every height, of a corner too.
        direction: "down" or "up".
        layout: what is found from the numbers; leave it out.
        speed_unit: as of ``Rub``.
        feed_per_tooth: f_z, m, the mean of all teeth, each of which takes its share by its pitch angle: the chip is
            f_z sin φ thick without vibration, and that of a runout more. It is the forcing of ``orbit``, and has no
            part in multipliers and limits; no tooth leaves the cut for it. None where no motion is asked for.
        heights: of teeth with a helix angle each, points along the part of each edge in the cut, by Gauss' rule; a
            warning tells where they may be too few, since ``error`` knows of the nodes in time alone.
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

    modes: Modes | ModesOverSpeed
    cutter: Cutter
    tangential: Number
    normal: Number
    radial_immersion: Number | None
    direction: str = "down"
    layout: Layout = _UNKNOWN
    speed_unit: str = "rpm"
    feed_per_tooth: Number | None = None
    heights: int = 6
    process_damping: ProcessDamping | None = None
    speed_variation: SpeedVariation | None = None
    axial: Number | None = None
    edge: Real[AnyArray, "3"] | None = None
    angles: Real[AnyArray, "2"] | None = None

    gain: ClassVar[Quantity] = DEPTH_OF_CUT

    def __init__(
        self,
        modes: Modes | ModesOverSpeed,
        cutter: Cutter | int | None = None,
        tangential: Any = None,
        normal: Any = None,
        radial_immersion: Any = None,
        direction: str = "down",
        layout: Layout = _UNKNOWN,
        speed_unit: str = "rpm",
        feed_per_tooth: Number | None = None,
        heights: int = 6,
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
            angles = _checks.as_array(angles_degrees) * (np.pi / 180)
        edge, angles = _checks.as_array(edge), _checks.as_array(angles)
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
        object.__setattr__(self, "heights", _checks.integer("heights", heights, 1, _MOST_HEIGHTS))
        object.__setattr__(self, "cutter", as_cutter(teeth if cutter is None else cutter))
        arc = _check(self)
        object.__setattr__(self, "layout", layout if arc is None else self._layout(arc))

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
    def passes(self) -> int:
        """Tooth passes per revolution."""
        return self.teeth

    def differentiable(self) -> tuple[tuple[float, "Milling"], ...]:
        """Processes, with weights, from which derivatives by the radial immersion a come out right as well.

        Where whole pitches are in the cut, a period in one piece hides the jump that moves with the immersion; the
        two pieces of any other immersion show it. At full immersion the angle goes with √(1 − a), and in one
        direction the force there with the angle, so that the derivative is D + n/√(1 − a) + O(√(1 − a)) just inside
        the range, with n of the discretisation alone: of two places in the ratio 1 : 4 that term drops out. In two
        directions the force does not vanish there, and the derivative is infinite.
        """
        if _checks.is_traced(self.angles):
            return ((1.0, replace(self, layout=self._in_pieces())),)
        if not _checks.is_traced(self.radial_immersion):
            return ((1.0, self),)
        immersion = jnp.asarray(self.radial_immersion, dtype=jnp.result_type(float))
        form = replace(self, radial_immersion=immersion, layout=self._in_pieces())
        if self.modes.directions > 1:
            return ((1.0, form),)
        inside = max(_INSIDE, 8 * float(jnp.finfo(immersion.dtype).eps))

        def at(most: float) -> "Milling":
            beyond = jnp.where((immersion > most) & (immersion <= 1), immersion - most, 0.0)
            return replace(form, radial_immersion=immersion - jax.lax.stop_gradient(beyond))

        return (2.0, at(1 - 4 * inside)), (-1.0, at(1 - inside))

    def doubt(self, speed: Any, gain: Any) -> str | None:
        """What ``heights`` may leave of the force at known speeds, Hz, and depths, m, in words; None for little."""
        if self.cutter.one_helix or not np.size(speed) or not np.size(gain):
            return None
        entry, exit_ = self.engagement
        fastest = np.max(np.asarray(self.modes.angular_frequency)) / np.min(speed)
        radians = radians_along(np.asarray(self.cutter.twist), exit_ - entry, np.max(gain), fastest)
        return doubt_of_points(radians, self.heights, _MOST_HEIGHTS)

    def _in_pieces(self) -> Layout:
        """The layout, without what a period in one piece hides."""
        return self.layout._replace(parts=None, places=None) if self.layout.parts == WHOLE else self.layout

    @property
    def engagement(self) -> tuple[Number, Number]:
        """Entry and exit angles of a tooth, rad."""
        if self.angles is not None:
            return self.angles[0], self.angles[1]
        immersion: Any = self.radial_immersion
        return cutting_angles(immersion, self.direction)

    def _layout(self, arc: float) -> Layout:
        """What is known of a period, at a known arc of the cut."""
        alike, varied = self.cutter.alike, self.speed_variation
        straight = self.cutter.helix is None and self.cutter.discs is None
        layout = Layout(parts_of(arc, alike) if straight else None)
        if varied is not None:
            layout = layout._replace(**dict(zip(("repeats", "cycles"), varied.passes(alike), strict=True)))
        known = not _checks.is_traced(self.cutter.pitch) and self.cutter.one_helix
        bounds = (float(np.min(self._shares())), float(np.max(self._shares()))) if known else (0.0, 1.0)
        if varied is not None:
            bounds = tuple(bound / layout.repeats for bound in varied.delay_range(*bounds))
        layout = layout._replace(shortest=bounds[0], longest=bounds[1])
        steady = varied is None and (not straight or alike == self.teeth)
        if not known or steady or _checks.is_traced((self.tangential, self.normal, self.modes, varied)):
            return layout
        object.__setattr__(self, "layout", layout)
        with at_once():
            system = self.system(_some_speed(self.modes), 1.0)
            # With a helix they move with the depth.
            places = places_that_matter(system) if straight else places_by_angle(system, layout.repeats)
            return layout._replace(places=places)

    def _shares(self) -> Float[Any, " alike"]:
        """Pitch angles of the teeth of a period, in periods."""
        return self.cutter.pattern * (self.cutter.alike / TURN)

    @in_float64
    def system(self, speed: Number, gain: Number) -> DelaySystem:
        """The delay system at one spindle speed (revolutions per second) and one depth of cut (m)."""
        check_point(self, speed, gain)
        teeth = list(self._teeth(gain))
        cuts = [term for tooth in teeth for term in (*tooth.cuts(), *tooth.steps())]
        cuts += self._standing(teeth)
        layout, varied = self.layout, self.speed_variation
        known = {"longest": layout.longest, "shortest": layout.shortest, "places": layout.places}
        turns = layout.repeats, layout.cycles
        system = modal_system(self.modes.at(speed), 1 / (self.cutter.alike * speed), tuple(cuts))
        system = replace(system, **known) if varied is None else varied.acting_on(system, *turns, **known)
        if self.feed_per_tooth is not None:
            system = with_feed(system, layout.repeats * len(teeth) * self.feed_per_tooth)
        if self.process_damping is None:
            return system
        per_speed = self.process_damping.per_speed(self.cutter.diameter, speed)
        flank = {"tangential": self.process_damping.friction * per_speed, "normal": per_speed, "axial": None}
        rubbing: Any = [Following(replace(tooth.force, **flank)) for tooth in teeth]
        return with_damping(system, rubbing if varied is None else [varied.per_pace(one, *turns) for one in rubbing])

    def _standing(self, teeth: list["_Tooth"]) -> list[Forcing]:
        """What pushes whatever the feed: an axis of the teeth that is off, and edges."""
        pushed: list[Any] = []
        if self.cutter.offset is not None:
            angle = 0.0 if self.cutter.offset_angle is None else self.cutter.offset_angle
            share = 1 / self.teeth
            pushed += [
                OrbitingAxis(tooth.force, self.cutter.offset, angle, share if tooth.share is None else tooth.share)
                for tooth in teeth
            ]
        if self.edge is not None:
            names = dict(zip(("tangential", "normal", "axial"), self.edge, strict=True))
            edges = [replace(tooth.force, law=EDGE, **names) for tooth in teeth]
            unit = np.eye(self.modes.directions)
            pushed += [Framed(-unit, one, np.ones((1, 1))) for one in edges]
        return [Forcing(Following(one)) for one in pushed]

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
        return at_work(self._edges(gain).in_cut(phase, motion), self.tangential, edge, friction, radius)

    def left_standing(
        self, gain: Number, height: Float[AnyArray, " h"]
    ) -> tuple[Float[Array, "teeth h"], Float[np.ndarray, " r"]]:
        """When the teeth pass the finished wall, and which outputs then leave material, as ``teeth_at_work.Toothed``
        asks: y of down-milling, at the angle π, and −y of up-milling, at the angle 0; nothing is known of y where modes
        have one direction."""
        angle, side = (np.pi, 1.0) if self.direction == "down" else (0.0, -1.0)
        wall = [np.nan] if self.modes.directions == 1 else [0.0, side]
        return self._edges(gain).passes(angle, height), np.array(wall)

    def _edges(self, depth: Number) -> WorkingEdges:
        """The teeth of a period, as what they cut along a motion is made of."""
        cutter, count = self.cutter, self.teeth // self.cutter.alike
        entry, exit_ = self.engagement
        twist = None if cutter.twist is None else jnp.broadcast_to(cutter.twist, (count,))
        return WorkingEdges(
            depth,
            entry,
            exit_,
            jnp.asarray(self._shares()),
            twist,
            None if cutter.one_helix or twist is None else jnp.roll(twist, -1) - twist,
            0.0 if self.feed_per_tooth is None else count * self.feed_per_tooth,
            jnp.zeros(count) if cutter.runout is None else cutter.steps,
            cutter.alike,
            self.modes.directions,
            self.heights,
        )

    def _teeth(self, depth: Number) -> Iterator["_Tooth"]:
        """The teeth of a period."""
        cutter, layout = self.cutter, self.layout
        entry, exit_ = self.engagement
        if layout.parts == WHOLE and _checks.is_traced(self.radial_immersion):
            entry = _no_derivative(entry, self.radial_immersion)

        def force(before: Number | None, twist: Number | None) -> Edges:
            numbers = depth, self.tangential, self.normal, self.axial, None, entry, exit_, before
            sizes = cutter.alike, self.modes.directions, CHIP
            if cutter.discs is not None:
                return DiscTeeth(*numbers, *sizes, cutter.discs)
            if cutter.shaped:
                lead = np.pi / 2 if cutter.lead is None else cutter.lead
                return ProfiledTeeth(*numbers, *sizes, cutter.corner_radius, lead, twist, layout.parts)
            return (
                StraightTeeth(*numbers, *sizes, layout.parts)
                if twist is None
                else HelicalTeeth(*numbers, *sizes, twist)
            )

        count = self.teeth // cutter.alike
        twist: Any = cutter.twist
        steps = [None] * count if cutter.runout is None else cutter.steps
        if count == 1:
            yield _Tooth(force(None, twist if cutter.one_helix else twist[0]), steps[0])
            return
        shares = self._shares()
        before = namespace(shares).cumsum(shares) - shares
        for number, (share, step) in enumerate(zip(shares, steps, strict=True)):
            if cutter.one_helix:
                yield _Tooth(force(before[number], twist), step, share)
                continue
            edge: Any = force(before[number], twist[number])
            narrowing = twist[(number + 1) % count] - twist[number]
            yield _Tooth(edge, step, share, tuple(edge_points(edge, TURN * share, narrowing, self.heights)))


class _Tooth(NamedTuple):
    """What a tooth of the period does.

    Attributes:
        force: of its edge.
        step: what its radius has above that of the tooth ahead, m; None without runout.
        share: its pitch angle, in periods; None where that is the period.
        points: of an edge along which the delay changes, each with its own.
    """

    force: Edges
    step: Number | None
    share: Number | None = None
    points: tuple[tuple[EdgePoint, EdgeDelay], ...] = ()

    def cuts(self) -> list[Term]:
        """What it meets."""
        if self.points:
            # The points of an edge enter and leave together.
            (first, since), *others = self.points
            rest: list[Term] = [Regenerative(Following(point), delay) for point, delay in others]
            return [Regenerative(first, since), *rest]
        return [Regenerative(self.force, WholePeriod() if self.share is None else Share(self.share))]

    def steps(self) -> list[Term]:
        """What its step gives to cut."""
        return [] if self.step is None else [_step_force(self.force, self.step)]


def _some_speed(modes: Modes | ModesOverSpeed) -> Number:
    """A speed, Hz, at which there are modes."""
    return modes.speed[0] if isinstance(modes, ModesOverSpeed) else 1.0


def _step_force(teeth: Edges, step: Number) -> Forcing:
    """−b Σ (K_t t + K_n n) step, of a chip that is thicker by a step."""
    pushed: Any = Framed(-np.eye(teeth.directions), Following(replace(teeth, law=STEP)), step * np.ones((1, 1)))
    return Forcing(pushed)


@jax.custom_jvp
def _no_derivative(angle: Number, immersion: Number) -> Float[Array, ""]:
    """An angle whose derivative by the immersion is no number, where what follows would make a wrong one of it."""
    return jnp.asarray(angle, dtype=jnp.result_type(float))


@_no_derivative.defjvp
def _(
    primals: tuple[Float[Array, ""], Float[Array, ""]], tangents: tuple[Float[Array, ""], Float[Array, ""]]
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    return _no_derivative(*primals), jnp.nan * tangents[1]


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
    check_modes(process.modes, over_speed=True)
    if process.modes.directions not in (1, 2, 3):
        raise ValueError(f"modes has {process.modes.directions} contact directions; milling takes 1, 2 or 3")
    return arc_of(process)
