"""What a milling cutter is: its teeth, the angles between them, their helix, and how far each stands out."""

from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Float, Real

from lobex import _checks
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, ArrayLike, Number
from lobex.processes.discs import sliced, stacked
from lobex.processes.serration import Serration, check_serration

TURN = 2 * np.pi
_MOST_TEETH, _MOST_DISCS = 1000, 1000
# Of a turn, what the rounding of angles in degrees leaves.
_ROUNDING = 1e-6
# So much may angles and radii differ that are the same.
_SAME = 1e-12


@pytree(static=("teeth", "alike"))
class Cutter:
    """A milling cutter, angles in radians; ``end_mill``, ``ball`` and others make one of degrees.

    Tooth j + 1 runs ahead of tooth j by ``pitch[j]``, measured at the tip, and tooth 0 ahead of the last one. With a
    helix the tip leads: an edge at the height z above it lags by 2 tan(helix) z/diameter.

    Attributes:
        teeth: their number.
        diameter: m. None where nothing asks for it: a helix and process damping do.
        pitch: the angle from each tooth to the next, rad, (teeth,), all of which make one turn. None where they are
            equal.
        helix: helix angle, rad: one of all teeth, or one of each, (teeth,). None of straight teeth.
        runout: what the radius of each tooth has above the nominal one, m, (teeth,). None where there is none.
        alike: how often the teeth repeat in a turn, found from the numbers; leave it out.
        corner_radius: of the corner between the face and the edge above it, m; None for a sharp one.
        lead: κ, from the plane of the face to the edge above the corner, rad; None for π/2, a cylinder.
        discs: thickness, m, lead angle and lag, rad, and radius, m, of straight discs from the tip, (discs, 4): in
            place of helix, corner and lead. None for none.
        offset: how far the axis of the teeth is from that of the spindle, m. None where they are one.
        offset_angle: at which it is, rad, from tooth 0 towards tooth 1; None for 0.
        serration: a wave along the edges of a cylinder, all of one helix angle or straight; None for none.
    """

    teeth: int
    diameter: Number | None = None
    pitch: Real[AnyArray, " teeth"] | None = None
    helix: Number | Real[AnyArray, " teeth"] | None = None
    runout: Real[AnyArray, " teeth"] | None = None
    alike: int = 1
    corner_radius: Number | None = None
    lead: Number | None = None
    offset: Number | None = None
    offset_angle: Number | None = None
    discs: Real[AnyArray, "discs 4"] | None = None
    serration: Serration | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "teeth", _checks.integer("teeth", self.teeth, 1, _MOST_TEETH))
        for name in ("pitch", "helix", "runout", "discs"):
            object.__setattr__(self, name, _checks.as_array(getattr(self, name), name))
        if self.diameter is not None:
            _checks.positive("diameter", self.diameter, "m")
            _checks.scalar("diameter", self.diameter)
        if self.pitch is not None:
            _checks.positive("pitch", self.pitch, "rad")
            self._check_shape("pitch", "rad")
            self._check_turn(self.pitch)
        if self.runout is not None:
            _checks.as_numbers("runout", self.runout, "m")
            self._check_shape("runout", "m")
        if self.helix is not None:
            self._check_helix(self.helix)
        self._check_profile()
        if self.serration is not None:
            check_serration(self.serration, self.teeth, self.diameter)
            self._check_smooth()
        object.__setattr__(self, "alike", self._repeats())

    @classmethod
    def end_mill(
        cls,
        diameter: Number | None = None,
        *,
        teeth: int | None = None,
        pitch_degrees: ArrayLike | None = None,
        helix_degrees: ArrayLike | None = None,
        runout: ArrayLike | None = None,
        offset: Number | None = None,
        offset_degrees: Number | None = None,
        corner_radius: Number | None = None,
        lead_degrees: Number | None = None,
        serration: Serration | None = None,
    ) -> "Cutter":
        """A cylindrical end mill, angles in degrees.

        Args:
            diameter: m.
            teeth: their number, where they are equally spaced. Else
            pitch_degrees: the angle from each tooth to the next, (teeth,): one turn, 360, together.
            helix_degrees: helix angle, one of all teeth or one of each; none, or 0, of straight teeth.
            runout: what the radius of each tooth has above the nominal one, m, (teeth,).
            offset: how far the axis of the teeth is from that of the spindle, m, and
            offset_degrees: at which angle, from tooth 0 towards tooth 1; 0 where it is left out.
            corner_radius: of the corner, m; none of a sharp one. It takes a diameter.
            lead_degrees: from the face to the edge above the corner; 90 of a cylinder.
            serration: a ``Serration`` of the edges; it takes one helix angle or none, and no corner, lead or offset.

        Raises:
            ValueError: unless either teeth or pitch angles are given, for angles that make no turn, helix angles that
                are not from 0 to below 90, lead angles that are not above 0 and up to 90, helix angles and corners
                without a diameter, corners above the radius, and waves of a serration that are not those of the teeth
                or not below the radius.
        """
        if (teeth is None) == (pitch_degrees is None):
            raise ValueError(
                f"teeth = {teeth}, pitch_degrees = {_checks.brief(pitch_degrees)}: give the number of equally spaced "
                "teeth, or the pitch angles in degrees"
            )
        count: Any = teeth
        pitch = _checks.as_array(pitch_degrees, "pitch_degrees")
        helix = _checks.as_array(helix_degrees, "helix_degrees")
        if pitch is not None:
            _checks.positive("pitch_degrees", pitch, "degrees")
            if np.ndim(pitch) != 1 or np.size(pitch) == 0:
                raise ValueError(f"pitch_degrees has shape {np.shape(pitch)}; give one angle a tooth")
            turn = _checks.as_numbers("pitch_degrees", pitch)
            if turn is not None and abs(turn.sum() - 360) > 360 * _ROUNDING:
                raise ValueError(f"pitch_degrees sum to {turn.sum():.6g}; give angles that make one turn, 360 degrees")
            count, pitch = np.shape(pitch)[0], pitch * (np.pi / 180)
        if helix is not None:
            if np.size(helix) == 0:
                raise ValueError("helix_degrees = [] has no angle; give one of all teeth, or one a tooth")
            angles = _checks.as_numbers("helix_degrees", helix, "degrees")
            if angles is not None and not np.all((angles >= 0) & (angles < 90)):
                raise ValueError(f"helix_degrees = {_checks.brief(helix_degrees)}; give angles from 0 to below 90")
            if angles is not None and np.any(angles) and not np.all(angles):
                raise ValueError(
                    f"helix_degrees = {_checks.brief(helix_degrees)}; give angles above 0 of all teeth, or 0 of all"
                )
            straight = angles is not None and not np.any(angles)
            helix = None if straight else helix * (np.pi / 180)
        lead = None if lead_degrees is None else _lead(lead_degrees)
        if offset_degrees is not None:
            _checks.as_numbers("offset_degrees", offset_degrees, "degrees")
            offset_degrees = offset_degrees * (np.pi / 180)
        stands: Any = _checks.as_array(runout, "runout")
        return cls(
            count,
            diameter,
            pitch,
            helix,
            stands,
            corner_radius=corner_radius,
            lead=lead,
            offset=offset,
            offset_angle=offset_degrees,
            serration=serration,
        )

    @classmethod
    def ball(cls, diameter: Number, **edges: Any) -> "Cutter":
        """A ball end mill: its corner is all of its radius. ``edges`` are those of ``end_mill``, by name."""
        return cls.end_mill(diameter, corner_radius=diameter / 2, **edges)

    @classmethod
    def bull_nose(cls, diameter: Number, corner_radius: Number, **edges: Any) -> "Cutter":
        """An end mill with a corner of a radius, m. ``edges`` are those of ``end_mill``, by name."""
        return cls.end_mill(diameter, corner_radius=corner_radius, **edges)

    @classmethod
    def tapered(cls, diameter: Number, taper_degrees: Number, **edges: Any) -> "Cutter":
        """A cone that widens by an angle to its axis, degrees, above the diameter of its tip, m.

        ``edges`` are those of ``end_mill``, by name; a helix lags by the height as on a cylinder of the diameter. With
        a corner the diameter is that where the corner ends.
        """
        angle = _checks.as_numbers("taper_degrees", taper_degrees, "degrees")
        if angle is not None and not np.all((angle >= 0) & (angle < 90)):
            raise ValueError(f"taper_degrees = {_checks.brief(taper_degrees)}; give an angle from 0 to below 90")
        return cls.end_mill(diameter, lead_degrees=90 - taper_degrees, **edges)

    @classmethod
    def inserts(cls, diameter: Number, lead_degrees: Number, **edges: Any) -> "Cutter":
        """A face mill of straight inserts at a lead angle, degrees. ``edges`` are those of ``end_mill``, by name."""
        return cls.end_mill(diameter, lead_degrees=lead_degrees, **edges)

    @classmethod
    def from_discs(
        cls,
        diameter: Number,
        thickness: ArrayLike,
        *,
        lag_degrees: ArrayLike | None = None,
        lead_degrees: ArrayLike | None = None,
        radius: ArrayLike | None = None,
        **edges: Any,
    ) -> "Cutter":
        """A cutter of any profile, as a stack of straight discs from the tip.

        Its force jumps with every disc, so that it takes many where a factory of the profile takes none, and converges
        to that with the square of their thickness.

        Args:
            diameter: m.
            thickness: of each disc, (discs,), m; the last one is as thick as it takes.
            lag_degrees: by which each lags behind the tip, (discs,); 0 for None.
            lead_degrees: lead angle of each, (discs,); 90 for None.
            radius: of each, (discs,), m; half the diameter for None. Of a radial immersion it says where each disc
                enters and leaves.
            edges: as of ``end_mill``, by name, but helix, corner and lead.
        """
        discs = stacked(thickness, lead_degrees, lag_degrees, radius, diameter)
        cutter = cls.end_mill(diameter, **edges)
        if cutter.helix is not None or cutter.shaped:
            raise ValueError("edges have a helix, a corner or a lead angle beside discs; give those of each disc")
        return replace(cutter, discs=discs)

    def in_discs(self, count: int, depth: Number) -> "Cutter":
        """The same in straight discs, each with the angles of the cut of its own radius.

        Of a wall that a radial immersion leaves standing, the part of a ball or a corner below has another arc in the
        cut than the whole diameter. A dozen discs take seconds a point.

        Args:
            count: of discs, equal parts along the profile: the error goes with their square.
            depth: of all of them, m; above, the last one goes on.

        Raises:
            ValueError: without a diameter, and with a helix angle a tooth.
        """
        count = _checks.integer("count", count, 1, _MOST_DISCS)
        _checks.positive("depth", depth, "m")
        if self.diameter is None or not self.one_helix or self.discs is not None:
            raise ValueError("discs are made of a cutter with a diameter and one helix angle, that has none yet")
        return replace(self, helix=None, corner_radius=None, lead=None, discs=sliced(self, count, depth))

    @property
    def pattern(self) -> Float[Any, " alike"]:
        """The pitch angles until the teeth repeat, rad."""
        return self._until_alike(np.full(self.teeth, TURN / self.teeth) if self.pitch is None else self.pitch)

    @property
    def shares(self) -> Float[Any, " alike"]:
        """The same in periods, which are the angle after which the teeth repeat."""
        return self.pattern * (self.alike / TURN)

    @property
    def steps(self) -> Float[Any, " alike"]:
        """Until the teeth repeat, what the radius of each has above that of the tooth ahead, m."""
        runout = self._until_alike(self.runout)
        return runout - namespace(runout).roll(runout, -1)

    @property
    def twist(self) -> Any:
        """By which edges lag behind their tips, rad/m, as ``helix``."""
        return None if self.helix is None else 2 * namespace(self.helix).tan(self.helix) / self.diameter

    @property
    def shaped(self) -> bool:
        """Whether the edges have another profile than that of a cylinder."""
        return any(part is not None for part in (self.corner_radius, self.lead, self.discs))

    @property
    def serrated(self) -> bool:
        """Whether teeth meet what others than the one ahead have left."""
        return self.serration is not None and self.alike < self.teeth

    @property
    def one_helix(self) -> bool:
        """Whether the edges are straight or have the same helix."""
        return self.helix is None or np.ndim(self.helix) == 0

    def _until_alike(self, numbers: Any) -> Float[Any, " alike"]:
        """The mean of the teeth that are alike, so that derivatives by each come out right."""
        lib = namespace(numbers)
        return lib.mean(lib.reshape(lib.asarray(numbers, dtype=lib.result_type(float)), (self.alike, -1)), axis=0)

    def _repeats(self) -> int:
        """How often the teeth repeat in a turn; once where that is not known. With edges of different helix, too."""
        each: list[Any] = [part for part in (self.pitch, self.runout) if part is not None]
        if not self.one_helix or self.offset is not None or _checks.is_traced((each, self.serration)):
            return 1
        if self.serration is not None:
            each.append(self.serration.of_teeth(self.teeth))
        for count in range(1, self.teeth + 1):
            shifted = all(
                np.allclose(part, np.roll(part, count), rtol=_SAME, atol=_SAME * np.max(np.abs(part))) for part in each
            )
            if self.teeth % count == 0 and shifted:
                return self.teeth // count
        return 1

    def _check_shape(self, name: str, unit: str) -> None:
        shape = np.shape(getattr(self, name))
        if shape != (self.teeth,):
            raise ValueError(f"{name} has shape {shape}; give one number in {unit} a tooth, {(self.teeth,)}")

    def _check_turn(self, pitch: Any) -> None:
        if _checks.is_traced(pitch):
            return
        share = np.asarray(pitch, dtype=float) / TURN
        if abs(share.sum() - 1) > _ROUNDING:
            hint = "; they are in degrees: use Cutter.end_mill" if abs(TURN * share.sum() - 360) < 1e-3 else ""
            raise ValueError(f"pitch sums to {TURN * share.sum():.6g} rad; give angles that make one turn, 2π{hint}")
        object.__setattr__(self, "pitch", TURN * share / share.sum())

    def _check_helix(self, helix: Any) -> None:
        if np.shape(helix) not in ((), (self.teeth,)):
            raise ValueError(f"helix has shape {np.shape(helix)}; give one angle, or one a tooth, {(self.teeth,)}")
        angles = _checks.as_numbers("helix", helix, "rad")
        if angles is not None and not np.all((angles > 0) & (angles < np.pi / 2)):
            raise ValueError(
                f"helix = {_checks.brief(helix)}; give angles in rad above 0 and below π/2, or None for straight teeth"
            )
        if self.diameter is None:
            raise ValueError("diameter = None with a helix; give the diameter of the cutter in m")

    def _check_smooth(self) -> None:
        """Require of serrated edges nothing that they are not taken with."""
        for name, value, hint in (
            ("corner_radius", self.corner_radius, "leave it out"),
            ("lead", self.lead, "leave it out"),
            ("discs", self.discs, "leave them out"),
            ("helix", None if self.one_helix else self.helix, "give one angle of all teeth"),
            ("offset", self.offset, "give a runout of every tooth in its place"),
        ):
            if value is not None:
                raise ValueError(f"{name} = {_checks.brief(value)} with a serration; {hint}")

    def _check_profile(self) -> None:
        for name, unit in (("corner_radius", "m"), ("lead", "rad")):
            if getattr(self, name) is not None:
                _checks.positive(name, getattr(self, name), unit)
                _checks.scalar(name, getattr(self, name))
        for name, unit in (("offset", "m"), ("offset_angle", "rad")):
            if getattr(self, name) is not None:
                _checks.as_numbers(name, getattr(self, name), unit)
                _checks.scalar(name, getattr(self, name))
        if self.offset_angle is not None and self.offset is None:
            raise ValueError("offset = None with an angle of it; give how far the axis of the teeth is off, in m")
        lead = None if self.lead is None else _checks.as_numbers("lead", self.lead)
        if lead is not None and lead > np.pi / 2 * (1 + _SAME):
            raise ValueError(f"lead = {float(lead):.6g} rad; give an angle above 0 and up to π/2, that of a cylinder")
        if self.shaped and not self.one_helix:
            raise ValueError("helix has an angle a tooth; give one helix angle with a corner radius or a lead angle")
        if self.corner_radius is None:
            return
        if self.diameter is None:
            raise ValueError("diameter = None with a corner; give the diameter of the cutter in m")
        if _checks.is_traced((self.corner_radius, self.diameter, self.lead)):
            return
        radius, wide = float(self.corner_radius), float(self.diameter) / 2
        if radius * (1.0 if lead is None else np.sin(lead)) > wide * (1 + _SAME):
            raise ValueError(
                f"corner_radius = {radius:.6g} m is above the radius of the cutter; give at most {wide:.6g} m"
            )


def _lead(lead_degrees: Number) -> Number | None:
    """κ, rad; None of a cylinder."""
    _checks.scalar("lead_degrees", lead_degrees)
    angle = _checks.as_numbers("lead_degrees", lead_degrees, "degrees")
    if angle is not None and not 0 < angle <= 90:
        raise ValueError(f"lead_degrees = {float(angle):.6g}; give an angle above 0 and up to 90, that of a cylinder")
    return None if angle is not None and angle == 90 else lead_degrees * (np.pi / 180)


def as_cutter(cutter: Any) -> Cutter:
    """A cutter; of a number of teeth, that with so many straight teeth at equal angles."""
    if isinstance(cutter, Cutter):
        return cutter
    if not isinstance(cutter, int | float | np.number):
        raise ValueError(f"cutter = {_checks.brief(cutter)} is none; give a lobex.Cutter, or the number of teeth")
    return Cutter(cutter)  # pyright: ignore[reportArgumentType]
