"""The exact stability limit of constant regenerative feedback, by D-subdivision.

With the receptance G, the characteristic equation 1 + K G(ω)(1 − e^{−jωτ}) = 0 has an imaginary root jω where
K = −1/(2 Re G), Re G < 0, and ωτ − 2 arg G = (2j + 1)π with arg G in (−2π, 0): the classical lobes (Tlusty and
Poláček, 1963). K = 0 is stable, so the limit at a speed is the least K over all ω and all lobes j = 1, 2, …
As Re G < 0 holds arg G in (−3π/2, −π/2), ωτ lies in ((2j − 2)π, 2jπ), and no other j has a delay above zero. A driving
point, Im G < 0, has the upper half of that alone; where force and displacement have directions of their own, G may
have any argument, and Re G < 0 below the first mode too. Of several contacts, each in its own track, every eigenvalue
of their receptance is such a G.
"""

from functools import partial
from typing import Any, cast

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float, Int

from lobex import _checks
from lobex._batches import in_batches
from lobex._compiled import compiled, compiled_for, compiled_quickly
from lobex._float64 import in_float64
from lobex._missing import where_there, with_stand_in
from lobex._namespace import namespace, still
from lobex._pytree import pytree
from lobex._shapes import AnyArray, ArrayLike, Number, Numbers
from lobex.characteristic.lanes import few
from lobex.limits.above import above
from lobex.limits.closed_form import Contacts, Regeneration, closed_form
from lobex.limits.eigenvalue_branches import along
from lobex.limits.lobe_search import lowest_lobe_point
from lobex.limits.modal_curve import ModalCurve
from lobex.limits.phase import half_turns, phase
from lobex.limits.receptance import Receptance, SampledCurve, receptance
from lobex.limits.receptance_curve import ReceptanceCurve
from lobex.limits.sections import Sections, from_parts, on_boundary, sections_of
from lobex.limits.several_contacts import Branched, branched, settled
from lobex.limits.stretches import Stretches, stretches
from lobex.limits.track_product import Uncoupled
from lobex.limits.tracks_form import Families
from lobex.limits.whole_stage import WholeStage
from lobex.processes.process import Process, check_speed
from lobex.structures.modes import Modes

Source = Modes | Receptance | Regeneration | Contacts | Process

# Speeds that are searched together: their phases at all stretches stay in cache.
_BATCH = 128
# In NumPy, speeds times stretches.
_AT_HAND = 2**20
# Of several contacts: programs are compiled for their number.
_STRETCHES = 4096
MOST_LOBES = 10_000


@pytree()
class ExactCritical:
    """The stability limit at each speed.

    Attributes:
        gain: least gain on the stability boundary: N/m, or m of ``Turning``; NaN where there is none.
        angular_frequency: ω of the motion there, rad/s; NaN where there is none.
        lobe: its lobe number j, 0 where there is none.
        tie: whether another root has the same gain within 1e-9: a cusp between two lobes, where the limit has
            a kink and its derivative is that of one side.
    """

    gain: Float[AnyArray, " *lanes"]
    angular_frequency: Float[AnyArray, " *lanes"]
    lobe: Int[AnyArray, " *lanes"]
    tie: Bool[AnyArray, " *lanes"]

    @property
    def chatter_frequency(self) -> float | Float[AnyArray, " *lanes"]:
        """ω/2π, Hz."""
        return self.angular_frequency / (2 * np.pi)


@pytree()
class ExactBranches:
    """The stability boundary as a curve in ω.

    Attributes:
        gain: gain at each ω: N/m, or m of ``Turning``, shape (n,); NaN where Re G ≥ 0.
        speed: speed at which lobe j passes there, shape (lobes, n), j = 1, 2, …, Hz; NaN where Re G ≥ 0.
    """

    gain: Float[AnyArray, " *points"]
    speed: Float[AnyArray, " lobes *points"]


@pytree()
class ExactMinimum:
    """The least stability limit over all speeds.

    Attributes:
        gain: N/m, or m of ``Turning``; NaN where there is no limit.
        angular_frequency: ω of the motion there, rad/s.
        speed: the speeds at which lobes 1, 2, … have it, shape (lobes,), Hz.
    """

    gain: Float[AnyArray, ""]
    angular_frequency: Float[AnyArray, ""]
    speed: Float[AnyArray, " lobes"]


def exact_branches(source: Source, omega: ArrayLike, lobes: int = 10) -> ExactBranches:
    """Gain and speeds of the stability boundary at given frequencies.

    Args:
        source: what ``exact_limit`` takes, or the ``Modes`` (one contact direction) or ``Receptance`` of a rub.
        omega: ω, shape (n,), rad/s.
        lobes: number of lobes, from the first.

    Raises:
        ValueError: for a source of another kind, several contact directions, or ω not above zero.
    """
    found = source_of(source)
    if isinstance(found, Contacts):
        raise ValueError(f"source = {_checks.brief(source)} has several contact directions; give exact_lobes")
    omega = np.asarray(omega) if isinstance(omega, list | tuple) else omega
    _checks.positive("omega", omega, "rad/s")
    if np.ndim(omega) != 1:
        raise ValueError(f"omega has shape {np.shape(omega)}; give a one-dimensional array")
    return ExactBranches(*_branches(found, omega, _checks.integer("lobes", lobes, 1, MOST_LOBES)))


def branches_of_several(
    sections: Sections, omega: Float[AnyArray, " n"], lobes: int
) -> tuple[Float[np.ndarray, " points"], ExactBranches]:
    """``exact_branches`` of m contacts at ω (n,), and ω with them, (m (n + 1),).

    One eigenvalue of their receptance follows the other, with NaN between them.
    """
    omega, response = along(sections, omega)
    return omega, ExactBranches(*_curves(response, omega, lobes))


def exact_critical(source: Source, speed: ArrayLike, lowest: float | None = None) -> ExactCritical:
    """The stability limit at each speed, to rounding: no discretisation of the delay, no grid of gains.

    The frequency axis is cut, independently of the speed, into stretches where Re G and d arg G/dω are
    monotonic. Within one the phase ωτ − 2 arg G has one extremum at most, so that the root of lowest
    gain is found for certain; stretches are searched in order of the least gain that they can hold, until no
    other can hold a lower one. The stretches of a structure are exact if its grid of 65 points a mode
    separates the zeros of Re G and of those derivatives. Work is bounded; nothing grows with ωτ.

    Differentiable with respect to speed and every number in ``source``, twice: two Newton steps on the root
    carry the derivative. ``jit`` and ``vmap`` work, and inputs under them keep their precision. Of several contacts
    the stretches are those of the eigenvalues of their receptance, see ``eigenvalue_branches``, whose cells depend on
    the numbers: once differentiable, and not within ``jit`` or ``vmap``.

    Args:
        source: what ``exact_limit`` takes, or the ``Modes`` (one contact direction) or ``Receptance`` of a rub.
        speed: speeds in Hz (revolutions per second), any shape.
        lowest: of modes, a gain above zero to search from, one number, in the place of 0.

    Returns:
        ``ExactCritical`` of the shape of ``speed``. Modes have a limit at every speed, and it is 0 where a mode
        without damping gains energy; of a measurement only frequencies within its band are looked at. NaN where the
        gain ``lowest`` is unstable.

    Raises:
        ValueError: for a source of another kind, speeds that are not above zero, not finite, or by their size rpm; and
            for several contacts traced by ``jit`` or ``vmap``, or with ``lowest``.
    """
    found = source_of(source)
    speed = np.asarray(speed) if isinstance(speed, list | tuple) else speed
    check_speed(source, speed)
    if isinstance(found, Contacts):
        if lowest is not None:
            raise ValueError(f"lowest = {lowest!r} is for one contact direction; give None")
        branches, known = branched(found.receptance, speed)
        return ExactCritical(*settled(found.receptance, speed, known, *_critical(branches, known, None)))
    return ExactCritical(*_critical(found, speed, lowest))


def exact_minimum(source: Source, lobes: int = 10) -> ExactMinimum:
    """The least stability limit over all speeds, −1/(2 min Re G), and the speeds at which lobes reach it.

    For one mode of stiffness k it is 2kξ(1 + ξ) at ω = ωₙ√(1 + 2ξ). Differentiable once with respect to every
    number in ``source``. Arguments and errors as for ``exact_branches``; of a process with several contacts it is that
    of all eigenvalues of their receptance, and not differentiable.
    """
    found = source_of(source)
    if isinstance(found, Contacts):
        _checks.untraced("exact_minimum of several contacts", source=source)
        found, _ = branched(found.receptance, np.zeros(1))
    return ExactMinimum(*_minimum(found, _checks.integer("lobes", lobes, 1, MOST_LOBES)))


def source_of(source: Any) -> Regeneration | Contacts:
    """What D-subdivision takes of a process with a closed form, of modes, or of a measured receptance.

    Raises:
        ValueError: for another source.
    """
    if isinstance(source, Regeneration | Contacts):
        return source
    if isinstance(source, Receptance):
        return Regeneration(source, 1.0)
    if isinstance(source, Modes):
        return Regeneration(sections_of(source), 1.0)
    if isinstance(source, type) or not callable(getattr(source, "system", None)):
        raise ValueError(
            f"source = {_checks.brief(source)} has no exact limit; give a process, lobex.Modes or lobex.Receptance"
        )
    found = closed_form(source)
    if isinstance(found, Regeneration | Contacts):
        return found
    if isinstance(found, Uncoupled | Families | WholeStage):
        raise ValueError(f"process = {type(source).__name__} is of blades in each other's track; give exact_limit")
    why = found if isinstance(found, str) else "is Hayes' equation, of which lobex.limits.hayes has the limits"
    raise ValueError(f"process = {type(source).__name__} has no exact limit by D-subdivision: it {why}")


def _curve(source: Regeneration | Branched, *beside: Any) -> ReceptanceCurve:
    """Its receptance, in JAX where that traces numbers beside it."""
    part: Any = source.receptance
    if isinstance(source, Branched):
        return part
    return SampledCurve(part, *beside) if isinstance(part, Receptance) else ModalCurve(part, source.turn)


def _gain(
    curve: ReceptanceCurve,
    row: Int[AnyArray, " *lanes"],
    offset: Float[AnyArray, " *lanes"],
    there: Bool[AnyArray, " *lanes"],
) -> Float[AnyArray, " *lanes"]:
    """Where there is a limit; elsewhere NaN."""
    gain = on_boundary(with_stand_in(there, curve.at(row, offset)[0].real, -1.0))
    # At the pole of an undamped mode: exactly zero, with the derivative by damping that it has.
    return where_there(there, gain - namespace(gain).where(curve.undamped_at(row, offset), still(gain), 0.0))


@in_float64
def _branches(
    source: Regeneration, omega: Numbers, lobes: int
) -> tuple[Float[AnyArray, " *points"], Float[AnyArray, " lobes *points"]]:
    lib = namespace(source, omega)
    at = lib.asarray(omega, dtype=lib.result_type(float))
    gain, speed = _curves(cast(AnyArray, receptance(source.receptance, at)), at, lobes)
    return gain / source.stiffness, speed


def _curves(
    response: Complex[AnyArray, " *points"], omega: Float[AnyArray, " *points"], lobes: int
) -> tuple[Float[AnyArray, " *points"], Float[AnyArray, " lobes *points"]]:
    there = response.real < 0
    real = with_stand_in(there, response.real, -1.0)
    speed = _lobe_speeds(from_parts(real, response.imag), omega, lobes)
    return where_there(there, on_boundary(real)), where_there(there, speed)


def _lobe_speeds(
    response: Complex[AnyArray, " *points"], omega: Float[AnyArray, " *points"], lobes: int
) -> Float[AnyArray, " lobes *points"]:
    numbers = np.arange(1, lobes + 1).reshape(-1, *(1,) * omega.ndim)
    return omega / (2 * np.pi * (numbers - half_turns(response)))


def _stretches(source: Regeneration | Branched) -> Stretches:
    parts = every_stretch(source)
    if not isinstance(source, Branched):
        return parts
    # Of many rows most have none.
    some = few(max(int(np.sum(np.isfinite(parts.gain))), _STRETCHES))
    return jax.tree.map(lambda part: np.asarray(part)[:some], parts)


# Of a structure, whatever is asked of it.
@compiled_quickly
def every_stretch(source: Regeneration | Branched) -> Stretches:
    """The stretches of its receptance."""
    return stretches(_curve(still(source)))


@in_float64
def _critical(
    source: Regeneration | Branched, speed: Numbers, lowest: float | None
) -> tuple[Float[AnyArray, " *lanes"], Float[AnyArray, " *lanes"], Int[AnyArray, " *lanes"], Bool[AnyArray, " *lanes"]]:
    lib = namespace(source, speed, lowest)
    speeds = lib.asarray(speed, dtype=lib.result_type(float))
    if lib is np and not isinstance(source, Branched):
        gain, omega, lobe, tie = (part.reshape(speeds.shape) for part in _at_hand(source, lowest, speeds.ravel()))
        return gain, omega, lobe, tie
    flat, parts, count = speeds.ravel(), _stretches(source), speeds.size
    if lib is jnp and count <= _BATCH:
        results = _limits(source, parts, lowest, flat)
    elif count == 0:
        results = flat, flat, flat.astype(int), flat > 0
    elif lib is jnp:
        # Whole batches only, the last filled up with repeats: a shorter one would be compiled a second time.
        rows = -(-count // _BATCH)
        filled = jnp.concatenate([flat, jnp.broadcast_to(flat[-1], (rows * _BATCH - count,))])
        results = jax.lax.map(partial(_limits, source, parts, lowest), filled.reshape(rows, _BATCH))
    else:
        results = in_batches(lambda _, batch: _limits(source, parts, lowest, batch), (flat,), _BATCH)
    gain, omega, lobe, tie = (r.ravel()[:count].reshape(speeds.shape) for r in results)
    return gain, omega, lobe, tie


def _at_hand(source: Regeneration, lowest: float | None, speed: Float[np.ndarray, " p"]) -> tuple[Any, Any, Any, Any]:
    """As ``_critical`` in NumPy: to compile for so few numbers takes longer."""
    with np.errstate(all="ignore"):
        parts = stretches(_curve(source))
        size = max(_AT_HAND // len(parts.gain), 1)
        batches = [speed[start : start + size] for start in range(0, max(len(speed), 1), size)]
        results = [limit_at(source, parts, lowest, batch) for batch in batches]
    gain, omega, lobe, tie = (np.concatenate(part) for part in zip(*results, strict=True))
    return gain, omega, lobe, tie


@compiled
def _limits(
    source: Regeneration | Branched, parts: Stretches, lowest: Float[Array, ""] | None, speed: Float[Array, " p"]
) -> tuple[Float[AnyArray, " p"], Float[AnyArray, " p"], Int[AnyArray, " p"], Bool[AnyArray, " p"]]:
    """At speeds (b,)."""
    return jax.vmap(partial(limit_at, source, parts, lowest))(speed)


def limit_at(
    source: Regeneration | Branched,
    parts: Stretches,
    lowest: Number | None,
    speed: Float[AnyArray, " *lanes"],
) -> tuple[Float[AnyArray, " *lanes"], Float[AnyArray, " *lanes"], Int[AnyArray, " *lanes"], Bool[AnyArray, " *lanes"]]:
    """Gain, ω, lobe and tie at a speed, Hz, from the stretches of its receptance: of one that JAX traces, or of many in
    NumPy.
    """
    lib, curve = namespace(source, parts, lowest, speed), _curve(source)
    # The search is done with the values alone; the derivative is put on its result.
    bare, bare_speed = _curve(still(source)), still(speed)
    mine, stable = parts, True
    if lowest is not None:
        mine, stable = above(bare, parts, bare_speed, lowest * still(source.stiffness))
    found = lowest_lobe_point(bare, mine, bare_speed)
    offset = _follow(curve, speed, found.row, found.offset)
    exists = stable & (found.gain < lib.inf)
    gain = _gain(curve, found.row, offset, exists) / source.stiffness
    omega = where_there(exists, curve.anchor[found.row] + offset)
    return gain, omega, found.lobe.astype(int), found.tie


def limit_followed(source: Regeneration, speed: Float[Array, ""], omega: Float[Array, ""]) -> Float[AnyArray, ""]:
    """The gain of a limit that was found at ω, as a function of the samples of a measurement and the speed; traced."""
    curve = _curve(source, omega)
    anchor = still(curve.anchor)
    row = jnp.clip(jnp.searchsorted(anchor, omega, side="right") - 1, 0, len(anchor) - 1)
    offset = _follow(curve, speed, row, omega - anchor[row])
    return _gain(curve, row, offset, jnp.isfinite(omega)) / source.stiffness


def _follow(
    curve: ReceptanceCurve, speed: Float[AnyArray, " *lanes"], row: Int[AnyArray, " *lanes"], offset: Any
) -> Float[AnyArray, " *lanes"]:
    """The root's offset as a function of speed and curve: two Newton steps, exact to the second derivative."""
    level = still(phase(curve, speed, row, offset)[0])
    for _ in range(2):
        value, slope, _ = phase(curve, speed, row, offset)
        offset = offset - (value - level) / namespace(slope).where(slope == 0, 1.0, slope)
    return offset


@in_float64
def _minimum(
    source: Regeneration | Branched, lobes: int
) -> tuple[Float[AnyArray, ""], Float[AnyArray, ""], Float[AnyArray, " lobes"]]:
    return _least(source, _stretches(source), lobes)


@compiled_for("lobes")
def _least(
    source: Regeneration | Branched, parts: Stretches, lobes: int
) -> tuple[Float[AnyArray, ""], Float[AnyArray, ""], Float[AnyArray, " lobes"]]:
    curve = _curve(source)
    lowest = jax.tree.map(lambda a: a[0], parts)
    row, offset = lowest.row, lowest.low
    _, slope, bend = curve.at(row, offset)
    # At an end of a measured band the minimum is no zero of the slope, and stays where it is.
    step = slope.real / jnp.where(bend.real == 0, 1.0, bend.real)
    step = jnp.where(jnp.abs(step) < 1e-6 * (curve.anchor[row] + offset), step, 0.0)
    offset = offset - step
    exists = lowest.gain < jnp.inf
    omega = curve.anchor[row] + offset
    response = with_stand_in(exists, curve.at(row, offset)[0], -1.0)
    gain = _gain(curve, row, offset, exists) / source.stiffness
    speed = _lobe_speeds(response, omega, lobes)
    return (
        gain,
        where_there(exists, omega),
        where_there(exists, speed),
    )
