"""Large maps brought down to what a picture can show, in order and without losing their peaks."""

import numpy as np


def speed_order(kind: str, speed: np.ndarray, instead: str = "") -> np.ndarray:
    """The order of increasing speed; an error unless there are two or more and all differ, as a map needs."""
    different = len(np.unique(speed))
    if len(speed) < 2 or different < len(speed):
        raise ValueError(
            f"a {kind} at {different} different speeds of {len(speed)} is no map; give two or more, each once{instead}"
        )
    return np.argsort(speed)


def pooled(values: np.ndarray, axis_values: np.ndarray, most: int) -> tuple[np.ndarray, np.ndarray]:
    """The largest of every group of neighbours along the last axis, in at most ``most`` groups.

    Returns the groups' values (…, groups) and the means of ``axis_values`` (groups,).
    """
    count = values.shape[-1]
    size = -(-count // most)
    starts = np.arange(0, count, size)
    members = np.diff(np.r_[starts, count])
    return np.maximum.reduceat(values, starts, axis=-1), np.add.reduceat(axis_values, starts) / members


def on_common_frequencies(amplitude: np.ndarray, frequency: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Spectra (n, m), each over its own increasing frequencies (n, m), on common rows between ``edges`` (r + 1,).

    A row takes the largest line inside it, or, where the lines are further apart than rows, the value between
    them. NaN above a spectrum's last line. Shape (n, r).
    """
    middle = (edges[1:] + edges[:-1]) / 2
    out = np.empty((len(amplitude), len(middle)))
    for row, lines, places in zip(out, amplitude, frequency, strict=True):
        row[:] = np.interp(middle, places, lines, right=np.nan)
        index = np.searchsorted(edges, places, side="right") - 1
        inside = (index >= 0) & (index < len(middle))
        largest = np.full(len(middle), -np.inf)
        np.maximum.at(largest, index[inside], lines[inside])
        row[:] = np.where(np.isneginf(largest), row, largest)
    return out
