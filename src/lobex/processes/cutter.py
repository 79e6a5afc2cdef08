"""What a milling cutter is: its teeth, the angles between them, their helix, and how far each stands out."""

from typing import Any

import numpy as np
from jaxtyping import Float, Real

from lobex import _checks
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray, ArrayLike, Number

TURN = 2 * np.pi
_MOST_TEETH = 1000
# Of a turn, what the rounding of angles in degrees leaves.
_ROUNDING = 1e-6
# So much may angles and radii differ that are the same.
_SAME = 1e-12


@pytree(static=("teeth", "alike"))
class Cutter:
    """A milling cutter, angles in radians; ``end_mill`` makes one of degrees.

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
    """

    teeth: int
    diameter: Number | None = None
    pitch: Real[AnyArray, " teeth"] | None = None
    helix: Number | Real[AnyArray, " teeth"] | None = None
    runout: Real[AnyArray, " teeth"] | None = None
    alike: int = 1

    def __post_init__(self) -> None:
        object.__setattr__(self, "teeth", _checks.integer("teeth", self.teeth, 1, _MOST_TEETH))
        for name in ("pitch", "helix", "runout"):
            object.__setattr__(self, name, _checks.as_array(getattr(self, name)))
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
    ) -> "Cutter":
        """A cylindrical end mill, angles in degrees.

        Args:
            diameter: m.
            teeth: their number, where they are equally spaced. Else
            pitch_degrees: the angle from each tooth to the next, (teeth,): one turn, 360, together.
            helix_degrees: helix angle, one of all teeth or one of each; none, or 0, of straight teeth.
            runout: what the radius of each tooth has above the nominal one, m, (teeth,).

        Raises:
            ValueError: unless either teeth or pitch angles are given, for angles that make no turn, helix angles that
                are not from 0 to below 90, and helix angles without a diameter.
        """
        if (teeth is None) == (pitch_degrees is None):
            raise ValueError(
                f"teeth = {teeth}, pitch_degrees = {_checks.brief(pitch_degrees)}: give the number of equally spaced "
                "teeth, or the pitch angles in degrees"
            )
        count: Any = teeth
        pitch, helix = _checks.as_array(pitch_degrees), _checks.as_array(helix_degrees)
        if pitch is not None:
            _checks.positive("pitch_degrees", pitch, "degrees")
            if np.ndim(pitch) != 1:
                raise ValueError(f"pitch_degrees has shape {np.shape(pitch)}; give one angle a tooth")
            turn = _checks.as_numbers("pitch_degrees", pitch)
            if turn is not None and abs(turn.sum() - 360) > 360 * _ROUNDING:
                raise ValueError(f"pitch_degrees sum to {turn.sum():.6g}; give angles that make one turn, 360 degrees")
            count, pitch = np.shape(pitch)[0], pitch * (np.pi / 180)
        if helix is not None:
            angles = _checks.as_numbers("helix_degrees", helix, "degrees")
            if angles is not None and not np.all((angles >= 0) & (angles < 90)):
                raise ValueError(f"helix_degrees = {_checks.brief(helix_degrees)}; give angles from 0 to below 90")
            straight = angles is not None and not np.any(angles)
            helix = None if straight else helix * (np.pi / 180)
        return cls(count, diameter, pitch, helix, _checks.as_array(runout))

    @property
    def pattern(self) -> Float[Any, " alike"]:
        """The pitch angles until the teeth repeat, rad."""
        return self._until_alike(np.full(self.teeth, TURN / self.teeth) if self.pitch is None else self.pitch)

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
    def one_helix(self) -> bool:
        """Whether the edges are straight or have the same helix."""
        return self.helix is None or np.ndim(self.helix) == 0

    def _until_alike(self, numbers: Any) -> Float[Any, " alike"]:
        """The mean of the teeth that are alike, so that derivatives by each come out right."""
        lib = namespace(numbers)
        return lib.mean(lib.reshape(lib.asarray(numbers, dtype=lib.result_type(float)), (self.alike, -1)), axis=0)

    def _repeats(self) -> int:
        """How often the teeth repeat in a turn; once where that is not known. With edges of different helix, too."""
        each = [part for part in (self.pitch, self.runout) if part is not None]
        if not self.one_helix or _checks.is_traced(each):
            return 1
        for count in range(1, self.teeth + 1):
            shifted = all(np.allclose(part, np.roll(part, count), rtol=_SAME, atol=0) for part in each)
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


def as_cutter(cutter: Any) -> Cutter:
    """A cutter; of a number of teeth, that with so many straight teeth at equal angles."""
    if isinstance(cutter, Cutter):
        return cutter
    if not isinstance(cutter, int | float | np.number):
        raise ValueError(f"cutter = {_checks.brief(cutter)} is none; give a lobex.Cutter, or the number of teeth")
    return Cutter(cutter)  # pyright: ignore[reportArgumentType]
