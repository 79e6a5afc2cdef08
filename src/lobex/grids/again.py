"""Further points of a chart, by the process and the method that it describes."""

from collections.abc import Iterator

import jax
import numpy as np

from lobex.characteristic.method import CharacteristicRoots
from lobex.grids.evaluation import dominant_at_points, dominant_over_grid
from lobex.grids.finer import LEAST, Sample
from lobex.grids.refinement import MANY
from lobex.operators.operator import Method
from lobex.processes.process import Process
from lobex.results.chart import Chart
from lobex.results.rebuild import rebuild

# Speeds and gains that are followed at a time, at least: most of the work is the same for few.
_LEAST_BLOCK = 128


def sampler(chart: Chart) -> Sample:
    """log max|μ| at scattered points, as the chart's own were computed and mostly with the same compiled programs.

    Raises:
        ValueError: where the chart's process is not one of lobex's own, and cannot be made again.
    """
    process, method = rebuild(chart.process), rebuild(chart.method)
    # As in a sweep: numbers of another type would be compiled for anew.
    process = jax.tree.map(lambda leaf: np.asarray(leaf, dtype=np.float64), process)

    def sample(speed: np.ndarray, gain: np.ndarray) -> np.ndarray:
        with jax.enable_x64(True):
            if isinstance(method, CharacteristicRoots):
                multiplier = _by_roots(process, method, chart, speed, gain)
            else:
                multiplier = _by_operators(process, method, chart, speed, gain)
        with np.errstate(divide="ignore"):
            return np.maximum(np.log(np.abs(multiplier)), LEAST)

    return sample


def _by_operators(process: Process, method: Method, chart: Chart, speed: np.ndarray, gain: np.ndarray) -> np.ndarray:
    # The lowest speed, and whether points are many, decide which sizes of the operator are compiled.
    many = chart.spectral_radius.size >= MANY
    most = len(speed) if many else MANY - 2
    parts = []
    for begin in range(0, len(speed), max(most, 1)):
        part = np.s_[begin : begin + most]
        count = max(len(speed[part]) + 1, MANY if many else 0)
        speeds = np.resize(np.r_[chart.speed[0], speed[part]], count)
        gains = np.resize(np.r_[chart.gain[0], gain[part]], count)
        found = dominant_at_points(process, speeds, gains, method)
        parts.append(found.multiplier[1 : len(speed[part]) + 1])
    return np.concatenate([*parts, np.empty(0, dtype=complex)])


def _by_roots(
    process: Process, method: CharacteristicRoots, chart: Chart, speed: np.ndarray, gain: np.ndarray
) -> np.ndarray:
    """Neighbouring speeds by all gains that any of them asks for, in blocks of one size."""
    multiplier = np.full(len(speed), np.nan + 0j)
    for these, speeds in _blocks(np.unique(speed), chart.speed):
        here = np.isin(speed, these)
        for those, gains in _blocks(np.unique(gain[here]), chart.gain):
            mine = here & np.isin(gain, those)
            place = np.searchsorted(speeds, speed[mine]), np.searchsorted(gains, gain[mine])
            multiplier[mine] = dominant_over_grid(process, speeds, gains, method, False).multiplier[place]
    return multiplier


def _blocks(wanted: np.ndarray, own: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Parts of increasing values, and each filled up to the same number, from the first of ``own`` to its last."""
    size = max(len(own), _LEAST_BLOCK)
    for begin in range(0, len(wanted), size - 2):
        part = wanted[begin : begin + size - 2]
        full = np.unique(np.r_[own[0], own[-1], part])
        others = np.setdiff1d(np.linspace(own[0], own[-1], 2 * size), full)
        more = np.linspace(0, len(others) - 1, size - len(full)).astype(int)
        yield part, np.sort(np.r_[full, others[more]])
