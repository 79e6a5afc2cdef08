"""Brackets of every change of stability along the gain, from a scan that is finer where a pair may hide."""

from typing import NamedTuple

import numpy as np

from lobex._hidden import doubtful_cells, hidden_sign_changes
from lobex.grids.choice import tolerance_of
from lobex.grids.evaluation import dominant_at_points, dominant_over_grid
from lobex.operators.operator import Method
from lobex.processes.process import Process

_REFINEMENTS = 2
_PARTS = 8
# Growth beyond this is not about to change sign, however it bends.
_FAR = 1.0
# Of the growth at a sample, what its error may be: its sign is sure then, and where it may change it is polished.
_OF_GROWTH = 0.01


class _Samples(NamedTuple):
    """Samples by lane and then by gain, each (p,)."""

    lane: np.ndarray
    gain: np.ndarray
    growth: np.ndarray
    error: np.ndarray


class Brackets(NamedTuple):
    """Pairs of gains between which the growth changes sign, each (e,): lane, gains, growth, and about where it does."""

    lane: np.ndarray
    low: np.ndarray
    high: np.ndarray
    start: np.ndarray
    end: np.ndarray
    guess: np.ndarray


class Scan(NamedTuple):
    """What a scan of n speeds found.

    Attributes:
        stable: whether the lowest gain is stable, (n,).
        failed: the lowest gain at which a sample failed, ∞ where none did, (n,).
        brackets: of the changes of stability.
        samples: how many there are.
        doubtful: at how many of them the estimated error is above the tolerance and leaves stability open.
    """

    stable: np.ndarray
    failed: np.ndarray
    brackets: Brackets
    samples: int
    doubtful: int


def scan_gains(
    process: Process, method: Method, speeds: np.ndarray, gains: np.ndarray, progress: bool, quickly: bool = False
) -> Scan:
    """Scan increasing gains (m,) at speeds (n,), Hz, with programs compiled ``quickly`` or not; call in the scope of
    float64.
    """
    number = np.arange(len(speeds))
    whole = dominant_over_grid(process, speeds, gains, method, progress, _OF_GROWTH, quickly)
    lanes, columns = np.repeat(number, len(gains)), np.tile(gains, len(speeds))
    samples = _Samples(lanes, columns, _log(whole.multiplier.ravel()), whole.error.ravel())
    for _ in range(_REFINEMENTS):
        samples = _finer(process, method, speeds, samples, quickly)
    lane, gain, growth, error = samples
    opening = np.flatnonzero((lane[1:] == lane[:-1]) & (growth[1:] * growth[:-1] < 0))
    following = opening + 1
    failed = np.full(len(speeds), np.inf)
    np.minimum.at(failed, lane[np.isnan(growth)], gain[np.isnan(growth)])
    return Scan(
        stable=growth[np.searchsorted(lane, number)] < 0,
        failed=failed,
        brackets=Brackets(
            lane[opening],
            gain[opening],
            gain[following],
            growth[opening],
            growth[following],
            _crossing(samples, opening),
        ),
        samples=len(lane),
        doubtful=int(np.sum((error > tolerance_of(method)) & ~(error < np.abs(growth)))),
    )


def _crossing(samples: _Samples, opening: np.ndarray) -> np.ndarray:
    """About where the growth is zero after samples (e,): by the cubic through the two on either side, if that lies
    between the two beside it, else by the line through these.
    """
    lane, gain, growth, _ = samples
    beside = np.clip(opening[:, None] + np.arange(-1, 3), 0, len(lane) - 1)
    (_, low, high, _), (_, start, end, _) = gain[beside].T, growth[beside].T
    line = low + (high - low) * start / (start - end)
    # The gain as a function of the growth, by Lagrange; samples of other lanes, or none, make no number of it.
    place = np.where(lane[beside] == lane[opening, None], growth[beside], np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = -place[:, None] / (place[:, :, None] - place[:, None])
        shares[:, np.arange(4), np.arange(4)] = 1
        cubic = np.sum(gain[beside] * np.prod(shares, axis=2), axis=1)
    return np.where((cubic > low) & (cubic < high), cubic, line)


def _finer(process: Process, method: Method, speeds: np.ndarray, samples: _Samples, quickly: bool) -> _Samples:
    """More samples where a pair of changes may hide."""
    lane, gain, growth, _ = samples
    bent = doubtful_cells(lane, gain, np.clip(growth, -_FAR, _FAR))
    cells = np.union1d(hidden_sign_changes(lane, gain, growth)[0], bent)
    if not cells.size:
        return samples
    share = np.arange(1, _PARTS) / _PARTS
    lane = np.repeat(samples.lane[cells], _PARTS - 1)
    gain = (samples.gain[cells, None] + share * (samples.gain[cells + 1] - samples.gain[cells])[:, None]).ravel()
    found = dominant_at_points(process, speeds[lane], gain, method, of_growth=_OF_GROWTH, quickly=quickly)
    more = _Samples(lane, gain, _log(found.multiplier), found.error)
    both = [np.concatenate(pair) for pair in zip(samples, more, strict=True)]
    order = np.lexsort((both[1], both[0]))
    return _Samples(*(part[order] for part in both))


def _log(multiplier: np.ndarray) -> np.ndarray:
    """log |μ|, with exactly 1 taken as just unstable and 0 as far below."""
    with np.errstate(divide="ignore"):
        growth = np.maximum(np.log(np.abs(multiplier)), -1e3)
    return np.where(growth == 0, np.finfo(float).tiny, growth)
