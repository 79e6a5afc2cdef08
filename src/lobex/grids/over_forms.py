"""The dominant multiplier over grids and at points, where more is known of a process at some gains than at others."""

from collections.abc import Callable
from functools import partial

import numpy as np

from lobex.grids.dominant import Dominant
from lobex.grids.refinement import Refinement
from lobex.operators.duhamel import Duhamel
from lobex.processes.process import Process, by_gain

# Of fewer points it is quicker to compute large operators than to compile small ones.
_WORTH = 100


def refined_over_grid(
    process: Process,
    speeds: np.ndarray,
    gains: np.ndarray,
    method: Duhamel,
    progress: bool,
    of_growth: float = 0.0,
    quickly: bool = False,
) -> Dominant:
    """Over the grid of speeds (n,) and gains (m,), shape (n, m); ``evaluation`` says what the last two are."""
    shape = (len(speeds), len(gains))
    row, column = (index.ravel() for index in np.indices(shape))
    whole = partial(Refinement, method=method, of_growth=of_growth, quickly=quickly)
    result = _refined(whole, process, speeds, row, gains[column], progress)
    return Dominant(*(part.reshape(shape) for part in result))


def refined_at_points(
    process: Process,
    speeds: np.ndarray,
    gains: np.ndarray,
    method: Duhamel,
    every_mode: bool = False,
    of_growth: float = 0.0,
    quickly: bool = False,
) -> Dominant:
    """At the points (speeds[i], gains[i]), shape (p,); begun with nodes for the first mode, or for ``every_mode``."""
    unique, row = np.unique(speeds, return_inverse=True)
    whole = partial(Refinement, method=method, every_mode=every_mode, of_growth=of_growth, quickly=quickly)
    return _refined(whole, process, unique, row, gains, progress=False)


def _refined(
    whole: Callable[[Process], Refinement],
    process: Process,
    speeds: np.ndarray,
    row: np.ndarray,
    gain: np.ndarray,
    progress: bool,
) -> Dominant:
    forms = by_gain(process, gain) if len(gain) >= _WORTH else ()
    parts = [(form, np.flatnonzero(served)) for form, served in forms if np.sum(served) >= _WORTH]
    rest = np.ones(len(gain), dtype=bool)
    for _, points in parts:
        rest[points] = False
    if rest.any() or not parts:
        parts.append((process, np.flatnonzero(rest)))
    found = [whole(form).run(speeds, row[points], gain[points], progress) for form, points in parts]
    if len(found) == 1:
        return found[0]
    order = np.argsort(np.concatenate([points for _, points in parts]))
    return Dominant(*(np.concatenate(part)[order] for part in zip(*found, strict=True)))
