"""Pairs of sign changes between two samples, which only the slopes beside them give away."""

import numpy as np


def hidden_sign_changes(lane: np.ndarray, place: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cells without a sign change over which the lines through the neighbouring cells meet across zero.

    Args:
        lane: which row of samples each belongs to, in order, (p,).
        place: where it is, increasing within a lane, (p,).
        value: the function there, (p,).

    Returns:
        The first sample of each such cell, and the place where the lines meet, each (c,).
    """
    cell = np.arange(1, len(lane) - 2)
    cell = cell[lane[cell - 1] == lane[cell + 2]]
    step = place[cell + 1] - place[cell]
    sign = np.sign(value[cell])
    # Samples may coincide, and may have failed.
    with np.errstate(divide="ignore", invalid="ignore"):
        left = (value[cell] - value[cell - 1]) / (place[cell] - place[cell - 1])
        right = (value[cell + 2] - value[cell + 1]) / (place[cell + 2] - place[cell + 1])
        meeting = (value[cell + 1] - value[cell] - right * step) / (left - right)
        height = value[cell] + left * meeting
    inside = (meeting > 0) & (meeting < step)
    there = (sign == np.sign(value[cell + 1])) & inside & (sign * height < 0)
    return cell[there], place[cell[there]] + meeting[there]


def doubtful_cells(lane: np.ndarray, place: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Cells without a sign change in which there may be two, as between its ends a function may differ from the line by
    half of what it bends there: the first sample of each.

    Arguments as of ``hidden_sign_changes``. Where functions change places their maximum has a corner, of which the
    lines through the cells beside it say nothing.
    """
    apart = lane[1:] != lane[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        width = np.diff(place)
        slope = np.where(apart, np.nan, np.diff(value) / width)
        bend = np.abs(np.diff(slope, prepend=np.nan, append=np.nan))
        off = np.fmax(bend[:-1], bend[1:]) * width / 2
        near = np.minimum(np.abs(value[:-1]), np.abs(value[1:])) < off
    return np.flatnonzero(near & ~apart & (value[:-1] * value[1:] > 0))
