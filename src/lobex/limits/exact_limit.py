"""The exact stability limit of a process as a ``Limit``, and its lobes as curves."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from lobex import _checks
from lobex._float64 import in_float64
from lobex._missing import where_there
from lobex._namespace import namespace
from lobex._pytree import pytree
from lobex._shapes import AnyArray
from lobex._timing import timed
from lobex.limits.chattering_mode import Labels, labels_of, labels_of_families, no_labels
from lobex.limits.closed_form import Contacts, Form, Rate, Regeneration, closed_form, closed_forms
from lobex.limits.d_subdivision import (
    MOST_LOBES,
    ExactMinimum,
    branches_of_several,
    exact_branches,
    exact_critical,
    exact_minimum,
    source_of,
)
from lobex.limits.each_structure import limits_of_each
from lobex.limits.hayes import hayes_interval
from lobex.limits.modal_curve import ModalCurve
from lobex.limits.receptance import Receptance
from lobex.limits.sections import Sections
from lobex.limits.track_product import Uncoupled, limits_of_tracks
from lobex.limits.tracks_form import Families
from lobex.limits.undamped import undefined
from lobex.limits.whole_stage import WholeStage, limits_of_stage
from lobex.processes.at_speeds import at_speed, has_followers, tabled
from lobex.processes.declared import check_system
from lobex.processes.plausible import warn_of_implausible, warn_of_thick
from lobex.processes.process import Process, check_process, check_speed
from lobex.processes.quantity import quantity_of
from lobex.results.codes import Kind, Status
from lobex.results.description import describe
from lobex.results.limit import Limit

# Rounding of the closed form: the bound that tests hold it to.
_RELATIVE_ERROR = 1e-12
# Families of waves whose limits are as near to each other are a tie.
_TIE = 1e-9
_REACH = 3.0
_FILL = 6


@pytree()
class ExactLobes:
    """The stability boundary as curves over ω: every lobe is (speed[j − 1], gain).

    Attributes:
        angular_frequency: ω, increasing, (n,), rad/s; of several contacts so for each eigenvalue of their receptance,
            one after the other with a gap of NaN between.
        gain: (n,), N/m or m; NaN where no gain is on the boundary.
        speed: speeds at which lobes 1, 2, … pass there, (lobes, n), Hz.
        minimum: the least limit over all speeds, with its speeds.
    """

    angular_frequency: Float[AnyArray, " points"]
    gain: Float[AnyArray, " points"]
    speed: Float[AnyArray, "lobes points"]
    minimum: ExactMinimum


def exact_limit(process: Process, speed: Any) -> Limit:
    """The stability limit in closed form: forces K [y − y(t − τ)] and any number of modes.

    D-subdivision over all lobes and modes, of ``Rub`` and ``Turning``, with modes or with a measured ``Receptance`` in
    their place, and of any process whose equations say the same: constant coefficients that are proportional to the
    gain, one delay, which is the period and one revolution, and a structure that is stable by itself and follows
    neither speed nor gain; or whose modes follow the speed (``RotatingModes``, ``ModesOverSpeed``), which are taken at
    each. Hayes' limits for a single state, such as ``Scalar``, whose ``gain`` is the upper one. Several contacts, each
    in its own track, are as many of one with the eigenvalues of their receptance for a receptance: modes with damping
    and several directions, or forces −K W [y − y(t − τ)] with any matrix W. Blades each in the track of the one before
    it, of any ``Blading``. Good to 1e-12 relative, and differentiable with respect to speed and every number in the
    process; of several contacts and blades once, and outside ``jit`` and ``vmap``; not of blades that are coupled
    through the disc without being alike.
    ``intervals`` holds the stable interval below the limit; whether the process is stable again above it is not looked
    at.

    Args:
        process: ``Rub``, ``Turning``, ``Scalar``, or one of your own of that form.
        speed: speeds, Hz (revolutions per second), (n,) or one number.

    Returns:
        A ``Limit``; status "tie" marks a cusp between two lobes, or two eigenvalues with the same limit, where the
        derivative is that of one side, "beyond the measured frequencies" a speed without a limit in the band of a
        ``Receptance``, and "undefined" one at which a mode without damping turns a whole number of times per
        revolution, see ``lobex.limits.undamped``.

    Raises:
        ValueError: for a process of another form, such as one with periodic coefficients, in words; and for speeds
            that are not positive and finite.

    Warns:
        LobexWarning: for numbers that can hardly be meant: speeds in rpm, damping in per cent.
    """
    check_process(process)
    check_speed(process, speed)
    lib: Any = jnp if _checks.is_traced((process, speed)) else np
    speed = jnp.atleast_1d(jnp.asarray(speed)) if _checks.is_traced(speed) else np.atleast_1d(np.asarray(speed, float))
    if np.ndim(speed) != 1 or np.size(speed) == 0:
        raise ValueError(f"speed has shape {np.shape(speed)}; give one speed or a list of them")
    check_system(process, speed)
    warn_of_implausible(process, speed)
    with timed() as spent:
        if has_followers(process):
            parts = _at_each(tabled(process, speed), speed)
        else:
            parts = _limits_of(_form_of(process), speed)
    gain, frequency, low = (where_there(~parts.neutral, part) for part in (parts.gain, parts.frequency, parts.low))
    warn_of_thick(process, gain)
    there = lib.isfinite(gain)
    status = lib.where(there, lib.where(parts.tie, int(Status.TIE), int(Status.FOUND)), parts.missing)
    status = lib.where(parts.neutral, int(Status.UNDEFINED), status)
    return Limit(
        speed=speed,
        gain=gain,
        chatter_frequency=frequency,
        kind_code=lib.where(there, parts.kind, int(Kind.NONE)).astype("int8"),
        status_code=status.astype("int8"),
        intervals=lib.stack([where_there(there, low), gain], axis=-1)[:, None],
        **parts.labels._asdict(),
        error=_RELATIVE_ERROR * lib.abs(gain),
        bounds=(-np.inf if process.gain.signed else 0.0, np.inf),
        quantity=quantity_of(process),
        speed_unit=process.speed_unit,
        process={"type": type(process).__name__} if lib is jnp else describe(process),
        method={"type": "DSubdivision"},
        seconds=spent.seconds,
        compiling=spent.compiling,
    )


def exact_lobes(process: Process, lobes: int = 10) -> ExactLobes:
    """The boundary of stability as one curve per lobe, for plots, with the least limit over all speeds.

    Args:
        process: ``Rub`` or ``Turning``, with modes or a measured ``Receptance``, or one of your own of that form.
        lobes: number of lobes, from the first, the one of highest speed.

    Raises:
        ValueError: for any other process, or fewer than one lobe.

    Warns:
        LobexWarning: for damping that can only be in per cent.
    """
    check_process(process)
    _checks.untraced("exact_lobes", process=process)
    found = source_of(process)
    warn_of_implausible(process, [])
    omega = _frequencies(found.receptance)
    if isinstance(found, Contacts):
        lobes = _checks.integer("lobes", lobes, 1, MOST_LOBES)
        omega, curves = branches_of_several(found.receptance, omega, lobes)
    else:
        curves = exact_branches(found, omega, lobes)
    return ExactLobes(omega, curves.gain, curves.speed, exact_minimum(found, lobes))


class _Limits(NamedTuple):
    """Of one structure at speeds, (n,): limits, whether they are undefined, and what to say where there is none."""

    gain: Float[AnyArray, " n"]
    frequency: Any
    low: Float[AnyArray, " n"]
    tie: Bool[AnyArray, " n"]
    neutral: Bool[AnyArray, " n"]
    kind: Int[AnyArray, " n"]
    missing: Int[AnyArray, " n"]
    labels: Labels


def _at_each(process: Process, speed: Float[AnyArray, " n"]) -> _Limits:
    """Of a structure that follows the speed: those that have one contact at all speeds together."""
    forms = closed_forms([at_speed(process, speed[i]) for i in range(np.size(speed))])
    if isinstance(forms, str):
        raise _refused(process, forms)
    lib = namespace(forms, speed)
    if isinstance(forms[0], Families):
        receptance = jax.tree.map(lambda *leaves: lib.stack(leaves), *(form.receptance for form in forms))
        return _of_families(forms[0]._replace(receptance=receptance), speed)
    if isinstance(forms[0], Regeneration):
        sources = jax.tree.map(lambda *leaves: lib.stack(leaves), *forms)
        gain, omega, tie = limits_of_each(sources, np.arange(len(forms)), speed)
        return _of_one_contact(gain, omega, tie, labels_of(sources, gain, omega))
    each = [_limits_of(form, speed[i : i + 1]) for i, form in enumerate(forms)]
    return jax.tree.map(lambda *part: lib.concatenate(part), *each)


def _of_one_contact(gain: Any, omega: Any, tie: Any, labels: Labels) -> _Limits:
    lib = namespace(gain, omega)
    none, everywhere = lib.zeros(np.shape(gain)), lib.ones(np.shape(gain), int)
    return _Limits(
        gain,
        omega / (2 * np.pi),
        none,
        tie,
        none > 0,
        everywhere * Kind.HOPF,
        everywhere * Status.NONE_IN_RANGE,
        labels,
    )


def _form_of(process: Process) -> Form:
    found = closed_form(process)
    if isinstance(found, str):
        raise _refused(process, found)
    return found


def _refused(process: Process, why: str) -> ValueError:
    return ValueError(f"process = {type(process).__name__} has no exact limit, since it {why}; give critical_gain")


def _of_families(found: Families, speed: Float[AnyArray, " n"]) -> _Limits:
    """The least limit of all numbers of waves around the disc, of one structure or, with a leading axis in all fields
    of its receptance, of one for each speed.
    """
    lib, families, count = namespace(found, speed), found.blades, np.size(speed)
    seen = found.receptance
    each = np.ndim(seen.angular_frequency) == 3
    rows = count if each else 1
    sources = Regeneration(
        jax.tree.map(lambda part: part.reshape(rows * families, -1), seen),
        lib.ones(rows * families),
        lib.asarray(np.tile(found.turn, rows)),
    )
    number = np.arange(families)[:, None] + families * np.arange(count) * each
    gain, omega, tie = (
        part.reshape(families, -1)
        for part in limits_of_each(sources, number.ravel(), families * lib.tile(speed, families))
    )
    least = lib.argmin(lib.where(lib.isfinite(gain), gain, lib.inf), axis=0)[None]
    gain_of, omega_of, tie_of = (lib.take_along_axis(part, least, axis=0)[0] for part in (gain, omega, tie))
    same = lib.sum(gain <= gain_of * (1 + _TIE), axis=0) > 1
    waves = np.asarray(least)[0] if found.even and not _checks.is_traced(least) else np.full(count, -1)
    if each and not _checks.is_traced(seen):
        seen = jax.tree.map(lambda part: np.asarray(part)[np.arange(count), np.maximum(waves, 0)], seen)
        labels = labels_of(Regeneration(seen, 1.0), gain_of, omega_of)
        labels = labels._replace(nodal_diameter=np.where(labels.mode > 0, waves, -1))
    else:
        labels = labels_of_families(seen, waves, gain_of, omega_of)
    return _of_one_contact(gain_of, omega_of, tie_of | same, labels)


def _limits_of(found: Form, speed: Float[AnyArray, " n"]) -> _Limits:
    lib = namespace(found, speed)
    if isinstance(found, Families):
        return _of_families(found, speed)
    if isinstance(found, Uncoupled):
        gain, omega, tie = limits_of_tracks(found, speed)
        return _of_one_contact(gain, omega, tie, labels_of(found, gain, omega))
    if isinstance(found, WholeStage):
        gain, omega, tie = limits_of_stage(found, speed)
        return _of_one_contact(gain, omega, tie, labels_of(found, gain, omega))
    none, nowhere = lib.zeros(speed.shape), lib.zeros(speed.shape, bool)
    everywhere = lib.ones(speed.shape, int)
    if isinstance(found, Rate):
        interval = hayes_interval(found.own, speed)
        low, gain = interval.lower / found.delayed, interval.upper / found.delayed
        return _Limits(
            gain,
            none,
            low,
            nowhere,
            nowhere,
            everywhere * Kind.FOLD,
            everywhere * Status.NONE_IN_RANGE,
            no_labels(np.size(speed)),
        )
    by_lobes = exact_critical(found, speed)
    seen = found.receptance
    missing = Status.BEYOND_THE_MEASURED_FREQUENCIES if isinstance(seen, Receptance) else Status.NONE_IN_RANGE
    neutral = undefined(seen, speed) if isinstance(found, Regeneration) and isinstance(seen, Sections) else nowhere
    parts = by_lobes.gain, by_lobes.chatter_frequency, none, by_lobes.tie, neutral
    labels = labels_of(found, by_lobes.gain, by_lobes.angular_frequency)
    return _Limits(*parts, everywhere * Kind.HOPF, everywhere * missing, labels)


@in_float64
def _frequencies(source: Sections | Receptance) -> Float[AnyArray, " points"]:
    """Frequencies dense at the resonances, up to three times the highest."""
    if isinstance(source, Receptance):
        knots = 2 * np.pi * np.asarray(source.frequency)
    else:
        curve = ModalCurve(source)
        row, offset = curve.grid()
        knots = np.sort(curve.anchor[row] + offset)
        knots = knots[(knots > 0) & (knots < _REACH * np.max(curve.anchor))]
    parts = np.arange(_FILL) / _FILL
    filled = (knots[:-1, None] + parts * np.diff(knots)[:, None]).ravel()
    return np.unique(np.append(filled, knots[-1]))
