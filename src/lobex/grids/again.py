"""Further points of a chart, by the process and the method that it describes."""

import jax
import numpy as np

from lobex.characteristic.method import CharacteristicRoots
from lobex.grids.choice import tolerance_of
from lobex.grids.evaluation import dominant_at_points
from lobex.grids.finer import LEAST, Sample
from lobex.grids.node_counts import MANY
from lobex.operators.operator import Method
from lobex.processes.process import Process, fine_enough
from lobex.results.chart import Chart
from lobex.results.rebuild import rebuild


def sampler(chart: Chart) -> Sample:
    """log max|μ| at scattered points, as the chart's own were computed and mostly with the same compiled programs.

    Raises:
        ValueError: where the chart's process is not one of lobex's own, and cannot be made again.
    """
    process, method = rebuild(chart.process), rebuild(chart.method)
    # As in a sweep: numbers of another type would be compiled for anew.
    process = jax.tree.map(lambda leaf: np.asarray(leaf, dtype=np.float64), process)
    process = fine_enough(process, chart.speed, chart.gain, tolerance_of(method))

    def sample(speed: np.ndarray, gain: np.ndarray) -> np.ndarray:
        with jax.enable_x64(True):
            if isinstance(method, CharacteristicRoots):
                multiplier = dominant_at_points(process, speed, gain, method).multiplier
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
