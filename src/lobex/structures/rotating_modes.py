"""Modes of a structure that turns: stiffened by the square of the speed, and coupled by Coriolis forces."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Complex, Float, Real

from lobex import _checks
from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, Number
from lobex.structures.contact_shapes import in_contact, seen_at
from lobex.structures.contact_vectors import contact_vectors
from lobex.structures.damping import modal_damping
from lobex.structures.eigenproblem import keep_modes, vibration_modes
from lobex.structures.matrices import check_same_size, check_symmetric, is_sparse, whole
from lobex.structures.matrix_modes import check_contact
from lobex.structures.modes import Modes, unchecked
from lobex.structures.modes_over_speed import ModesOverSpeed

# Of the largest entry, in matrices of a structure's own modes.
_ROUNDING = 1e-6
_BASIS = 100


@pytree(static=("keep",))
class RotatingModes:
    """Modes that follow the speed of a turning structure: q̈ + Ω Γ q̇ + (ω² + Ω² S) q = ψᵀF in p of its modes at rest.

    ``Beam.rotating`` and ``Modes.from_matrices`` make it; ``Rub``, ``Turning`` and ``Milling`` take it in place of
    ``Modes``. At each speed the eigenproblem of these p modes is solved, and those of ``keep`` are the structure there,
    each with a damping ratio of its own. With Γ they are complex: points move out of phase.

    Attributes:
        angular_frequency: ω at rest, (p,), rad/s.
        spin_stiffness: S, symmetric, (p, p): what the turning adds to the squares of frequencies, per Ω², Ω in rad/s.
        gyroscopic: Γ, skew, (p, p), of Coriolis forces ΩΓq̇; None for none.
        damping_ratio: ξ of the modes kept, in order of frequency, (k,).
        shape, force_shape: as of ``Modes`` at rest, (p, r), 1/√kg.
        keep: numbers of the modes kept, from 1 in order of frequency at each speed.

    Raises:
        ValueError: as ``Modes`` does; for matrices of another shape, S that is not symmetric, and Γ that is not skew.
    """

    angular_frequency: Real[AnyArray, " p"]
    spin_stiffness: Real[AnyArray, "p p"]
    gyroscopic: Real[AnyArray, "p p"] | None
    damping_ratio: Real[AnyArray, " k"]
    shape: Real[AnyArray, "p r"]
    force_shape: Real[AnyArray, "p r"] | None = None
    keep: Any = (1,)

    def __post_init__(self) -> None:
        rest = Modes(self.angular_frequency, np.zeros(np.shape(self.angular_frequency)), self.shape, self.force_shape)
        p = rest.count
        keep = tuple(int(number) + 1 for number in keep_modes([int(number) for number in self.keep], p))
        object.__setattr__(self, "keep", keep)
        object.__setattr__(self, "damping_ratio", modal_damping(self.damping_ratio, len(keep)))
        for name, sign, words in (("spin_stiffness", 1, "symmetric"), ("gyroscopic", -1, "skew")):
            given = getattr(self, name)
            if given is None:
                continue
            numbers, matrix = _checks.as_numbers(name, given), _checks.as_array(given, name)
            if np.shape(matrix) != (p, p):
                raise ValueError(f"{name} has shape {np.shape(matrix)}; give that of {p} modes, {(p, p)}")
            if numbers is not None and np.any(
                np.abs(numbers - sign * numbers.T) > _ROUNDING * np.max(np.abs(numbers), initial=0.0)
            ):
                raise ValueError(f"{name} is not {words}; give a matrix that is")
            object.__setattr__(self, name, matrix)

    @classmethod
    def from_matrices(
        cls,
        mass: Any,
        stiffness: Any,
        contact: Any,
        damping_ratio: Any,
        keep: Sequence[int] | None = None,
        *,
        spin_stiffness: Any = None,
        gyroscopic: Any = None,
        force: Any = None,
        triangle: str | None = None,
        condense: bool = False,
        basis: int | None = None,
    ) -> "RotatingModes":
        """Modes over speed of M q̈ + Ω C_g q̇ + (K + Ω² K_s) q, with Ω in rad/s.

        Args:
            mass, stiffness, contact, force, triangle, condense: as of ``Modes.from_matrices``; all of a skew matrix is
                given with a ``triangle`` of the others, too.
            damping_ratio: ξ, one number or one per mode kept.
            keep: mode numbers to keep, from 1 in order of frequency at each speed; all of the basis by default.
            spin_stiffness: K_s, symmetric, (dof, dof), dense or scipy sparse, kg; None for none.
            gyroscopic: C_g, skew, as many, kg; None for none.
            basis: of how many modes at rest those at a speed are made (Rayleigh and Ritz), p; by default 100 or, if
                more, twice the last one kept, and all of a model that has no more.

        Raises:
            ValueError: as ``Modes.from_matrices``, for matrices of another shape, K_s that is not symmetric, C_g that
                is not skew, and a basis of fewer modes than are kept.
        """
        given = {"mass": mass, "stiffness": stiffness}
        mass, stiffness = (whole(name, value, triangle) for name, value in given.items())
        check_same_size("stiffness", stiffness, mass)
        check_contact(mass, contact, force)
        dof = np.shape(contact)[0]
        last = 1 if keep is None else int(max(keep_modes(keep, dof))) + 1
        size = min(dof, max(_BASIS, 2 * last)) if basis is None else _checks.integer("basis", basis, last, dof)
        omega, vectors = vibration_modes(mass, stiffness, range(1, size + 1), condense)
        spin = None if spin_stiffness is None else whole("spin_stiffness", spin_stiffness, triangle)
        if spin is not None:
            check_symmetric("spin_stiffness", spin)
        numbers = range(1, np.shape(vectors)[1] + 1) if keep is None else keep
        return cls(
            omega,
            np.zeros((len(vectors[0]),) * 2) if spin is None else _in_modes("spin_stiffness", spin, vectors),
            None if gyroscopic is None else _in_modes("gyroscopic", gyroscopic, vectors),
            modal_damping(damping_ratio, len(numbers)),
            seen_at(vectors, contact),
            None if force is None else seen_at(vectors, force),
            numbers,
        )

    @property
    def count(self) -> int:
        """Number of modes kept, k."""
        return len(self.keep)

    @property
    def directions(self) -> int:
        """Number of contact directions r."""
        return np.shape(self.shape)[1]

    @property
    def loading(self) -> Real[AnyArray, "p r"]:
        """ψ, ``force_shape`` or, without, ``shape``, (p, r)."""
        return self.shape if self.force_shape is None else self.force_shape

    @property
    def complex(self) -> bool:
        """Whether Coriolis forces make the modes complex."""
        return self.gyroscopic is not None

    @property
    def divergence_speed(self) -> float:
        """The speed, Hz, at which the softened stiffness vanishes; infinite where it stiffens in every direction."""
        _checks.untraced("divergence_speed", modes=self)
        scaled = np.asarray(self.spin_stiffness) / np.outer(self.angular_frequency, self.angular_frequency)
        least = float(np.linalg.eigvalsh(scaled)[0])
        return float("inf") if least >= 0 else 1 / (2 * np.pi * np.sqrt(-least))

    def in_contact(self, normal: Any, sliding: Any = None, friction: Any = 0.0) -> "RotatingModes":
        """The modes as a contact, or several, see and load them; arguments and errors as of ``Modes.in_contact``."""
        return replace(self, **in_contact(self, *contact_vectors(normal, sliding, friction, self.directions)))

    def check_speed(self, speed: Any) -> None:
        """Require speeds, Hz, below that of divergence, of numbers that are known."""
        numbers = _checks.as_numbers("speed", speed, "Hz")
        if numbers is None or not numbers.size or _checks.is_traced(self):
            return
        most, limit = float(np.max(numbers)), self.divergence_speed
        if most >= limit:
            raise ValueError(
                f"speed = {most:.6g} Hz softens the structure to a negative stiffness; give less than {limit:.6g} Hz, "
                "at which it diverges"
            )

    @in_float64
    def at(self, speed: Number) -> Modes:
        """The modes at a speed, Hz; no numbers from that of divergence on."""
        self.check_speed(speed)
        _checks.scalar("speed", speed)
        return self._at(speed)

    def _at(self, speed: Number) -> Modes:
        lib = namespace(self, speed)
        spin = 2 * np.pi * lib.asarray(speed, dtype=lib.result_type(float))
        own, matrix = lib.asarray(self.angular_frequency), lib.asarray(self.spin_stiffness)
        stiffness = lib.diag(own**2) + spin**2 * (matrix + matrix.T) / 2
        index = np.asarray(self.keep) - 1
        if self.gyroscopic is None:
            squared, vectors = lib.linalg.eigh(stiffness)
            omega, vectors = lib.sqrt(squared[index]), vectors[:, index]
            loading = None if self.force_shape is None else vectors.T @ self.force_shape
            return unchecked(
                angular_frequency=omega,
                damping_ratio=self.damping_ratio,
                shape=vectors.T @ self.shape,
                force_shape=loading,
            )
        skew = lib.asarray(self.gyroscopic)
        omega, motion = _whirling(stiffness, spin * (skew - skew.T) / 2, index)
        seen, acting = lib.matmul(motion.T, self.shape), lib.matmul(motion.conj().T, self.loading)
        return unchecked(
            angular_frequency=omega,
            damping_ratio=self.damping_ratio,
            shape=seen.real,
            force_shape=acting.real,
            quadrature=seen.imag,
            force_quadrature=acting.imag,
        )

    @in_float64
    def over(self, speed: Float[np.ndarray, " n"]) -> Modes | ModesOverSpeed:
        """The modes at increasing speeds, (n,), Hz, as a table that is exact at these; at one speed those there.

        Tables have a power of two of rows, the last repeated, so that programs for one serve another.
        """
        self.check_speed(speed)
        rows = [self._at(one) for one in speed]
        if len(rows) == 1:
            return rows[0]
        more = 2 ** int(np.ceil(np.log2(len(rows)))) - len(rows)
        beyond = speed[-1] * (2.0 + np.arange(more))
        return ModesOverSpeed.from_modes(np.append(speed, beyond), rows + more * rows[-1:])


@in_float64
def _in_modes(name: str, matrix: Any, vectors: Float[AnyArray, "dof p"]) -> Float[AnyArray, "p p"]:
    shape, dof = (matrix.shape if is_sparse(matrix) else np.shape(matrix)), np.shape(vectors)[0]
    if shape != (dof, dof):
        raise ValueError(f"{name} has shape {shape} and mass {(dof, dof)}; give the same size")
    _checks.as_numbers(name, matrix.tocoo().data if is_sparse(matrix) else matrix)
    lib = namespace(matrix, vectors)
    vectors = lib.asarray(vectors)
    return vectors.T @ (matrix @ vectors if is_sparse(matrix) else lib.asarray(matrix) @ vectors)


def _whirling(
    stiffness: Float[AnyArray, "p p"], coriolis: Float[AnyArray, "p p"], index: np.ndarray
) -> tuple[Float[AnyArray, " k"], Complex[AnyArray, "p k"]]:
    """ω and the velocities of each coordinate in a motion e^{jωt}, as large as shapes that are mass-normalised.

    In the states (q̇, Cᵀq), with C Cᵀ the stiffness, the equations are skew, so that −j times them are Hermitian
    (Meirovitch, AIAA J. 12, 1974). Each motion is turned so that its velocities are as nearly real as they can be.
    """
    lib = namespace(stiffness, coriolis)
    p = stiffness.shape[0]
    factor = lib.linalg.cholesky(stiffness)
    skew = lib.block([[-coriolis, -factor], [factor.T, lib.zeros((p, p), dtype=factor.dtype)]])
    omega, vectors = lib.linalg.eigh(-1j * skew)
    motion = 2**0.5 * vectors[:p, p + index]
    turned = lib.sum(motion**2, axis=0)
    return omega[p + index], motion * lib.sqrt(turned.conj() / lib.abs(turned))


AnyModes = Modes | ModesOverSpeed | RotatingModes
"""Modes that processes take: at every speed the same, or those that follow it."""
