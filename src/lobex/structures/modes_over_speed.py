"""Modes that depend on the speed: a table of them, with lines between its rows."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from jaxtyping import Float, Real

from lobex import _checks
from lobex._float64 import in_float64
from lobex._missing import where_there
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, ArrayLike, Number
from lobex.structures.contact_shapes import SHAPES, shapes_of
from lobex.structures.modes import Modes, unchecked


@pytree()
class ModesOverSpeed:
    """Vibration modes at k speeds, such as those of a spindle or of a blade that stiffens: ``from_modes`` makes it.

    ``Rub``, ``Turning`` and ``Milling`` take it in place of ``Modes``. Frequencies, damping ratios and shapes are
    linear between the speeds, so that a limit has a bend at each of them.

    Attributes:
        speed: increasing, (k,), Hz.
        angular_frequency: ω, (k, n), rad/s.
        damping_ratio: ξ, (k, n).
        shape, force_shape, quadrature, force_quadrature: as of ``Modes``, (k, n, r) each, or None.
    """

    speed: Real[AnyArray, " k"]
    angular_frequency: Real[AnyArray, "k n"]
    damping_ratio: Real[AnyArray, "k n"]
    shape: Real[AnyArray, "k n r"]
    force_shape: Real[AnyArray, "k n r"] | None = None
    quadrature: Real[AnyArray, "k n r"] | None = None
    force_quadrature: Real[AnyArray, "k n r"] | None = None

    @classmethod
    def from_modes(cls, speed: ArrayLike, modes: Sequence[Modes]) -> "ModesOverSpeed":
        """The table of the modes at k speeds, of which mode i is the same one at all of them.

        Args:
            speed: increasing, (k,), Hz.
            modes: k of them.

        Raises:
            ValueError: for fewer than two speeds, speeds that do not increase, and modes of another number or shape.
        """
        speeds = _checks.grid("speed", _checks.as_array(speed), "Hz")
        if len(speeds) < 2 or len(modes) != len(speeds):
            raise ValueError(f"modes has {len(modes)} entries for {len(speeds)} speeds; give one each, of two or more")
        for one in modes:
            if not isinstance(one, Modes) or np.shape(one.shape) != np.shape(modes[0].shape):
                raise ValueError("modes differ in number or directions; give lobex.Modes with as many at every speed")
        return cls(speeds, *_table(modes))

    @property
    def count(self) -> int:
        """Number of modes n."""
        return np.shape(self.shape)[1]

    @property
    def directions(self) -> int:
        """Number of contact directions r."""
        return np.shape(self.shape)[2]

    @property
    def loading(self) -> Real[AnyArray, "k n r"]:
        """ψ, ``force_shape`` or, without, ``shape``, (k, n, r)."""
        return self.shape if self.force_shape is None else self.force_shape

    @property
    def complex(self) -> bool:
        """Whether any shape has a part in quadrature."""
        return self.quadrature is not None or self.force_quadrature is not None

    def check_speed(self, speed: Any) -> None:
        """Require speeds, Hz, within the table, of numbers that are known."""
        numbers = _checks.as_numbers("speed", speed, "Hz")
        if numbers is None or _checks.is_traced(self.speed):
            return
        first, last = np.asarray(self.speed)[[0, -1]]
        outside = numbers[(numbers < first) | (numbers > last)]
        if outside.size:
            raise ValueError(
                f"speed = {outside.ravel()[0]:.6g} Hz is outside the table of modes; give {first:.6g} to {last:.6g} Hz"
            )

    def at(self, speed: Number) -> Modes:
        """The modes at a speed, Hz; no numbers outside the table."""
        self.check_speed(speed)
        _checks.scalar("speed", speed)
        lib = namespace(self, speed)
        table = lib.asarray(self.speed)
        row = lib.clip(lib.searchsorted(table, speed, side="right") - 1, 0, np.shape(table)[0] - 2)
        share = (speed - table[row]) / (table[row + 1] - table[row])
        share = where_there((speed >= table[0]) & (speed <= table[-1]), share)

        def between(part: Any) -> Any:
            part = lib.asarray(part)
            return part[row] + share * (part[row + 1] - part[row])

        fields = ("angular_frequency", "damping_ratio", *SHAPES)
        known = {name: getattr(self, name) for name in fields}
        return unchecked(**{name: None if part is None else between(part) for name, part in known.items()})


@in_float64
def _table(modes: Sequence[Modes]) -> tuple[Any, ...]:
    lib = namespace(modes)
    sign = lib.stack(_signs(lib.stack([lib.asarray(one.shape) for one in modes])))[..., None]
    table = [lib.stack([lib.asarray(getattr(one, n)) for one in modes]) for n in ("angular_frequency", "damping_ratio")]
    shapes = [shapes_of(modes, name) for name in SHAPES]
    return (*table, *(None if parts is None else sign * lib.stack(parts) for parts in shapes))


def _signs(shape: Float[AnyArray, "k n r"]) -> list[Float[AnyArray, " n"]]:
    """Of each mode at each speed, since the sign of a shape is nobody's: so that it goes on from that before."""
    lib = namespace(shape)
    signs = [lib.ones(np.shape(shape)[1])]
    for before, after in pairwise(shape):
        signs.append(signs[-1] * lib.where(lib.sum(before * after, axis=1) < 0, -1.0, 1.0))
    return signs
