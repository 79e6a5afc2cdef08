"""Brackets of every change of stability along the gain, from a scan that is finer where a pair may hide."""

from typing import NamedTuple

import numpy as np

from lobex._hidden import hidden_sign_changes
from lobex.grids.choice import tolerance_of
from lobex.grids.evaluation import dominant_at_points, dominant_over_grid
from lobex.operators.operator import Method
from lobex.processes.process import Process

_REFINEMENTS = 2
_PARTS = 8


class _Samples(NamedTuple):
    """Samples by lane and then by gain, each (p,)."""

    lane: np.ndarray
    gain: np.ndarray
    growth: np.ndarray
    error: np.ndarray
    nodes: np.ndarray


class Brackets(NamedTuple):
    """Pairs of gains between which the growth changes sign, each (e,): lane, gains, growth, and nodes to use."""

    lane: np.ndarray
    low: np.ndarray
    high: np.ndarray
    start: np.ndarray
    end: np.ndarray
    nodes: np.ndarray


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


def scan_gains(process: Process, method: Method, speeds: np.ndarray, gains: np.ndarray, progress: bool) -> Scan:
    """Scan increasing gains (m,) at speeds (n,), Hz; call in the scope of float64."""
    number = np.arange(len(speeds))
    whole = dominant_over_grid(process, speeds, gains, method, progress)
    lanes, columns = np.repeat(number, len(gains)), np.tile(gains, len(speeds))
    samples = _Samples(lanes, columns, _log(whole.multiplier.ravel()), whole.error.ravel(), whole.nodes.ravel())
    for _ in range(_REFINEMENTS):
        samples = _finer(process, method, speeds, samples)
    lane, gain, growth, error, nodes = samples
    opening = np.flatnonzero((lane[1:] == lane[:-1]) & (growth[1:] * growth[:-1] < 0))
    following = opening + 1
    most = np.maximum(nodes[opening], nodes[following])
    failed = np.full(len(speeds), np.inf)
    np.minimum.at(failed, lane[np.isnan(growth)], gain[np.isnan(growth)])
    return Scan(
        stable=growth[np.searchsorted(lane, number)] < 0,
        failed=failed,
        brackets=Brackets(lane[opening], gain[opening], gain[following], growth[opening], growth[following], most),
        samples=len(lane),
        doubtful=int(np.sum((error > tolerance_of(method)) & ~(error < np.abs(growth)))),
    )


def _finer(process: Process, method: Method, speeds: np.ndarray, samples: _Samples) -> _Samples:
    """More samples where a pair of changes may hide."""
    cells, _ = hidden_sign_changes(*samples[:3])
    if not cells.size:
        return samples
    share = np.arange(1, _PARTS) / _PARTS
    lane = np.repeat(samples.lane[cells], _PARTS - 1)
    gain = (samples.gain[cells, None] + share * (samples.gain[cells + 1] - samples.gain[cells])[:, None]).ravel()
    found = dominant_at_points(process, speeds[lane], gain, method)
    more = _Samples(lane, gain, _log(found.multiplier), found.error, found.nodes)
    both = [np.concatenate(pair) for pair in zip(samples, more, strict=True)]
    order = np.lexsort((both[1], both[0]))
    return _Samples(*(part[order] for part in both))


def _log(multiplier: np.ndarray) -> np.ndarray:
    """log |μ|, with exactly 1 taken as just unstable and 0 as far below."""
    with np.errstate(divide="ignore"):
        growth = np.maximum(np.log(np.abs(multiplier)), -1e3)
    return np.where(growth == 0, np.finfo(float).tiny, growth)
