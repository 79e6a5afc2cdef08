"""Milling limits from receptances alone: the zero-order and the multi-frequency solution."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Complex, Float
from scipy.optimize import brentq, linear_sum_assignment

from lobex import _checks
from lobex._float64 import in_float64
from lobex._timing import timed
from lobex.limits.chattering_mode import no_labels
from lobex.limits.phase import half_turns
from lobex.limits.receptance_matrix import MatrixCurve
from lobex.limits.sections import on_boundary
from lobex.processes.milling import Milling
from lobex.processes.plausible import warn_of_implausible
from lobex.processes.process import check_process, check_speed
from lobex.processes.quantity import quantity_of
from lobex.processes.tooth import Tooth, teeth_of
from lobex.results.codes import Kind, Status
from lobex.results.description import describe
from lobex.results.limit import Limit

# Points of a grid for each tooth passing frequency, beside each resonance, and between two samples.
_PER_PASS, _PER_MODE, _PARTS = 24, 40, 2
# How far beyond the highest natural frequency modes are looked at, and harmonics are kept by default.
_ABOVE, _REACH = 1.5, 4.0
# Of eigenvalues those that matter, the smallest limit being that of one of the largest.
_MOST_BRANCHES = 12
_STILL = 1e-15


class _Boundary(NamedTuple):
    """Where eigenvalues are those of a limit: so many turns at ω are whole there, and the gain by the eigenvalue."""

    turns: Callable[[Any, Any], Any]
    gain: Callable[[Any], Any]


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
            found = _of_mean(curve, forces_of(process, 0), passing)
        else:
            top = _reach(curve, reach[0])
            settings["reach"] = top / (2 * np.pi)
            most = max(int(np.ceil(top / (2 * np.pi * float(passing.min())))), 1)
            forces = forces_of(process, 2 * most)
            found = [_of_harmonics(curve, forces, 2 * np.pi * one, top) for one in passing]
    gain = np.array([one.gain if one else np.nan for one in found])
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


class Forces(NamedTuple):
    """Of the teeth of a period.

    Attributes:
        harmonics: H_k of each per depth of cut, N/m², k = 0, 1, …, (teeth, k, r, r); H_{−k} is the conjugate.
        share: of each its delay, in periods, (teeth,).
    """

    harmonics: Complex[np.ndarray, "teeth k r r"]
    share: Float[np.ndarray, " teeth"]

    @property
    def alike(self) -> bool:
        """Whether the period is the one delay."""
        return len(self.share) == 1

    @property
    def mean(self) -> Complex[np.ndarray, "r r"]:
        """H₀ of all together."""
        return np.sum(self.harmonics[:, 0], axis=0)


def forces_of(process: Milling, most: int) -> Forces:
    """Of the teeth of a process, with harmonics up to ``most``."""
    teeth = list(teeth_of(process, 1.0))
    share = np.array([1.0 if tooth.share is None else float(tooth.share) for tooth in teeth])
    return Forces(np.stack([_harmonics(tooth, most) for tooth in teeth]), share)


@in_float64
def _harmonics(tooth: Tooth, most: int) -> Complex[np.ndarray, "k r r"]:
    order = np.arange(most + 1)
    total = 0
    for piece in tooth.force.pieces():
        start, length = float(piece.start), float(piece.length)
        # Each node sees less than a wave.
        nodes, weights = np.polynomial.legendre.leggauss(24 + 4 * most)
        phase = start + length * (nodes + 1) / 2
        force = np.asarray(tooth.force.within(np.asarray(start + length / 2), phase))
        wave = np.exp(-2j * np.pi * order[:, None] * phase) * weights * length / 2
        total = total + (0 if piece.idle is True else np.einsum("kp,pij->kij", wave, force))
    return np.asarray(total)


def _of_mean(curve: MatrixCurve, forces: Forces, passing: Float[np.ndarray, " n"]) -> list[Found | None]:
    """By the eigenvalues of G H₀, at frequencies of the period, Hz."""
    grid = _along(curve)
    found = []
    known = _followed(_of_one_delay(curve, forces, grid)) if forces.alike else np.empty(0)
    for frequency in passing:
        tau = 1 / frequency
        if forces.alike:
            eigenvalues, here, branch, boundary = partial(_of_one_delay, curve, forces), grid, known, _regenerative(tau)
        else:
            eigenvalues, boundary = partial(_of_delays, curve, forces, tau), _NEGATIVE
            waves = np.arange(grid[0], grid[-1], 2 * np.pi / (_PER_PASS * tau * np.max(forces.share)))
            here = np.union1d(grid, waves)
            branch = _followed(eigenvalues(here))
        best = _lowest(here, branch, boundary, eigenvalues)
        found.append(None if best is None else Found(best[0], best[1] / (2 * np.pi), Kind.HOPF))
    return found


def _of_one_delay(curve: MatrixCurve, forces: Forces, omega: np.ndarray) -> Complex[np.ndarray, "k r"]:
    """Eigenvalues of G H₀ at ω."""
    return np.linalg.eigvals(curve(omega) @ forces.mean)


def _of_delays(curve: MatrixCurve, forces: Forces, period: float, omega: np.ndarray) -> Complex[np.ndarray, "k r"]:
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


def _of_harmonics(curve: MatrixCurve, forces: Forces, passing: float, top: float) -> Found | None:
    """By the eigenvalues of all blocks H_{k−l} G(ω + lω_T), at one frequency of the period ω_T, rad/s."""
    most = max(int(np.ceil(top / passing)), 1)
    order = np.arange(-most, most)
    apart = order[:, None] - order
    r, known = curve.directions, forces.harmonics[:, np.abs(apart)]
    coupling = np.where((apart < 0)[..., None, None], np.conj(known), known)

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
    branch = _followed(eigenvalues(grid))
    boundary = _regenerative(2 * np.pi / passing) if forces.alike else _NEGATIVE
    best = _lowest(grid[:-1], branch[:-1], boundary, eigenvalues)
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


def _followed(values: Complex[np.ndarray, "k n"]) -> Complex[np.ndarray, "k n"]:
    """Eigenvalues in an order in which each goes on from the one before."""
    found = values.copy()
    for i in range(1, len(found)):
        # Where it goes if it goes on as before.
        ahead = found[i - 1] if i == 1 else 2 * found[i - 1] - found[i - 2]
        apart = np.abs(ahead[:, None] - values[i]) + np.abs(found[i - 1][:, None] - values[i])
        found[i] = values[i][linear_sum_assignment(apart)[1]]
    return found


def _regenerative(tau: float) -> _Boundary:
    """Of eigenvalues μ with 1 + b (1 − e^{−jωτ}) μ = 0: ωτ less what the phase asks for is whole."""
    return _Boundary(lambda omega, value: omega * tau / (2 * np.pi) + half_turns(value), on_boundary)


_NEGATIVE = _Boundary(lambda omega, value: np.angle(-value) / (2 * np.pi), lambda real: -1 / real)
"""Of eigenvalues −1/b."""


def _lowest(
    grid: Float[np.ndarray, " k"],
    branch: Complex[np.ndarray, "k n"],
    boundary: _Boundary,
    eigenvalues: Callable[[np.ndarray], np.ndarray],
) -> tuple[float, float] | None:
    """The lowest gain, and its ω, at which an eigenvalue is that of a limit."""
    feeds = np.real(branch) < 0
    turns = boundary.turns(grid[:, None], branch)
    passed = feeds[1:] & feeds[:-1] & (np.floor(turns[1:]) != np.floor(turns[:-1]))
    brackets = []
    for i, j in zip(*np.nonzero(passed), strict=True):
        ends = np.sort(turns[i : i + 2, j])
        for whole in range(int(np.floor(ends[0])) + 1, int(np.floor(ends[1])) + 1):
            share = (whole - turns[i, j]) / (turns[i + 1, j] - turns[i, j])
            value = branch[i, j] + share * (branch[i + 1, j] - branch[i, j])
            brackets.append((boundary.gain(value.real), i, j, whole))
    best: tuple[float, float] | None = None
    for estimate, i, j, whole in sorted(brackets):
        if best is not None and estimate > 1.5 * best[0]:
            break
        gain, omega = _settled(grid[i : i + 2], branch[i : i + 2, j], whole, boundary, eigenvalues)
        if gain > 0 and (best is None or gain < best[0]):
            best = gain, omega
    return best


def _settled(
    ends: Float[np.ndarray, "2"],
    values: Complex[np.ndarray, "2"],
    whole: int,
    boundary: _Boundary,
    eigenvalues: Callable[[np.ndarray], np.ndarray],
) -> tuple[float, float]:
    """A root between two points of a branch; of the eigenvalues there, that nearest to the line between its ends."""
    (low, high), (first, last) = ends.tolist(), values.tolist()

    def value(omega: float) -> complex:
        between = first + (last - first) * (omega - low) / (high - low)
        near = eigenvalues(np.array([omega]))[0]
        return complex(near[np.argmin(np.abs(near - between))])

    off = [float(boundary.turns(omega, one)) - whole for omega, one in ((low, first), (high, last))]
    if off[0] * off[1] >= 0:
        omega = low if off[0] == 0 else high
    else:
        omega: Any = brentq(lambda at: float(boundary.turns(at, value(at))) - whole, low, high, xtol=_STILL * high)
    return float(boundary.gain(np.asarray(value(omega).real))), float(omega)
