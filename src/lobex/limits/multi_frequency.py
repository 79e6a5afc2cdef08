"""Milling limits from receptances alone: the zero-order and the multi-frequency solution."""

from functools import partial
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Complex, Float

from lobex import _checks
from lobex._timing import timed
from lobex.limits.chattering_mode import no_labels
from lobex.limits.eigenvalue_crossings import NEGATIVE, followed, lowest_on, regenerative
from lobex.limits.receptance_matrix import MatrixCurve
from lobex.limits.tooth_harmonics import ToothHarmonics, harmonics_of, orders_up_to
from lobex.processes.milling import Milling
from lobex.processes.plausible import warn_of_implausible, warn_of_thick
from lobex.processes.process import check_process, check_speed
from lobex.processes.quantity import quantity_of
from lobex.results.codes import Kind, Status
from lobex.results.description import describe
from lobex.results.limit import Limit

# Points of a grid for each tooth passing frequency, beside each resonance, and between two samples.
_PER_PASS, _PER_MODE, _PARTS = 24, 40, 2
# How far beyond the highest natural frequency modes are looked at, and harmonics are kept by default.
_ABOVE, _REACH = 1.5, 4.0
# Of eigenvalues those that matter, the smallest limit being that of one of the largest.
_MOST_BRANCHES = 12


class Found(NamedTuple):
    """A limit at one speed."""

    gain: float
    frequency: float
    kind: Kind


def zero_order_limit(process: Milling, speed: Any) -> Limit:
    """The limit of milling by the mean of its force over a tooth pass (Altintas and Budak, Analytical prediction of
    stability lobes in milling, CIRP Annals 44, 1995).

    With the mean H₀ of the force in place of the periodic one, 1 + b (1 − e^{−jωτ}) μ = 0 with the eigenvalues μ of
    G(ω) H₀, which needs the receptances alone: no modes, and no fit. Of teeth at other angles each has a mean and a
    delay, and −1/b is an eigenvalue of Σ (1 − e^{−jωτᵢ}) G(ω) Hᵢ (Altintas, Engin and Budak, Analytical stability
    prediction and design of variable pitch cutters, J. Manuf. Sci. Eng. 121, 1999). What it neglects is all that the
    coming and going of teeth does: it has no flip lobes, and is good where several teeth cut at a time, and poor at
    small immersion and above the first lobe. ``multi_frequency_limit`` has that, too.

    Args:
        process: ``Milling`` of straight teeth, with modes, or a ``Receptance`` or ``ReceptanceMatrix`` in their place.
        speed: speeds, Hz (revolutions per second), (n,) or one number.

    Returns:
        A ``Limit``; "beyond the measured frequencies" marks a speed without a limit in the band of a measurement.
        ``error`` is NaN: what is neglected is not estimated.

    Raises:
        ValueError: for other processes, in words, and speeds that are not positive and finite.

    Warns:
        LobexWarning: for numbers that can hardly be meant.
    """
    return _limit(process, speed, None, "ZeroOrder")


def multi_frequency_limit(process: Milling, speed: Any, reach: Any = None) -> Limit:
    """The limit of milling by all harmonics of its force, from receptances (Budak and Altintas, Analytical prediction
    of chatter stability in milling, part I, J. Dyn. Syst. Meas. Control 120, 1998).

    The vibration has the frequencies ω + kω_T, ω_T being that of the teeth, of which the force couples each to all
    others by its harmonics H_{k−l}: 1 + b (1 − e^{−jωτ}) μ = 0 with the eigenvalues μ of the matrix of blocks
    H_{k−l} G(ω + lω_T). Of teeth at other angles ω_T is that after which they repeat, each has harmonics and a delay of
    its own, and −1/b is an eigenvalue of Σ Hᵢ_{k−l} (1 − e^{−j(ω + lω_T)τᵢ}) G(ω + lω_T): as many more frequencies take
    longer, and less up to a lower ``reach``. What it neglects are frequencies above ``reach``, or above the
    measured band, where G is taken for zero; below that band G is the mean real part of its first lines. With that, it
    has every lobe, flips included.
    It has no error of its own: ask again with a larger ``reach``.

    Args:
        process: as of ``zero_order_limit``.
        speed: as of ``zero_order_limit``.
        reach: highest frequency of the vibration that is kept, Hz; None for the end of the measured band, or four times
            the highest natural frequency.

    Returns:
        As ``zero_order_limit``; the chatter frequency is that of the largest displacement.

    Raises:
        ValueError: as ``zero_order_limit``, and for a ``reach`` below the resonances.

    Warns:
        LobexWarning: for numbers that can hardly be meant.
    """
    return _limit(process, speed, (reach,), "MultiFrequency")


def _limit(process: Any, speed: Any, reach: tuple[Any] | None, method: str) -> Limit:
    _checks.untraced("a limit from receptances", process=process, speed=speed)
    check_process(process)
    check_speed(process, speed)
    speeds = np.atleast_1d(np.asarray(speed, float))
    if speeds.ndim != 1 or speeds.size == 0:
        raise ValueError(f"speed has shape {np.shape(speed)}; give one speed or a list of them")
    _check(process)
    warn_of_implausible(process, speeds)
    curve = MatrixCurve(process.modes)
    measured = np.isfinite(curve.high)
    settings: dict[str, Any] = {}
    with timed() as spent:
        passing = speeds * process.cutter.alike
        if reach is None:
            found = _of_mean(curve, harmonics_of(process, 0), passing)
        else:
            top = _reach(curve, reach[0])
            settings["reach"] = top / (2 * np.pi)
            forces = harmonics_of(process, len(orders_up_to(top, 2 * np.pi * float(passing.min()))))
            found = [_of_harmonics(curve, forces, 2 * np.pi * one, top) for one in passing]
    gain = np.array([one.gain if one else np.nan for one in found])
    warn_of_thick(process, gain)
    missing = Status.BEYOND_THE_MEASURED_FREQUENCIES if measured else Status.NONE_IN_RANGE
    return Limit(
        speed=speeds,
        gain=gain,
        chatter_frequency=np.array([one.frequency if one else np.nan for one in found]),
        kind_code=np.array([one.kind if one else Kind.NONE for one in found], dtype=np.int8),
        status_code=np.array([Status.FOUND if one else missing for one in found], dtype=np.int8),
        intervals=np.stack([np.where(np.isfinite(gain), 0.0, np.nan), gain], axis=1)[:, None],
        **no_labels(len(speeds))._asdict(),
        error=np.full(len(speeds), np.nan),
        bounds=(0.0, np.inf),
        quantity=quantity_of(process),
        speed_unit=process.speed_unit,
        process=describe(process),
        method={"type": method, **settings},
        seconds=spent.seconds,
        compiling=spent.compiling,
    )


def _check(process: Any) -> None:
    """Require milling of straight teeth at a steady speed, without runout and process damping."""
    if not isinstance(process, Milling):
        raise ValueError(f"process = {type(process).__name__} is no milling; give exact_limit, or lobex.Milling")
    cutter = process.cutter
    others = {
        "a helix": cutter.helix is not None,
        "runout": cutter.runout is not None,
        "serrated teeth": cutter.serrated,
        "edges other than of an end mill": cutter.shaped or cutter.discs is not None,
        "process damping": process.process_damping is not None,
        "a speed that varies": process.speed_variation is not None,
        "modes that follow the speed": hasattr(process.modes, "check_speed"),
    }
    for name, there in others.items():
        if there:
            remedy = "give critical_gain"
            if hasattr(process.modes, "response"):
                remedy += ", with modes fitted by Frf.modes in the place of the measurement"
            raise ValueError(f"process = Milling has {name}, which this solution does not take; {remedy}")


def _reach(curve: MatrixCurve, reach: Any) -> float:
    """The highest frequency that is kept, rad/s."""
    usual = curve.high if np.isfinite(curve.high) else _REACH * float(np.max(curve.resonance))
    if reach is None:
        return usual
    _checks.positive("reach", reach, "Hz")
    _checks.scalar("reach", reach)
    top, least = 2 * np.pi * float(reach), curve.low if np.isfinite(curve.high) else float(np.max(curve.resonance))
    if top <= least:
        raise ValueError(f"reach = {float(reach):.6g} Hz is not above {least / (2 * np.pi):.6g} Hz; give a higher one")
    return min(top, curve.high)


def _of_mean(curve: MatrixCurve, forces: ToothHarmonics, passing: Float[np.ndarray, " n"]) -> list[Found | None]:
    """By the eigenvalues of G H₀, at frequencies of the period, Hz."""
    grid = _along(curve)
    found = []
    known = followed(_of_one_delay(curve, forces, grid)) if forces.alike else np.empty(0)
    for frequency in passing:
        tau = 1 / frequency
        if forces.alike:
            eigenvalues, here, branch, boundary = partial(_of_one_delay, curve, forces), grid, known, regenerative(tau)
        else:
            eigenvalues, boundary = partial(_of_delays, curve, forces, tau), NEGATIVE
            waves = np.arange(grid[0], grid[-1], 2 * np.pi / (_PER_PASS * tau * np.max(forces.share)))
            here = np.union1d(grid, waves)
            branch = followed(eigenvalues(here))
        best = lowest_on(here, branch, boundary, eigenvalues)
        found.append(None if best is None else Found(best[0], best[1] / (2 * np.pi), Kind.HOPF))
    return found


def _of_one_delay(curve: MatrixCurve, forces: ToothHarmonics, omega: np.ndarray) -> Complex[np.ndarray, "k r"]:
    """Eigenvalues of G H₀ at ω."""
    return np.linalg.eigvals(curve(omega) @ forces.mean)


def _of_delays(
    curve: MatrixCurve, forces: ToothHarmonics, period: float, omega: np.ndarray
) -> Complex[np.ndarray, "k r"]:
    """Eigenvalues of Σ (1 − e^{−jωτᵢ}) G Hᵢ at ω."""
    met = 1 - np.exp(-1j * omega[:, None] * period * forces.share)
    return np.linalg.eigvals(curve(omega) @ np.einsum("kt,tij->kij", met, forces.harmonics[:, 0]))


def _along(curve: MatrixCurve) -> Float[np.ndarray, " k"]:
    """Frequencies of the band, dense at resonances, rad/s."""
    if np.isfinite(curve.high):
        parts = np.arange(_PARTS) / _PARTS
        return np.append((curve.knot[:-1, None] + parts * np.diff(curve.knot)[:, None]).ravel(), curve.knot[-1])
    spread = np.sinh(np.linspace(-6, 6, _PER_MODE)) / 6
    near = (curve.resonance[:, None] + curve.width[:, None] * spread).ravel()
    top = _ABOVE * float(np.max(curve.resonance))
    return np.unique(np.r_[near[(near > 0) & (near < top)], np.linspace(0, top, 400)[1:]])


def _of_harmonics(curve: MatrixCurve, forces: ToothHarmonics, passing: float, top: float) -> Found | None:
    """By the eigenvalues of all blocks H_{k−l} G(ω + lω_T), at one frequency of the period ω_T, rad/s."""
    order = orders_up_to(top, passing)
    r, coupling = curve.directions, forces.coupling(order)

    def matrix(omega: np.ndarray) -> np.ndarray:
        lines = omega[:, None] + order * passing
        response = np.where((np.abs(lines) <= top)[..., None, None], curve(lines), 0.0)
        if forces.alike:
            whole = np.einsum("klij,wljm->wkilm", coupling[0], response)
        else:
            met = 1 - np.exp(-2j * np.pi * lines[..., None] / passing * forces.share)
            whole = np.einsum("wlt,tklij,wljm->wkilm", met, coupling, response, optimize=True)
        return whole.reshape(len(omega), len(order) * r, len(order) * r)

    def eigenvalues(omega: np.ndarray) -> np.ndarray:
        found = np.linalg.eigvals(matrix(omega))
        largest = np.argsort(-np.abs(found), axis=1)[:, :_MOST_BRANCHES]
        return np.take_along_axis(found, largest, axis=1)

    half = passing / 2
    grid = _folded(curve, passing, half)
    branch = followed(eigenvalues(grid))
    boundary = regenerative(2 * np.pi / passing) if forces.alike else NEGATIVE
    best = lowest_on(grid[:-1], branch[:-1], boundary, eigenvalues)
    kind = Kind.HOPF
    # The half of the frequency has flips, where 1 − e^{−jωτ} is 2, and of several delays 0 has folds.
    ends = [(Kind.FLIP, half, branch[-1])]
    if not forces.alike:
        ends.append((Kind.FOLD, 0.0, eigenvalues(np.zeros(1))[0]))
    for sort, omega, values in ends:
        real = values[(np.abs(values.imag) < 1e-9 * np.abs(values)) & (values.real < 0)]
        if real.size and (best is None or boundary.gain(real.real.min()) < best[0]):
            best, kind = (float(boundary.gain(real.real.min())), omega), sort
    if best is None:
        return None
    gain, omega = best
    factor = gain * (1 - np.exp(-2j * np.pi * omega / passing) if forces.alike else 1.0)
    # The force that feeds itself, and the frequency at which it moves the structure most.
    values, vectors = np.linalg.eig(matrix(np.array([omega]))[0])
    force = vectors[:, np.argmin(np.abs(1 + factor * values))].reshape(len(order), r)
    lines = omega + order * passing
    moved = np.linalg.norm(np.einsum("lij,lj->li", curve(lines), force), axis=1)
    return Found(gain, float(np.abs(lines[np.argmax(moved)])) / (2 * np.pi), kind)


def _folded(curve: MatrixCurve, passing: float, half: float) -> Float[np.ndarray, " k"]:
    """Frequencies up to half that of the teeth, dense where a resonance lies beside a harmonic, with the half."""
    if np.isfinite(curve.high):
        peak = np.abs(np.einsum("nii->n", curve(curve.knot)))
        tops = np.flatnonzero((peak[1:-1] > peak[:-2]) & (peak[1:-1] > peak[2:])) + 1
        tops = tops[np.argsort(-peak[tops])[:8]]
        resonance, width = curve.knot[tops], np.maximum(0.02 * curve.knot[tops], 2 * np.diff(curve.knot).max())
    else:
        resonance, width = curve.resonance, curve.width
    spread = np.sinh(np.linspace(-5, 5, _PER_MODE)) / 5
    near = np.mod((resonance[:, None] + width[:, None] * spread).ravel(), passing)
    near = np.minimum(near, passing - near)
    grid = np.unique(np.r_[near, np.linspace(0, half, _PER_PASS + 1)])
    return np.append(grid[(grid > 1e-6 * half) & (grid < half * (1 - 1e-9))], half)
