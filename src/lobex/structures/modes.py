"""The modes of a structure, as its contact point sees them."""

from collections.abc import Sequence
from typing import Any

import jax
import numpy as np
from jaxtyping import Float, Real

from lobex import _checks
from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray
from lobex.structures.damping import proportional_damping
from lobex.structures.eigenproblem import keep_modes, vibration_modes
from lobex.structures.matrices import is_sparse, whole


@pytree()
class Modes:
    """Vibration modes with modal damping: ü + 2ξω u̇ + ω² u = ψᵀ F, displacement at the contact y = Σ φ u.

    Displacement and force may have directions of their own, such as the surface normal and the direction of the
    cutting force: then ψ is not φ, and the residues φψ may have either sign.

    Attributes:
        angular_frequency: angular natural frequencies ω, shape (n,), rad/s.
        damping_ratio: modal damping ratios ξ, shape (n,).
        shape: mass-normalised mode shapes φ at the contact, shape (n, r), 1/√kg; r is the number of
            displacement directions that the contact acts on.
        force_shape: ψ, how a unit contact force loads each mode, shape (n, r), 1/√kg; None where it is ``shape``.

    Raises:
        ValueError: for values that are complex or not finite, frequencies not above zero, damping below zero, or
            lengths that do not agree.
    """

    angular_frequency: Real[AnyArray, " n"]
    damping_ratio: Real[AnyArray, " n"]
    shape: Real[AnyArray, "n r"]
    # None and not a copy: gradients and sensitivities to the one shape are those of both its parts together.
    force_shape: Real[AnyArray, "n r"] | None = None

    def __post_init__(self) -> None:
        _checks.positive("angular_frequency", self.angular_frequency, "rad/s")
        _checks.not_negative("damping_ratio", self.damping_ratio)
        _checks.as_numbers("shape", self.shape, "1/√kg, and force_shape for residues of another sign")
        if self.force_shape is not None:
            _checks.as_numbers("force_shape", self.force_shape, "1/√kg")
        for name in ("angular_frequency", "damping_ratio", "shape", "force_shape"):
            # JAX takes a list for a tree of numbers.
            object.__setattr__(self, name, _checks.as_array(getattr(self, name)))
        count = np.shape(self.angular_frequency)
        if len(count) != 1 or count[0] == 0:
            raise ValueError(f"angular_frequency has shape {count}; give one value per mode, shape (n,)")
        if np.shape(self.damping_ratio) != count:
            raise ValueError(
                f"damping_ratio has shape {np.shape(self.damping_ratio)}; give one value per mode, shape {count}"
            )
        if len(np.shape(self.shape)) != 2 or np.shape(self.shape)[0] != count[0]:
            raise ValueError(f"shape has shape {np.shape(self.shape)}; give ({count[0]}, directions)")
        if np.shape(self.loading) != np.shape(self.shape):
            raise ValueError(f"force_shape has shape {np.shape(self.loading)}; give that of shape, {self.shape.shape}")

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

    @classmethod
    def single(cls, *, frequency: float, damping_ratio: float, mass: float) -> "Modes":
        """One mode, from its natural frequency (Hz), damping ratio and modal mass (kg)."""
        _checks.positive("frequency", frequency, "Hz")
        _checks.not_negative("damping_ratio", damping_ratio)
        _checks.positive("mass", mass, "kg")
        for name, value in (("frequency", frequency), ("damping_ratio", damping_ratio), ("mass", mass)):
            _checks.scalar(name, value)
        return cls(*_single(frequency, damping_ratio, mass))

    @classmethod
    def plane(cls, *, x: "Modes", y: "Modes") -> "Modes":
        """The modes of two perpendicular directions, as r = 2 for milling in the plane."""
        for name, modes in (("x", x), ("y", y)):
            if modes.directions != 1:
                raise ValueError(f"{name} has {modes.directions} contact directions; give modes with one")
        return cls(*_plane(x, y))

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
    ) -> "Modes":
        """Modes of any finite-element model K v = ω² M v.

        Degrees of freedom that a large number on the diagonal of K holds, such as the 1e36 of Abaqus, are fixed.

        Args:
            mass: symmetric positive definite M, (dof, dof), dense or scipy sparse.
            stiffness: symmetric K, (dof, dof), dense or scipy sparse, without rigid-body motion.
            contact: the contact displacement as a combination of the degrees of freedom, (dof,) or (dof, r).
            damping_ratio: ξ, one number or one per mode kept.
            keep: mode numbers to keep, counted from 1 in order of frequency; all by default. Sparse
                matrices with ``keep`` are solved for the lowest modes alone.
            damping: in place of ``damping_ratio``, a symmetric matrix C, (dof, dof), N s/m, that the modes
                diagonalise, such as αM + βK.
            force: the unit contact force as a combination of the degrees of freedom, of the shape of ``contact``,
                where it acts in another direction than the displacement is taken in.
            triangle: "lower" or "upper" for matrices of which that triangle alone is stored.
            condense: take degrees of freedom without mass, such as rotations of a lumped model, by static (Guyan)
                condensation, which is exact for them.

        Raises:
            ValueError: naming the matrix that has a wrong shape, is not symmetric, or is singular, and for
                damping that couples modes.
        """
        if (damping_ratio is None) == (damping is None):
            raise ValueError("give either damping_ratio or damping, a matrix")
        given = {"mass": mass, "stiffness": stiffness} | ({} if damping is None else {"damping": damping})
        mass, stiffness, *matrix = (whole(name, value, triangle) for name, value in given.items())
        dof = (mass.shape if is_sparse(mass) else np.shape(mass))[0]
        _checks.as_numbers("contact", contact)
        if len(np.shape(contact)) not in (1, 2) or np.shape(contact)[0] != dof:
            raise ValueError(f"contact has shape {np.shape(contact)}; give ({dof},) or ({dof}, directions)")
        if force is not None:
            _checks.as_numbers("force", force)
            if np.shape(force) != np.shape(contact):
                raise ValueError(f"force has shape {np.shape(force)}; give that of contact, {np.shape(contact)}")
        angular_frequency, vectors = vibration_modes(mass, stiffness, keep, condense)
        if matrix:
            ratio = proportional_damping(matrix[0], mass, stiffness, angular_frequency, vectors)
        else:
            ratio = modal_damping(damping_ratio, np.shape(vectors)[1])
        loading = None if force is None else _seen_at(vectors, force)
        return cls(angular_frequency, ratio, _seen_at(vectors, contact), loading)

    def select(self, keep: Sequence[int]) -> "Modes":
        """The modes of the given numbers, counted from 1."""
        index = keep_modes(keep, self.count)
        return jax.tree.map(lambda leaf: leaf[index], self)


def check_modes(modes: Any, measured: bool = False) -> None:
    """Require ``Modes`` or, if ``measured``, a measured receptance in their place."""
    if isinstance(modes, Modes) or (measured and hasattr(modes, "response")):
        return
    if hasattr(modes, "response"):
        hint = "a measured receptance serves exact_limit alone; give lobex.Modes"
    else:
        hint = "give lobex.Modes, such as lobex.Rod().modes()"
    raise ValueError(f"modes = {_checks.brief(modes)}: {hint}")


@in_float64
def modal_damping(damping_ratio: Any, count: int) -> Float[AnyArray, " n"]:
    """Damping ratios of ``count`` modes, shape (count,), from one number or one per mode."""
    _checks.not_negative("damping_ratio", damping_ratio)
    if np.shape(damping_ratio) not in ((), (count,)):
        raise ValueError(
            f"damping_ratio has shape {np.shape(damping_ratio)}; give one number or one per mode, ({count},)"
        )
    lib = namespace(damping_ratio)
    return lib.broadcast_to(lib.asarray(damping_ratio, dtype=lib.result_type(float)), (count,))


@in_float64
def _single(
    frequency: Any, damping_ratio: Any, mass: Any
) -> tuple[Float[AnyArray, "1"], Float[AnyArray, "1"], Float[AnyArray, "1 1"]]:
    lib = namespace(frequency, damping_ratio, mass)
    number = [lib.asarray(value, dtype=lib.result_type(float)) for value in (frequency, damping_ratio, mass)]
    return 2 * lib.pi * number[0][None], number[1][None], 1 / lib.sqrt(number[2])[None, None]


@in_float64
def _plane(
    x: Modes, y: Modes
) -> tuple[Float[AnyArray, " n"], Float[AnyArray, " n"], Float[AnyArray, "n 2"], Float[AnyArray, "n 2"] | None]:
    lib = namespace(x, y)

    def beside(one: Any, other: Any) -> Float[AnyArray, "n 2"]:
        return lib.block([[lib.asarray(one), lib.zeros((x.count, 1))], [lib.zeros((y.count, 1)), lib.asarray(other)]])

    same = x.force_shape is None and y.force_shape is None
    return (
        lib.concatenate([x.angular_frequency, y.angular_frequency]),
        lib.concatenate([x.damping_ratio, y.damping_ratio]),
        beside(x.shape, y.shape),
        None if same else beside(x.loading, y.loading),
    )


@in_float64
def _seen_at(vectors: Any, contact: Any) -> Float[AnyArray, "n r"]:
    lib = namespace(vectors, contact)
    directions = lib.asarray(contact, dtype=lib.result_type(float))
    return lib.asarray(vectors).T @ directions.reshape(directions.shape[0], -1)
