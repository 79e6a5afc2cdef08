"""The modes of a structure, as its contact point sees them."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, overload

import jax
import numpy as np
from jaxtyping import Float, Real

from lobex import _checks
from lobex._pytree import pytree
from lobex._shapes import AnyArray, ArrayLike, ComplexLike, Number
from lobex.structures.complex_modes import of_residues
from lobex.structures.contact_shapes import SHAPES, in_contact, together
from lobex.structures.contact_vectors import contact_vectors
from lobex.structures.eigenproblem import keep_modes
from lobex.structures.matrix_modes import modes_of_matrices
from lobex.structures.modal_table import table_of

if TYPE_CHECKING:
    from lobex.structures.rotating_modes import RotatingModes


@pytree()
class Modes:
    """Vibration modes with modal damping: ü + 2ξω u̇ + ω² u = ψᵀ F, displacement at the contact y = Σ φ u.

    Displacement and force may have directions of their own, such as the surface normal and the direction of the
    cutting force: then ψ is not φ, and the residues φψ may have either sign.

    Of a damping that couples modes, points do not move in phase: a complex mode is u̇ = ωv + χ̂ᵀF/ω,
    v̇ = −ωu − 2ξωv + ψᵀF/ω, y = Σ φu + χv, with shapes in quadrature χ and χ̂ that are zero elsewhere.

    Attributes:
        angular_frequency: angular natural frequencies ω, shape (n,), rad/s.
        damping_ratio: modal damping ratios ξ, shape (n,).
        shape: mass-normalised mode shapes φ at the contact, shape (n, r), 1/√kg; r is the number of
            displacement directions that the contact acts on.
        force_shape: ψ, how a unit contact force loads each mode, shape (n, r), 1/√kg; None where it is ``shape``.
        quadrature: χ, what the contact sees of u̇/ω, shape (n, r), 1/√kg; None for none.
        force_quadrature: χ̂, how a unit contact force acts on u̇, shape (n, r), 1/√kg; None for none.

    Raises:
        ValueError: for values that are complex or not finite, frequencies not above zero, damping below zero, or
            lengths that do not agree.
    """

    angular_frequency: Real[AnyArray, " n"]
    damping_ratio: Real[AnyArray, " n"]
    shape: Real[AnyArray, "n r"]
    # None and not a copy: gradients and sensitivities to the one shape are those of both its parts together.
    force_shape: Real[AnyArray, "n r"] | None = None
    quadrature: Real[AnyArray, "n r"] | None = None
    force_quadrature: Real[AnyArray, "n r"] | None = None

    def __post_init__(self) -> None:
        _checks.positive("angular_frequency", self.angular_frequency, "rad/s")
        _checks.not_negative("damping_ratio", self.damping_ratio)
        _checks.as_numbers("shape", self.shape, "1/√kg, and force_shape for residues of another sign")
        others = ("force_shape", "quadrature", "force_quadrature")
        for name in others:
            if getattr(self, name) is not None:
                _checks.as_numbers(name, getattr(self, name), "1/√kg")
        for name in ("angular_frequency", "damping_ratio", "shape", *others):
            # JAX takes a list for a tree of numbers.
            object.__setattr__(self, name, _checks.as_array(getattr(self, name), name))
        count = np.shape(self.angular_frequency)
        if len(count) != 1 or count[0] == 0:
            raise ValueError(f"angular_frequency has shape {count}; give one value per mode, shape (n,)")
        if np.shape(self.damping_ratio) != count:
            raise ValueError(
                f"damping_ratio has shape {np.shape(self.damping_ratio)}; give one value per mode, shape {count}"
            )
        if len(np.shape(self.shape)) != 2 or np.shape(self.shape)[0] != count[0]:
            raise ValueError(f"shape has shape {np.shape(self.shape)}; give ({count[0]}, directions)")
        for name in others:
            if getattr(self, name) is not None and np.shape(getattr(self, name)) != np.shape(self.shape):
                given = np.shape(getattr(self, name))
                raise ValueError(f"{name} has shape {given}; give that of shape, {np.shape(self.shape)}")

    @property
    def loading(self) -> Real[AnyArray, "n r"]:
        """ψ, how a unit contact force loads each mode, shape (n, r), 1/√kg: ``force_shape`` or, without, ``shape``."""
        return self.shape if self.force_shape is None else self.force_shape

    @property
    def count(self) -> int:
        """Number of modes n."""
        return np.shape(self.angular_frequency)[0]

    @property
    def directions(self) -> int:
        """Number of contact directions r."""
        return np.shape(self.shape)[1]

    @property
    def frequency(self) -> Float[AnyArray, " n"]:
        """Natural frequencies ω/2π, shape (n,), Hz."""
        return self.angular_frequency / (2 * np.pi)

    @property
    def complex(self) -> bool:
        """Whether any shape has a part in quadrature."""
        return self.quadrature is not None or self.force_quadrature is not None

    def at(self, speed: Number) -> "Modes":
        """Themselves: ``ModesOverSpeed`` are others at another speed."""
        return self

    @classmethod
    def single(
        cls, *, frequency: Number, damping_ratio: Number, mass: Number | None = None, stiffness: Number | None = None
    ) -> "Modes":
        """One mode, from its natural frequency (Hz), damping ratio, and modal mass (kg) or modal stiffness (N/m).

        Raises:
            ValueError: unless one of mass and stiffness is given, and for numbers that are not above zero, with damping
                0 or more.
        """
        for name, value in (("frequency", frequency), ("damping_ratio", damping_ratio)):
            _checks.scalar(name, value)
        return cls(*table_of(frequency, damping_ratio, mass, stiffness, None))

    @classmethod
    def from_table(
        cls,
        frequency: ArrayLike,
        damping_ratio: ArrayLike,
        *,
        mass: ArrayLike | None = None,
        stiffness: ArrayLike | None = None,
        direction: Any = None,
    ) -> "Modes":
        """Modes of a table, such as that of a tap test in several directions, one a row.

        Args:
            frequency: natural frequencies, (n,), Hz.
            damping_ratio: ξ, one number or (n,).
            mass: modal masses, one number or (n,), kg; or
            stiffness: modal stiffnesses, one number or (n,), N/m, of motion along the direction of each mode.
            direction: names of axes, one or n of "x", "y" and "z"; or n vectors along which each mode moves and is
                pushed, (n, r), of any length. None for one contact direction.

        Returns:
            Modes seen in as many directions r as the vectors have, or up to the last axis named.

        Raises:
            ValueError: for numbers as of ``single``, tables of other lengths, axes of other names, vectors of no
                length.
        """
        return cls(*table_of(frequency, damping_ratio, mass, stiffness, direction))

    @classmethod
    def from_poles(cls, pole: ComplexLike, residue: ComplexLike) -> "Modes":
        """Complex modes, as a modal test fits them: G(s) = Σ R/(s − λ) + R̄/(s − λ̄).

        Args:
            pole: λ = −ξω + jω√(1 − ξ²), one of each pair, (n,), rad/s.
            residue: R of one contact direction, (n,), or of r, (n, r, r) and of rank one each, m/(N s).

        Raises:
            ValueError: for poles that are not such, residues of another shape or rank, and numbers that are not finite.
        """
        return cls(*of_residues(pole, residue))

    @classmethod
    def plane(cls, *, x: "Modes", y: "Modes") -> "Modes":
        """The modes of two perpendicular directions, as r = 2 for milling in the plane."""
        return cls(*_beside({"x": x, "y": y}))

    @classmethod
    def space(cls, *, x: "Modes", y: "Modes", z: "Modes") -> "Modes":
        """The modes of three perpendicular directions: r = 3, of milling with z along the axis of the tool."""
        return cls(*_beside({"x": x, "y": y, "z": z}))

    @classmethod
    def relative(cls, *, tool: "Modes", workpiece: "Modes") -> "Modes":
        """The modes of tool and workpiece, both flexible, as the cut between them sees them.

        The force acts on both, in opposite directions, and the cut sees the difference of their displacements, so that
        their receptances add up.
        """
        for name, modes in (("tool", tool), ("workpiece", workpiece)):
            if not isinstance(modes, Modes):
                raise ValueError(f"{name} = {_checks.brief(modes)}; give lobex.Modes")
        if tool.directions != workpiece.directions:
            raise ValueError(
                f"tool has {tool.directions} contact directions and workpiece {workpiece.directions}; give as many"
            )
        return cls(*together([(tool, 1.0), (workpiece, -1.0)]))

    @overload
    @classmethod
    def from_matrices(
        cls,
        mass: Any,
        stiffness: Any,
        contact: Any,
        damping_ratio: Any = None,
        keep: Sequence[int] | None = None,
        *,
        damping: Any = None,
        force: Any = None,
        triangle: str | None = None,
        condense: bool = False,
        spin_stiffness: None = None,
        gyroscopic: None = None,
    ) -> "Modes": ...

    @overload
    @classmethod
    def from_matrices(cls, *model: Any, **others: Any) -> "RotatingModes": ...

    @classmethod
    def from_matrices(
        cls,
        mass: Any,
        stiffness: Any,
        contact: Any,
        damping_ratio: Any = None,
        keep: Sequence[int] | None = None,
        *,
        damping: Any = None,
        force: Any = None,
        triangle: str | None = None,
        condense: bool = False,
        spin_stiffness: Any = None,
        gyroscopic: Any = None,
    ) -> "Modes | RotatingModes":
        """Modes of any finite-element model K v = ω² M v.

        Degrees of freedom that a large number on the diagonal of K holds, such as the 1e36 of Abaqus, are fixed.

        Args:
            mass: symmetric positive definite M, (dof, dof), dense or scipy sparse.
            stiffness: symmetric K, (dof, dof), dense or scipy sparse, without rigid-body motion.
            contact: the contact displacement as a combination of the degrees of freedom, (dof,) or (dof, r).
            damping_ratio: ξ, one number or one per mode kept.
            keep: mode numbers to keep, counted from 1 in order of frequency; all by default. Sparse
                matrices with ``keep`` are solved for the lowest modes alone.
            damping: in place of ``damping_ratio``, a symmetric matrix C, (dof, dof), N s/m. Where the modes diagonalise
                it, such as αM + βK, they have damping ratios; where it couples them, those that are kept make complex
                modes among themselves.
            force: the unit contact force as a combination of the degrees of freedom, of the shape of ``contact``,
                where it acts in another direction than the displacement is taken in.
            triangle: "lower" or "upper" for matrices of which that triangle alone is stored.
            condense: take degrees of freedom without mass, such as rotations of a lumped model, by static (Guyan)
                condensation, which is exact for them.
            spin_stiffness, gyroscopic: of a structure that turns, K_s and C_g of ``RotatingModes.from_matrices``, which
                is asked then: modes that follow the speed.

        Raises:
            ValueError: naming the matrix that has a wrong shape, is not symmetric, or is singular, and for damping that
                lets a vibration grow.

        Warns:
            LobexWarning: where damping couples the modes kept to others, of what force is lost.
        """
        given: dict[str, Any] = {"damping": damping, "force": force, "triangle": triangle, "condense": condense}
        if spin_stiffness is None and gyroscopic is None:
            return cls(*modes_of_matrices(mass, stiffness, contact, damping_ratio, keep, **given))
        if given.pop("damping") is not None:
            raise ValueError("damping is a matrix, which modes that follow the speed do not take; give damping_ratio")
        from lobex.structures.rotating_modes import RotatingModes

        parts = {"spin_stiffness": spin_stiffness, "gyroscopic": gyroscopic}
        return RotatingModes.from_matrices(mass, stiffness, contact, damping_ratio, keep, **parts, **given)

    def in_contact(self, normal: Any, sliding: Any = None, friction: Any = 0.0) -> "Modes":
        """The modes as a contact sees and loads them that is pressed in along a normal and rubs along its surface.

        Pressed in by h, it holds against the structure with −K h (n + μ t), so that it sees the receptance
        G = nᵀ R (n + μ t) of a structure with the receptance matrix R.

        Args:
            normal: n, into what is rubbed, one number per contact direction, of any length; of m contacts, each of
                which becomes a direction of its own, a row each, (m, r).
            sliding: t, in which the structure slides along that, as many; None without friction.
            friction: coefficient μ of Coulomb's friction, 0 or more, one or (m,): sliding the other way turns t.

        Raises:
            ValueError: for vectors of no length or another shape, a sliding that is not at right angles to the normal,
                and a coefficient below zero or without a sliding.
        """
        return replace(self, **in_contact(self, *contact_vectors(normal, sliding, friction, self.directions)))

    def select(self, keep: Sequence[int]) -> "Modes":
        """The modes of the given numbers, counted from 1."""
        index = keep_modes(keep, self.count)
        return jax.tree.map(lambda leaf: leaf[index], self)


def check_modes(modes: Any, measured: bool = False, over_speed: bool = False, name: str = "modes") -> None:
    """Require ``Modes`` or, if ``measured``, a measured receptance, or, if ``over_speed``, a table in their place, of
    the argument ``name``.
    """
    table = hasattr(modes, "check_speed")
    if isinstance(modes, Modes) or (measured and hasattr(modes, "response")) or (over_speed and table):
        return
    if table:
        hint = "modes over speed serve processes alone; give those at one speed, by at(speed)"
    elif hasattr(modes, "response"):
        hint = "a measured receptance serves exact_limit and, of milling, zero_order_limit and "
        hint += "multi_frequency_limit; give lobex.Modes"
    elif hasattr(modes, "driving_points"):
        hint = "it is measured; give the modes fitted to it, by modes()"
    else:
        hint = "give lobex.Modes, such as lobex.Rod().modes()"
    raise ValueError(f"{name} = {_checks.brief(modes)}: {hint}")


def unchecked(**fields: Any) -> Modes:
    """``Modes`` without the checks of the constructor, which would refuse what is no number."""
    made = object.__new__(Modes)
    for name in ("angular_frequency", "damping_ratio", *SHAPES):
        object.__setattr__(made, name, fields.get(name))
    return made


def _beside(parts: dict[str, Modes]) -> tuple[Any, ...]:
    """Fields of modes that each part has in a direction of its own."""
    for name, modes in parts.items():
        if not isinstance(modes, Modes) or modes.directions != 1:
            has = f"has {modes.directions} contact directions" if isinstance(modes, Modes) else "is none"
            raise ValueError(f"{name} {has}; give modes with one")
    axes = np.eye(len(parts))[:, None]
    return together(list(zip(parts.values(), axes, strict=True)))
