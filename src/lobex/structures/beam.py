"""A blade as a twisted, tapered beam of finite elements that turns with its rotor."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from lobex import _checks
from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.structures import span
from lobex.structures.beam_loads import TIP, root_stress
from lobex.structures.beam_loads import root_loads as loads_of_root
from lobex.structures.beam_matrices import ROOT, BeamMatrices, Section, beam_matrices
from lobex.structures.contact_vectors import contact_vectors
from lobex.structures.modes import Modes
from lobex.structures.plausible_blade import warn_of_blade
from lobex.structures.rectangle import torsion_constant
from lobex.structures.rotating_modes import RotatingModes

# Its matrices are dense.
_MOST_ELEMENTS = 100
# Where nothing else is said.
_KEPT = 10
_UNITS = {"length": "m", "young_modulus": "Pa", "density": "kg/m³"}
_SECTION = {"area": "m²", "flap_inertia": "m⁴", "edge_inertia": "m⁴", "torsion_constant": "m⁴"}
_ANGLES = {"stagger": "rad", "twist": "rad"}
_RADIAL = (1.0, 0.0, 0.0)


@pytree(static=("elements",))
class Beam:
    """A blade that stretches, bends in two directions and twists: Euler and Bernoulli's beam, Saint-Venant's torsion.

    It stands radially on a disc that turns. Displacements are those along the span (radial), in the direction in which
    the blade moves (tangential), and along the axis of the rotor (axial), in this order and right-handed.

    What is given along the span is one number, values at equal steps from root to tip with lines between them, or a
    function of the share of the span, an array of numbers from 0 at the root to 1 at the tip. ``Beam.rectangular``
    takes width and thickness in place of areas and moments.

    A steady deformation under rotation, rotary inertia of bending, shear, warping and offsets between the centres of a
    section are left out; that a twisted blade unwinds as it stretches with them.

    Attributes:
        elements: number of equal elements, 1 to 100.
        length: L, m, from the disc to the tip.
        young_modulus: E, Pa.
        density: ρ, kg/m³.
        area: A, along the span, m².
        flap_inertia, edge_inertia: second moments of area of what lies across the chord, ∫η²dA with η the distance from
            it, and of what lies along it, along the span, m⁴: for bending across the chord, and along it.
        torsion_constant: J, along the span, m⁴.
        poisson_ratio: ν, for the shear modulus E/(2(1 + ν)).
        stagger: angle of the chord at the root against the axis of the rotor, towards the motion, rad.
        twist: what is added to it along the span, rad.
        hub_radius: of the disc, where the root is, m.
        root_stiffness: springs at the root, (6,): radial and tangential (N/m), of the rotation in the plane of the
            disc (N m/rad), axial (N/m), of the rotation across the disc and about the span (N m/rad). None if clamped.

    Raises:
        ValueError: for numbers that are not finite, lengths, moduli, densities and sections not above zero, a ratio ν
            outside −1 to 0.5, springs below zero, arrays of another shape, and elements outside 1 to 100.
    """

    elements: int
    length: Number
    young_modulus: Number
    density: Number
    area: Any
    flap_inertia: Any
    edge_inertia: Any
    torsion_constant: Any
    poisson_ratio: Number = 0.3
    stagger: Number = 0.0
    twist: Any = 0.0
    hub_radius: Number = 0.0
    root_stiffness: Float[AnyArray, " 6"] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "elements", _checks.integer("elements", self.elements, 1, _MOST_ELEMENTS))
        for name in (*_SECTION, "twist"):
            object.__setattr__(self, name, span.along(name, getattr(self, name), self.elements))
        for name, unit in (_UNITS | _SECTION).items():
            _checks.positive(name, getattr(self, name), unit)
        for name, unit in _ANGLES.items():
            _checks.as_numbers(name, getattr(self, name), unit)
        _checks.not_negative("hub_radius", self.hub_radius, "m")
        for name in (*_UNITS, "poisson_ratio", "stagger", "hub_radius"):
            _checks.scalar(name, getattr(self, name))
        ratio = _checks.as_numbers("poisson_ratio", self.poisson_ratio)
        if ratio is not None and not -1 < ratio <= 0.5:
            raise ValueError(f"poisson_ratio = {float(ratio):.6g} is no material's; give a number from −1 to 0.5")
        doubtful = ("length", "young_modulus", "density", "hub_radius")
        warn_of_blade(**{name: getattr(self, name) for name in doubtful})
        if self.root_stiffness is None:
            return
        _checks.not_negative("root_stiffness", self.root_stiffness, "N/m and N m/rad")
        springs = _checks.as_array(self.root_stiffness)
        if np.shape(springs) != (len(ROOT),):
            raise ValueError(f"root_stiffness has shape {np.shape(springs)}; give one of each of {', '.join(ROOT)}")
        object.__setattr__(self, "root_stiffness", springs)

    @classmethod
    def rectangular(
        cls,
        *,
        elements: int = 10,
        length: Number,
        width: Any,
        thickness: Any,
        young_modulus: Number,
        density: Number,
        stagger_degrees: Number = 0.0,
        twist_degrees: Any = 0.0,
        **others: Any,
    ) -> "Beam":
        """A beam of rectangular sections, with angles in degrees.

        Args:
            elements, length, young_modulus, density: as of ``Beam``.
            width: along the chord, m, along the span.
            thickness: across it, m, along the span.
            stagger_degrees: of the chord at the root against the axis of the rotor.
            twist_degrees: what is added to it along the span.
            others: ``poisson_ratio``, ``hub_radius`` and ``root_stiffness`` as of ``Beam``.
        """
        elements = _checks.integer("elements", elements, 1, _MOST_ELEMENTS)
        sides = []
        for name, given in (("width", width), ("thickness", thickness)):
            side = span.along(name, given, elements)
            _checks.positive(name, side, "m")
            # Products of what is linear along the span are not.
            sides.append(side if np.ndim(side) == 0 else span.at_points(side, elements))
        b, h = sides
        turning = span.along("twist_degrees", twist_degrees, elements)
        for name, angle in (("stagger_degrees", stagger_degrees), ("twist_degrees", turning)):
            _checks.as_numbers(name, angle, "degrees")
        return cls(
            elements,
            length,
            young_modulus,
            density,
            area=b * h,
            flap_inertia=b * h**3 / 12,
            edge_inertia=h * b**3 / 12,
            torsion_constant=torsion_constant(b, h),
            stagger=stagger_degrees * (np.pi / 180),
            twist=turning * (np.pi / 180),
            **others,
        )

    @in_float64
    def matrices(self) -> BeamMatrices:
        """Mass, stiffness, spin stiffness and gyroscopic matrix, (dof, dof) each, without what is clamped.

        The degrees of freedom are those of nodes from the root, with two of the middle of each element between: a node
        has radial and tangential displacement, the slope of the latter, axial displacement and its slope, and the
        rotation about the span; a middle has radial displacement and rotation.
        """
        return beam_matrices(self._section(), self.length, self.hub_radius, self.root_stiffness)

    def _section(self) -> Section:
        made = {name: span.at_points(getattr(self, name), self.elements) for name in (*_SECTION, "twist")}
        shear = self.young_modulus / (2 * (1 + self.poisson_ratio))
        return Section(
            mass=self.density * made["area"],
            stretching=self.young_modulus * made["area"],
            flap=made["flap_inertia"],
            edge=made["edge_inertia"],
            young_modulus=self.young_modulus,
            density=self.density,
            torsion=shear * made["torsion_constant"],
            area=made["area"],
            angle=self.stagger + made["twist"],
        )

    @in_float64
    def contact(
        self, normal: Any = _RADIAL, sliding: Any = None, friction: Any = 0.0, chord: Any = 0.0
    ) -> tuple[Float[AnyArray, "dof m"], Float[AnyArray, "dof m"] | None]:
        """What contacts at m points of the tip see and, with sliding, load, as combinations of the degrees of freedom.

        Args:
            normal: n, into the casing, (radial, tangential, axial), of any length; or one for each place, (m, 3).
            sliding: t, the direction along the casing in which the tip slides, as many; None without friction.
            friction: coefficient μ of the force −μ K h along ``sliding``, one or (m,).
            chord: places along the chord of the tip from the axis of the beam, m, one or (m,).

        Returns:
            n and n + μ t at the places, (dof, m) each, the latter None without sliding.

        Raises:
            ValueError: as ``Modes.in_contact``.
        """
        seen, loading = contact_vectors(normal, sliding, friction, len(_RADIAL))
        _checks.as_numbers("chord", chord, "m")
        place = _checks.as_array(chord)
        if np.ndim(place) > 1 or np.size(place) == 0:
            raise ValueError(f"chord has shape {np.shape(place)}; give one place along the tip or several, (m,)")
        lib = namespace(self, place, seen, loading)
        angle = self.stagger + span.at_points(self.twist, self.elements)[-1, -1]
        count = max(np.size(place), *(np.shape(part)[0] for part in (seen, loading) if part is not None))
        if any(size not in (1, count) for size in (np.size(place), np.shape(seen)[0])):
            raise ValueError(
                f"chord has {np.size(place)} places, where normal, sliding and friction are of {count} contacts; give "
                "one for all, or one for each"
            )
        place = lib.broadcast_to(lib.asarray(place, dtype=lib.result_type(float)), (count,))
        across, along, none = place * lib.sin(angle), place * lib.cos(angle), lib.zeros(np.shape(place))
        one = none + 1.0
        # What each motion of the tip's node moves the places by: radially, tangentially and axially.
        moved = [
            (one, none, none),
            (none, one, none),
            (-across, none, none),
            (none, none, one),
            (-along, none, none),
            (none, -along, across),
        ]
        by_node = lib.stack([lib.stack(motion) for motion in moved])
        before = lib.zeros((self._dof - span.NODE, np.shape(place)[0]))

        def columns(vectors: Any) -> Float[AnyArray, "dof m"]:
            along = lib.broadcast_to(vectors, (count, len(_RADIAL)))
            return lib.concatenate([before, lib.einsum("idm,md->im", by_node, along)])

        return columns(seen), None if loading is None else columns(loading)

    @in_float64
    def watch(self, *, tip: bool = False, root_loads: bool = False, stress_at: Any = None) -> Float[AnyArray, "dof k"]:
        """What ``modes`` and ``rotating`` take as ``watched``, as combinations of degrees of freedom, in this order.

        Args:
            tip: the radial, tangential and axial displacement of the axis at the tip, m.
            root_loads: what holds the root: radial and tangential force (N), moment in the plane of the disc (N m),
                axial force (N), moment across the disc and torque about the span (N m).
            stress_at: points (along the chord, across it) of the section at the root, m, (2,) or (points, 2), such as
                the corners of a rectangle, in which the stress along the span is seen, Pa.

        Raises:
            ValueError: where nothing is to be watched, and for points of another shape.
        """
        columns = []
        if tip:
            node = np.eye(self._dof)[:, self._dof - span.NODE :]
            columns.append(node[:, list(TIP)])
        if root_loads or stress_at is not None:
            loads = loads_of_root(self._section(), self.length, self.root_stiffness)
            columns += [loads] if root_loads else []
            if stress_at is not None:
                _checks.as_numbers("stress_at", stress_at, "m")
                points = _checks.as_array(stress_at)
                if np.shape(points)[-1:] != (2,) or np.ndim(points) > 2:
                    raise ValueError(f"stress_at has shape {np.shape(points)}; give (2,) or (points, 2)")
                points = namespace(points).atleast_2d(points)
                columns.append(root_stress(self._section(), loads, points[:, 0], points[:, 1]))
        if not columns:
            raise ValueError("watch takes nothing; give tip=True, root_loads=True or stress_at")
        return namespace(self, columns).concatenate(columns, axis=1)

    def modes(
        self, damping_ratio: Any, keep: Sequence[int] | None = None, *, watched: Any = None, **contact: Any
    ) -> Modes:
        """The modes of the blade at rest, seen at its tip: of m places, each in its own track, m contact directions.

        Args:
            damping_ratio: ξ, one number or one per mode kept.
            keep: mode numbers to keep, from 1 in order of frequency; the first ten by default.
            watched: what is seen besides in further directions, from ``watch``, for ``march_wear(…, watched=)``.
            contact: ``normal``, ``sliding``, ``friction`` and ``chord`` of ``Beam.contact``: by default the middle of
                the tip, radially, which sees stretch alone.

        Raises:
            ValueError: for springs that leave the blade free to move, and as ``Beam.contact``.
        """
        mass, stiffness, _, _ = self.matrices()
        seen, force = self._seen(watched, contact)
        return Modes.from_matrices(mass, stiffness, seen, damping_ratio, self._kept(keep), force=force)

    def rotating(
        self,
        damping_ratio: Any,
        keep: Sequence[int] | None = None,
        *,
        basis: int | None = None,
        watched: Any = None,
        **contact: Any,
    ) -> RotatingModes:
        """The modes of the turning blade over its speed: stiffened, softened, and coupled by Coriolis forces.

        Args:
            damping_ratio, keep, watched, contact: as of ``Beam.modes``; modes are numbered by frequency at each speed.
            basis: as of ``RotatingModes.from_matrices``.

        Raises:
            ValueError: as ``Beam.modes``.
        """
        mass, stiffness, spin_stiffness, gyroscopic = self.matrices()
        seen, force = self._seen(watched, contact)
        return RotatingModes.from_matrices(
            mass,
            stiffness,
            seen,
            damping_ratio,
            self._kept(keep),
            spin_stiffness=spin_stiffness,
            gyroscopic=gyroscopic,
            force=force,
            basis=basis,
        )

    def _seen(self, watched: Any, contact: dict[str, Any]) -> tuple[Any, Any]:
        """Of the contact, and of what is watched: that is no force, and loads what it sees."""
        seen, force = self.contact(**contact)
        if watched is None:
            return seen, force
        if np.ndim(watched) != 2 or np.shape(watched)[0] != self._dof:
            raise ValueError(f"watched has shape {np.shape(watched)}; give what watch() makes, ({self._dof}, k)")
        lib = namespace(self, seen, watched)
        columns = [None if side is None else lib.concatenate([side, watched], axis=1) for side in (seen, force)]
        return columns[0], columns[1]

    @property
    def _dof(self) -> int:
        clamped = span.NODE if self.root_stiffness is None else 0
        return (span.NODE + span.MIDDLE) * self.elements + span.NODE - clamped

    def _kept(self, keep: Sequence[int] | None) -> Sequence[int]:
        return range(1, 1 + min(_KEPT, self._dof)) if keep is None else keep
