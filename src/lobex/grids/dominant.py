"""What an evaluation of many points gives."""

from typing import NamedTuple

import numpy as np


class Dominant(NamedTuple):
    """The dominant multiplier at points.

    Attributes:
        multiplier: μ, Im ≥ 0, NaN where a point failed.
        frequency: chatter frequency, Hz.
        error: estimated relative error of |μ| by discretisation and rounding, NaN where the method gives none.
        nodes: how many nodes per piece it took, where the method chooses; 0 elsewhere.
        again: where the dense solver had to settle a point, or after characteristic roots an operator.
    """

    multiplier: np.ndarray
    frequency: np.ndarray
    error: np.ndarray
    nodes: np.ndarray
    again: np.ndarray
