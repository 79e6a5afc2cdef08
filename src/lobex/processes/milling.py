"""Milling with straight teeth in one or two directions, (3.24)-(3.29)."""

import math
from dataclasses import replace
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from lobex import _checks
from lobex._float64 import in_float64
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex.processes.process import check_point
from lobex.processes.quantity import DEPTH_OF_CUT, SPEED_UNITS, Quantity
from lobex.structures.modes import Modes, check_modes
from lobex.systems.coefficients import Framed, Piece
from lobex.systems.system import DelaySystem, modal_system
from lobex.systems.terms import Forcing, Regenerative

Array = Any

_MOST_TEETH = 1000

# Which parts of a tooth period are in the cut, where that is known before tracing.
Layout = tuple[str, ...]
_WHOLE: Layout = ("cut",)
# How far inside full immersion derivatives by it are taken: a power of 2, so that 1 − a is exact.
_INSIDE = 2.0**-40


@pytree(static=("teeth", "direction", "layout", "speed_unit"))
class Milling:
    """Milling with equally spaced straight teeth; each tooth meets the surface left by the one before.

    The force on the tool is −b H(t) [y(t) − y(t − τ)], τ = 1/(teeth · speed); with one direction (feed, x)
    H is K_s(t) of (3.25), with two (x along the feed, y across it) the 2×2 matrix of the same forces
    (Insperger and Stépán, Semi-Discretization for Time-Delay Systems, 2011, ch. 5). Angles are those of
    Appendix A: down-milling cuts from acos(2a − 1) to π, up-milling from 0 to acos(1 − 2a), with the radial
    immersion a.

    Attributes:
        modes: the tool's modes, r = 1 or r = 2 directions.
        teeth: number of teeth.
        tangential: tangential specific cutting force K_t, N/m².
        normal: normal (radial) specific cutting force K_n, N/m².
        radial_immersion: radial depth of cut over tool diameter, in (0, 1].
        direction: "down" or "up".
        layout: the parts of a tooth period, found from the immersion; leave it out.
        speed_unit: as of ``Rub``.
        feed_per_tooth: f_z, m, of which the chip is f_z sin φ thick without vibration: the forcing of ``orbit``. It has
            no part in multipliers and limits. None where no motion is asked for.

    The gain is the axial depth of cut b, m.
    """

    modes: Modes
    teeth: int
    tangential: Array
    normal: Array
    radial_immersion: Array
    direction: str = "down"
    layout: Layout | None = None
    speed_unit: str = "rpm"
    feed_per_tooth: Array | None = None

    gain: ClassVar[Quantity] = DEPTH_OF_CUT

    def __post_init__(self) -> None:
        object.__setattr__(self, "teeth", _checks.integer("teeth", self.teeth, 1, _MOST_TEETH))
        immersion = check_cutting(self)
        layout = self.layout if immersion is None else _layout(float(immersion), self.teeth, self.direction)
        object.__setattr__(self, "layout", layout)

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
        if not _checks.is_traced(self.radial_immersion):
            return ((1.0, self),)
        immersion = jnp.asarray(self.radial_immersion, dtype=jnp.result_type(float))
        form = replace(self, radial_immersion=immersion, layout=None if self.layout == _WHOLE else self.layout)
        if self.modes.directions == 2:
            return ((1.0, form),)
        inside = max(_INSIDE, 8 * float(jnp.finfo(immersion.dtype).eps))

        def at(most: float) -> "Milling":
            beyond = jnp.where((immersion > most) & (immersion <= 1), immersion - most, 0.0)
            return replace(form, radial_immersion=immersion - jax.lax.stop_gradient(beyond))

        return (2.0, at(1 - 4 * inside)), (-1.0, at(1 - inside))

    @in_float64
    def system(self, speed: Array, gain: Array) -> DelaySystem:
        """The delay system at one spindle speed (revolutions per second) and one depth of cut (m)."""
        check_point(self, speed, gain)
        entry, exit_ = cutting_angles(self.radial_immersion, self.direction)
        if self.layout == _WHOLE and _checks.is_traced(self.radial_immersion):
            entry = _no_derivative(entry, self.radial_immersion)
        cutting = CuttingForce(
            depth=gain,
            tangential=self.tangential,
            normal=self.normal,
            entry=entry,
            exit=exit_,
            teeth=self.teeth,
            directions=self.modes.directions,
            layout=self.layout,
        )
        pushed = () if self.feed_per_tooth is None else (feed_force(cutting, self.feed_per_tooth),)
        return modal_system(self.modes, 1 / (self.teeth * speed), (Regenerative(cutting), *pushed))


def feed_force(cutting: Any, feed: Array) -> Forcing:
    """−b H(t) (feed, 0): what the feed along x gives to cut, as a displacement would."""
    lib = namespace(feed)
    unit = np.eye(cutting.directions)
    pushed: Any = Framed(-unit, cutting, lib.asarray(feed) * unit[:, :1])
    return Forcing(pushed)


@jax.custom_jvp
def _no_derivative(angle: Array, immersion: Array) -> Array:
    """An angle whose derivative by the immersion is no number, where what follows would make a wrong one of it."""
    return jnp.asarray(angle, dtype=jnp.result_type(float))


@_no_derivative.defjvp
def _(primals: tuple[Array, Array], tangents: tuple[Array, Array]) -> tuple[Array, Array]:
    return _no_derivative(*primals), jnp.nan * tangents[1]


def check_cutting(process: Any) -> np.ndarray | None:
    """Check modes, coefficients, immersion, direction and feed of a milling process; return the immersion if known."""
    _checks.choice("direction", process.direction, ("down", "up"))
    _checks.choice("speed_unit", process.speed_unit, SPEED_UNITS)
    for name in ("tangential", "normal"):
        check = _checks.positive if name == "tangential" else _checks.not_negative
        check(name, getattr(process, name), "N/m²")
        _checks.scalar(name, getattr(process, name))
    _checks.scalar("radial_immersion", process.radial_immersion)
    immersion = _checks.as_numbers("radial_immersion", process.radial_immersion)
    if immersion is not None and not 0 < immersion <= 1:
        raise ValueError(
            f"radial_immersion = {float(immersion):.6g} is outside (0, 1]; "
            "give radial depth of cut divided by tool diameter"
        )
    if process.feed_per_tooth is not None:
        _checks.positive("feed_per_tooth", process.feed_per_tooth, "m")
        _checks.scalar("feed_per_tooth", process.feed_per_tooth)
    check_modes(process.modes)
    if process.modes.directions not in (1, 2):
        raise ValueError(f"modes has {process.modes.directions} contact directions; milling takes 1 or 2")
    return immersion


def cutting_angles(radial_immersion: Array, direction: str) -> tuple[Array, Array]:
    """Entry and exit angles of a tooth, rad, from the feed-normal axis (Appendix A)."""
    lib = namespace(radial_immersion)
    immersion = lib.asarray(radial_immersion, dtype=lib.result_type(float))
    # acos(2a − 1) and acos(1 − 2a) without their loss of digits at both ends.
    sides = lib.sqrt(1 - immersion), lib.sqrt(immersion)
    return (2 * lib.arctan2(*sides), lib.pi) if direction == "down" else (0.0, 2 * lib.arctan2(*sides[::-1]))


def _layout(immersion: float, teeth: int, direction: str) -> Layout:
    arc = 2 * math.atan2(math.sqrt(immersion), math.sqrt(1 - immersion))
    engaged = arc * teeth / (2 * math.pi)
    if abs(engaged - round(engaged)) < 1e-12 and round(engaged) > 0:
        return _WHOLE
    return ("cut", "idle") if engaged < 1 else ("cut", "cut")


@pytree(static=("teeth", "directions", "layout"))
class CuttingForce:
    """b H(t) over one tooth period; tooth j is at the angle 2π (phase + j)/teeth, j = 0, 1, …

    A period that starts when a tooth enters has one further jump, when a tooth leaves.
    """

    depth: Array
    tangential: Array
    normal: Array
    entry: Array
    exit: Array
    teeth: int
    directions: int
    layout: Layout | None

    constant: ClassVar[bool] = False

    def pieces(self) -> tuple[Piece, ...]:
        start = self.entry * self.teeth / (2 * jnp.pi)
        if self.layout == _WHOLE:
            return (Piece(start, 1.0, False),)
        whole, part = self._engaged()
        idle = (whole == 0) if self.layout is None else self.layout[1] == "idle"
        return Piece(start, part, False), Piece(start + part, 1.0 - part, idle)

    def within(self, inside: Array, phase: Array) -> Array:
        """The teeth that are in the cut at the phase ``inside``, wherever they are at the others."""
        pitch = 2 * jnp.pi / self.teeth
        # A whole number of revolutions, so that the angles of a piece that goes on beyond the last are its own.
        order = jnp.arange(self.teeth)[:, None]
        behind = 2 * jnp.pi * jnp.floor(pitch * (inside + order) / (2 * jnp.pi))
        middle, angle = (pitch * (place + order) - behind for place in (inside, phase))
        cutting = (middle >= self.entry) & (middle <= self.exit)
        return self._matrix(jnp.sum(cutting * specific_force(self, angle), axis=-2))

    def at(self, phase: Array) -> Array:
        angle = 2 * jnp.pi / self.teeth * (phase + jnp.arange(self.teeth)[:, None])
        angle = jnp.mod(angle, 2 * jnp.pi)
        cutting = (angle >= self.entry) & (angle <= self.exit)
        return self._matrix(jnp.sum(cutting * specific_force(self, angle), axis=-2))

    def mean(self, start: Array, stop: Array) -> Array:
        pitch = 2 * jnp.pi / self.teeth
        # An interval may reach past the end of the revolution, so the tooth behind is counted there too.
        order = jnp.arange(-self.teeth, self.teeth)[:, None]
        ends = [jnp.clip(pitch * (edge + order), self.entry, self.exit) for edge in (start, stop)]
        work = jnp.sum(specific_work(self, ends[1]) - specific_work(self, ends[0]), axis=-2)
        return self._matrix(work / (pitch * (stop - start)))

    def _engaged(self) -> tuple[Array, Array]:
        """Teeth in the cut just before a tooth enters, and the phase after it at which one leaves."""
        lib = namespace(self.exit, self.entry)
        engaged = (self.exit - self.entry) * self.teeth / (2 * lib.pi)
        if self.layout == _WHOLE:
            return lib.round(engaged), lib.zeros_like(engaged)
        if self.layout == ("cut", "idle"):
            return lib.zeros_like(engaged), engaged
        whole = lib.floor(engaged)
        return whole, engaged - whole

    def _matrix(self, entries: Array) -> Array:
        matrix = self.depth * jnp.moveaxis(entries, 0, -1)
        return matrix.reshape(*np.shape(matrix)[:-1], self.directions, self.directions)


def specific_force(cutting: Any, angle: Array) -> Array:
    """H of one tooth at an angle, N/m², by entry (xx or xx, xy, yx, yy), shape (entries, …).

    Of anything that has ``tangential``, ``normal`` and ``directions``.
    """
    sine, cosine = jnp.sin(angle), jnp.cos(angle)
    along, *across = by_thickness(cutting, sine, cosine)
    if not across:
        return (along * sine)[None]
    return jnp.stack([along * sine, along * cosine, across[0] * sine, across[0] * cosine])


def by_thickness(cutting: Any, sine: Array, cosine: Array) -> tuple[Array, ...]:
    """The force of one tooth per chip thickness and depth, N/m², along the feed and, of two directions, across it.

    Its antiderivative over the angle is that of −cosine and sine.
    """
    along = cutting.tangential * cosine + cutting.normal * sine
    return (along,) if cutting.directions == 1 else (along, cutting.normal * cosine - cutting.tangential * sine)


def specific_work(cutting: Any, angle: Array) -> Array:
    """Antiderivative of ``specific_force`` over the angle."""
    sine = jnp.sin(angle)
    product = sine * sine / 2
    sine_squared = angle / 2 - jnp.sin(2 * angle) / 4
    cosine_squared = angle / 2 + jnp.sin(2 * angle) / 4
    t, n = cutting.tangential, cutting.normal
    entries = [t * product + n * sine_squared]
    if cutting.directions == 2:
        entries += [
            t * cosine_squared + n * product,
            n * product - t * sine_squared,
            n * cosine_squared - t * product,
        ]
    return jnp.stack(entries)
