"""``recommend``: the cuts of highest removal rate that keep all limits."""

import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float, Int

from lobex import _checks
from lobex._float64 import at_once, widened
from lobex._timing import timed
from lobex._warnings import SweepWarning, warn
from lobex.grids.evaluation import dominant_at_points, dominant_over_grid
from lobex.motions.cut_along import furthest_of
from lobex.motions.forced_motion import BATCH, check_moves, orbit
from lobex.operators.duhamel import Duhamel
from lobex.processes.process import check_gain, check_process, check_speed, fine_enough
from lobex.processes.quantity import quantity_of
from lobex.processes.teeth_at_work import Toothed
from lobex.results.codes import Binding, OrbitStatus
from lobex.results.description import describe
from lobex.results.recommendation import Recommendation

# Speeds looked at first: so many a lobe, and not fewer or more than these.
_A_LOBE, _FEWEST, _MOST = 12, 33, 193
# Then around each of the best, so many between its neighbours, so often.
_AROUND, _ROUNDS = 7, 3
# Steps towards the depth at which a limit binds, and how near is enough, while speeds are compared and in the end.
_STEPS, _ROUGH, _NEAR = 24, 1e-3, 1e-6
# Depths of the scan for stability limits.
_SCAN = 33
# Of the rate, what leaving all of the stability limit is worth: of cuts that are alike the safest is taken.
_SAFE = 1e-3

Depths = Float[np.ndarray, " p"]


class _Limits(NamedTuple):
    """Of mean power, W, of the largest torque, N m, and of the location error, m; infinite where there is none."""

    power: float
    torque: float
    location_error: float


_BY_LIMIT = (Binding.POWER, Binding.TORQUE, Binding.LOCATION_ERROR)


class _Deepest(NamedTuple):
    """At p speeds the depth that keeps all limits, m, what binds, and the stability limit, m."""

    depth: Depths
    binding: Int[np.ndarray, " p"]
    stable: Depths


def recommend(
    process: Any,
    speed: Any,
    depth: Any,
    *,
    power: float | None = None,
    torque: float | None = None,
    location_error: float | None = None,
    margin: float = 0.1,
    count: int = 3,
) -> Recommendation:
    """The cuts of highest removal rate that keep all limits, best first: each is the best between its neighbours.

    At every speed the depth is one up to which the cut is stable, at which it keeps all limits, and the first of them
    binds; what lies above is not looked at, stable islands included. Speeds are scanned, equally spaced in 1/speed, and
    then sought more finely around the best.

    Args:
        process: a process with teeth, a feed and a diameter: ``Milling(…, feed_per_tooth=1e-4)``.
        speed: lowest and highest speed, Hz (revolutions per second).
        depth: lowest and highest depth of cut, m.
        power: of the spindle, W: the mean over the period stays below.
        torque: of the spindle, N m: the largest of the period stays below.
        location_error: m: so far at most the finished wall lies from where it should, on either side.
        margin: the share of every limit, that of stability included, that is left.
        count: of cuts, at most.

    Returns:
        A ``Recommendation``.

    Raises:
        ValueError: for ranges that are empty, limits that are not above zero, a margin that is not from 0 to below 1,
            a process without teeth, feed or diameter, and where no cut keeps the limits.

    Warns:
        SweepWarning: where a tooth leaves the cut in one of the cuts, or its motion is not as exact as asked.
    """
    check_process(process)
    _check_removes(process)
    _checks.untraced("recommend", process=process, speed=speed, depth=depth)
    speeds, depths = (_range(name, part, unit) for name, part, unit in (("speed", speed, "Hz"), ("depth", depth, "m")))
    check_speed(process, speeds)
    check_gain(process, depths)
    limits = _Limits(
        *(
            _limit(name, part, unit)
            for name, part, unit in (
                ("power", power, "W"),
                ("torque", torque, "N m"),
                ("location_error", location_error, "m"),
            )
        )
    )
    share = _checks.as_numbers("margin", margin)
    if share is None or share.ndim or not 0 <= share < 1:
        raise ValueError(f"margin = {_checks.brief(margin)} must be a share of the limits, from 0 to below 1")
    count = _checks.integer("count", count, 1)
    rate: Callable[[Any, Any], np.ndarray] = process.removal_rate
    rate(speeds[0], depths[0])
    if np.isfinite(limits.location_error) and np.isnan(process.left_standing(depths[0], np.zeros(1))[1]).any():
        raise ValueError(
            f"location_error = {limits.location_error:.6g} limits a wall of which modes along the feed alone know "
            "nothing; give modes of two directions, such as lobex.Modes.plane(x=…, y=…)"
        )
    left = 1 - float(share)

    def deepest(at: np.ndarray, near: float = _ROUGH) -> tuple[_Deepest, np.ndarray]:
        """What is deepest at speeds, and how good that is."""
        found = _deepest(process, at, depths, limits, left, near)
        free = 1 - found.depth / np.where(np.isnan(found.stable), depths[1] / left, found.stable)
        return found, np.nan_to_num(rate(at, found.depth) * (1 + _SAFE * free), nan=-1.0)

    with timed() as spent, warnings.catch_warnings():
        warnings.simplefilter("ignore", SweepWarning)
        scanned = _scanned(process, speeds)
        found, worth = deepest(scanned)
        if not np.isfinite(found.depth).any():
            raise ValueError(
                f"depth = {depths[0]:.6g} m or more keeps the limits at no speed from {speeds[0]:.6g} to "
                f"{speeds[1]:.6g} Hz; give a lower depth, or other limits"
            )
        best = _best(worth, count)
        middle, step = scanned[best], np.gradient(scanned)[best]
        for _ in range(_ROUNDS):
            around = np.clip(middle[:, None] + step[:, None] * np.linspace(-1, 1, _AROUND), *speeds)
            near = deepest(around.ravel())[1].reshape(around.shape)
            middle, step = around[np.arange(len(best)), np.argmax(near, axis=1)], 2 * step / (_AROUND - 1)
        last, worth = deepest(middle, _NEAR)
        order = np.argsort(-worth)
        middle, last = middle[order], _Deepest(*(part[order] for part in last))
        motion = _motion(process, middle, last.depth)
    for code, words in (
        (OrbitStatus.TOOTH_LEAVES_THE_CUT, "let a tooth leave the cut: force, power and wall are those without that"),
        (OrbitStatus.ABOVE_TOLERANCE, "have an estimated error above the tolerance"),
    ):
        if number := int(np.sum(motion.status_code == code)):
            warn(f"{number} of {len(middle)} cuts {words}", SweepWarning)
    return Recommendation(
        speed=middle,
        depth=last.depth,
        removal_rate=np.asarray(rate(middle, last.depth)),
        stability_margin=1 - last.depth / last.stable,
        mean_power=motion.power,
        highest_torque=motion.torque,
        location_error=motion.location_error,
        binding_code=last.binding.astype(np.int8),
        status_code=motion.status_code,
        scanned_speed=scanned,
        scanned_depth=found.depth,
        scanned_binding_code=found.binding.astype(np.int8),
        power=limits.power,
        torque=limits.torque,
        location_error_limit=limits.location_error,
        margin=float(share),
        quantity=quantity_of(process),
        speed_unit=process.speed_unit,
        process=describe(process),
        seconds=spent.seconds,
        compiling=spent.compiling,
    )


def _check_removes(process: Any) -> None:
    """Require teeth of which it is known what they do, and what says how much they remove."""
    if not isinstance(process, Toothed) or not callable(getattr(process, "removal_rate", None)):
        raise ValueError(f"process = {_checks.brief(process)} removes nothing; give one with teeth, lobex.Milling(…)")
    if not process.tells_of_teeth:
        raise ValueError(
            f"process = {_checks.brief(process)} does not tell what its teeth do; give a cylindrical cutter about its "
            "own axis, a steady speed and modes along x and y"
        )
    check_moves(process)


def _range(name: str, value: Any, unit: str) -> np.ndarray:
    """The two ends of a range."""
    ends = _checks.as_numbers(name, value, unit)
    if ends is None or ends.shape != (2,) or not ends[0] < ends[1]:
        raise ValueError(f"{name} = {_checks.brief(value)} must be a range in {unit}, its lowest and its highest value")
    return ends


def _limit(name: str, value: Any, unit: str) -> float:
    """A limit; infinite where there is none."""
    if value is None:
        return np.inf
    _checks.positive(name, value, unit)
    _checks.scalar(name, value)
    return float(value)


def _scanned(process: Any, speeds: np.ndarray) -> np.ndarray:
    """Speeds to look at first: lobes are equally spaced in 1/speed."""
    fastest = getattr(getattr(process, "modes", None), "frequency", None)
    lobes = 0.0 if fastest is None else float(np.max(fastest)) / process.teeth * (1 / speeds[0] - 1 / speeds[1])
    number = int(np.clip(np.ceil(_A_LOBE * lobes), _FEWEST, _MOST))
    # The ends to the last digit.
    return np.r_[speeds[0], 1 / np.linspace(1 / speeds[0], 1 / speeds[1], number)[1:-1], speeds[1]]


def _best(worth: np.ndarray, count: int) -> np.ndarray:
    """Where something is worth more than at both neighbours, best first, (up to count,)."""
    known = np.r_[-1.0, worth, -1.0]
    tops = np.flatnonzero((worth > known[:-2]) & (worth >= known[2:]) & (worth >= 0))
    return tops[np.argsort(-worth[tops], kind="stable")][:count]


def _deepest(
    process: Any, speeds: np.ndarray, depths: np.ndarray, limits: _Limits, left: float, near: float
) -> _Deepest:
    """At speeds the depth in the range ``depths`` that keeps the share ``left`` of all limits, to a share ``near``."""
    stable = _stable(process, speeds, float(depths[0]), float(depths[1] / left), near)
    within = np.minimum(left * stable, depths[1])
    binding = np.where(left * stable <= depths[1], int(Binding.STABILITY), int(Binding.RANGE))
    within[~(within >= depths[0])] = np.nan
    bounds = left * np.array(limits)[:, None]

    def shares(depth: np.ndarray, where: np.ndarray) -> np.ndarray:
        """Of what the limits leave that is taken, by limit, (3, p); infinite where nothing is known."""
        motion = _motion(process, speeds[where], depth)
        taken = np.abs(np.stack(motion[:3]))
        return np.where(np.isinf(bounds), 0.0, np.nan_to_num(taken / bounds, nan=np.inf))

    lanes = np.flatnonzero(np.isfinite(within))
    if np.isfinite(limits).any() and len(lanes):
        top = shares(within[lanes], lanes)
        over = np.max(top, axis=0) > 1
        lanes = lanes[over]
        if len(lanes):
            low = np.full(len(lanes), depths[0])
            within[lanes], which = _where_binding(shares, lanes, low, within[lanes], top[:, over], near)
            binding[lanes] = np.array(_BY_LIMIT)[which]
    return _Deepest(within, binding, np.where(np.isinf(stable), np.nan, stable))


def _stable(process: Any, speeds: np.ndarray, low: float, high: float, near: float) -> Depths:
    """The lowest depth in a range at which each speed turns unstable; infinite where none does, NaN at once."""
    scan = np.linspace(low, high, _SCAN)
    method = Duhamel()
    with at_once():
        wide = fine_enough(widened(process), speeds, scan, method.tolerance)
        radius = np.abs(dominant_over_grid(wide, speeds, scan, method, progress=False).multiplier)

        def shares(depth: np.ndarray, where: np.ndarray) -> np.ndarray:
            return np.abs(dominant_at_points(wide, speeds[where], depth, method).multiplier)[None]

        unstable = ~(radius < 1)
        first = np.argmax(unstable, axis=1)
        found = np.where(unstable.any(axis=1), np.where(first > 0, 0.0, np.nan), np.inf)
        lanes = np.flatnonzero(found == 0)
        if len(lanes):
            over = radius[lanes, first[lanes]][None]
            below = scan[first[lanes] - 1]
            found[lanes] = _where_binding(shares, lanes, below, scan[first[lanes]], over, near)[0]
    return found


def _where_binding(
    shares: Callable[[np.ndarray, np.ndarray], np.ndarray],
    lanes: np.ndarray,
    low: Depths,
    high: Depths,
    top: Float[np.ndarray, "l p"],
    near: float,
) -> tuple[Depths, Int[np.ndarray, " p"]]:
    """A depth at which a limit binds, and which does, from ``low``, where none should, to ``high``, where one does.

    By the rule of false position, of which an end that stays counts half (Illinois); NaN where one binds at ``low``.
    """
    bottom = shares(low, lanes)
    ends, values = np.stack([low, high]), np.stack([np.max(bottom, axis=0), np.max(top, axis=0)]) - 1
    which, moved = np.argmax(top, axis=0), np.full(len(lanes), -1)
    left = possible = np.flatnonzero(values[0] <= 0)
    for _ in range(_STEPS):
        if not len(left):
            break
        (a, b), (below, above) = ends[:, left], values[:, left]
        with np.errstate(invalid="ignore"):
            middle = np.where(np.isfinite(above), b - above * (b - a) / (above - below), (a + b) / 2)
        found = shares(middle, lanes[left])
        value = np.max(found, axis=0) - 1
        # The end to move.
        end = np.where(value <= 0, 0, 1)
        again = left[end == moved[left]], 1 - end[end == moved[left]]
        values[again[::-1]] /= 2
        ends[end, left], values[end, left], which[left], moved[left] = middle, value, np.argmax(found, axis=0), end
        left = left[(value > 0) | (value < -near)]
        left = left[ends[1, left] - ends[0, left] > near * ends[1, left]]
    result = np.full(len(lanes), np.nan)
    result[possible] = ends[0, possible]
    return result, which


class _Motion(NamedTuple):
    """What limits ask of motions, p of them: W, N m, m, and members of ``OrbitStatus``."""

    power: Float[np.ndarray, " p"]
    torque: Float[np.ndarray, " p"]
    location_error: Float[np.ndarray, " p"]
    status_code: Int[np.ndarray, " p"]


def _motion(process: Any, speeds: np.ndarray, depths: np.ndarray) -> _Motion:
    """At p points; what is left of all teeth and heights that which is furthest from zero."""
    # So many that one program serves all calls.
    filled = np.resize(np.arange(len(speeds)), max(len(speeds), BATCH))
    motion: Any = orbit(process, speeds[filled], depths[filled], phase=[0.0])
    wall: Any = furthest_of(motion.surface_location_error, np)
    parts = motion.mean_power, motion.highest_torque, wall, motion.status_code
    return _Motion(*(part[: len(speeds)] for part in parts))
